"""How much better any design could be: a bound beside what starts have led to, by boxes of several variables.

On a box every response at a sampled speed lies above a row that is linear in the logs of the variables
(`rows_on_boxes`).  With weights of the goal's rows that sum to one, and any weights of the limits', the least of their
sum on the box is a bound of the goal: what a linear program would say, of which any weights say no more than is true.
Boxes are split, those that promise most first, until none promises more than the gap or all are counted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms.bounds import FormBounds
from vibopt.forms.monomials import Monomials, mounts
from vibopt.forms.rational import Sampled
from vibopt.forms.rows_on_boxes import Rows, coefficients, power_rows, response_rows
from vibopt.frontier import Frontier
from vibopt.mechanics.monomial import Monomial
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import cached_property, dataclass
from vibopt.solve.boundable import FAR, no_rows, refusal
from vibopt.solve.branch import first_speeds, may_hold
from vibopt.solve.hanging import masses_on_springs
from vibopt.solve.hung_boxes import MOST, HungBoxes
from vibopt.solve.interchange import orders
from vibopt.solve.log_boxes import LogBoxes
from vibopt.solve.method import Found, Told
from vibopt.solve.ranges import FLOOR
from vibopt.work import Budget

NAME = "boxes"
_GAP = 1e-6
"""Part of the goal that an optimum may be away from its bound."""
_WORK, _COST = 120_000, 0.02
"""Coefficients of responses on all boxes together, and the work of each of them [nominal ms]."""
_PATIENCE, _HOPELESS, _FIRST = 0.3, 2.0, 1000
"""Part of the boxes by which something must be known, the log within which it counts as such, and boxes that are
looked at before any search whether there is a design."""
_EARLY, _LITTLE = 0.33, 0.7
"""Part of these boxes after which so much of the way to the goal must be gained for the others to be looked at."""
_WHOLE = 4
"""Variables of devices on one host of which all boxes are looked at: mostly they prove all, and they rise late where
devices can take turns."""
_PLANE = 2
"""Variables up to which a search for a design is as quick as boxes that say there is none."""
_BATCH, _SPEEDS, _MOST_TURNS = 128, 64, 400
"""Boxes that are cut together at most, speeds, and turns: where all that is left open is at one end boxes are few."""
_ROWS, _STEPS = 16, 10
"""Rows of the goal and of the limits that are weighed, and steps of it."""
_LOW, _TINY = 1e3, 1e-14
"""How far below the others a row says nothing, in slopes over a box, and what rounding may take of these."""
_NOTHING, _LONG = -1e3, 0.5
"""A bound that is none, and the part of what is open that the length of a side counts beside what its halves promise:
halves of a long side promise little at first, and halves of a short one less each time."""
_TOLD = 0.02
"""Part of what is open by which the speeds known may miss a peak."""
_TURNS, _AGAIN, _NEAR = 3, 0.25, 0.02
"""How often a box is cut by what its sides promised before they are tried again, what is left of it for a side, and how
near (in logs) to what is to be proven: farther away promises are not kept."""
_HANDED, _CHEAP = 0.1, 16
"""How near (in logs) to what is to be proven boxes are that discs leave to rows, and how many more there may be."""
_SOON, _LEFT = 16_000, 2000
"""Boxes by which discs of several places come so near, and leave so few, that rows need not begin anew."""
_HOLDS = 1e-8
_SAME = 1e-9
"""Difference of logs that rounding may make."""


def with_least(
    program: Program, found: Found, known: Callable[[], float] = lambda: float("nan"), told: Told | None = None
) -> Found:
    """An answer that starts have led to with what boxes prove about it: optimal, or how far from it at most.

    They are not looked at to the end where they promise no better bound than the one `known`, which is asked for only
    then, nor again for a goal that they have `told` of.  Where nothing was found and no box may hold a design, that
    there is none.
    """
    aim = program.aim
    if found.status == "unproven":
        return none_holds(program) or found
    if found.status != "feasible" or found.x is None or aim is None or refusal(program, aim.pieces):
        return found
    value = max(piece.sense * piece.form.value(piece.model, found.x) for piece in aim.pieces)
    if not 0.0 < abs(value) < np.inf:
        return found
    sign = float(np.sign(value))
    best = sign * float(np.log(abs(value)))

    def floor() -> float:
        bounds = [sign * float(np.log(abs(one))) for one in (known(), found.bound) if one * sign > 0.0]
        return max([*bounds, best - _HOPELESS])

    told = {} if told is None else told
    goal = next((one for one in told if abs(one - best) <= _SAME), best)
    if goal not in told:
        boxes = _Relaxed(program, aim.pieces)
        boxes.learn(found.x)
        told[goal] = boxes.search(best + float(np.log1p(-_GAP)), floor), boxes.counted
    least, budget = told[goal]
    bound = sign * float(np.exp(sign * least))
    details = {**found.details, "boxes": budget.spent, "bound": bound}
    if best - least <= 1.01 * _GAP:
        claim = f"proven by {budget} of all variables: nothing is better by more than {_GAP:.0e} of the goal"
        return replace(found, status="optimal", claim=claim, bound=bound, details=details)
    part = 100.0 * abs(float(np.expm1(sign * (best - least))))
    if not best - least < np.inf or found.bound >= bound:
        return found
    if best - least > FAR:
        return replace(found, bound=bound, details=details)
    way = "above the least" if sign > 0.0 else "below the greatest"
    claim = f"{found.claim}; at most {_no_less(part)} % {way} possible"
    return replace(found, claim=claim, bound=bound, details=details)


def _no_less(percent: float) -> str:
    """Two digits of a number above zero, whole from ten on, rounded up: never less than what is true."""
    step = min(10.0 ** (np.floor(np.log10(percent)) - 1.0), 1.0)
    return f"{np.ceil(percent / step * (1.0 - 1e-12)) * step:.{max(0, round(-np.log10(step)))}f}"


def none_holds(program: Program, most: int = _WORK) -> Found | None:
    """That no design keeps all limits, where that many boxes prove it."""
    if refusal(program, program.limits):
        return None
    boxes = _Relaxed(program, (), most)
    if boxes.search(_HOLDS) < _HOLDS:
        return None
    claim = f"proven by boxes of all variables: every one of {boxes.counted} breaks a limit"
    return Found("infeasible", None, claim, NAME, details={"boxes": boxes.counted.spent})


def hopeless(program: Program) -> Found | None:
    """The same before a search that takes longer, where few boxes show it; one of two variables is as quick."""
    free = sum(axis.values is None and axis.high > axis.low for axis in program.axes)
    return none_holds(program, _FIRST) if free > _PLANE else None


_Open = tuple[FloatArray, FloatArray, FloatArray]
"""Boxes with what the log of the goal is at least there, (n_boxes,), and their logs, low and high (n_boxes, n_vars)."""


class _Relaxed:
    """The rows of a program on boxes, and the search with them; without goals, of limits that cannot hold together."""

    def __init__(self, program: Program, aims: Sequence[Aim], most: int = _WORK) -> None:
        self.program = program
        kept = [limit for limit in program.limits if not no_rows(limit)]
        self.goals: Sequence[Limit | Aim] = list(aims) or kept
        self.limits: Sequence[Limit] = kept if aims else []
        self.lines = {id(one): _Speeds(program, one) for one in (*self.goals, *self.limits) if one.form.powers is None}
        middle = np.sqrt(np.maximum(program.low, FLOOR * program.high) * program.high)
        others = [limit for limit in program.limits if no_rows(limit) and (limit.side == "outside" or _still(limit))]
        self.others = [(limit, FormBounds(limit.model, limit.form, middle)) for limit in others]
        asked = (*self.goals, *self.limits, *others)
        sampled = {key: line.sampled for key, line in self.lines.items()}
        self.space = LogBoxes(program, tuple(orders(program, asked, sampled)))
        each = sum(line.count for line in self.lines.values()) or 1
        self.budget = Budget(min(most, max(_WORK // each, 1)), "boxes", _COST * each)
        self.hung = self._hung(min(_CHEAP * most, MOST)) if len(program.axes) > _PLANE else None

    def _hung(self, most: int) -> HungBoxes | None:
        """What discs say of these boxes, of so many; None where that is nothing."""
        hung = HungBoxes(self.space, self.goals, self.limits, most)
        return hung if hung.says else None

    @property
    def counted(self) -> Budget:
        """All boxes that were looked at."""
        return replace(self.budget, spent=self.budget.spent + (0 if self.hung is None else self.hung.budget.spent))

    def learn(self, x: FloatArray, open_: float = 1e-3) -> None:
        """Look at the speeds at which the design x (n_vars,) is worst, where those known say too little of them.

        Little is judged by what is still open of the log of the goal.
        """
        for line in self.lines.values():
            line.learn(x, open_)

    def search(self, bar: float, floor: Callable[[], float] = lambda: -np.inf) -> float:
        """No log of the goal is below this, at most `bar`; given up far below `floor`, early where it hardly moves.

        Where all acts on one place discs leave few boxes to rows, and close what these leave.  On several they do so
        where they soon come near, and else take what rows leave.
        """
        whole = np.array([-np.inf]), *self.space.whole
        if self.hung is None:
            return self._by_rows(whole, bar, floor)[0]
        told, left = self._by_discs(whole, bar, floor, _HANDED, _SOON if self.hung.places > 1 else np.inf)
        if told <= bar - _HANDED and self.hung.places == 1:
            return max(told, self._by_rows(whole, bar, lambda: max(told, floor()))[0])
        far = told <= bar - _HANDED or len(left[0]) > _LEFT
        found, open_ = self._by_rows(whole if far else left, bar, floor)
        return max(told, found, self._by_discs(open_ if found >= told else left, bar, floor, 0.0)[0])

    def _by_discs(
        self, boxes: _Open, bar: float, floor: Callable[[], float], near: float, most: float = np.inf
    ) -> tuple[float, _Open]:
        """The same of boxes with a bound each until all are `near` the bar, and what of them stays open."""
        assert self.hung is not None
        if not len(boxes[0]):
            return -np.inf, boxes
        left = self.hung.left(boxes, bar, floor, near, most)
        return float(left[0].min(initial=bar)), left

    def _by_rows(self, given: _Open, bar: float, floor: Callable[[], float]) -> tuple[float, _Open]:
        """The same of some boxes, and what of them stays open."""
        frontier, (bound, low, high) = Frontier(self.budget), given
        frontier.add(bound, low, high, np.zeros(low.shape), np.zeros(len(low)))
        begun, least, turns = np.inf, np.inf, Budget(_MOST_TURNS, "turns")
        hosts = [device.host for device in masses_on_springs(self.program) if device.host]
        whole = low.shape[1] <= _WHOLE and len(set(hosts)) < len(hosts)
        while frontier and not frontier.over and not turns.over:
            turns.spend(1)
            begun = min(begun, frontier.bound) if np.isfinite(frontier.bound) else begun
            part = self.budget.spent / (_PATIENCE * self.budget.most)
            slow = part > _EARLY and begun < np.inf and frontier.bound < begun + _LITTLE * (bar - begun)
            if (part > 1.0 or slow) and not whole and frontier.bound < floor():
                break
            boxes = _Boxes(*frontier.take(_BATCH))
            wide: BoolArray = np.any(boxes.high > boxes.low, axis=1)
            if not wide.all():  # what rounding leaves of a range is not measured: it is near to what is known
                points = boxes.chosen(~wide)
                least = min(least, self._of_points(points, bar) if self.space.lists else float(points.bound.min()))
                boxes = boxes.chosen(wide)
            if not wide.any():
                continue
            if least <= min(frontier.bound, float(boxes.bound.min())):
                frontier.add(*boxes.columns)
                break
            self.learn(np.exp(0.5 * (boxes.low + boxes.high)[0]), bar - boxes.bound[0])
            tried = (boxes.turns > 0) & (boxes.bound > bar - _NEAR)
            for some, split in ((boxes.chosen(~tried), self._best_side), (boxes.chosen(tried), self._next_side)):
                if len(some.bound):
                    halves = split(some, bar)
                    frontier.add(*halves.chosen(halves.bound < bar).columns)
        if least < bar or not frontier:
            return min(frontier.bound, least, bar), (bound[:0], low[:0], high[:0])
        return min(frontier.bound, bar), (frontier.bounds, frontier.columns[0], frontier.columns[1])

    def _of_points(self, points: _Boxes, bar: float) -> float:
        """The least bound of single designs, as of listed values, that is below `bar` at their own worst speeds."""
        for x in np.exp(points.low):
            self.learn(x)
        bound = self._on(points.low, points.high, bar)[0]
        return float(bound.min(where=bound < bar, initial=np.inf))

    def _best_side(self, boxes: _Boxes, bar: float) -> _Boxes:
        """Both halves of every box across the side whose halves promise least, and what each side would have gained."""
        low, high = boxes.low, boxes.high
        sides, rows = np.flatnonzero((high > low).any(axis=0)), np.arange(len(low))
        halves = [self.space.halves(low, high, np.full(len(low), side)) for side in sides]
        lows, highs = (np.stack(one, axis=1) for one in zip(*halves, strict=True))  # (2 n_boxes, n_sides, n_vars)
        bound, lows, highs = self._on(lows.reshape(-1, low.shape[1]), highs.reshape(-1, low.shape[1]), bar)
        lows, highs = (one.reshape(len(low), 2, len(sides), -1) for one in (lows, highs))
        bound = np.maximum(bound.reshape(len(low), 2, -1), boxes.bound[:, None, None])
        some = (bound < bar)[..., None]  # what is left of the halves across any side holds all designs
        low = np.where(some, lows, np.inf).min(axis=1).max(axis=1)
        high = np.where(some, highs, -np.inf).max(axis=1).min(axis=1)
        begun = np.clip(boxes.bound, _NOTHING, bar)[:, None]
        gain = _LONG * (bar - begun) * np.minimum(boxes.high - boxes.low, 1.0)
        gain[:, sides] += (np.clip(bound, _NOTHING, bar) - begun[:, None]).sum(axis=1)
        gain[boxes.high <= boxes.low] = 0.0
        best = gain[:, sides].argmax(axis=1)
        gain[rows, sides[best]] *= _AGAIN
        low, high = np.maximum(lows[rows, :, best], low[:, None]), np.minimum(highs[rows, :, best], high[:, None])
        found = np.where((low > high).any(axis=-1), np.inf, bound[rows, :, best]).ravel()
        low, high = (one.reshape(-1, one.shape[-1]) for one in (low, high))
        return _Boxes(found, low, high, gain.repeat(2, axis=0), np.full(len(found), float(_TURNS)))

    def _next_side(self, boxes: _Boxes, bar: float) -> _Boxes:
        """Both halves of every box across the side that would have gained most."""
        gain, rows = np.where(boxes.high > boxes.low, boxes.gain, -np.inf), np.arange(len(boxes.bound))
        side = gain.argmax(axis=1)
        low, high = self.space.halves(boxes.low, boxes.high, side)
        gain = boxes.gain.copy()
        gain[rows, side] *= _AGAIN
        twice = np.repeat(rows, 2)
        bound, low, high = self._on(low, high, bar)
        return _Boxes(np.maximum(bound, boxes.bound[twice]), low, high, gain[twice], boxes.turns[twice] - 1)

    def _on(self, low: FloatArray, high: FloatArray, bar: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Bound of the log of the goal on boxes of logs (n_boxes, n_vars), (n_boxes,); above `bar` any is enough.

        With what is left of each without what its rows say is above `bar`, or breaks a limit.
        Each box counts; inf where they hold the other order of devices that are alike.
        """
        self.budget.spend(len(low))
        x, half = np.exp(0.5 * (low + high)), 0.5 * (high - low)
        fades = self.space.fades(low)
        goals = Rows.joined([self._rows(goal, x, half, fades) for goal in self.goals]).highest(_ROWS)
        limits = [self._rows(limit, x, half, fades) for limit in self.limits]
        every = Rows.joined([goals, Rows.joined(limits).highest(_ROWS)]) if limits else goals
        aims = np.arange(every.value.shape[1]) < goals.value.shape[1]
        bound = _weighed(every, aims, half, bar)
        self._drop(bound, *self.space.ends(low, high), bar)
        bound[self.space.in_other_order(low, high)] = np.inf
        up, down = every.within(np.where(aims, bar, _HOLDS), half)
        listed = [i for i, _ in self.space.lists]
        up[:, listed] = down[:, listed] = np.inf
        return bound, np.maximum(low, high - down), np.minimum(high, low + up)

    def _drop(self, bound: FloatArray, low: FloatArray, high: FloatArray, bar: float) -> None:
        """Boxes (n_boxes, n_vars) on which a limit without rows is broken, as one of a natural frequency, are out."""
        for limit, bounds in self.others:
            open_ = np.flatnonzero(bound < bar)
            held = may_hold(limit, bounds, low[open_] * (1.0 - _SAME), high[open_] * (1.0 + _SAME))
            bound[open_[~held]] = np.inf

    def _rows(self, part: Limit | Aim, x: FloatArray, half: FloatArray, down: BoolArray) -> Rows:
        log = 0.0 if isinstance(part, Aim) else float(np.log(part.bound))
        powers = part.form.powers
        if powers is None:
            line = self.lines[id(part)]
            return response_rows(line.sampled, x, half, down).over(line.mounts, x).less(log)
        least = part.least_wanted
        return power_rows(powers, x, half, down, least=least).less(-log if least else log)


def _still(limit: Limit) -> bool:
    """Whether boxes bound what a limit asks, and that at once: it knows no speeds, no noise and no damping."""
    form = limit.form
    return not (form.drives or form.random or form.poles) and form.harmonic is None and form.bounded(limit.model)


@dataclass(frozen=True, slots=True)
class _Boxes:
    """Boxes of logs, low and high (n_boxes, n_vars), with their bounds and how to cut them.

    gain
        What cutting each side in two would add to the bounds of the halves, (n_boxes, n_vars).
    turns
        How often they are cut by that before all sides are tried again, (n_boxes,).
    """

    bound: FloatArray
    low: FloatArray
    high: FloatArray
    gain: FloatArray
    turns: FloatArray

    @property
    def columns(self) -> tuple[FloatArray, ...]:
        return self.bound, self.low, self.high, self.gain, self.turns

    def chosen(self, some: BoolArray) -> _Boxes:
        return _Boxes(*(column[some] for column in self.columns))


@dataclass
class _Speeds:
    """A response at the speeds that are looked at [rad/s]."""

    program: Program
    part: Limit | Aim
    known: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.sampled: Sampled
        if self.part.form.drives:
            self._add([speed for some in first_speeds(self.part.form).values() for speed in some])
        else:
            self.sampled = self._at([])

    def _at(self, speeds: list[float]) -> Sampled:
        high = self.program.high
        middle = np.sqrt(np.maximum(self.program.low, FLOOR * high) * high)
        return self.part.form.sampled(self.part.model, np.array(speeds), middle)

    @cached_property
    def mounts(self) -> Monomials:
        """Number of mounts that bear what is asked of one."""
        form = self.part.form.harmonic
        return Monomials.of(self.part.model, Monomial(1.0)) if form is None else mounts(self.part.model, form.output)

    @property
    def count(self) -> int:
        """Coefficients of a response."""
        return coefficients(self.sampled)

    def learn(self, x: FloatArray, open_: float) -> None:
        if not self.part.form.drives or len(self.known) >= _SPEEDS:
            return
        found, known = self.part.extremes(x), np.array(self.known)
        with np.errstate(divide="ignore"):
            said = 0.5 * np.log(self.sampled.square(x[None])[0]) - np.log(self.mounts.at(x[None]))
        top = (
            max((local.value for local in found), default=0.0)
            if isinstance(self.part, Aim)
            else np.log(self.part.bound)
        )
        self._add(
            [
                local.speeds[0]
                for local in found
                if local.value >= top - open_
                and not local.value - said[np.abs(known - local.speeds[0]).argmin()] <= _TOLD * open_
            ]
        )

    def _add(self, speeds: list[float]) -> None:
        fresh: list[float] = []
        for speed in speeds:
            if speed > 0.0 and all(abs(speed - old) > 1e-4 * speed for old in [*self.known, *fresh]):
                fresh.append(speed)
        if fresh:
            self.sampled = self.sampled.joined(self._at(fresh)) if self.known else self._at(fresh)
            self.known += fresh


def _weighed(rows: Rows, goal: BoolArray, half: FloatArray, bar: float) -> FloatArray:
    """The greatest bound that rows say alone or weighed against each other, (n_boxes,); above `bar` any is enough."""
    lows = rows.lows(half)
    bound = lows[:, goal].max(axis=1)
    bound[(lows[:, ~goal] > _HOLDS).any(axis=1)] = np.inf
    some = np.flatnonzero((bound < bar) & rows.slope.any(axis=(1, 2)))  # the highest of level rows says it all
    if len(some):
        bound[some] = np.maximum(bound[some], _best_weighed(rows.of(some), goal, half[some]))
    return np.asarray(bound)


def _best_weighed(rows: Rows, goal: BoolArray, half: FloatArray) -> FloatArray:
    """The bound with the multipliers of: least z with rows of the goal <= z, and of limits <= 0, on each box.

    A few steps of a primal-dual interior point method from outside (Wright, 1997), all boxes at once.  Any weights say
    what is true, so the program need not be solved to its end; -inf where no row of the goal says anything.
    """
    (count, many), n = rows.value.shape, half.shape[1]
    known = np.isfinite(rows.value)
    slope, value = np.where(known[..., None], rows.slope * half[:, None], 0.0), np.where(known, rows.value, 0.0)
    top = np.where(known & goal, value, -np.inf).max(axis=1, keepdims=True)
    size = np.abs(slope).max(axis=(1, 2))[:, None] + _TINY
    B, level = np.zeros((count, many + 2 * n, n + 1)), np.full((count, many + 2 * n), -1.0)
    B[:, :many, :n], B[:, :many, n] = slope / size[..., None], -1.0 * goal
    B[:, many:, :n] = np.concatenate([np.eye(n), -np.eye(n)])  # |t| <= 1
    level[:, :many] = np.where(known, ((value - np.where(goal, top, 0.0)) / size).clip(-_LOW, _LOW), -_LOW)
    x = np.tile(np.eye(n + 1)[n], (count, 1))  # t, z
    room, y = np.maximum(-level - _times(B, x), 0.1), np.full(level.shape, 1.0 / many)
    for _ in range(_STEPS):
        missed, pull = level + _times(B, x) + room, np.eye(n + 1)[n] + _times(B.swapaxes(1, 2), y)
        off = room * y - 0.1 / len(y[0]) * (room * y).sum(axis=1, keepdims=True)
        matrix = B.swapaxes(1, 2) @ ((y / room)[..., None] * B)
        right = -pull - _times(B.swapaxes(1, 2), (y * missed - off) / room)
        step = np.linalg.solve(matrix + _TINY * np.eye(n + 1), right[..., None])[..., 0]
        wider = -missed - _times(B, step)
        more = -(off + y * wider) / room
        x, room, y = x + _within(room, wider) * step, room + _within(room, wider) * wider, y + _within(y, more) * more
    weights = np.where(known, y[:, :many], 0.0)
    share = (weights * goal).sum(axis=1, keepdims=True)
    told = np.isfinite(weights).all(axis=1, keepdims=True) & (share > _TINY)
    weights = np.where(told, weights, 0.0) / np.where(told, share, 1.0)
    bound = (weights * value).sum(axis=1) - np.abs(_times(slope.swapaxes(1, 2), weights)).sum(axis=1)
    return np.where(told[:, 0] & np.isfinite(bound), bound, -np.inf)


def _times(matrices: FloatArray, vectors: Any) -> Any:
    """Of each box."""
    return (matrices @ vectors[..., None])[..., 0]


def _within(now: FloatArray, change: FloatArray) -> FloatArray:
    """How much of a change, (n_boxes, 1), leaves numbers above zero, all of it at most."""
    return np.asarray(1.0 / np.maximum((-change / now).max(axis=1, keepdims=True) / 0.95, 1.0))
