"""Every smallest set of limits that cannot hold together, from few answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from vibopt.records import dataclass

K = TypeVar("K")
MOST = 12
"""Limits of which every set is mapped; of more the first smallest set is found."""
_POSSIBLE, _CLASHES, _OPEN = 1, 2, 3


@dataclass(frozen=True, slots=True)
class Clashes(Generic[K]):
    """Smallest sets, the one found first in front, whether there is no other, and how many answers that took.

    `doubtful` are those of the sets without which the others may clash as well: neither a design nor a proof was found.
    """

    sets: tuple[tuple[K, ...], ...]
    complete: bool
    answers: int
    doubtful: tuple[K, ...] = ()


def every_clash(
    keys: Sequence[K], clashes: Callable[[tuple[K, ...]], bool | None], may: Callable[[], bool] = lambda: True
) -> Clashes[K]:
    """All smallest sets of limits that cannot hold together.

    What is possible stays so with fewer limits, and what clashes with more: of the sets that neither follows for a
    largest one is asked, and one that clashes is made smaller limit by limit (Liffiton, Previti, Malik and
    Marques-Silva, Fast, flexible MUS enumeration, Constraints 21, 2016).

    Parameters
    ----------
    keys
        All limits; together they clash.
    clashes
        Whether it is proven that some of them cannot hold together; None where neither that nor a design was found.
    may
        Whether, after the first set, another answer may be asked for.
    """
    known = _Map(keys, clashes)
    whole = (1 << len(keys)) - 1
    found = [known.smallest(whole)]
    complete = len(keys) <= MOST
    if not found[0]:  # it is not the limits
        return Clashes((), True, known.answers)
    if complete:
        known.above(found[0])
        while (seed := known.unknown()) is not None:
            if not may():
                complete = False
                break
            if known.asked(seed) == _CLASHES:
                found.append(known.smallest(seed))
                known.above(found[-1])
    sets = tuple(known.names(one) for one in found)
    return Clashes(sets, complete and not known.doubts, known.answers, known.names(known.doubtful))


class _Map(Generic[K]):
    """What is known of each set of limits, a set being the bits of a number."""

    def __init__(self, keys: Sequence[K], clashes: Callable[[tuple[K, ...]], bool | None]) -> None:
        self.keys, self.clashes = keys, clashes
        self.known = bytearray(1 << len(keys)) if len(keys) <= MOST else bytearray()
        self.order = sorted(range(len(self.known)), key=lambda one: (-one.bit_count(), -one))
        self.answers, self.doubts, self.doubtful = 0, False, 0

    def names(self, some: int) -> tuple[K, ...]:
        """The limits of a set, in their order."""
        return tuple(key for k, key in enumerate(self.keys) if some >> k & 1)

    def unknown(self) -> int | None:
        """A largest set of which nothing is known."""
        self.order = [one for one in self.order if not self.known[one]]
        return self.order[0] if self.order else None

    def asked(self, some: int) -> int:
        """What is so of a set, by what is known or by one more answer."""
        if self.known and self.known[some]:
            return self.known[some]
        self.answers += 1
        said = self.clashes(self.names(some))
        self.doubts |= said is None
        if said is False:
            self.below(some)
        elif said:
            self.above(some)
        elif self.known:
            self.known[some] = _OPEN
        return _CLASHES if said else _POSSIBLE if said is False else _OPEN

    def smallest(self, some: int) -> int:
        """A smallest clashing set in one that clashes: what is not needed is left out, in order."""
        tried: Sequence[int] = range(len(self.keys))
        for _ in range(2):  # what was not decided may be, of the fewer limits that are left
            open_ = []
            for k in tried:
                fewer = some & ~(1 << k)
                said = self.asked(fewer) if fewer != some else _POSSIBLE
                some = fewer if said == _CLASHES else some
                open_ += [k] if said == _OPEN else []
            tried = open_
        self.doubtful |= sum(1 << k for k in tried)
        return some

    def below(self, some: int) -> None:
        """Whatever leaves out more is possible, too."""
        part = some
        while self.known:
            self.known[part] = _POSSIBLE
            if not part:
                break
            part = (part - 1) & some

    def above(self, some: int) -> None:
        """Whatever asks for more clashes, too."""
        rest = ((1 << len(self.keys)) - 1) & ~some
        more = rest
        while self.known:
            self.known[some | more] = _CLASHES
            if not more:
                break
            more = (more - 1) & rest
