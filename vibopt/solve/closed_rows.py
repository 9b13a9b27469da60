"""Limits of one-mass questions as rows a k^2 + b k + g + d q <= 0, q = c^2, and the extreme point of many such sets.

With one variable k is that variable, and d = 0.  Of one question alone (`LoneRows`) all are plain floats.
"""

from __future__ import annotations

from math import copysign, inf, isfinite, sqrt

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray, every, some
from vibopt.records import dataclass
from vibopt.solve.closed_program import Number, Numbers, Question, coefficients

_ROOM = 4e-15
_FLAT = 1e-14
"""Part of its terms below which what stands before q is rounding."""
_TOUCH = 1e-14
_NO_ROW = np.array([0.0, 0.0, -1e250])[:, None, None]


def take(numbers: Numbers, chosen: IntArray | BoolArray | slice) -> dict[str, Number]:
    """The numbers of some of the questions."""
    return {name: number[chosen] if isinstance(number, np.ndarray) else number for name, number in numbers.items()}


def plain_row(asked: Question, numbers: Numbers, index: int) -> list[Number]:
    """Row of a limit without speeds: a, b, g, d."""
    kind = asked.rows[index]
    bound = numbers[f"{index}.bound"]
    k0, k1, m0, m1 = (numbers[name] for name in ("K0", "K1", "M0", "M1"))
    a = b = g = d = 0.0
    if kind.kind == "frequency":
        b, g = k1 - bound**2 * m1, k0 - bound**2 * m0
    elif kind.kind == "static":
        s0, s1, gravity = (numbers[f"{index}.{name}"] for name in ("S0", "S1", "gravity"))
        b, g = gravity * m1 - bound * s1, gravity * m0 - bound * s0
    elif kind.kind == "damping":
        z = 4.0 * bound**2
        c0, c1, ch = (numbers[name] for name in ("C0", "C1", "Ch"))
        a, b, g = -z * k1 * m1, -z * (k0 * m1 + k1 * m0), c0**2 - z * k0 * m0
        if asked.plane:
            d = c1**2
        else:
            a, b = a + c1**2, b + 2.0 * c0 * c1 + ch**2
    else:
        a, b, g, d = _monomial(asked, numbers, index)
    return [a, b, g, d] if kind.sign > 0.0 else [-a, -b, -g, -d]


def _monomial(asked: Question, numbers: Numbers, index: int) -> tuple[Number, Number, Number, Number]:
    kind, bound = asked.rows[index], numbers[f"{index}.bound"]
    if asked.plane:
        bound = bound / numbers[f"{index}.scale0"]
        on_k = kind.exponents[0][asked.order[0]] == 1.0
        return (0.0, 1.0, -bound, 0.0) if on_k else (0.0, 0.0, -(bound**2), 1.0)
    parts: list[Number] = [0.0, 0.0, 0.0]
    for j, (power,) in enumerate(kind.exponents):
        parts[int(power)] = parts[int(power)] + numbers[f"{index}.scale{j}"]
    return parts[2], parts[1], parts[0] - bound, 0.0


def harmonic_row(asked: Question, numbers: Numbers, index: int, w: Number) -> list[Number]:
    """Rows of a limit at squared frequencies: a, b, g, d, each of the shape of w, or one number for all of them."""
    kind = asked.rows[index]
    bound = numbers[f"{index}.bound"] ** 2
    row = [-bound * one for one in _square(numbers, "", w, inertia=True)]
    lead = numbers[f"{index}.size"] ** 2
    if kind.tabled is not None:
        lead = lead * kind.amplitude(w**0.5) ** 2
    if kind.power:
        lead = lead * w ** float(kind.power)
    if kind.inertia:
        lead = lead * numbers["M0"] ** 2
    if kind.through:
        top = _square(numbers, f"{index}.", w, inertia=False)
        bare = row[3]
        row = [lead * t + one for t, one in zip(top, row, strict=True)]
        row[3] = row[3] * (abs(row[3]) > _FLAT * abs(bare))
    else:
        row[2] = row[2] + lead
    if not asked.plane:
        row[0], row[3] = row[0] + row[3], 0.0
    return row if kind.sign > 0.0 else [-one for one in row]


def _square(numbers: Numbers, prefix: str, w: Number, *, inertia: bool) -> list[Number]:
    """|z|^2 of an impedance: coefficients of k^2, k, 1 and of the damping that is chosen, squared."""
    m0, m1, k0, k1, c0, c1, ch, h0, h1 = coefficients(prefix)(numbers)
    has = some if isinstance(w, np.ndarray) else bool
    if inertia:
        k0 = k0 - m0 * w
        if has(m1):
            k1 = k1 - m1 * w
    a, b, g = k1**2, 2.0 * k0 * k1, k0**2
    d = c1**2 * w
    if has(ch):
        b = b + ch**2 * w
    if has(h0) or has(h1) or has(c0):
        omega = w**0.5
        real, steep = omega * c0 + h0, h1
        a = a + steep**2 + 2.0 * omega * c1 * steep
        b = b + 2.0 * real * (omega * c1 + steep)
        g = g + real**2
    return [a, b, g, d]


def stacked(parts: list[Number], n: int, count: int) -> FloatArray:
    """Rows of many questions, (4, n, count)."""
    table = np.empty((4, n, count))
    for place, part in enumerate(parts):
        table[place] = part
    return table


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of many questions as q + S(k) <= 0, S(k) - q <= 0 and S(k) <= 0: a, b, g of S, each (3, n, count)."""

    upper: FloatArray
    lower: FloatArray
    walls: FloatArray

    @classmethod
    def of(cls, asked: Question, table: FloatArray) -> Rows:
        """Of rows a k^2 + b k + g + d q <= 0, shape (4, n, count)."""
        if not asked.plane:
            return cls(table[:3, :0], table[:3, :0], table[:3])
        d = table[3]
        scaled = table[:3] / np.where(d == 0.0, 1.0, np.abs(d))
        up, down = d > 0.0, d < 0.0
        if d.shape[1] == 1:
            return cls(*(scaled[:, here[:, 0]] for here in (up, down, ~(up | down))))
        return cls(*(_chosen(scaled, here) for here in (up, down, ~(up | down))))

    def plus(self, other: Rows) -> Rows:
        """These rows and others."""
        parts = (self.upper, other.upper), (self.lower, other.lower), (self.walls, other.walls)
        return Rows(*(np.concatenate(two, axis=1) if two[1].shape[1] else two[0] for two in parts))

    def some(self, chosen: BoolArray) -> Rows:
        """Those of some of the questions."""
        return Rows(*(one.compress(chosen, axis=2) for one in (self.upper, self.lower, self.walls)))


def _chosen(rows: FloatArray, here: BoolArray) -> FloatArray:
    """The rows of a side (3, n, count); what is of another side asks for nothing."""
    there = np.logical_or.reduce(here, axis=1)
    rows, here = rows[:, there], here[there]
    return rows if every(here) else np.where(here, rows, _NO_ROW)


def ends_of_damping(asked: Question) -> list[list[float]]:
    """Rows for the range of the damping, an open end left out; of one variable none."""
    if not asked.plane:
        return []
    rows = [[0.0, 0.0, asked.low[1] ** 2, -1.0], [0.0, 0.0, -(asked.high[1] ** 2), 1.0]]
    return rows[: 1 if _damping_open(asked) else 2]


def _damping_open(asked: Question) -> bool:
    """Whether the damping may go as far as it likes: it may not where it is the goal."""
    return asked.opened[1] and asked.goal[0] == 0


def extreme(asked: Question, rows: Rows) -> tuple[FloatArray, FloatArray]:
    """The best point of each question, and how far its ranges were looked through, both (n_vars, count).

    Returns
    -------
    tuple
        k, and c where there is one, nan where no point meets all rows; the far end of an open range where the best
        point lies on it, else infinity.
    """
    (place, sense), span, count = asked.goal, _span(asked), rows.walls.shape[2]
    if not asked.plane:
        k, reach = _outermost(rows.walls, span, sense)
        return k[None], reach[None]
    pairs = (rows.upper[:, :, None] + rows.lower[:, None]).reshape(3, -1, count)
    must = np.concatenate([pairs, rows.walls], axis=1)
    if place == 0:
        k, reach = _outermost(must, span, sense)
        a, b, g = rows.lower
        q = ((a * k + b) * k + g).max(axis=0)
    else:
        reach = np.full(count, asked.high[0])
        k, q = _outermost_damping(rows, must, span, sense)
    c = np.sqrt(np.maximum(q, asked.low[1] ** 2)) + 0.0 * k  # nan where k is
    most = np.inf if _damping_open(asked) else asked.high[1]
    return np.array([k, np.minimum(c, most)]), np.array([reach, np.full(count, most)])


def _span(asked: Question) -> tuple[float, float, float]:
    """Least and greatest k, infinite where an open end is looked for, and the far end that stands for it."""
    opened = asked.opened[:1] == (True,) and asked.goal[0] == 0
    return asked.low[0], inf if opened else asked.high[0], asked.high[0]


class LoneRows:
    """`Rows` and `extreme` of one question, of which k is looked for: the same in plain floats.

    Rows are only added, so that k goes on from where it was.
    """

    def __init__(self, asked: Question) -> None:
        self.asked, self.sense = asked, asked.goal[1]
        low, high, self.far = _span(asked)
        self.start, self.stop = (high, low) if self.sense > 0.0 else (-low, -high)
        self.k = self.start
        self.upper: list[tuple[float, float, float]] = []
        self.lower: list[tuple[float, float, float]] = []
        self.steps: list[tuple[float, float, float, float]] = []

    def add(self, row: list[float]) -> None:
        """One row a, b, g, d more."""
        a, b, g, d = row
        if d == 0.0:
            self.steps.append(_step(a, self.sense * b, g))
            return
        own, others = (self.upper, self.lower) if d > 0.0 else (self.lower, self.upper)
        a, b, g = a / abs(d), b / abs(d), g / abs(d)
        own.append((a, b, g))
        self.steps += [_step(a + one[0], self.sense * (b + one[1]), g + one[2]) for one in others]

    def extreme(self) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        """The best point, and how far its ranges were looked through; None where no point meets all rows."""
        asked, new, reach = self.asked, self.k, inf
        for _ in range(2 * len(self.steps) + 2):
            k = new
            for first, cap, rest, _ in self.steps:
                new = min(new, cap if k >= first else rest)
            if new == k:
                break
        self.k = k = new
        if k == inf:
            k = reach = max(4.0 * max((abs(one[3]) for one in self.steps if isfinite(one[3])), default=0.0), self.far)
        if not k >= self.stop or k == -inf:
            return None
        k *= self.sense
        if not asked.plane:
            return (k,), (reach,)
        q = max((a * k + b) * k + g for a, b, g in self.lower)
        most = inf if _damping_open(asked) else asked.high[1]
        return (k, min(sqrt(max(q, asked.low[1] ** 2)), most)), (reach, most)


def _step(a: float, b: float, g: float) -> tuple[float, float, float, float]:
    """As in `_outermost`: from where on k may be as great as what comes next, or else what then; its greater root."""
    a += 0.0
    four, squared = 4.0 * a * g, b * b
    square = squared - four + copysign(_TOUCH * (squared + abs(four)), a)
    if not square >= 0.0 or (a == 0.0 and b == 0.0):
        good = g <= 0.0 if a == 0.0 else a < 0.0
        return (-inf, inf, -inf, inf) if good else (inf, -inf, -inf, inf)
    large = -0.5 * (b + copysign(sqrt(square), b))
    one = large / a if a else copysign(inf, large)
    two = g / large if large else one
    left, right = (one, two) if one <= two else (two, one)
    first, cap, rest = (left, right, -inf) if a >= 0.0 else (right, inf, left)
    return first - _ROOM * abs(first), cap, rest, right


def _roots(a: FloatArray, b: FloatArray, g: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Both roots of quadratics, the lesser first, inf and nan where there are none.

    What touches zero up to rounding touches it: the values count as a little less than they are.
    """
    four, squared = 4.0 * a * g, b * b
    square = squared - four + np.copysign(_TOUCH * (squared + np.abs(four)), a)
    large = -0.5 * (b + np.copysign(np.sqrt(square), b))
    one, two = large / a, g / large
    return np.fmin(one, two), np.fmax(one, two)


def _outermost(rows: FloatArray, span: tuple[float, float, float], sense: float) -> tuple[FloatArray, FloatArray]:
    """The greatest (least) k in [low, high] at which no row (3, n, count) is positive, nan where there is none.

    A row alone says how far k must go down at least; where no row moves it any more, all rows hold.  An infinite `high`
    becomes a far one, which is told beside k.
    """
    low, high, far = span
    start, stop = (high, low) if sense > 0.0 else (-low, -high)
    a, b, g = rows[0] + 0.0, sense * rows[1], rows[2]
    left, right = _roots(a, b, g)
    up, flat = a >= 0.0, a == 0.0
    same = np.isnan(left) | (flat & (b == 0.0))  # of one sign everywhere
    if some(same):
        left = np.where(same, np.where(np.where(flat, g <= 0.0, ~up), -np.inf, np.inf), left)
        right = np.where(same, -left, right)
        up |= same
    first, cap, rest = np.where(up, left, right), np.where(up, right, np.inf), np.where(up, -np.inf, left)
    first = first - _ROOM * np.abs(first)
    k = np.full(rows.shape[2], start)
    for _ in range(2 * rows.shape[1] + 2):
        new = np.minimum(k, np.minimum.reduce(np.where(k >= first, cap, rest), axis=0, initial=start))
        if every(new == k):
            break
        k = new
    reach = np.full(rows.shape[2], np.inf)
    if start == np.inf and some(np.isposinf(k)):
        ends = 4.0 * np.where(np.isfinite(right), np.abs(right), 0.0).max(axis=0, initial=0.0)
        reach = np.where(np.isposinf(k), np.maximum(ends, far), np.inf)
        k = np.minimum(k, reach)
    return np.where((k >= stop) & (k > -inf), sense * k, np.nan), reach


def _outermost_damping(
    rows: Rows, must: FloatArray, span: tuple[float, float, float], sense: float
) -> tuple[FloatArray, FloatArray]:
    """k and the greatest (least) q = c^2, by enumeration of every k at which it can be; nan where no point is good.

    `must` are the sums of an upper and a lower row, and the walls.  None is positive where the greatest upper and the
    greatest lower row add to nothing more than rounding.
    """
    low, high, _ = span
    side = rows.upper if sense > 0.0 else rows.lower
    i, j = np.triu_indices(side.shape[1], 1)
    cuts = [*_roots(*must), *_roots(*(side[:, i] - side[:, j])), -side[1] / (2.0 * side[0])]
    ends = np.broadcast_to(np.array([[low], [high]]), (2, side.shape[2]))
    k = np.concatenate([*cuts, ends])
    k = np.where((k >= low) & (k <= high), k, low)
    k = np.unique(k)[:, None] if k.shape[1] == 1 else k
    (above, room), (below, more), (wall, most) = (_greatest(some, k) for some in (rows.upper, rows.lower, rows.walls))
    good = (above + below <= room + more) & (wall <= most)
    value = above if sense > 0.0 else below
    at, columns = np.where(good, value, np.inf).argmin(axis=0), np.arange(side.shape[2])
    best = np.where(good[at, columns], k[at, columns], np.nan)
    return best, -sense * value[at, columns]


def _greatest(rows: FloatArray, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The greatest of some rows (3, n, count) at each k (n_k, count), -inf of none, and what of it is rounding."""
    if not rows.shape[1]:
        return np.full(k.shape, -np.inf), np.zeros(k.shape)
    values = (rows[0][:, None] * k + rows[1][:, None]) * k + rows[2][:, None]
    at = values.argmax(axis=0)
    a, b, g = np.abs(rows[:, at, np.arange(k.shape[1])])
    return np.take_along_axis(values, at[None], axis=0)[0], 4.0 * _TOUCH * ((a * k + b) * k + g)
