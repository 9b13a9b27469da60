"""Limits that cannot hold together: every smallest set of them, from few answers, and what they say."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any, Generic, TypeVar

from vibopt.answer.entry import Entry
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


@dataclass(frozen=True, slots=True)
class Conflict:
    """Limits that cannot hold together, and for each the smallest loosening that helps, rounded outward.

    limits
        Names of a smallest such set.
    loosenings
        (name, bound now, bound that makes the job feasible); a limit that no loosening alone mends is left out.
    proof
        How the conflict was proven, in words.
    left
        Names of limits for which no loosening was looked for, because of the work.
    others
        Names of every other smallest set that cannot hold together.
    complete
        Whether there is no further set: all were looked at.
    soft
        How easily a limit may be loosened, beside 1 of those that are not named.
    doubtful
        Names of limits of these sets without which the others may clash as well: that was not decided.
    """

    limits: tuple[str, ...]
    loosenings: tuple[tuple[str, Entry, Entry], ...]
    proof: str
    left: tuple[str, ...] = ()
    others: tuple[tuple[str, ...], ...] = ()
    complete: bool = True
    soft: Mapping[str, float] = field(default_factory=dict)
    doubtful: tuple[str, ...] = ()

    def said(self, quote: str = "") -> str:
        """That the limits cannot hold together; `quote` stands around each name."""
        together = "These cannot hold together" if len(self.limits) > 1 else "This cannot hold"
        return f"{together}: {', '.join(f'{quote}{name}{quote}' for name in self.limits)}."

    def others_said(self, quote: str = "") -> tuple[str, ...]:
        """The other sets in words, and that some may be missing; `quote` stands around each name."""
        rows = [", ".join(f"{quote}{name}{quote}" for name in other) for other in self.others]
        said = [
            f"Nor {'these' if len(other) > 1 else 'this'}: {row}." for other, row in zip(self.others, rows, strict=True)
        ]
        if self.doubtful:
            without = " or ".join(f"{quote}{name}{quote}" for name in self.doubtful)
            said += [f"Fewer may clash already: without {without} neither a design nor a proof was found."]
        said += [] if self.complete else ["There may be further sets: not all were looked at."]
        return tuple(said)

    @property
    def by_size(self) -> list[tuple[str, Entry, Entry]]:
        """The loosenings, the smallest part of its bound first, by the weights of the limits."""

        def part(one: tuple[str, Entry, Entry]) -> float:
            name, now, then = one
            return abs(then.value - now.value) / (abs(now.value) or 1.0) / self.soft.get(name, 1.0)

        return sorted(self.loosenings, key=part)

    @property
    def least(self) -> tuple[str, Entry, Entry] | None:
        """The smallest of them; None without one."""
        return next(iter(self.by_size), None)

    @property
    def steps(self) -> list[str]:
        """Each loosening in words, "start_up 20 mm -> 24 mm", the smallest in front."""
        return [f"{name} {now.shown} -> {then.shown}" for name, now, then in self.by_size]

    def to_json(self) -> dict[str, Any]:
        steps = [{"limit": name, "from": now, "to": then} for name, now, then in self.loosenings]
        said = {"limits": list(self.limits), "loosenings": steps, "left": list(self.left), "proof": self.proof}
        others = [list(other) for other in self.others]
        further = {"complete": self.complete, "soft": dict(self.soft), "doubtful": list(self.doubtful)}
        return {**said, "others": others, **further}
