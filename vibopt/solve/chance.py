"""A design of which enough of all machines keep the limits `with_probability`.

It lies between two designs: the one that holds for the worst machine, and the one without these limits.  Where both
are as good, it is proven.  Else each of these limits is asked of one machine that stands for those at the edge of what
must keep it (sequential optimisation and reliability assessment, Du and Chen, J. Mech. Des. 126, 2004; here the machine
comes from the draw).  How much must be asked so that machines which were not drawn keep it too, a rehearsal on others
tells; the answer is then judged on machines that neither has seen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from vibopt.answer.answer import Tolerances
from vibopt.answer.entry import TOLERANCE, Checked
from vibopt.arrays import FloatArray, IntArray
from vibopt.bracketing import crossing
from vibopt.program.drawn import MET, RARE, drawn, every_one, in_batches, looks, sure_share
from vibopt.program.far_off import Beyond
from vibopt.program.program import Limit, Program
from vibopt.program.worst_case import around, hit, missed
from vibopt.records import dataclass
from vibopt.scene.scene import Design, Scene
from vibopt.scene.uncertain import Uncertain, uncertain
from vibopt.solve.deviations import goal_machine, limits_over, measures_over, side_by_side
from vibopt.solve.method import Found, Method, Progress
from vibopt.solve.odds import DRAWN, rows_drawn
from vibopt.solve.rare import beyond, proven_beyond
from vibopt.solve.robust import Among, Robust, judged, nearby, robust
from vibopt.values.tolerance import NORMAL, SIGMAS, Scatter
from vibopt.verify.as_built import differing
from vibopt.work import late, worked

Key = tuple[str, str]
_LEARNED_FROM = 4096
_ROUNDS, _REHEARSALS, _STRAIGHT = 8, 5, 2
_SETTLED = 1e-6
_SPARE = 0.05
"""Standard deviations by which a share may be better than it must, before the design is driven on."""
_MORE = 0.0, 0.1, 0.3
"""Standard deviations by which more is asked, where the machines of the verdict happen to be worse than those drawn."""
_EVEN = 1e-6
_TIMES, _FEW = 4, 64
"""Machines that are looked at again near a design: by how many times more, and by how many, than may break a limit."""
_NEAR = 0.1
"""Log of a factor within which designs are near each other."""
_FAR = 100.0
"""By how many times more machines are far off than may break a limit, before a design is known."""
_HALF = 0.5
"""Of all machines that there are, the one that just counts is counted by half: rounding decides nothing."""
_EDGE = 3
"""Machines at the edge that are averaged at least, to either side."""


@dataclass(frozen=True, slots=True)
class Sought:
    """What the search came to.

    found
        A design, or None with what is known.
    both
        The answer without tolerances, and what is told of each limit with a probability.
    rows
        Limits and measures.
    machine
        The one that is worst for the goal: by which factors its numbers are off.
    """

    found: Found
    both: Tolerances
    rows: tuple[dict[str, Checked], dict[str, Checked]] = ({}, {})
    machine: dict[str, float] = field(default_factory=dict)


def by_chance(
    scene: Scene,
    again: Callable[[Scene], Design],
    method: str | Method | None,
    progress: Progress | None,
) -> Design | Sought:
    """A design for limits with a probability, or an answer that is proven; `again` answers a scene without any."""
    asked = {name: limit.with_probability for name, limit in scene.limits.items()}
    names = {name: share for name, share in asked.items() if share is not None}
    said = ", ".join(names)
    loose = again(
        replace(scene, limits={name: response for name, response in scene.limits.items() if name not in names})
    )
    if loose.status == "infeasible":
        return replace(loose, job=scene, claim=f"already without {said}: {loose.claim}")
    each = {name: limit.model_copy(update={"with_probability": None}) for name, limit in scene.limits.items()}
    strict = again(replace(scene, limits=each))
    if _as_good(strict, loose) and _within(scene) >= max(names.values()):
        words = f"{strict.claim}; it is as good without {said}, so no share of all machines allows a better one"
        return replace(strict, job=scene, claim=words)
    starts = [np.array(answer.x) for answer in (strict, loose) if answer.x and answer.status != "unbounded"][:1]
    held = starts[:1] if strict.x and strict.status != "unbounded" else []
    both = strict.tolerances
    if both is not None and both.variables:
        starts.insert(0, np.array([both.variables[variable.path].value for variable in scene.variables]))
    for x in _candidates(scene, names, starts, held, method, progress):
        sought = _judged(scene, x, both)
        if sought is not None:
            return sought
    both = both or side_by_side(scene, None, Robust(Found("", None, "", "")), {})
    claim = f"no design was found that enough of all machines bear ({said}), which proves nothing"
    if strict.status == "infeasible":
        claim += f"; for the worst machine there is none: {strict.claim}"
    return Sought(Found("unproven", None, claim, DRAWN), both)


def _candidates(
    scene: Scene,
    names: Mapping[str, float],
    starts: list[FloatArray],
    held: list[FloatArray],
    method: str | Method | None,
    progress: Progress | None,
) -> Iterator[FloatArray]:
    """Designs (n_vars,) to be judged, the best first; the last is the one that holds for the worst machine."""
    for more in _MORE if scene.goal is not None or not held else ():
        x = _Search(scene, names, more).best(starts, method, progress)
        if x is None:
            break
        yield x
    yield from held


def _judged(scene: Scene, x: FloatArray, both: Tolerances | None) -> Sought | None:
    """A design x (n_vars,) by machines that the search has not seen; None where not enough of them keep a limit."""
    best = judged(scene, x)
    measures, best = measures_over(scene, x, best)
    limits = limits_over(scene, x, best)
    limits, odds = rows_drawn(scene, x, limits)
    if any(one.verdict != MET for one in odds.values()):
        return None
    machine = goal_machine(scene, best.hits)
    left = tuple(name for name in best.open if name not in odds)
    both = both or side_by_side(scene, None, best, {})
    both = replace(both, goal_off=differing(scene, machine), open=left, odds=odds)
    others = "; the other limits over all machines within the tolerances" if len(odds) < len(limits) else ""
    others += f", not proven for {', '.join(left)}" if left else ""
    told = "; ".join(f"{key}: {one.words}" for key, one in odds.items())
    claim = f"every limit holds{others}; {told}; that nothing better exists is not proven"
    return Sought(Found("feasible", x, claim, DRAWN), both, (limits, measures), machine)


def _as_good(strict: Design, loose: Design) -> bool:
    """Whether both are proven the best, and the limits that are told apart cost nothing."""
    if strict.status != "optimal" or loose.status != "optimal" or strict.goal is None or loose.goal is None:
        return False
    value, other = strict.goal[1].value, loose.goal[1].value
    return abs(value - other) <= _EVEN * max(abs(value), abs(other))


def _within(scene: Scene) -> float:
    """Share of all machines that lie within the tolerances of the worst case."""
    from scipy.special import ndtr

    inside = 1.0 - 2.0 * float(ndtr(-SIGMAS))
    kinds = [one.tolerance.kind for one in uncertain(scene) if isinstance(one.tolerance, Scatter)]
    return inside ** kinds.count(NORMAL)


class _Machines:
    """Machines drawn (n, n_doubts); near a design at which all were looked at, only those that were worst there are.

    What is left out so keeps its limit by far, and no verdict is told by these machines.
    """

    def __init__(self, factors: FloatArray) -> None:
        self.factors = factors
        self._worst: dict[Key, IntArray] = {}
        self._at: FloatArray | None = None

    def missed(self, x: FloatArray, key: Key, parts: list[Limit], share: float) -> FloatArray:
        """By how much each part of a limit, which a share is to keep, is missed at x (n_vars,), shape (n_parts, n)."""
        count = len(self.factors)
        if self._at is None or np.abs(np.log(np.maximum(x, 1e-300) / np.maximum(self._at, 1e-300))).max() > _NEAR:
            self._worst.clear()
            self._at = x
        worst = self._worst.get(key)
        looked = np.arange(count) if worst is None else worst
        values = np.full((len(parts), count), -np.inf)
        values[:, looked] = missed_on(parts, self.factors[looked])
        if worst is None:
            tail = min(_TIMES * int((1.0 - share) * count) + _FEW, count)
            self._worst[key] = np.argsort(values.max(axis=0), kind="stable")[-tail:]
        return values


def missed_on(parts: list[Limit], machines: FloatArray) -> FloatArray:
    """By how much each part is missed on machines (n, n_doubts), shape (n_parts, n)."""
    worked(len(machines) * sum(part.cost for part in parts))
    found = np.empty((len(parts), len(machines)))
    for some in in_batches(len(machines)):
        found[:, some] = [[missed(part, value) for value in part.values(machines[some])] for part in parts]
    return found


class _Asked:
    """What is asked of the machines drawn for one limit: of all, or of those `far` off where hardly any may break it.

    Where there are few enough, `whole` (n, n_doubts) are all machines that there are, and nothing is drawn.

    wanted, aim
        Share of those that are drawn: as asked, and so that the verdict hardly ever fails.
    """

    def __init__(
        self,
        doubts: Sequence[Uncertain],
        wanted: float,
        far: Beyond | None,
        count: int,
        confidence: float,
        whole: FloatArray | None,
        more: float,
    ) -> None:
        if whole is not None:
            self.wanted = self.aim = (np.ceil(wanted * len(whole) - _SETTLED) - _HALF) / len(whole)
            self.learned = self.rehearsal = _Machines(whole)
            return
        few = count if far is not None else min(_LEARNED_FROM, count)
        self.wanted = 1.0 - (1.0 - wanted) / (far.part if far is not None else 1.0)
        self.aim = sure_share(self.wanted, count, confidence)
        self.aim = _moved(self.aim, more) if more else self.aim
        self.learned = _Machines(far.machines(few, "design") if far else drawn(doubts, few, "design", evenly=True))
        self.rehearsal = _Machines(far.machines(count, "rehearsal") if far else drawn(doubts, count, "rehearsal"))


class _Search:
    def __init__(self, scene: Scene, names: Mapping[str, float], more: float) -> None:
        self.scene, self.names, self.more = scene, names, more
        self.doubts = uncertain(scene)
        parts = self._parts(self._around(np.array([max(variable.low, 1e-300) for variable in scene.variables])))
        cost = max(sum(limit.cost for limit in many) for many in parts.values())
        sizes, self.confidence = looks(cost)
        self.whole = every_one(self.doubts, cost)
        self.count = sizes[-1] if self.whole is None else len(self.whole)
        self.asked = {
            key: self._asked(key, beyond(many, self.doubts, names[key[0]], _FAR)) for key, many in parts.items()
        }

    def _asked(self, key: Key, far: Beyond | None) -> _Asked:
        wanted = self.names[key[0]]
        far = far if wanted > RARE else None
        return _Asked(self.doubts, wanted, far, self.count, self.confidence, self.whole, self.more)

    def _around(self, x: FloatArray) -> Program:
        return around(self.scene, x)

    def _parts(self, program: Program) -> dict[Key, list[Limit]]:
        """Limits with a probability by name and side; of several places one each."""
        found: dict[Key, list[Limit]] = {}
        for limit in program.limits:
            if limit.name in self.names:
                found.setdefault((limit.name, limit.user_side), []).append(limit)
        return found

    def best(
        self, starts: list[FloatArray], method: str | Method | None, progress: Progress | None
    ) -> FloatArray | None:
        """The best design x (n_vars,) that the rehearsal bears, or None."""
        if any(np.isnan(asked.aim) for asked in self.asked.values()):
            return None
        aims = {key: asked.aim for key, asked in self.asked.items()}
        reached = [self._followed(x, aims, method, whole=not k) for k, x in enumerate(starts)]
        for x in sorted((one for one in reached if one is not None), key=self._goal):
            found = self._borne(x, method, progress)
            if found is not None:
                return found
        return None

    def _borne(self, x: FloatArray, method: str | Method | None, progress: Progress | None) -> FloatArray | None:
        """The best design near x (n_vars,) that the rehearsal bears, with no more asked than that takes; or None."""
        for key, many in self._parts(self._around(x)).items():
            if self.names[key[0]] > RARE:  # as far off as the verdict will draw them
                self.asked[key] = self._asked(key, proven_beyond(many, self.doubts, self.names[key[0]]))
        targets, found = {key: asked.aim for key, asked in self.asked.items()}, None
        if any(np.isnan(one) for one in targets.values()):
            return None
        for step in range(_REHEARSALS):
            if progress is not None:
                progress("machines drawn", (step + 0.5) / _REHEARSALS)
            off = self._rehearsed(x)
            if all(value >= 0.0 for value in off.values()) and (found is None or self._goal(x) < self._goal(found)):
                found = x
            edges = self._edges(x, targets)
            held = {key: self._tight(x, key, edges[key]) for key in off}
            if all(value >= 0.0 and (value <= _SPARE or not held[key]) for key, value in off.items()):
                break
            more = 0.5 * _SPARE if step >= _STRAIGHT else 0.0
            by = {key: more - value if value < 0.0 or held[key] else 0.0 for key, value in off.items()}
            targets = {key: _moved(targets[key], value) for key, value in by.items()}
            there = self._followed(x, targets, method)
            if there is None or late("the search among machines drawn"):
                break
            x = there
        return found

    def _followed(
        self, x: FloatArray, targets: Mapping[Key, float], method: str | Method | None, whole: bool = False
    ) -> FloatArray | None:
        """Where one machine for each limit after the other leads from x (n_vars,); `whole` searches the range first."""
        value = np.inf
        for step in range(_ROUNDS):
            among = self._edges(x, targets)
            there = nearby(self.scene, x, among) if step or not whole else None
            if there is None and not step:
                found = robust(self.scene, Found("feasible", x, "", ""), method, None, among).found
                there = found.x if found.status in ("optimal", "feasible") else None
            if there is None:
                return None
            before, value, x = value, self._goal(there), there
            if abs(before - value) <= _SETTLED * abs(value):
                break
        return x

    def _goal(self, x: FloatArray) -> float:
        """To be minimised, on the machine that is worst for it."""
        program = self._around(x)
        return 0.0 if program.aim is None else program.aim.sense * hit(program.aim, program.axes, quick=True).value

    def _edges(self, x: FloatArray, targets: Mapping[Key, float]) -> Among:
        """One machine (one for each place) that stands for those at the edge of what must keep each limit."""
        return {key: self._edge(x, key, many, targets[key]) for key, many in self._parts(self._around(x)).items()}

    def _edge(self, x: FloatArray, key: Key, parts: list[Limit], target: float) -> FloatArray:
        learned = self.asked[key].learned
        values = learned.missed(x, key, parts, target)
        worst = values.max(axis=0)
        order = np.argsort(worst, kind="stable")
        at = min(int(np.ceil(target * len(order))), len(order)) - 1
        width = max(_EDGE, (len(order) - at) // 2) if self.whole is None else 0
        edge = order[max(at - width, 0) : at + width + 1]
        by = values[:, edge].argmax(axis=0)
        found = [
            self._scaled(parts, learned.factors[edge[by == k]].mean(axis=0), float(worst[order[at]]))
            for k in set(by.tolist())
        ]
        return np.array(found)

    def _scaled(self, parts: list[Limit], machine: FloatArray, level: float) -> FloatArray:
        """The machine on the way from the one as said through `machine` (n_doubts,) that misses as much as the edge."""

        def over(t: float) -> float:
            return float(missed_on(parts, (1.0 + t * (machine - 1.0))[None, :]).max()) - level

        low, high = 0.0, 1.5
        if not (np.isfinite(level) and over(low) < 0.0 < over(high)):
            return machine
        return np.asarray(1.0 + crossing(over, low, high, least=1e-9)[0] * (machine - 1.0))

    def _tight(self, x: FloatArray, key: Key, machines: FloatArray) -> bool:
        """Whether a limit holds the design back."""
        return bool(missed_on(self._parts(self._around(x))[key], machines).max() > -1e-4)

    def _rehearsed(self, x: FloatArray) -> dict[Key, float]:
        """How much better the share of machines is than it must be [standard deviations of a normal distribution]."""
        from scipy.special import ndtri

        found = {}
        for key, many in self._parts(self._around(x)).items():
            asked = self.asked[key]
            kept = asked.rehearsal.missed(x, key, many, asked.wanted).max(axis=0) <= TOLERANCE
            share = float(kept.sum() - (_HALF if self.whole is not None else 0.0)) / len(kept)
            most = 1.0 - 0.5 / self.count
            found[key] = float(ndtri(min(share, most)) - ndtri(asked.aim)) if share > 0.0 else -np.inf
        return found


def _moved(share: float, by: float) -> float:
    """A share further by some standard deviations of a normal distribution."""
    from scipy.special import ndtr, ndtri

    return float(np.clip(ndtr(ndtri(share) + np.clip(by, -1.0, 1.0)), 0.5, 1.0 - 1e-9))
