"""What would help where there is no design: each piece of advice is solved as a whole job before it is given."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.mechanics.constants import GRAVITY
from vibopt.records import dataclass
from vibopt.responses import Response
from vibopt.scene.facts import fact_at, facts
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Design, Scene
from vibopt.solve.physical import Impossible
from vibopt.units import outward, read_quantity, show, to_unit
from vibopt.values.fact_at import FactAt
from vibopt.verify.checked import shown_value

_DIGITS = 3
"""Of a number that is advised, at least."""
MOST_DIGITS = 9
FINE = 0.005
"""Part of a change by which a bound is looser than needed at most."""
_WIDER = (1.0, 1.01, 1.04, 1.16, 1.64, 3.56)
"""Loosenings that are tried, as parts of the one that should do."""
_GREATER = (1.0, 1.02, 1.05, 1.1, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0)
"""Masses that are tried, as parts of the least that a balance of forces allows."""

Answer = Callable[..., Design]
"""Solves a scene, also from a design `near` [SI]."""


@dataclass(frozen=True, slots=True)
class _Trial:
    """The whole job with one number of its file changed, by that number in the user's unit."""

    scene: Scene
    fact: FactAt
    answer: Answer
    near: FloatArray | None = None

    def holds(self, number: float) -> bool:
        """Whether there is a design; of one variable, or near one that is known, any is found as surely as the best."""
        text: str | float = f"{number:.12g} {self.fact.unit}" if self.fact.unit else number
        place = self.fact.place or self.fact.path
        try:
            changed = with_changes(self.scene, {place: text})
            asked = replace(changed, goal=None) if len(changed.variables) == 1 or self.near is not None else changed
            answer = self.answer(asked) if self.near is None else self.answer(asked, near=self.near)
        except InputError:
            return False
        return answer.status in ("optimal", "feasible")

    def number(self, value: float) -> float:
        """A value [SI] in the user's unit."""
        return to_unit(value, self.fact.unit, self.fact.dimension) if self.fact.unit else value

    def least(self, numbers: list[float], *, known: bool = False, fine: bool = False) -> float | None:
        """The first of the numbers with which there is a design, brought as near to those without as three digits say.

        numbers
            From one without a design outward.  None where no other does.
        known
            Whether the second is known to be the least, if it does.
        fine
            As near as a small part of the change from the first.
        """
        good = next((index for index, number in enumerate(numbers) if index and self.holds(number)), None)
        if good is None:
            return None
        without, having = numbers[good - 1], numbers[good]
        if known and good == 1:
            return having
        now = numbers[0] if fine else None
        stride = _step(having, now)
        while (inside := _less(without, having, now, stride)) != without:
            if self.holds(inside):
                having, stride = inside, 2.0 * stride
            else:  # from here on halves
                without, stride = inside, math.inf
        return having


def _step(number: float, now: float | None) -> float:
    """One in the third digit of what lies next to a number, towards zero; of a change as fine as tells it, too."""
    step = float(10.0 ** (math.floor(math.log10(abs(number) * (1.0 - 1e-9) or 1.0)) - _DIGITS + 1))
    change = abs(number - now) if now is not None else 0.0
    fine = 10.0 ** math.floor(math.log10(FINE * change)) if change else step
    return min(step, max(fine, step * 10.0 ** (_DIGITS - MOST_DIGITS)))


def _less(without: float, having: float, now: float | None, stride: float) -> float:
    """By a stride, or the middle where that is nearer, from the second number to the first in whole steps.

    The first where there is nothing between.
    """
    step = _step(having, now)
    there = max(0.5 * abs(having - without), abs(having - without) - stride)
    inside = float(f"{round((without + math.copysign(there, having - without)) / step) * step:.12g}")
    return inside if abs(having - without) > 1.5 * step else without


def confirmed_bound(
    scene: Scene,
    name: str,
    side: str,
    guess: float,
    answer: Answer,
    *,
    known: bool = False,
    closely: bool = False,
    near: FloatArray | None = None,
) -> Entry | None:
    """The least loosening of a limit, to 0.5 % of the change, with which the whole job has a design.

    Parameters
    ----------
    scene
        Without a design.
    name, side
        The limit and its bound, "at_most" or "at_least".
    guess
        A bound that should be enough [SI].
    answer
        Solves a scene.
    known
        Whether the guess is proven to be the least.
    closely
        Whether what is known is told as closely as what is looked for.
    near
        A design that keeps the guess, as starts found it [SI].

    Returns
    -------
    Entry
        It was solved and, where it was not known to be the least, so was a step less, which is not enough; None where
        none near the guess is enough.
    """
    fact, response = fact_at(scene, f"limits.{name}.{side}"), scene.limits[name]
    trial, step = _Trial(scene, fact, answer, near), guess - fact.value
    wide = [fact.value + part * step for part in _WIDER]
    try:
        now = trial.number(fact.value)
        aimed = [beside(trial.number(value), now, side) for value in wide]
        if response.dimension == "count":
            aimed = [
                float(math.ceil(value - 1e-9) if side == "at_most" else math.floor(value + 1e-9)) for value in wide
            ]
        elif known and closely:
            aimed[0] = _next_step(trial.number(guess), now, side)
        numbers = [now, *[value for value in dict.fromkeys(aimed) if value != now]]
        found = trial.least(numbers, known=known, fine=response.dimension != "count")
    except ValueError:  # no such number in this unit: decibels of what is not positive
        return None
    return None if found is None else _bound(response, found, fact.unit)


def _next_step(number: float, now: float, side: str) -> float:
    """A bound rounded outward to steps as fine as tell its change from `now`."""
    step, sign = _step(number, now), 1.0 if side == "at_most" else -1.0
    return float(f"{sign * math.ceil(sign * number / step) * step:.12g}")


def _bound(response: Response, number: float, unit: str) -> Entry:
    """A bound by its number in the user's unit, told with all its digits."""
    value = number
    if unit:
        value = read_quantity(f"{number:.12g} {unit}", response.dimension, amplitude=response.amplitude).value
    return replace(shown_value(response, value, unit), digits=MOST_DIGITS)


def beside(number: float, now: float, side: str) -> float:
    """A bound rounded outward, with as few digits as leave the way from `now` what it is."""
    value = outward(number, side, _DIGITS)
    for digits in range(_DIGITS + 1, MOST_DIGITS + 1):
        if abs(value - number) <= FINE * abs(number - now):
            break
        value = float(f"{outward(number, side, digits):.12g}")
    return value


def mass_words(scene: Scene, clash: Impossible, answer: Answer) -> str:
    """The least mass with which the whole job has a design, as a sentence; "" where the file says no mass."""
    fact = _mass(scene)
    if fact is None:
        return ""
    trial, per = _Trial(scene, fact, answer), GRAVITY if fact.dimension == "force" else 1.0
    values = [fact.value + per * (part * clash.needed - clash.mass) for part in _GREATER]
    numbers = [outward(trial.number(value), "at_most", _DIGITS) for value in values]
    found = trial.least([trial.number(fact.value), *numbers])
    key = fact.path.split(".")[2]
    word = f"{'an' if key == 'inertia' else 'a'} {key}"
    if found is None:
        most = show(values[-1], fact.unit, fact.dimension, digits=_DIGITS)
        return f"No {key} up to {most} was found with which every limit could hold."
    now = show(fact.value, fact.unit, fact.dimension)
    return f"With {word} of {f'{found:.12g} {fact.unit}'.strip()} instead of {now} every limit could hold."


def _mass(scene: Scene) -> FactAt | None:
    """The one mass, weight or inertia that the file gives; the greatest of a range is no fact."""
    keys = ("mass", "weight", "inertia")
    paths = {f"bodies.{name}.{key}" for name in scene.bodies for key in keys}
    found = [fact for fact in facts(scene) if fact.path.removesuffix(".value") in paths]
    return found[0] if len(found) == 1 else None
