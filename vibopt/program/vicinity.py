"""Proof by bounds on boxes that a limit holds on all machines within tolerances, at all speeds; for any machine."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms import ModeFrequency, Modulus
from vibopt.forms.sags import UnderWeights
from vibopt.mechanics.modes import natural_frequencies
from vibopt.program.boxes import Boxes, Scalar, amplitude_on, modulus_on, powers_on
from vibopt.program.linear import Linear
from vibopt.program.over import pieces_of
from vibopt.program.program import Aim, Axis, Limit
from vibopt.records import dataclass
from vibopt.signals import Band, Drive
from vibopt.work import Budget

_ROUNDING = 1e-9
_BATCH, _CHUNK = 512, 256
"""Boxes that are looked at before the next are cut, and of them those at once: more would not stay in fast memory."""
_MOST = 200_000

Kept = Callable[[Boxes], tuple[BoolArray, FloatArray, FloatArray]]
"""Boxes on which a level is kept, what each axis adds, and by how much the machines in the middle pass the level."""


@dataclass
class Vicinity:
    """A limit to be proven on the box of factors `axes` and over its speeds, for machines of any size.

    level
        What the greatest value (the least, with `least`) must not pass.
    margin
        Part by which each end of a band that modes keep outside of is drawn in.
    boxes
        Boxes looked at.
    witness
        Factors (n_factors,) of a machine that passes the level, where one was met.
    """

    part: Limit | Aim
    axes: tuple[Axis, ...]
    level: float
    least: bool = False
    margin: float = 0.0
    boxes: int = 0
    witness: FloatArray | None = None

    def proven(self, budget: Budget) -> bool:
        """Whether the level is kept everywhere; False where a budget of batches does not show it."""
        self._budget = budget
        return self.part.form.around(self)

    def of_modes(self, form: ModeFrequency) -> bool:
        rates = self._rates(form)
        return bool(rates) and self._covered(self._regular(form), rates, self._budget)

    def of_weights(self, form: UnderWeights) -> bool:
        return np.isfinite(self.level) and self._covered(self._static(form), [Band(0.0, 0.0)], self._budget)

    def of_response(self, form: Modulus) -> bool:
        if not np.isfinite(self.level) or form.rigid_link or len(form.drives) != 1 or self.least:
            return False
        drive = form.drives[0]
        return self._covered(self._harmonic(form, drive), pieces_of(drive), self._budget)

    def _covered(self, kept: Kept, bands: list[Band], budget: Budget) -> bool:
        low = np.array([[*(axis.low for axis in self.axes), band.low] for band in bands])
        high = np.array([[*(axis.high for axis in self.axes), band.high] for band in bands])
        left = Boxes(low, high)
        while len(left.low):
            if budget.over or len(left.low) > _MOST:
                return False
            budget.spend()
            some = left.part(slice(-_BATCH, None))
            self.boxes += len(some.low)
            with np.errstate(all="ignore"):  # of a box that is too wide nothing is known
                parts = [kept(some.part(slice(i, i + _CHUNK))) for i in range(0, len(some.low), _CHUNK)]
            good, weight, excess = (np.concatenate(one) for one in zip(*parts, strict=True))
            first = int(np.argmax(np.nan_to_num(excess, nan=-np.inf)))
            if excess[first] > 0.0:
                self.witness = some.middle[first, :-1]
                return False
            bad = Boxes(some.low[~good], some.high[~good])
            if len(bad.low) and not weight[~good].any(axis=1).all():
                return False
            halves, rest = bad.halves(weight[~good]), left.part(slice(None, -_BATCH))
            left = Boxes(np.concatenate([rest.low, halves.low]), np.concatenate([rest.high, halves.high]))
        return True

    def _rates(self, form: ModeFrequency) -> list[Band]:
        """Rates that no mode may have: on every machine as many are below them then as on the one that is said."""
        part = self.part
        if isinstance(part, Limit) and part.side == "outside":
            return [Band(part.bound * (1.0 + self.margin), part.upper * (1.0 - self.margin))]
        rest = np.array([axis.rest for axis in self.axes])
        kept = self._beyond(form, rest) < 0.0
        return [Band(self.level, self.level)] if kept else []

    def _beyond(self, form: ModeFrequency, machine: FloatArray) -> float:
        """By how much the mode of a machine (n_factors,) passes the level, or is inside the band that is kept free."""
        part = self.part
        rate = float(natural_frequencies(part.model, part.model.values(machine))[form.index])
        if isinstance(part, Limit) and part.side == "outside":
            return min(rate - part.bound, part.upper - rate)
        return self.level - rate if self.least else rate - self.level

    def _regular(self, form: ModeFrequency) -> Kept:
        linear = Linear.of_modes(self.part.model)

        def kept(boxes: Boxes) -> tuple[BoolArray, FloatArray, FloatArray]:
            value, weights = linear.on(boxes)
            good: BoolArray = np.isfinite(value.rest)
            excess = np.full(len(good), -1.0)
            for first in np.flatnonzero(~good)[:1]:
                excess[first] = self._beyond(form, boxes.middle[first, :-1])
            return good, _spread(weights, boxes.half, boxes), excess

        return kept

    def _harmonic(self, form: Modulus, drive: Drive) -> Kept:
        model = self.part.model
        share = model.counts[form.output.shared_by].scale if form.output.shared_by else 1.0
        lines = [(line, Linear.of_line(model, form, line)) for line in drive.lines]

        def kept(boxes: Boxes) -> tuple[BoolArray, FloatArray, FloatArray]:
            tops, here, weights, half = [], [], np.zeros_like(boxes.low), boxes.half
            for line, linear in lines:
                value, own = linear.on(boxes)
                size = amplitude_on(boxes, line, form.output.power)
                whole = value.times(size, half)
                tops.append(modulus_on(whole, half) / share)
                here.append(np.abs(whole.at) / share)
                known = np.isfinite(whole.rest)[:, None]
                weights += np.where(known, own * np.abs(size.at)[:, None] + np.abs(whole.slope) * half, 1e150 * own)
            total, middle = (
                np.sqrt((np.array(one) ** 2).sum(axis=0)) if form.combine == "rss" else np.sum(one, axis=0)
                for one in (tops, here)
            )
            good: BoolArray = total * (1.0 + _ROUNDING) <= self.level
            excess = middle - self.level if form.combine != "peak" or len(lines) == 1 else np.full(len(middle), -1.0)
            return good, _spread(weights, half, boxes), excess

        return kept

    def _static(self, form: UnderWeights) -> Kept:
        linear = Linear.of_weights(self.part.model, form)

        def kept(boxes: Boxes) -> tuple[BoolArray, FloatArray, FloatArray]:
            half = boxes.half
            value, weights = linear.on(boxes)
            whole = Scalar(value.at.real, value.slope.real, value.rest)
            if form.factor is not None:
                size = powers_on(boxes, form.factor.exponents, np.zeros(1, dtype=int))
                scale = form.factor.scale[0]
                factor = Scalar(scale * size.at[:, 0], scale * size.slope[:, 0], scale * size.rest[:, 0])
                whole = whole.times(factor, half)
            far = whole.spread(half) + _ROUNDING * np.abs(whole.at)
            middle = whole.at if form.signed else np.abs(whole.at)
            good: BoolArray = middle - far >= self.level if self.least else middle + far <= self.level
            known = np.isfinite(whole.rest)[:, None]
            weights = np.where(known, weights + np.abs(whole.slope) * half, weights)
            excess = self.level - middle if self.least else middle - self.level
            return good, _spread(weights, half, boxes), excess

        return kept


def _spread(weights: FloatArray, half: FloatArray, boxes: Boxes) -> FloatArray:
    """What each axis adds; where nothing is known of it, how wide it is."""
    lost: BoolArray = ~np.all(np.isfinite(weights), axis=1) | np.all(weights <= 0.0, axis=1)
    wide = half.copy()
    wide[:, -1] = half[:, -1] / np.maximum(boxes.middle[:, -1], 1e-300)
    found: FloatArray = np.where(lost[:, None], wide, weights)
    return np.where(half > 0.0, found, 0.0)
