"""Optima at which poles meet: the best least decay rate, or least damping ratio, is a multiple pole.

There a pole has no slope and a gradient goes astray.  The polynomial whose roots the poles are is
smooth: "this polynomial has an m-fold root there" is m smooth equations, and the best design that
keeps them is found by Newton.  Which poles meet is read off a design nearby, by several guesses;
a guess counts only where the design that it leads to is measured to be better.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.forms.damped import OfPoles
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import characteristic, rates_and_shapes
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass

_NEAR = (0.01, 0.03, 0.1, 0.2, 0.35, 0.6)
"""Distance over frequency at which poles are guessed to belong together."""
_STEP = 1e-5
_ROUNDS = 40
_SMALL = 1e-13
_MARGINS = (1e-6, 1e-5, 1e-4)
"""Parts of a lower limit by which meeting poles must lie beyond it: rounding parts them by the root of itself."""


@dataclass(frozen=True, slots=True)
class Cluster:
    """Poles that are to meet: how many of them in one place, and its frequency over the scale (0: real)."""

    count: int
    height: float


@dataclass(frozen=True, slots=True)
class Question:
    """Least decay rate or damping ratio: to be made greatest, or (with `aim`) held at `bound` while the aim is met."""

    model: Model
    form: OfPoles
    aim: Aim | None = None
    bound: float = 0.0


def question(program: Program) -> Question | None:
    """The least decay rate or damping ratio of a program, as its goal or as a lower limit; None without one."""
    aim = program.aim
    if aim is None:
        return None
    form = _of_poles(aim)
    if form is not None and aim.sense < 0:
        return Question(aim.model, form)
    for limit in program.limits:
        form = _of_poles(limit)
        if form is not None and limit.side == "at_least":
            return Question(limit.model, form, aim, limit.bound)
    return None


def _of_poles(part: Limit | Aim) -> OfPoles | None:
    form = part.form.poles
    return form if form is not None and form.meet(part.model) else None


def polished(
    program: Program,
    y: FloatArray,
    ends: tuple[FloatArray, FloatArray],
    holds: Callable[[FloatArray], bool],
    goal: Callable[[FloatArray], float],
) -> FloatArray:
    """The best design near `y` (n_vars,) at which poles meet; `y` itself where none is better.

    Parameters
    ----------
    program, y
        What is asked, and a design y = log x nearby.
    ends
        Least and greatest y.
    holds, goal
        Exact judgement of a design: whether every limit holds, and the goal to be minimised.
    """
    asked = question(program)
    if asked is None:
        return y
    best, value = y, goal(y) if holds(y) else float("inf")
    for there in _merged(asked, y, *ends):
        if goal(there) < value and holds(there):
            best, value = there, goal(there)
    return best


def _merged(asked: Question, y: FloatArray, low: FloatArray, high: FloatArray) -> Iterator[FloatArray]:
    """Designs within the ends near `y` at which poles meet."""
    wide = high > low
    inside = wide & (y > low + 1e-6) & (y < high - 1e-6)
    for free in (inside,) if (inside == wide).all() else (inside, wide):  # at ends of ranges they may be left
        for clusters, level, scale in _guesses(asked, y):
            for margin in _MARGINS if asked.aim is not None else (0.0,):
                there = _Meeting(asked, y, free, clusters, scale, margin).solve(level)
                if there is None or not np.isfinite(there).all():
                    break
                there = np.clip(there, low, high)
                reached = asked.form.value(asked.model, np.exp(there))
                if asked.aim is None or reached > asked.bound * (1.0 + 0.5 * margin):
                    yield there
                    break


def _guesses(asked: Question, y: FloatArray) -> Iterator[tuple[tuple[Cluster, ...], float, float]]:
    """Clusters of poles near the least, the level that they begin with, and the scale of frequency."""
    rates, _ = rates_and_shapes(asked.model, asked.model.values(np.exp(y)))
    if not len(rates):
        return
    scale = float(np.exp(np.log(np.abs(rates)).mean()))
    s = rates / scale
    ratio, level = asked.form.relative, asked.form.level(s)
    seen = set()
    for near in _NEAR:
        active = s[level <= level.min() + near * (1.0 if ratio else np.abs(s[level.argmin()]))]
        for flat in (False, True):
            clusters = _clusters(active, near, flat=flat and not ratio)
            key = tuple((cluster.count, round(cluster.height, 6)) for cluster in clusters)
            if clusters and key not in seen:
                seen.add(key)
                yield clusters, float(level[np.isin(s, active)].mean()), scale


def _clusters(active: ComplexArray, near: float, *, flat: bool) -> tuple[Cluster, ...]:
    """Poles grouped by distance; with `flat`, those near the real axis meet their conjugates on it."""
    groups: list[list[complex]] = []
    for one in sorted(active, key=lambda s: float(s.imag)):
        home = next((g for g in groups if min(abs(one - other) for other in g) <= near * abs(one)), None)
        if home is None:
            groups.append([complex(one)])
        else:
            home.append(complex(one))
    made = []
    for group in groups:
        height = float(np.mean([one.imag for one in group]))
        size = float(np.mean([abs(one) for one in group]))
        real = [one for one in group if one.imag <= 1e-12 * abs(one)]
        if flat and height <= max(near, 0.3) * size:
            made.append(Cluster(2 * len(group) - len(real), 0.0))
        elif len(real) == len(group):
            made.append(Cluster(len(group), 0.0))
        elif not real:
            made.append(Cluster(len(group), height))
        else:
            return ()
    return tuple(made)


@dataclass(frozen=True)
class _Meeting:
    """Newton's search for the best design at which the poles of each cluster meet on the common level.

    The unknowns are the free variables, the level where it is to be found, and the height of each cluster
    off the real axis.
    """

    asked: Question
    y: FloatArray
    free: BoolArray
    clusters: tuple[Cluster, ...]
    scale: float
    margin: float

    def solve(self, level: float) -> FloatArray | None:
        """The design y (n_vars,), or None where Newton does not get there."""
        if not self.free.any():
            return None
        begin = [level] if self.asked.aim is None else []
        heights = [cluster.height for cluster in self.clusters if cluster.height > 0.0]
        v = np.concatenate([self.y[self.free], begin, heights])
        weights: FloatArray | None = None
        for _ in range(_ROUNDS):
            values, table = self._rows(v), self._table(v)
            if not (np.isfinite(values).all() and np.isfinite(table).all()):
                return None
            if len(values) >= len(v):
                step = np.linalg.lstsq(table, -values, rcond=1e-12)[0]
            else:
                step, weights = self._best_step(v, values, table, weights)
            size = float(np.abs(step).max(initial=0.0))
            v = v + step * min(1.0, 0.3 / max(size, 1e-300))
            if size < _SMALL * max(1.0, float(np.abs(v).max())):
                break
        if float(np.abs(self._rows(v)).max()) > 1e-9:
            return None
        return self._design(v)

    def _design(self, v: FloatArray) -> FloatArray:
        found = np.broadcast_to(self.y, (*v.shape[:-1], len(self.y))).copy()
        found[..., self.free] = v[..., : int(self.free.sum())]
        return found

    def _wanted(self, v: FloatArray) -> FloatArray:
        """Slope of what is to be made least."""
        wanted, count = np.zeros(len(v)), int(self.free.sum())
        aim = self.asked.aim
        if aim is None:
            wanted[count] = -1.0
        else:
            x = np.exp(self._design(v))
            worst = aim.extremes(x)[0]
            wanted[:count] = aim.sense * worst.slope[self.free]
        return wanted

    def _best_step(
        self, v: FloatArray, values: FloatArray, table: FloatArray, weights: FloatArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """Newton step of the conditions of an optimum, with all poles in their places."""
        wanted = self._wanted(v)
        held = np.asarray(np.linalg.lstsq(table.T, -wanted, rcond=None)[0]) if weights is None else weights
        n, m, wide = len(v), len(values), 10.0 * _STEP
        ahead, back = v + wide * np.eye(n), v - wide * np.eye(n)
        bend = held @ (self._table(ahead) - self._table(back))
        if self.asked.aim is not None:
            bend = bend + [self._wanted(up) - self._wanted(down) for up, down in zip(ahead, back, strict=True)]
        bend = bend / (2.0 * wide)
        matrix = np.zeros((n + m, n + m))
        matrix[:n, :n] = 0.5 * (bend + bend.T)
        matrix[:n, n:] = table.T
        matrix[n:, :n] = table
        right = np.concatenate([-(wanted + table.T @ held), -values])
        solved = np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-13)[0])
        return solved[:n], held + solved[n:]

    def _table(self, v: FloatArray) -> FloatArray:
        """Slopes of the rows (..., n_rows, n), by central differences: all of many v (..., n) side by side."""
        step = _STEP * np.eye(v.shape[-1])
        rows = self._rows(v[..., None, :] + np.array([step, -step]).reshape(2, *[1] * (v.ndim - 1), *step.shape))
        return np.asarray((rows[0] - rows[1]) / (2.0 * _STEP)).mT

    def _rows(self, v: FloatArray) -> FloatArray:
        """The polynomial and its derivatives at the place of each cluster, of each v (..., n): (..., n_rows)."""
        asked, count = self.asked, int(self.free.sum())
        y = self._design(v)
        numbers = np.moveaxis(characteristic(asked.model, asked.model.values(np.exp(y)), self.scale), -1, 0)
        if asked.aim is None:
            level, rest = v[..., count], v[..., count + 1 :]
        else:
            bound = asked.bound * (1.0 + self.margin) / (1.0 if asked.form.relative else self.scale)
            level, rest = np.full(v.shape[:-1], bound), v[..., count:]
        heights = iter(np.moveaxis(rest, -1, 0))
        rows: list[FloatArray] = []
        for cluster in self.clusters:
            height = next(heights) if cluster.height > 0.0 else np.zeros(v.shape[:-1])
            s = asked.form.place(level, height)
            derivative = numbers.astype(complex)
            for order in range(cluster.count):
                value = np.polynomial.polynomial.polyval(s, derivative, tensor=False)
                rows += [value.real, value.imag] if cluster.height > 0.0 else [value.real]
                derivative = np.polynomial.polynomial.polyder(derivative) / (order + 1.0)
        return np.stack(rows, axis=-1)
