"""How far the same things hold an answer back when one number of its file moves one way, and what comes then."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from vibopt.answer.entry import Entry, Way
from vibopt.records import dataclass
from vibopt.study.axis import Axis, is_shelf
from vibopt.study.holding import Road, State, difference, no_more
from vibopt.study.seen import shown_value
from vibopt.work import SpentError

_WIDEST = 6.0
"""Decades by which a limit is loosened; every other number goes to ten times, or a tenth."""
_ALONE = (0.12, 0.3, 0.6, 1.0)
_MANY = 48
_CLOSE, _CLOSER = 2e-5, 2e-7
"""Decades to which the end of a range is known: one by one, and many together."""
_GUESSES = 24
_BRINKS = 3
"""Regions of designs that are followed to their end, one after the other."""
_BESIDE = 1e-6
"""Decades on either side of a guess at which it is confirmed."""
_FILLINGS = 24
"""Values each way at which the filling of a shelf weight ten times as heavy, or as light, is looked at."""
OTHERS = "other fillings beyond"
_BEHIND, _FEW_BEHIND = 24, 4
"""Values at which it is looked for designs behind the end of a fact: many together, and one by one."""
NONE = "no design"
_SAME = 1e-7
"""Part of a goal below which two are the same."""
_TIGHTER, _LOOSER = 0.003, 0.1
"""Parts of a bound by which it is moved to see whether the goal feels it."""
_NO_TURN = 1e-3
"""Decades behind a place within which the goal turns at the place itself: there it may feel next to nothing yet."""
_NO_ANGLE = 1e-10
"""Angle [rad] below which a goal is the rounding of zero, as where places are chosen so that nothing tilts."""


@dataclass
class Along:
    """One number, both ways.

    road, axis
        Answers along it, and how its values lie.
    sense
        1 where more of what is measured is better, else -1.
    key
        What stands among the things that hold the answer back where this number does; "" for a fact.
    loose
        The way in which it is loosened: 1, -1; 0 for a fact.
    guess
        The value [SI] of what it limits at an answer; None where that is not known.
    """

    road: Road
    axis: Axis
    here: State
    sense: int
    key: str = ""
    loose: int = 0
    guess: Callable[[State], float | None] = lambda state: None

    def stepped(self, way: int) -> Way:
        """What a sensible step does."""
        value = self.axis.step(way)
        state = self.road(value)
        return Way(self._entry(value), state.status, state.measure, self.change(state))

    def change(self, state: State) -> float | None:
        """Part of the goal by which another answer is better; of margins, or a goal of zero, the difference."""
        now, then = self.here.measure, state.measure
        if now is None or then is None:
            return None
        if now.dimension == "angle" and max(abs(now.value), abs(then.value)) <= _NO_ANGLE:
            return 0.0
        size = 1.0 if now.dimension == "ratio" and not self.road.has_goal else abs(now.value) or 1.0
        part = self.sense * (then.value - now.value) / size
        return 0.0 if abs(part) < _SAME else part

    def _entry(self, value: float) -> Entry:
        return shown_value(self.axis.fact, value)

    def ranged(self, way: Way, direction: int) -> Way:
        """The same with how far the same things hold the answer back, and what comes then."""
        if is_shelf(self.axis.fact.path):
            return self._filled(way, direction)
        wide = direction == self.loose and self.key in self.here.held and not self.axis.counted
        far = (2.0 if self.axis.complement else _WIDEST) if wide else 1.0
        begin, last, other = self._first(direction, far)
        edge = self._entry(begin.value)
        there = self.road(edge.value).measure
        if other is None or not self._close(begin, other):
            seen = last if other is None else begin
            if seen is self.here:
                return way
            flat = other is None and way.change == 0.0 and self.change(last) == 0.0
            return replace(way, far=self._entry(seen.value), there=there, beyond="changes nothing" if flat else "")
        outermost = self._entry(self.axis.value(direction * far))
        way = replace(way, until=edge, there=there, then=difference(begin, other), far=outermost)
        ended = self._ended(way, begin, other, direction, far)
        return self._looked_behind(ended, direction, far) if not self.loose and ended.beyond == NONE else ended

    def _looked_behind(self, way: Way, direction: int, far: float) -> Way:
        """The same with whether designs come again: a limit that is tightened has none, a fact may."""
        assert way.ends is not None
        end = abs(self._t_of(way.ends.value))
        if self.axis.counted:
            places = [value for value in self._ladder(direction, far) if abs(self._t_of(value)) > end]
        else:
            parts = np.linspace(end, far, (_BEHIND if self.road.together else _FEW_BEHIND) + 1)[1:]
            places = [self.axis.value(direction * float(part)) for part in parts if part > end]
        seen = self.road.at(places)
        if None in seen and not self.road.together:
            return replace(way, far=way.ends)
        states = [state for state in seen if state is not None and state.status != "refused"]
        again = next((self._entry(state.value) for state in states if state.good), None)
        return replace(way, looked=len(states), again=again)

    def _filled(self, way: Way, direction: int) -> Way:
        """How far, at every value of a shelf weight that is looked at, the same weights sit in the same holes.

        Fillings come and go with what a weight weighs, and designs with them: of what lies behind nothing is said.
        """

        plane = self.axis.fact.path.split(".")[1]

        def same(state: State) -> bool:
            return state.good and state.filling(plane) == self.here.filling(plane)

        good, bad = self.here, None
        for k in range(1, _FILLINGS + 1):
            state = self.road(self.axis.value(direction * k / _FILLINGS))
            if not same(state):
                good, bad = self._halved(good, state, direction, same)
                break
            good = state
        there, far = self.road(good.value).measure, self._entry(self.axis.value(float(direction)))
        if bad is None:
            return replace(way, far=far, there=there)
        return replace(way, far=far, there=there, until=self._entry(good.value), then=OTHERS)

    def _ended(self, way: Way, begin: State, other: State, direction: int, far: float) -> Way:
        """Where more of it changes nothing, or where no design is left."""
        if not other.good:
            return replace(way, ends=way.until, beyond=no_more(other, begin.value))
        last = self.road.told(self.axis.value(direction * far))
        if last is None:
            return way
        if not self.loose and last.good:  # a fact may have designs again
            behind = sorted(
                (state for state in self.road.known.values() if not state.good), key=lambda state: abs(self._t(state))
            )
            last = next((state for state in behind if direction * self._t(state) > direction * self._t(other)), last)
        if not last.good:
            good, bad = self._edge(other, last, direction)
            if not self._close(good, bad):
                return way
            return replace(way, ends=self._entry(good.value), beyond=no_more(bad, good.value))
        if not self.key or self.key in last.held or direction != self.loose:
            return way
        if self.key not in other.held and self._same_goal(other, last):
            return replace(way, ends=way.until, beyond="nothing more to gain")
        inside = self._let_go(other, last, direction)
        if inside is None:
            inside, outer = self._halved(other, last, direction, lambda state: not self._same_goal(state, last))
            if not self._close(inside, outer):
                return way
        return replace(way, ends=self._entry(inside.value), beyond="nothing more to gain")

    def _let_go(self, other: State, last: State, direction: int) -> State | None:
        """The last value at which the limit itself is touched, where the loosest answer is what it takes; else None."""
        found = self._touched(last, other, last, direction)
        return found[0] if found and self.key in found[0].held and self._same_goal(found[1], last) else None

    def _touched(self, at: State, good: State, bad: State, direction: int) -> tuple[State, State] | None:
        """The answers beside the value that an answer takes of the limit itself; None where it is not between two."""
        value = self.guess(at)
        t = self.axis.at(value) if value is not None and not self.axis.counted else math.nan
        return self._beside(abs(t), direction) if abs(self._t(good)) < abs(t) < abs(self._t(bad)) else None

    def _beside(self, t: float, direction: int) -> tuple[State, State] | None:
        """The answers just before and just behind a place; None where the work does not do."""
        before, behind = (self.road.told(self.axis.value(direction * (t + off))) for off in (-_BESIDE, _BESIDE))
        return None if before is None or behind is None else (before, behind)

    def _close(self, good: State, bad: State) -> bool:
        """Whether what lies between two is no more than what may be: the work may have ended what looks there."""
        low, high = abs(self._t(good)), abs(self._t(bad))
        return high - low <= (1.5 if self.axis.counted else max(_NO_TURN * high, 2.0 * _CLOSE * max(1.0, low)))

    def _same_goal(self, state: State, other: State) -> bool:
        if state.measure is None or other.measure is None:
            return False
        size = max(abs(state.measure.value), abs(other.measure.value)) or 1.0
        return abs(state.measure.value - other.measure.value) <= _SAME * size

    def _first(self, direction: int, far: float) -> tuple[State, State, State | None]:
        """The last answer before other things hold it back, the last that was looked at, and the first behind."""
        before = self.here
        for again in (True, False):
            inner, last, outer = self._turn(before, before, before.like, direction, far)
            if outer is not None and not self._close(inner, outer):
                break
            if outer is not None and self._by_chance(before, inner, outer):
                then = self._turn(before, outer, partial(self._as_before, before), direction, far)
                if then[2] is None or abs(self._t(then[0])) - abs(self._t(outer)) > _NO_TURN:
                    return then
            if again and inner is self.here and not self.axis.counted and outer is not None and outer.good:
                before = outer  # held otherwise from now on
                continue
            return inner, last, outer
        return inner, last, outer

    def _turn(
        self, like: State, begin: State, holds: Callable[[State], bool], direction: int, far: float
    ) -> tuple[State, State, State | None]:
        """The same from an answer on, where something holds up to the first and no longer at the last."""
        good, bad = self._scanned(begin, holds, direction, far)
        if bad is None:
            return good, good, None
        if not bad.good:
            bad, end = self._edge(good, bad, direction)
            if holds(bad):
                return bad, end, end
        if begin is not like:
            inner, outer = self._halved(good, bad, direction, holds)
        else:
            guessed = self._guessed(like, good, bad, direction)
            inner, outer = guessed or self._followed(like, good, bad, direction)
        return inner, outer, outer

    def _by_chance(self, before: State, inner: State, outer: State) -> bool:
        """Whether the goal does not feel what tells two neighbours apart: to hold it a little tighter costs nothing."""
        if not (outer.good and inner.good and self.road.has_goal) or outer.like(before):
            return False
        if self.axis.counted and self._same_goal(inner, outer):
            return True
        return self._idle(outer, outer.held - before.held, -_TIGHTER) and self._idle(
            inner, before.held - outer.held, -_TIGHTER
        )

    def _as_before(self, before: State, state: State) -> bool:
        """Whether the same things hold the goal back, whatever else is touched: to loosen that buys nothing."""
        if not state.good or self._same_goal(state, before) or state.like(before):
            return state.good
        return self._idle(state, state.held - before.held, _LOOSER) and self._idle(
            before, before.held - state.held, _LOOSER
        )

    def _idle(self, state: State, names: frozenset[str], by: float) -> bool:
        """Whether the goal stays as it is while the numbers of what is touched leave a part more room."""
        try:
            return not names or self._same_goal(state, self.road.with_room(state.value, names, by))
        except SpentError:
            return False

    def _scanned(
        self, begin: State, holds: Callable[[State], bool], direction: int, far: float
    ) -> tuple[State, State | None]:
        """The last of a ladder of values up to which something holds, and the next; None where it holds at all."""
        good = begin
        ladder = self._ladder(direction, far)
        begun = abs(self._t(begin))
        values = [value for value in ladder if abs(self._t_of(value)) > begun * (1.0 + 1e-12)]
        states = self.road.at(values) if self.road.together else map(self.road.told, values)
        for state in states:
            if state is None and self.road.together:
                continue
            if state is None:
                break
            if not holds(state):
                return good, state
            good = state
        return good, None

    def _t(self, state: State) -> float:
        return self._t_of(state.value)

    def _t_of(self, value: float) -> float:
        return value - self.axis.fact.value if self.axis.counted else self.axis.at(value)

    def _ladder(self, direction: int, far: float) -> list[float]:
        """Values outward; the last is as far as is looked."""
        axis, now = self.axis, self.axis.fact.value
        if axis.counted:
            last = 10.0 * max(now, 1.0) if direction > 0 else 1.0
            steps = range(1, round(abs(last - now)) + 1)
            return [now + direction * k for k in steps if k <= 12 or (k & (k - 1)) == 0]
        if self.road.together:
            parts = far * np.linspace(0.0, 1.0, _MANY + 1)[1:] ** (2.0 if far > 1.0 else 1.0)
        else:
            parts = np.array([*_ALONE, *([2.0, far] if far > 1.0 else [])])
        ladder = [axis.step(direction), *(axis.value(direction * float(part)) for part in parts)]
        return sorted(set(ladder), key=lambda value: abs(axis.at(value)))

    def _guessed(self, like: State, good: State, bad: State, direction: int) -> tuple[State, State] | None:
        """Both sides of the value at which the limit itself begins, or ends, to matter, if it is between the two."""
        state = like if self.key not in like.held else bad
        changes = (self.key in like.held) != (self.key in bad.held)
        found = self._touched(state, good, bad, direction) if self.key and changes and state.good else None
        return found if found and found[0].like(like) and not found[1].like(like) else None

    def _followed(self, like: State, good: State, bad: State, direction: int) -> tuple[State, State]:
        """The end of what holds it back, from where the room of what takes over, or lets go, comes to nothing.

        That room is followed from the side on which there is some; where it tells nothing, answers are halved.
        """
        last, told = math.nan, 0.0
        for _ in range(0 if self.road.together or self.axis.counted else _GUESSES):
            low, high = abs(self._t(good)), abs(self._t(bad))
            if high - low <= _CLOSE:
                return good, bad
            t, nearest = self._vanishes(like, good, bad)
            wide, missed = high - low, abs(t - last) if nearest != told else math.nan
            last, told = t, nearest
            if not low - 0.2 * wide < t < high + 0.2 * wide:
                places = [0.5 * (low + high)]
            elif missed <= 0.1 * _CLOSE:
                places = [t - _BESIDE, t + _BESIDE]
            else:  # from a little before what was tried, the next is nearer
                off = min(max(0.3 * missed, 0.4 * _CLOSE), 0.3 * wide) if missed >= 0.0 else 0.1 * wide
                near = 0.1 * _CLOSE
                places = [t if low + near < t < high - near else min(max(t, low + off), high - off)]
            for place in places:
                if low < place < high:
                    state = self.road.told(self.axis.value(direction * place))
                    if state is None:
                        return good, bad
                    good, bad = (state, bad) if state.like(like) else (good, state)
        return self._halved(good, bad, direction, like.like)

    def _vanishes(self, like: State, good: State, bad: State) -> tuple[float, float]:
        """Where near two answers the room of what tells them apart is nothing, as three others tell; else nan.

        Beside it the place of the nearest of the three.
        """
        way = math.copysign(1.0, self._t(bad))
        low, high = way * self._t(good), way * self._t(bad)
        known = [(way * self._t(state), state) for state in self.road.known.values()]
        for names, side, end in ((bad.held - like.held, like, low), (like.held - bad.held, bad, high)):
            states = [one for one in known if one[1].like(side) and (0.0 <= one[0] <= low or one[0] >= high)]
            states.sort(key=lambda one: abs(one[0] - end))
            for name in sorted(names):
                room = [(t, state.room[name]) for t, state in states if state.room.get(name, 0.0) > 0.0][:3]
                if len(room) >= 2 and room[0][1] != room[1][1]:
                    return _at_nothing(room, end), room[0][0]
        return math.nan, math.nan

    def _edge(self, good: State, bad: State, direction: int) -> tuple[State, State]:
        """The last value before `bad` that has a design and the first behind it that has none."""
        way = math.copysign(1.0, self._t(bad))
        known = sorted(
            (state for state in self.road.known.values() if way * self._t(state) <= way * self._t(bad)), key=self._t
        )
        good = max((state for state in known if state.good), key=lambda state: way * self._t(state))
        bad = next(
            state for state in (known if way > 0.0 else known[::-1]) if way * self._t(state) > way * self._t(good)
        )
        for _ in range(0 if self.axis.counted else _BRINKS):  # whole numbers have nothing between
            low, high = abs(self._t(good)), abs(self._t(bad))
            if high - low <= 2.5 * _BESIDE:
                return good, bad
            t = self.road.brink(lambda t: self.axis.value(direction * t), (low, good), high)
            if not low < t < high:
                break
            beside = self._beside(t, direction)
            if beside is None:
                break
            inner, outer = beside
            good, bad = (outer, bad) if outer.good else (inner if inner.good else good, outer if inner.good else inner)
        return self._halved(good, bad, direction, lambda state: state.good)

    def _halved(self, good: State, bad: State, direction: int, holds: Callable[[State], bool]) -> tuple[State, State]:
        """The last value at which something holds and the first at which it does not, as near as they are known."""
        low, high = abs(self._t(good)), abs(self._t(bad))
        states = {low: good, high: bad}

        from vibopt.bracketing import narrowed

        def told(places: Sequence[float]) -> Iterator[bool | None]:
            now = self.axis.fact.value
            values = [now + direction * t if self.axis.counted else self.axis.value(direction * t) for t in places]
            found = self.road.at(values)
            states.update((t, state) for t, state in zip(places, found, strict=True) if state is not None)
            return (None if state is None else holds(state) for state in found)

        inner, outer = narrowed(told, low, high, self._inner)
        return states[inner], states[outer]

    def _inner(self, low: float, high: float) -> list[float]:
        """Places between two at which is looked next; none where they are as near as they are to be."""
        if self.axis.counted:
            return [float(round(0.5 * (low + high)))] if high - low > 1.5 else []
        close = _CLOSER if self.road.together else _CLOSE
        if high - low <= close * max(1.0, low):
            return []
        return [float(t) for t in np.linspace(low, high, 34)[1:-1]] if self.road.together else [0.5 * (low + high)]


def _at_nothing(points: list[tuple[float, float]], end: float) -> float:
    """Where values (t, room) come to zero next to an end, by the parabola through three of them, or a straight line."""
    (a, first), (b, second), *more = points
    slope = (second - first) / (b - a)
    line = a - first / slope if slope else math.nan
    if not more:
        return line
    bend = ((more[0][1] - second) / (more[0][0] - b) - slope) / (more[0][0] - a)
    inner = slope + bend * (a - b)  # slope of the parabola at a
    square = inner * inner - 4.0 * bend * first
    if not square >= 0.0 or not bend:
        return line
    large = -0.5 * (inner + math.copysign(math.sqrt(square), inner))
    roots = [a + large / bend, *([a + first / large] if large else [])]
    return min(roots, key=lambda value: abs(value - end))
