"""Proof that a harmonic limit holds for every machine within the tolerances, at every speed.

At a given design the speed is one more variable beside the factors: an inertia's impedance grows with
its square, a damper's with the speed itself.  N and D are then polynomials in speed and factors, and
bound^2 |D|^2 - |N|^2 is not negative on a box where its Bernstein coefficients are not.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms import Modulus
from vibopt.forms.rational import Groups, Sampled, box_coefficients, ratio_bounds, sampled
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, Model
from vibopt.program.program import Aim, Axis, Limit
from vibopt.records import dataclass
from vibopt.signals import Amplitude, Band, Drive, Line, Piece
from vibopt.work import Budget

MARGIN = 1e-3
"""Part of a bound up to which a limit that is just met is proven to hold."""
_ROUNDING = 1e-13
_BATCH = 64
_MOST_NODES = 260
_MOST_GROUPS = 8
_ONE = Amplitude((Piece(Band(0.0, np.inf), 1.0),))


@dataclass
class Cover:
    """A limit (or the goal as a limit) to be proven on the box of factors `axes` over its bands.

    level
        What the greatest value (the least, with `least`) must not pass.
    """

    part: Limit | Aim
    axes: tuple[Axis, ...]
    level: float
    least: bool = False
    boxes: int = 0

    def proven(self, budget: Budget) -> bool:
        """Whether the level is kept everywhere; False where a budget of batches does not show it."""
        form, model = self.part.form.harmonic, self.part.model
        if form is None or form.rigid_link or len(form.drives) != 1 or model.mixed:
            return False
        if form.combine == "peak" and len(form.drives[0].lines) > 1 and self.least:
            return False
        drive = form.drives[0]
        if not np.isfinite(self.level) or not self._small(model, form, drive):
            return False
        return all(self._on(model, form, drive, piece, budget) for piece in pieces_of(drive))

    def _small(self, model: Model, form: Modulus, drive: Drive) -> bool:
        """Whether the polynomials are of a size that can be worked with."""
        groups = Groups.of(_with_speed(model, 1.0), form.output.signs)
        nodes = int(np.prod([d + 1.0 for d in groups.degrees]))
        return len(groups.members) <= _MOST_GROUPS and nodes <= _MOST_NODES and len(drive.lines) <= 4

    def _on(self, model: Model, form: Modulus, drive: Drive, piece: Band, budget: Budget) -> bool:
        middle = np.concatenate([np.ones(len(self.axes)), [max(0.5 * (piece.low + piece.high), 1e-9)]])
        lines = [
            sampled(_with_speed(model, line.order), replace(form.output, power=0), _bare(line), np.ones(1), middle)
            for line in drive.lines
        ]
        low = np.array([[*(axis.low for axis in self.axes), piece.low]])
        high = np.array([[*(axis.high for axis in self.axes), piece.high]])
        used = np.append((model.exponents != 0.0).any(axis=0), True)
        low[:, ~used] = high[:, ~used] = 1.0
        share = model.counts[form.output.shared_by].scale if form.output.shared_by else 1.0
        while len(low):
            if budget.over:
                return False
            budget.spend()
            take_low, take_high = low[-_BATCH:], high[-_BATCH:]
            self.boxes += len(take_low)
            good = self._kept(form, drive, lines, take_low, take_high, share)
            parts = _halved(take_low[~good], take_high[~good])
            low, high = np.concatenate([low[:-_BATCH], parts[0]]), np.concatenate([high[:-_BATCH], parts[1]])
        return True

    def _kept(
        self, form: Modulus, drive: Drive, lines: list[Sampled], low: FloatArray, high: FloatArray, share: float
    ) -> BoolArray:
        """Boxes on which the level is kept for sure, shape (n_boxes,)."""
        lowest, highest = [], []
        kept: BoolArray
        single = len(lines) == 1
        for line, made in zip(drive.lines, lines, strict=True):
            small, large = _amplitudes(line, form.output.power, low[:, -1], high[:, -1])
            top, bottom = box_coefficients(made, low, high)
            top, bottom = top[:, 0], bottom[:, 0]
            if single:
                bottom *= (self.level * share) ** 2
                room = _ROUNDING * np.abs(bottom).max(axis=-1, keepdims=True)
                if self.least:
                    kept = np.all(top * small[:, None] ** 2 >= bottom + room, axis=-1)
                else:
                    kept = np.all(top * large[:, None] ** 2 <= bottom - room, axis=-1)
                return kept
            least, most = ratio_bounds(top[:, None], bottom[:, None])
            lowest.append(np.sqrt(least[:, 0]) * small)
            highest.append(np.sqrt(most[:, 0]) * large)
        pairs = np.array(lowest if self.least else highest) / share
        total = np.sqrt((pairs**2).sum(axis=0)) if form.combine == "rss" else pairs.sum(axis=0)
        kept = total >= self.level if self.least else total <= self.level
        return kept


def _with_speed(model: Model, order: float) -> Model:
    """The model with the speed as its last variable; impedances are taken at a frequency of one."""
    powers = {INERTIA: 2.0, DAMPING: 1.0, HYSTERETIC: 0.0}
    terms = []
    for term in model.terms:
        power = powers.get(term.kind, 0.0)
        terms.append(replace(term, scale=term.scale * order**power, exponents=np.append(term.exponents, power)))
    return replace(model, terms=tuple(terms))


def _bare(line: Line) -> Line:
    """The line with an amplitude of one at a frequency of one."""
    return replace(line, order=1.0, amplitude=_ONE)


def pieces_of(drive: Drive) -> list[Band]:
    """Bands cut where an amplitude has a bend; points stay points."""
    breaks = sorted({speed for line in drive.lines for speed in line.amplitude.breaks()})
    found = []
    for band in drive.bands:
        cuts = [band.low, *(value for value in breaks if band.low < value < band.high), band.high]
        found += [Band(a, b) for a, b in pairwise(cuts)]
    return found


def _amplitudes(line: Line, power: int, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least and greatest |amplitude * frequency**power| over intervals of speeds within one piece, each (n,)."""
    middle = 0.5 * (low + high)
    pieces = line.amplitude.pieces
    ends = np.array([piece.band.high for piece in pieces[:-1]])
    which = np.searchsorted(ends, middle, side="left")
    first = np.array([piece.constant for piece in pieces])[which]
    slope = np.array([piece.slope for piece in pieces])[which]
    extra = np.array([piece.power for piece in pieces])[which]
    here, there = first + slope * low, first + slope * high
    small, large = np.minimum(np.abs(here), np.abs(there)), np.maximum(np.abs(here), np.abs(there))
    small = np.where(here * there < 0.0, 0.0, small)
    whole, size = (extra + power).astype(float), abs(line.order) ** power
    with np.errstate(divide="ignore", invalid="ignore"):
        least = small * np.where(whole < 0.0, high, low) ** whole
        most = large * np.where(whole < 0.0, low, high) ** whole
    return size * least, size * most


def _halved(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Each box cut in two across its side that is widest in ratio."""
    if not len(low):
        return low, high
    floor = np.maximum(low, 1e-3 * high)
    with np.errstate(divide="ignore", invalid="ignore"):
        wide = np.nan_to_num(np.log(high / floor))
    axis = wide.argmax(axis=1)
    rows = np.arange(len(low))
    cut = 0.5 * (low[rows, axis] + high[rows, axis])
    first, second = high.copy(), low.copy()
    first[rows, axis] = second[rows, axis] = cut
    return np.concatenate([low, second]), np.concatenate([first, high])
