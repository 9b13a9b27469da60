"""Prices in words: a sentence for a limit, a table for all numbers, and what to argue about first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry, Way
from vibopt.errors import counted
from vibopt.units import plain

if TYPE_CHECKING:
    from vibopt.study.prices import Prices
    from vibopt.study.purse import Ranked

HEADS = ("Number", "A step", "Goal", "Better by")
GAIN = "nothing more to gain"
NONE = "no design"
WITHOUT = {"refused": "not asked", "unproven": "none found", "check_failed": "check failed"}
"""What stands for a goal where an answer has none, and it is not proven that there is no design."""
NOT_ASKED = "With a value that is not asked the file is refused: vibopt whatif FILE --set PATH=VALUE says why."
OF_WORK = "left out because of the work"
LIMITS, CAPS, FACTS = "limit", "cap", "fact"


def words_of(answer: Answer[Any], now: Entry, way: Way, ways: Sequence[Way] = ()) -> str:
    """What a loosened limit buys, then what a tighter one costs, and where there is nothing more to gain."""
    assert answer.goal is not None
    assert way.goal is not None
    name, goal = answer.goal[0].replace("_", " "), answer.goal[1]
    text = f"{now.shown} -> {way.value.shown}: {name} {goal.shown} -> {way.goal.shown}"
    if goal.shown == way.goal.shown:
        text = f"{now.shown} -> {way.value.shown}: {name} stays {goal.shown}"
    for other in ways:
        if other.value != way.value:
            text += (
                f"; {other.value.shown}: {WITHOUT.get(other.status, NONE) if other.goal is None else other.goal.shown}"
            )
    if way.ends is not None and way.beyond == GAIN:
        text += f"; {GAIN} beyond {way.ends.shown}"
    return text


def range_words(now: Entry, ways: Sequence[Way], *, gain: bool = True) -> str:
    """Over which range the same limits hold the answer back, and what takes over at its ends.

    Without `gain` not where there is nothing more to gain.
    """
    known = [way for way in ways if way.far is not None]
    if now.dimension == "count" and known and all(way.until == now for way in known):
        return f"{now.shown} alone: {' and '.join(way.value.shown for way in known)} have designs of other kinds"
    words = ("from", "to")[-len(known) :] if known else ()
    said = [f"{word} {_end(now, way, gain=gain)}" for word, way in zip(words, known, strict=True)]
    return f"the same holds {' '.join(said)}" if said else ""


def _end(now: Entry, way: Way, *, gain: bool) -> str:
    """One end of a range: "6.351 kN (no design beyond)"."""
    if way.until is None:
        assert way.far is not None
        return f"{way.far.shown} at least{f' ({way.beyond})' if way.beyond else ''}"
    then = [way.then if way.then != NONE else _none_beyond(way)] if way.then else []
    if way.ends is not None and way.beyond and way.then != way.beyond and (gain or way.beyond != GAIN):
        said = f"{way.beyond} beyond {way.ends.shown}"
        if way.beyond == NONE and way.looked:
            said = f"beyond {way.ends.shown} {_none_beyond(way)}"
        then.append(way.beyond if way.ends == way.until else said)
    at_once = abs(way.until.value - now.value) <= 1e-6 * abs(now.value)
    return f"{now.shown if at_once else way.until.shown} ({'; '.join(then)})"


def _none_beyond(way: Way) -> str:
    """That designs end: for sure where a limit is tightened, of a fact as far as was looked."""
    if way.again is not None:
        return f"no design, and one again at {way.again.shown}"
    if not way.looked:
        return "no design beyond"
    assert way.far is not None
    return f"no design at {counted(way.looked, 'values')} up to {way.far.shown}"


def better(now: Entry | None, way: Way) -> str:
    """By how much what is measured is better, in words: a part of what it is, and of zero the difference."""
    if way.change is None or way.goal is None:
        return NONE
    if way.change == 0.0:
        return "nothing"
    of_zero = now is not None and now.value == 0.0 and now.dimension != "ratio"
    size = replace(way.goal, value=abs(way.change)).shown if of_zero else f"{plain(abs(100.0 * way.change), 2)} %"
    return f"{'+' if way.change > 0 else '−'}{size}"


def first_words(prices: Prices) -> str:
    """What to argue about first: "Argue about start_up first: 20 mm -> 22 mm buys 1.2 %"."""
    limits = [row for row in prices.rows if row.sort != FACTS and row.gain > 0.0]
    facts = [row for row in prices.rows if row.sort == FACTS and row.gain > 0.0]
    if prices.rows and all(row.why.startswith("left out") for row in prices.rows):
        return f"Which number improves the {prices.measure} was left out because of the work: --thorough computes it."
    if not limits and not facts:
        return f"No sensible step of any number that was looked at improves the {prices.measure}."
    text = ""
    if limits:
        text = f"Argue about {_step(prices, limits[0])}"
    if facts:
        lead = "Of the facts" if limits else f"{_without_gain(prices)}; of the facts"
        text += f"{'. ' if limits else ''}{lead} {_step(prices, facts[0])}"
    return f"{text}."


def _without_gain(prices: Prices) -> str:
    """That a step of no limit buys anything, and which limit does farther on, where that is known."""
    holding = [
        (row, way.ends)
        for row in prices.rows
        for way in row.ways
        if row.sort != FACTS and way.ends is not None and way.beyond == GAIN
        if (way.ends.value - row.now.value) * (way.value.value - row.now.value) > 0.0
    ]
    far = [(row, ends) for row, ends in holding if ends.shown != row.now.shown]  # not where two hold in one place
    if not far:
        return f"No limit {'alone ' * bool(holding)}holds it back"
    said = ", ".join(f"{row.name} holds it back up to {ends.shown}" for row, ends in far)
    row, ends = far[0]
    return (
        f"The steps looked at of limits buy nothing, but {said} (vibopt sweep FILE --vary "
        f'{row.path}="{row.now.shown}..{ends.shown}")'
    )


def _step(prices: Prices, one: Ranked) -> str:
    best = one.best
    assert best is not None
    assert best.goal is not None
    bought = f"buys {better(prices.now, best).lstrip('+')} ({prices.measure} {prices.shown} -> {best.goal.shown})"
    return f"{one.name} first: {one.now.shown} -> {best.value.shown} {bought}"


def rows_of(prices: Prices) -> Iterator[tuple[str, ...]]:
    """A row for each way of each number, the better way first."""
    names = [row.name for row in prices.rows]
    for row in prices.rows:
        name = row.name if names.count(row.name) == 1 else row.path.removeprefix("limits.")
        ways = sorted(row.ways, key=lambda way: -(way.change if way.change is not None else -9e9))
        for index, way in enumerate(ways):
            goal = way.goal.shown if way.goal is not None else WITHOUT.get(way.status, NONE)
            gain = better(prices.now, way) if way.goal is not None else ""
            yield name if not index else "", f"{row.now.shown} -> {way.value.shown}", goal, gain


def range_rows(prices: Prices) -> Iterator[tuple[str, str]]:
    """How far the prices of each number go on, and what takes over; where that is not known, why, or a note says it."""
    for row in prices.rows:
        words = range_words(row.now, row.ways).removeprefix("the same holds ")
        if words or not row.why.endswith(OF_WORK):
            yield row.name, words or f"{row.now.shown}: {row.why}"
