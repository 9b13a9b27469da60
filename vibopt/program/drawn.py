"""Machines drawn from the distributions of their tolerances, and what share of all machines that says of."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from contextvars import ContextVar
from dataclasses import replace
from itertools import pairwise
from math import prod

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.errors import InputError
from vibopt.program.program import Limit
from vibopt.records import dataclass
from vibopt.scene.uncertain import Uncertain
from vibopt.values.tolerance import DATA, Scatter
from vibopt.work import late, within

SIZES = (256, 1024, 4096, 16384)
"""Machines that are drawn, until a verdict is reached: each draw begins with all machines of the one before."""
COUNTED = 100_000
"""Machines that are counted one by one at most, where numbers come from data alone."""
RARE = 0.999
"""Share beyond which machines that are drawn from all of them tell nothing."""
MOST_WORK = 20_000.0
"""Work [nominal ms] that drawing machines may take for one limit."""
COMPARED = 4096
"""Machines that are drawn at most, and always where the work allows, for each of several answers that are compared."""
CONFIDENCE = 0.99
"""Of a verdict, over all looks together."""
_HARDLY_EVER = 0.98
"""Of designs of which enough machines keep a limit, how many are told so."""
_ROUNDING = 1e-9
_BATCH = 256
_ALIKE: ContextVar[bool] = ContextVar("the same machines for every answer", default=False)
MET, NOT_MET, OPEN = "met", "not met", "cannot be told"


def drawn_alike() -> AbstractContextManager[None]:
    """The same machines, and as many, for every answer within: what differs then is not for the draw."""
    return within(_ALIKE, True)


def looks(cost: float) -> tuple[tuple[int, ...], float]:
    """Counts of machines after which a verdict is looked for, and the confidence of each look.

    The first look is always done, whatever one machine costs [nominal ms].
    """
    sizes = tuple(size for k, size in enumerate(SIZES) if not k or size * cost <= MOST_WORK)
    if _ALIKE.get():
        return (max(size for size in sizes if size <= COMPARED),), CONFIDENCE
    return sizes, 1.0 - (1.0 - CONFIDENCE) / len(SIZES)


@dataclass(frozen=True, slots=True)
class Sampled:
    """Values of one limit on machines that were drawn.

    values
        As the user counts them [SI], shape (n_drawn,).
    kept
        Whether each keeps the limit.
    confidence
        Of the interval of this one look.
    part
        Share of all machines of which these are drawn; the others are proven to keep the limit.
    counted
        Whether these are all machines that there are, each as likely as the others.
    """

    values: FloatArray
    kept: BoolArray
    confidence: float
    part: float = 1.0
    counted: bool = False

    @property
    def share(self) -> tuple[float, float]:
        """The interval of Clopper and Pearson for the share that keeps the limit; where counted, twice that share."""
        if self.counted:
            return (float(self.kept.mean()),) * 2
        low, high = clopper_pearson(int(self.kept.sum()), len(self.kept), self.confidence)
        return 1.0 - self.part * (1.0 - low), 1.0 - self.part * (1.0 - high)

    def verdict(self, wanted: float) -> str:
        """Whether a share of at least `wanted` keeps the limit."""
        low, high = self.share
        return MET if low >= wanted else NOT_MET if high < wanted else OPEN

    def stays_within(self, wanted: float, *, least: bool) -> float:
        """What a share of `wanted` stays below (above for the least) at the confidence; nan where too few were drawn.

        It is within a bound just where the verdict on that bound is MET.
        """
        ordered = np.sort(-self.values if least else self.values)
        if self.counted:
            fewest = max(int(np.ceil(wanted * len(ordered) - _ROUNDING)), 1)
        else:
            fewest = fewest_kept(1.0 - (1.0 - wanted) / self.part, len(ordered), self.confidence)
        if fewest > len(ordered):
            return float("nan")
        return float(-ordered[fewest - 1] if least else ordered[fewest - 1])


def until_told(sample: Callable[[slice], Sampled], sizes: Sequence[int], wanted: float) -> Sampled:
    """Machines drawn, each look with all of those before, until a verdict is reached or the last size is."""
    seen = sample(slice(0, sizes[0]))
    for before, size in pairwise(sizes):
        told = not np.isnan(seen.stays_within(wanted, least=False))  # enough for the value that is shown
        if seen.verdict(wanted) != OPEN and told:
            break
        more = sample(slice(before, size))
        seen = replace(seen, values=np.append(seen.values, more.values), kept=np.append(seen.kept, more.kept))
    return seen


def fewest_kept(wanted: float, drawn: int, confidence: float) -> int:
    """How many of those drawn must keep a bound for the verdict MET; one more than there are where none suffice."""
    low, high = 0, drawn + 1
    while high - low > 1:
        middle = (low + high) // 2
        enough = clopper_pearson(middle, drawn, confidence)[0] >= wanted
        low, high = (low, middle) if enough else (middle, high)
    return high


def sure_share(wanted: float, drawn: int, confidence: float) -> float:
    """The share that must keep a bound so that a verdict on machines drawn hardly ever fails; nan where none does."""
    from scipy.special import betaincinv

    fewest = fewest_kept(wanted, drawn, confidence)
    if fewest > drawn:
        return float("nan")
    return float(betaincinv(fewest, drawn - fewest + 1, _HARDLY_EVER))


def clopper_pearson(kept: int, drawn: int, confidence: float) -> tuple[float, float]:
    """The exact interval of a share, from `kept` of `drawn` (Clopper and Pearson, Biometrika 26, 1934)."""
    from scipy.special import betaincinv

    tail = 0.5 * (1.0 - confidence)
    low = float(betaincinv(kept, drawn - kept + 1, tail)) if kept else 0.0
    high = float(betaincinv(kept + 1, drawn - kept, 1.0 - tail)) if kept < drawn else 1.0
    return low, high


def drawn(doubts: Sequence[Uncertain], count: int, stream: str = "", *, evenly: bool = False) -> FloatArray:
    """Factors of uncertain numbers, shape (count, n_doubts): independent, the same each time for the same path.

    What is drawn of one number follows from its path alone, so that two designs are compared on the same machines;
    another `stream` is independent of the first.  Machines that are spread `evenly` (a Latin hypercube) say more of a
    share, and nothing of how sure it is.
    """
    shares = shares_of([doubt.path for doubt in doubts], count, stream, evenly=evenly)
    columns = []
    for uncertain, share in zip(doubts, shares.T, strict=True):
        assert isinstance(uncertain.tolerance, Scatter)
        columns.append(uncertain.tolerance.factors(share))
    return np.stack(columns, axis=1)


def every_one(doubts: Sequence[Uncertain], cost: float) -> FloatArray | None:
    """Factors of all machines that there are, each as likely as the others, shape (count, n_doubts).

    None where not all numbers come from data, or machines are too many; `cost` is that of `looks`.
    """
    lists = [
        doubt.tolerance.data
        for doubt in doubts
        if isinstance(doubt.tolerance, Scatter) and doubt.tolerance.kind == DATA
    ]
    count = prod(len(one) for one in lists)
    if not lists or len(lists) < len(doubts) or count > COUNTED or count * cost > MOST_WORK:
        return None
    return 1.0 + np.stack([one.ravel() for one in np.meshgrid(*lists, indexing="ij")], axis=1)


def shares_of(paths: Sequence[str], count: int, stream: str = "", *, evenly: bool = False) -> FloatArray:
    """Of each number the share of all machines that have less of it, shape (count, n_paths)."""
    columns = []
    for path in paths:
        seed = int.from_bytes(hashlib.sha256(f"{stream}{path}".encode()).digest()[:8], "big")
        chance = np.random.Generator(np.random.PCG64(seed))
        shares = chance.random(count)
        columns.append((chance.permutation(count) + shares) / count if evenly else shares)
    return np.stack(columns, axis=1)


def in_batches(count: int) -> Iterator[slice]:
    """So many machines, some at a time.

    Raises
    ------
    InputError
        The time that the user allows is over.
    """
    for start in range(0, count, _BATCH):
        if late("the drawing of machines"):
            raise InputError("the time was over before enough machines were drawn. Allow more with --time-limit.")
        yield slice(start, min(start + _BATCH, count))


def sampled(parts: Sequence[Limit], factors: FloatArray, confidence: float) -> Sampled:
    """The worst of a limit, which may be asked at several places, on machines with factors (n_drawn, n_doubts)."""
    first = parts[0]
    values = np.empty(len(factors))
    sense = -1.0 if first.side == "at_least" else 1.0
    for some in in_batches(len(factors)):
        values[some] = np.max([sense * part.values(factors[some]) for part in parts], axis=0) * sense
    size = abs(first.bound) or 1.0
    kept = sense * (values - first.bound) <= _ROUNDING * size
    return Sampled(1.0 - values if first.complement else values, kept, confidence)
