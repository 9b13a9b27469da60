"""What holds an answer back, at any value of one number of its file: answered anew, many together where that goes."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import ACTIVE, Entry
from vibopt.document.toml_reading import inside
from vibopt.errors import InputError
from vibopt.jobs import answer, facts, is_scene, with_changes
from vibopt.records import cached_property, dataclass
from vibopt.report.catalogue_choices import tied
from vibopt.solve import solve
from vibopt.study.seen import goal_of
from vibopt.values.fact_at import FactAt
from vibopt.verify.checked import in_usual_unit
from vibopt.work import SpentError, metered

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job
    from vibopt.study.points import Columns


FEWEST_TOGETHER = 12
LEAST_WORK = 5.0
"""Work of any answer [nominal ms]."""
_TOUCHED = 1e-4
"""Part of a limit or a cap of a balancing job within which its answer touches it."""
_LINE = 3
"""Neighbours that are looked through for the second on a line of designs."""
_AT_END = 1e-9
_PLACES = {"low": "its lowest", "high": "its highest"}


@dataclass(frozen=True, slots=True)
class State:
    """The answer at one value.

    value
        Of the number [SI].
    status
        Of the answer; "refused" where the file cannot have this value.
    measure
        The goal; of an analysis the least margin of its limits.  None without a design.
    held
        What holds it back: limits touched, ends of ranges reached, and what was chosen of parts and places; of an
        analysis the limit with the least margin and those that are broken.
    worst
        Value of each limit [SI], where it was answered alone.
    room
        How far what could hold it back is from doing so, by the same names: margins of limits, and what is left to
        ends of ranges, as parts; where it was answered alone.
    x
        The design.
    pieces
        Of a shelf: plane, hole, radius [m] and mass [kg] of each that is fitted.
    """

    value: float
    status: str
    measure: Entry | None
    held: frozenset[str]
    worst: Mapping[str, float] = field(default_factory=dict)
    room: Mapping[str, float] = field(default_factory=dict)
    x: tuple[float, ...] = ()
    pieces: tuple[tuple[str, int, float, float], ...] = ()

    @property
    def good(self) -> bool:
        """Whether there is a design."""
        return self.measure is not None

    def filling(self, plane: str) -> list[tuple[str, int, float, float]]:
        """The pieces, that of the value in a plane without its mass: what stays the same while it alone is moved."""
        same = (math.isclose(piece[3], self.value, rel_tol=1e-9) and piece[0] == plane for piece in self.pieces)
        return sorted((*one[:3], 0.0 if moved else one[3]) for one, moved in zip(self.pieces, same, strict=True))

    def like(self, other: State) -> bool:
        """Whether the same things hold both back."""
        return self.good == other.good and self.held == other.held


def measured_by(job: Job) -> tuple[str, int]:
    """Name of what a price is counted in, and 1 where more of it is better, else -1; ("", 0) where there is nothing."""
    if is_scene(job):
        if job.goal is not None:
            return job.goal.response.response.replace("_", " "), 1 if job.goal.sense == "maximise" else -1
        return ("least margin", 1) if job.limits and job.find_all is None else ("", 0)
    if job.aim:
        return job.aim.replace("_", " "), -1
    return ("least margin", 1) if getattr(job, "limits", None) else ("", 0)


def state_of(job: Job, answer: Answer[Any], value: float) -> State:
    """What holds an answer back."""
    if answer.status in ("met", "violated") and answer.goal is None:
        rows = {name: limit for name, limit in answer.limits.items() if math.isfinite(limit.margin)}
        if not rows:
            return State(value, answer.status, None, frozenset())
        least = min(rows, key=lambda name: rows[name].margin)
        broken = {f"{name} broken" for name, row in rows.items() if not row.met}
        return State(value, answer.status, Entry(rows[least].margin, "ratio", "%"), frozenset({least, *broken}))
    goal = goal_of(job, answer)
    if goal is None or answer.status not in ("optimal", "feasible"):
        return State(value, answer.status, None, frozenset())
    worst = {name: limit.value.value for name, limit in answer.limits.items()}
    room = {name: limit.margin for name, limit in answer.limits.items()}
    if not is_scene(job):
        caps = {path: part for path, _, part in caps_of(job, answer)}
        room |= {_at_most(path): 1.0 - part for path, part in caps.items()}
        touched = frozenset(_balancing_held(job, answer, caps))
        return State(value, answer.status, goal, touched, worst, room, pieces=tuple(_pieces(job, answer)))
    held = {name for name, limit in answer.limits.items() if limit.active}
    ends = {path: chosen.at_bound for path, chosen in answer.variables.items() if chosen.at_bound}
    held |= {f"{path} at {_PLACES['high' if end == 'to' else 'low']}" for path, end in ends.items()}
    listed = {variable.path for variable in answer.scene.variables if variable.values is not None} - tied(job).keys()
    held |= {f"{path} = {variable.value.shown}" for path, variable in answer.variables.items() if path in listed}
    held |= {f"{path} = {place.value}" for path, place in answer.places.items()}
    for one, x in zip(answer.scene.variables, answer.x, strict=False):
        if x > 0.0:
            room[f"{one.path} at {_PLACES['low']}"] = math.log(x / one.low) if one.low > 0.0 else math.inf
            room[f"{one.path} at {_PLACES['high']}"] = math.log(one.high / x)
    return State(value, answer.status, goal, frozenset(held), worst, room, tuple(answer.x))


def is_looser(path: str, change: float) -> bool:
    """Whether a bound that changes by so much leaves more room."""
    return change * (1 if path.endswith(("at_most", "lowest", ".to", ".deepest")) else -1) > 0.0


def in_steps(job: Job) -> bool:
    """Whether a limit may hold the answer to a balancing job back without being touched."""
    robust = getattr(getattr(job, "goal", None), "robust", "")
    listed = any(plane.is_discrete and plane.is_open for plane in getattr(job, "planes", ()))
    return bool(robust) or getattr(job, "is_search", False) or listed


def caps_of(job: Any, answer: Answer[Any]) -> Iterator[tuple[str, FactAt, float]]:
    """Upper ends of what a balancing job chooses: path of the choice, the number, and the part of it that is taken."""
    planes = {f"planes.{plane.name}": plane.weights for plane in answer.plan.planes}
    for fact in facts(job):
        path, _, end = fact.path.rpartition(".")
        if end not in ("to", "deepest") or not fact.value > 0.0:
            continue
        weights = planes.get(path.rpartition(".")[0])
        if weights is None:  # no measured rotor, whose entries are as many as its coefficients
            entries = answer.entries()
            one = entries.get(next(filter(entries.get, _chosen_at(path)), ""))
            taken = one.value if isinstance(one, Entry) else 0.0
        elif end == "deepest":
            taken = max((weight.depth or 0.0 for weight in weights), default=0.0)
        else:
            taken = sum((weight.mass for weight in weights), 0.0)
        yield path, fact, taken / fact.value


def _bounds_of(job: Job, name: str) -> Iterator[FactAt]:
    """The numbers of the file that bound something of `State.held`: a limit, or the end of a range."""
    path, _, end = name.partition(" at ")
    keys = ("to", "deepest") if end == _PLACES["high"] else ("from",)
    if is_scene(job):
        for variable in job.variables:
            given = inside(job.document, path) if end and variable.path == path else None
            if isinstance(given, dict) and keys[0] in given and not variable.choice.whole:
                number = variable.high if end == _PLACES["high"] else variable.low
                yield FactAt(f"{path}.{keys[0]}", number, variable.unit, variable.dimension)
    wanted = {f"{path}.{key}" for key in keys} if end else {f"limits.{name}.at_most", f"limits.{name}.at_least"}
    yield from (fact for fact in facts(job) if fact.path in wanted and fact.dimension != "count")


def wider(bounds: Iterable[FactAt], by: float) -> dict[str, str | float]:
    """Changes that leave a part more room at each of some bounds, or less."""
    ways = ((bound, 1.0 if is_looser(bound.path, 1.0) else -1.0) for bound in bounds)
    return {path: said for bound, way in ways for path, said in bound.changes(bound.value * (1.0 + by * way)).items()}


def is_touched(part: float) -> bool:
    """Whether an answer touches what it takes this part of."""
    return part >= 1.0 - _TOUCHED


def _at_most(path: str) -> str:
    return f"{path} at {_PLACES['high']}"


def _balancing_held(job: Any, answer: Answer[Any], caps: Mapping[str, float]) -> set[str]:
    """Limits and caps that are touched and hold the goal back, and what was chosen of lists."""
    rates = answer.rates if answer.rates is not None else {}
    held = {name for name, limit in answer.limits.items() if is_touched(1.0 - limit.margin) and rates.get(name, 1.0)}
    held |= {_at_most(path) for path, part in caps.items() if is_touched(part) and rates.get(path, 1.0)}
    for plane, made in zip(getattr(job, "planes", ()), answer.plan.planes, strict=False):
        if plane.is_discrete:
            held.add(f"{plane.name}: {' and '.join(_fitted(plane, made)) or 'nothing'}")
    if cranks := [path for path in job.choices if path.startswith("cyl")]:
        entries = answer.entries()
        held |= {f"{path} = {entries[path].shown}" for path in cranks if path in entries}
    return held


def _pieces(job: Any, answer: Answer[Any]) -> Iterator[tuple[str, int, float, float]]:
    """Plane, hole, radius and mass of each weight of a shelf that is fitted."""
    for plane, made in zip(getattr(job, "planes", ()), answer.plan.planes, strict=False):
        for weight in made.weights if plane.is_discrete else ():
            mass = min(plane.shelf, key=lambda kind: abs(kind - weight.mass), default=weight.mass)
            yield plane.name, -1 if weight.hole is None else weight.hole, weight.radius or 0.0, mass


def _fitted(plane: Any, made: Any) -> Iterator[str]:
    """Which weights of a shelf, the lightest first, sit in which holes, whatever they weigh."""
    for weight in made.weights:
        which = min(range(len(plane.shelf)), key=lambda k: abs(plane.shelf[k] - weight.mass), default=0)
        at = f" at radius {plane.radii.index(weight.radius) + 1}" if weight.radius in plane.radii[1:] else ""
        yield f"weight {which + 1} in hole {weight.hole + 1} of {len(plane.holes)}{at}"


def _chosen_at(path: str) -> tuple[str, ...]:
    """Where the entries of an answer have what is chosen at a path of the file."""
    return path, path.replace(".weight", ".mass"), path.partition(".")[2]


@dataclass
class Road:
    """Answers along one number of a job, kept; many together where all can be.

    near
        The design of the job as it is, where others begin that have no neighbour yet.
    most, each
        Work that may be done, in all and of one answer [nominal ms]; SpentError where it does not do.
    beside
        Designs that were met on the way and are no answers, by value.
    work
        Nominal ms done so far.
    """

    job: Job
    fact: FactAt
    near: Sequence[float] | None
    most: float = math.inf
    each: float = math.inf
    known: dict[float, State] = field(default_factory=dict)
    beside: dict[float, tuple[float, ...]] = field(default_factory=dict)
    work: float = 0.0

    @property
    def has_goal(self) -> bool:
        """Whether something is made best."""
        return (self.job.goal is not None) if is_scene(self.job) else bool(self.job.aim)

    @cached_property
    def together(self) -> bool:
        """Whether answers are found in one batch: two of them are tried."""
        from vibopt.study.many import batch

        return batch(self.job, [self.fact], self.fact.value * np.array([[0.999], [1.001]])) is not None

    def __call__(self, value: float) -> State:
        """The answer at a value [SI]."""
        if value not in self.known:
            self.known[value] = self.with_room(value)
        return self.known[value]

    def told(self, value: float) -> State | None:
        """The same; None where that takes more work than there is."""
        try:
            return self(value)
        except SpentError:
            return None

    def with_room(self, value: float, names: Collection[str] = (), by: float = 0.0) -> State:
        """The answer at a value where the bounds of what is touched leave a part more room; "refused" if they are none.

        names
            As in `State.held`: limits, and ends of ranges; none: the answer to the job with the value alone.
        """
        try:
            here = with_changes(self.job, self.fact.changes(value))
            bounds = {name: list(_bounds_of(here, name)) for name in names}
            if not all(bounds.values()):
                return State(value, "refused", None, frozenset())
            here = with_changes(here, wider(chain.from_iterable(bounds.values()), by)) if bounds else here
        except InputError:
            return State(value, "refused", None, frozenset())
        from vibopt.study.many import of_one_machine

        near = self._near(value) if is_scene(here) else None
        with self._counted(LEAST_WORK):
            if is_scene(here):
                near = near if near and len(near) == len(here.variables) and not names else None
                with of_one_machine(self.job, [self.fact.path]):
                    found: Answer[Any] = solve(here, explain=False, brief=True, near=near)
            else:
                found = answer(here, explain=False, brief=True)
            return state_of(here, found, value)

    @contextmanager
    def _counted(self, least: float = 0.0) -> Iterator[None]:
        """Add the work inside; SpentError where it is more than is left for it."""
        if self.work > self.most:
            raise SpentError
        with metered(min(self.most - self.work, self.each)) as meter:
            try:
                yield
            finally:
                self.work += max(meter.done, least)

    def _near(self, value: float) -> Sequence[float] | None:
        """A design to begin at: along the line through the two nearest of one kind, else the nearest."""
        known: dict[float, tuple[tuple[float, ...], object]] = {one: (x, None) for one, x in self.beside.items()}
        known.update({state.value: (state.x, state.held) for state in self.known.values() if state.x})
        first, *others = sorted(known, key=lambda one: abs(one - value)) or [math.nan]
        if not known:
            return self.near
        (x, held), gap = known[first], value - first
        for one in others[:_LINE]:
            other, same = known[one]
            if held is not None and same == held and abs(gap) <= abs(first - one) and min(*x, *other) > 0.0:
                return tuple(a * (a / b) ** (gap / (first - one)) for a, b in zip(x, other, strict=True))
        return x

    def brink(self, value: Callable[[float], float], good: tuple[float, State], bad: float) -> float:
        """About where designs end between two places, of which `value` says the number; nan where that is not known."""
        if self.together or not good[1].x:
            return math.nan
        from vibopt.study.brink import brink, follows

        if not follows(self.job):
            return math.nan
        try:
            with self._counted():
                t, x = brink(self.job, self.fact, value, (good[0], bad), good[1].x)
        except SpentError:
            return math.nan
        if math.isfinite(t):
            self.beside[value(t)] = tuple(x)
        return t

    def at(self, values: Sequence[float]) -> list[State | None]:
        """The answers at several values, in any order; None where a batch has proven nothing, or work is spent."""
        missing = sorted({value for value in values if value not in self.known})
        if len(missing) >= FEWEST_TOGETHER and self.together and self._batch(missing):
            return [self.known.get(value) for value in values]
        return [self.told(value) for value in values]

    def _batch(self, values: list[float]) -> bool:
        """Whether a batch answered them."""
        from vibopt.study.many import batch

        self.work += LEAST_WORK + 0.05 * len(values)
        columns = batch(self.job, [self.fact], np.array(values)[:, None], whole=False)
        if columns is None:
            return False
        for index, status in enumerate(columns.status):
            if status in ("optimal", "infeasible"):
                self.known[values[index]] = self._state(columns, index, values[index])
        return True

    def _state(self, columns: Columns, index: int, value: float) -> State:
        scene: Any = self.job
        if columns.status[index] == "infeasible":
            return State(value, "infeasible", None, frozenset())
        if columns.words is not None and columns.held is not None:
            held = {name if name in columns.margins else _at_most(name) for name in columns.held(index)}
            return State(value, "optimal", columns.words(index)[0], frozenset(held))
        held = {name for name, margin in columns.margins.items() if abs(margin[index]) <= ACTIVE}
        for variable, row in zip(scene.variables, columns.x, strict=True):
            for end, word in ((variable.low, "low"), (variable.high, "high")):
                if abs(row[index] - end) <= _AT_END * abs(end):
                    held.add(f"{variable.path} at {_PLACES[word]}")
        assert columns.goal is not None
        goal = in_usual_unit(scene, scene.goal.response, float(columns.goal[index]))
        return State(value, "optimal", goal, frozenset(held))


def no_more(state: State, now: float) -> str:
    """Why there is no answer at a value beyond `now`."""
    if state.status in ("unproven", "check_failed"):
        return "nothing found, nothing proven"
    refused = f"the file cannot have {'more' if state.value > now else 'less'}"
    return refused if state.status == "refused" else "no design"


def difference(before: State, after: State) -> str:
    """What takes over between two answers, in words."""
    if before.good and not after.good:
        return no_more(after, before.value)
    if not before.good and after.good:
        return "a design"
    news = sorted(after.held - before.held)
    gone = sorted(before.held - after.held)
    words = [f"{', '.join(news)} take{'s' * (len(news) == 1)} over"] if news else []
    words += [f"{', '.join(gone)} let{'s' * (len(gone) == 1)} go"] if gone else []
    return " and ".join(words) or "nothing changes"
