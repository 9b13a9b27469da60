"""Where no design meets every limit, or none was found: the one that misses least, and what each limit could be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from vibopt.answer.answer import Least, Nearest
from vibopt.answer.entry import Checked
from vibopt.arrays import FloatArray
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Program
from vibopt.records import dataclass
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.scene import Design, Scene
from vibopt.scene.uncertain import likely, uncertain
from vibopt.solve.choose import modest
from vibopt.solve.deviations import limits_over
from vibopt.solve.local import on_values
from vibopt.solve.loosen import beside, left_out
from vibopt.solve.measured_pieces import SLOPES, Exact, Piece, Point
from vibopt.solve.ranges import closed, log_box, starts
from vibopt.solve.robust import judged
from vibopt.solve.several import Several, keys_of
from vibopt.solve.sqp import Sqp
from vibopt.study.freeze import named
from vibopt.values.soft import bent, counted, softness
from vibopt.verify.checked import checked_limits, chosen_of, disagreement
from vibopt.verify.rated import parts_of
from vibopt.work import Budget, late, metered

PATIENCE = 2_000.0
"""Work [nominal ms] after which the limits that are left are named as not looked at."""
_MEASUREMENTS, _WORK, _FEWEST = 800, 8_000.0, 40
"""Most exact measurements; work of all where each is dear [nominal ms], and how many it may be then."""
_STARTS, _FOLLOWED = 16, 4
_ROUNDS = 4
_BETTER = 1e-9
_EVEN = 1e-7
"""Log of a factor within which limits are missed alike."""
_CLEAR = 1e-6
"""Part of every bound that is left over where a proof that there is no design is plainly wrong."""


def with_nearest(design: Design, *, thorough: bool = False) -> Design:
    """The same answer with the nearest design, where it has none of its own; others as they are.

    Parameters
    ----------
    design
        Of status "infeasible" or "unproven"; not where a limit asks for a probability.
    thorough
        Whatever the work; without it limits that are left are named.
    """
    scene = design.scene
    refused = design.status not in ("infeasible", "unproven") or bool(design.x) or design.nearest is not None
    refused = refused or likely(scene)
    if refused or not scene.variables or not scene.limits or open_places(scene) or open_positions(scene):
        return design
    program = closed(pose(scene))
    known = design.details.get("nearest")  # a catalogue has looked for it already
    most = beside(scene, np.inf if thorough else PATIENCE)
    with metered() as meter:
        x = np.array(known["x"]) if isinstance(known, dict) else nearest_to(program)
        if uncertain(scene) and not program.ties:
            x = _over_tolerances(scene, program, x)
        rows = _rows(scene, program, x)
        least: dict[str, Least] = {}
        left: list[str] = []
        for key, row in rows.items():
            if row.side == "outside":
                continue
            if meter.done > most or late("the search for the least of each limit"):
                left.append(key)
            elif (one := _least(scene, program, row)) is not None:
                least[key] = one
    if design.status == "infeasible" and all(one.margin > _CLEAR for one in rows.values()) and not uncertain(scene):
        claim = f"{design.method} claims that there is no design, but one meets every limit on the built machine"
        return replace(design, status="check_failed", claim=claim, conflict=None)
    if not uncertain(scene) and any(one.doubt for one in rows.values()):  # what is claimed is of another machine
        return replace(design, status="check_failed", claim=disagreement(rows), conflict=None)
    chosen = named(scene, x)
    found = Nearest(
        variables={variable.path: chosen_of(variable, chosen[variable.path]) for variable in scene.variables},
        places=parts_of(scene, chosen),
        x=tuple(float(one) for one in x),
        limits=rows,
        least=least,
        left=tuple(left),
        soft=softness(scene.limits),
    )
    note = f"The least of {', '.join(left)} was not looked for: {left_out(scene)}"
    return replace(design, nearest=found, notes=(*design.notes, *([note] if left else [])))


def _rows(scene: Scene, program: Program, x: FloatArray) -> dict[str, Checked]:
    """Every limit on the machine as built, the worst within its tolerances."""
    if uncertain(scene):
        return limits_over(scene, x, judged(scene, x))
    return checked_limits(scene, named(scene, x), model=program.model)


def _least(scene: Scene, program: Program, row: Checked) -> Least | None:
    """What a limit could be if there were no other, measured on the machine as built; None where nothing was found."""
    own = [limit for limit in program.limits if limit.name == row.name and limit.user_side == row.side]
    if not own:
        return None
    sense = 1.0 if own[0].side == "at_most" else -1.0
    aims = [Aim(limit.name, limit.model, limit.form, sense, limit.complement) for limit in own]
    alone = replace(program, limits=(), aim=replace(aims[0], others=tuple(aims[1:])))
    best = modest(alone).solve(alone)
    if best.x is None or best.status not in ("optimal", "feasible"):
        return None
    rows = checked_limits(scene, named(scene, np.asarray(best.x)), model=program.model)
    same = next(one for one in rows.values() if (one.name, one.side) == (row.name, row.side))
    opened = any(axis.open_high or axis.open_low for axis in program.axes)
    value = same.value
    if row.name not in scene.limits and same.limit is not None:  # a rating is that of each part
        value = replace(value, text=f"{value.shown} of {same.limit.shown}")
    return Least(value, best.status == "optimal" and not opened, same.met)


def _over_tolerances(scene: Scene, program: Program, x: FloatArray) -> FloatArray:
    """The nearest over the worst machines found, machine after machine; x (n_vars,) is the one without tolerances."""
    machines = Several(scene)
    for _ in range(_ROUNDS):
        hits, known = judged(scene, x).hits, machines.asked
        for index, key in keys_of(program).items():
            if index in hits and index >= 0:
                machines.add(key, machines.parts_off(x, hits[index].factors))
        if machines.asked == known or late("the search for the nearest design"):
            break
        x = nearest_to(machines.program(), (x,))
    return x


@dataclass
class Missing(Exact):
    """By which factor each limit is missed, as its weight counts it: to be made least; those in `kept` no more."""

    kept: Mapping[int, float] = field(default_factory=dict)

    def _at(self, y: FloatArray) -> Point:
        every = tuple(self._counted(limit) for limit in super()._at(y).limits)
        kept = tuple(
            replace(piece, value=piece.value - self.kept[piece.part]) for piece in every if piece.part in self.kept
        )
        goals = tuple(replace(piece, part=-1 - piece.part) for piece in every if piece.part not in self.kept)
        return Point(np.array(y), kept, goals)

    def _counted(self, piece: Piece) -> Piece:
        """A piece as the weight of its limit counts it."""
        limit = self.program.limits[piece.part]
        at_least = limit.side == "at_least"
        if limit.soft == 1.0 and not at_least:
            return piece
        value, first, second = counted(piece.value, limit.soft, at_least=at_least)
        bend = bent(piece.slope, piece.bend, first, second)
        return replace(piece, value=value, slope=first * piece.slope, bend=bend)


def nearest_to(program: Program, given: Sequence[FloatArray] = ()) -> FloatArray:
    """The design x (n_vars,) whose worst limit is missed by the least factor, of all that some starts lead to.

    Continuous variables follow the slopes of the limits that are missed most; values of a list and parts change one at
    a time as long as that helps.
    """
    budget = _budget(program)
    bare = replace(program, aim=None)
    begun = [np.asarray(one, dtype=float) for one in given]
    begun += [_snapped(program, x) for x in np.exp(starts(program, _STARTS))]
    search = _Search(bare, budget)
    ranked = sorted(((search.missed(x), number) for number, x in enumerate(begun)))
    best, least = begun[ranked[0][1]], ranked[0][0]
    for _, number in ranked[:_FOLLOWED]:
        x, value = search.followed(begun[number])
        if value < least - _BETTER:
            best, least = x, value
        if budget.over:
            break
    return search.settled(best)


def slid(program: Program, x: FloatArray) -> tuple[FloatArray, float]:
    """Where slopes lead from x (n_vars,) towards missing the worst limit least, and the log of that factor."""
    return _Search(program, _budget(program)).slid(x)


def _budget(program: Program) -> Budget:
    most = int(np.clip(_WORK / program.cost, _FEWEST, _MEASUREMENTS))
    return Budget(most, "exact measurements", SLOPES * program.cost)


@dataclass
class _Search:
    program: Program
    budget: Budget

    def missed(self, x: FloatArray) -> float:
        """Log of the factor by which the worst limit is missed at x (n_vars,)."""
        return self._exact(x).at(np.log(np.maximum(x, 1e-300))).goal

    def followed(self, x: FloatArray) -> tuple[FloatArray, float]:
        """Where slopes and single changes lead from x (n_vars,), and what is missed there."""
        x, value = self.slid(x)
        while not self.budget.over:
            better = min(((self.missed(one), tuple(one)) for one in self._changed(x)), default=(np.inf, ()))
            if better[0] >= value - _BETTER:
                break
            x, value = self.slid(np.array(better[1]))
        return x, value

    def settled(self, x: FloatArray) -> FloatArray:
        """Near x, the worst limit missed no more: the next worst made least in turn, until the rest are met."""
        kept: dict[int, float] = {}
        for _ in self.program.limits:
            exact = self._exact(x, kept)
            here = exact.at(np.log(np.maximum(x, 1e-300)))
            if here.goal <= 0.0 or not exact.free.any() or self.budget.over:
                break
            kept |= {-1 - goal.part: here.goal for goal in here.goals if goal.value >= here.goal - _EVEN}
            if len(kept) == len(self.program.limits):
                break
            there, _ = self.slid(x, kept)
            moved = self._exact(there, kept).at(np.log(np.maximum(there, 1e-300)))
            x = there if moved.missed <= _EVEN and moved.goal < here.goal - _BETTER else x
        return x

    def _exact(self, x: FloatArray, kept: Mapping[int, float] | None = None) -> Missing:
        low, high = log_box(self.program)
        for i, axis in enumerate(self.program.axes):
            if axis.values is not None:
                low[i] = high[i] = np.log(max(x[i], 1e-300))
        return Missing(self.program, low, high, self.budget, kept=kept or {})

    def slid(self, x: FloatArray, kept: Mapping[int, float] | None = None) -> tuple[FloatArray, float]:
        """Where the slopes of the limits that are missed most lead from x, and what is missed there."""
        exact, start = self._exact(x, kept), np.log(np.maximum(x, 1e-300))
        if not exact.free.any():
            return x, exact.at(start).goal
        point = Sqp(exact).run(np.clip(start, exact.low, exact.high))
        there = np.where(exact.free, np.exp(point.y), x)
        for i in np.flatnonzero(exact.free):
            axis = self.program.axes[i]
            there[i] = np.clip(there[i], axis.low, axis.high)
        return there, point.goal

    def _changed(self, x: FloatArray) -> Iterator[FloatArray]:
        """Designs with one part, or one value of a list, exchanged."""
        tied = {i for tie in self.program.ties for i in tie.axes}
        for tie in self.program.ties:
            for row in tie.table:
                yield _with(x, dict(zip(tie.axes, row, strict=True)))
        for i, axis in enumerate(self.program.axes):
            for value in axis.values or () if i not in tied else ():
                if value != x[i]:
                    yield _with(x, {i: value})


def _with(x: FloatArray, values: Mapping[int, float]) -> FloatArray:
    found = x.copy()
    for i, value in values.items():
        found[i] = value
    return found


def _snapped(program: Program, x: FloatArray) -> FloatArray:
    """The nearest values and parts that there are."""
    found = on_values(program, x)
    for tie in program.ties:
        found[list(tie.axes)] = tie.table[tie.chosen(found)]
    return found
