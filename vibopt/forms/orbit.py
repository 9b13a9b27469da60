"""Greatest of an orbit: what whirls about bearings that are not alike in both planes, over the speeds of unbalances."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms.form import Against, AtWorst, Local, Worst, by_differences, log_of, top_by_differences
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.harmonic import impedances, mount_count
from vibopt.mechanics.orbits import spun
from vibopt.mechanics.peaks import least, peaks
from vibopt.records import dataclass
from vibopt.signals import Band, Combine, Drive, Line, Output

if TYPE_CHECKING:
    from vibopt.mechanics.model import Model

_WITHIN, _MOST, _FROZEN = 0.5, 12, 5
"""Part of the greatest down to which other extremes are kept, how many, and spins of a band whose poles are taken."""
_CARRIED, _KNOWN = 1e-2, 1e-3
"""Part of all roundings that is carried to an axis, of each coefficient by itself, and of the axis by which it may be
off at most."""
_TOGETHER, _BESIDE, _EVEN = 1e-7, 1e-6, 1e-10
"""Part of a speed within which two are one; beside which a top is none where it rises by more than a part of itself."""


@dataclass(frozen=True, slots=True)
class Orbit(AtWorst):
    """Greater half axis of the ellipse on which a reading goes round, the greatest over bands of speeds.

    With F and B the forward and the backward part it is |F| + |B|.
    """

    output: Output
    shaken: tuple[Drive, ...]
    combine: Combine
    no_bounds = "is an orbit in bearings that are not alike in both planes, which has no bounds on boxes of designs"
    not_convex = "is an orbit in bearings that are not alike in both planes, which is not convex in the design"
    rough = "is an orbit in bearings that are not alike in both planes, whose axis has no statement as a formula"

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        found = {drive.name: self._tops(model, x, drive, least_wanted)[0] for drive in self.shaken}
        return Worst(self._total([one.value for one in found.values()]), {k: one.speed for k, one in found.items()})

    def _total(self, values: list[float]) -> float:
        return hypot(*values) if self.combine == "rss" else float(sum(values))

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """Of one excitation each; of several the worst of all together."""
        if len(self.shaken) > 1:
            worst = self.worst(model, x, least_wanted=least_wanted)
            speeds = tuple(worst.speeds.values())
            return [Local(log_of(worst.value), self._slope(model, x, speeds), speeds)]
        tops = self._tops(model, x, self.shaken[0], least_wanted)
        kept = [top for top in tops if least_wanted or top.value >= within * tops[0].value][:_MOST]
        return [self._local(model, x, one) for one in kept]

    def _local(self, model: Model, x: FloatArray, top: Extreme) -> Local:
        drive = self.shaken[0]
        moves = min(abs(top.speed - end) for end in edges(drive.bands)) > _BESIDE * top.speed

        def at(some: FloatArray, speeds: FloatArray) -> FloatArray:
            pairs = zip(some, speeds, strict=True)
            return np.array([self.sizes(model, one, drive, np.array([speed]))[0] for one, speed in pairs])

        return top_by_differences(at, x, top.value, top.speed, moves=moves)

    def _slope(self, model: Model, x: FloatArray, speeds: tuple[float, ...]) -> FloatArray:
        """Where the speeds stay: moving one changes nothing to first order."""

        def at(y: FloatArray) -> float:
            each = zip(self.shaken, speeds, strict=True)
            return self._total([float(self.sizes(model, y, drive, np.array([speed]))[0]) for drive, speed in each])

        return by_differences(at, x)

    def acting(self, model: Model) -> FloatArray:
        return model.acting

    def watched(self, ends: tuple[float, ...]) -> list[float]:
        return [line.order * end for drive in self.shaken for line in drive.lines for end in edges(drive.bands)]

    def cost(self, model: Model) -> float:
        return sum(2.0 if band.is_point else 60.0 for drive in self.shaken for band in drive.bands)

    def parts(self, model: Model, x: FloatArray, drive: Drive, speeds: FloatArray) -> ComplexArray:
        """Forward and backward part of the reading at speeds (k,) [rad/s], of each line of a drive, (n_lines, 2, k)."""
        rotor, n = spun(model, x), model.n_free
        found = []
        for line in drive.lines:
            omega = line.order * speeds
            size = line.amplitude.at(speeds) * (1j * omega) ** self.output.power / mount_count(model, self.output, x)
            found.append(rotor.reading(self.output, line.vector[:n], omega) * size)
        return np.array(found)

    def sizes(self, model: Model, x: FloatArray, drive: Drive, speeds: FloatArray) -> FloatArray:
        """Greater half axis at speeds of any shape [rad/s]."""
        with np.errstate(all="ignore"):
            axes = np.abs(self.parts(model, x, drive, np.ravel(speeds))).sum(axis=1)
        whole = np.array([self._total(one) for one in axes.T.tolist()]) if len(axes) > 1 else axes[0]
        return np.asarray(np.where(np.isnan(whole), np.inf, whole).reshape(np.shape(speeds)))

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """As of all, and how far rounding of each coefficient is carried to both parts where the orbit is greatest.

        No more than a number may be off that is told.
        """
        least, speeds = AtWorst.room(self, model, x, value, other, rounding), self.worst(model, x).speeds
        if any(self.output.held) or not all(speeds.values()):
            return least
        with np.errstate(all="ignore"), suppress(np.linalg.LinAlgError):
            moved = sum(
                self._carried(model, x, line, speeds[drive.name]) for drive in self.shaken for line in drive.lines
            )
            return max(least, min(_CARRIED * rounding * moved, _KNOWN * max(value, other)))
        return least

    def _carried(self, model: Model, x: FloatArray, line: Line, speed: float) -> float:
        """Sum of |coefficient| times what motion and adjoint make of it, forward and backward, nothing cancelled."""
        n, omega, rotor = model.n_free, line.order * speed, spun(model, x)
        stiff, rows = rotor.dynamic(omega, omega), np.kron(np.eye(2), self.output.row[:n])
        u = np.linalg.solve(stiff, np.concatenate([line.vector[:n], np.zeros(n)]))
        back = np.linalg.solve(stiff.T, rows.T)
        read, pushed = (np.abs(np.array(np.split(one, 2))) for one in (u, np.abs(back).sum(axis=1)))  # (2, n) each
        vectors, sizes = np.abs(model.vectors[:, :n]), np.abs(impedances(model, rotor.p, np.array(omega)))
        moved = float((sizes * (pushed @ vectors.T) * (read @ vectors.T)).sum())
        for one in model.bearings:
            film = np.add(
                *(
                    np.abs(part) * factor
                    for part, factor in zip(one.whirling(x, np.array(omega)), (1.0, omega), strict=True)
                )
            )
            moved += float((pushed @ np.abs(one.row[:n])) @ film @ (read @ np.abs(one.row[:n])))
        size = abs(float(line.amplitude.at(np.array([speed]))[0])) * omega**self.output.power
        return size * moved / mount_count(model, self.output, x)

    def against(self, model: Model, x: FloatArray, name: str, *, least_wanted: bool) -> Against:
        (drive,), others = ([one for one in self.shaken if (one.name == name) is own] for own in (True, False))
        rest = [self._tops(model, x, other, least_wanted)[0].value for other in others]
        knots = np.unique(np.concatenate([bearing.speeds for bearing in model.bearings]))
        spins = np.concatenate([frozen(band, knots) for band in drive.bands])
        singular = spun(model, x).singular(spins) if len(spins) else np.zeros(0, dtype=complex)
        response = partial(self.sizes, model, x, drive)
        return Against(response, singular, knots, self._total(rest), self.combine == "rss")

    def _tops(self, model: Model, x: FloatArray, drive: Drive, least_wanted: bool) -> list[Extreme]:
        """Local extremes over the bands, the worst first."""
        alone = replace(self, shaken=(drive,)).against(model, x, drive.name, least_wanted=least_wanted)
        response, singular, knots = alone.sizes, alone.singular, alone.breaks
        if least_wanted:
            return [least(response, drive.bands, singular, knots)]
        distinct: list[Extreme] = []
        for peak in peaks(response, drive.bands, singular, knots, within=_WITHIN):
            if all(abs(peak.speed - other.speed) > _TOGETHER * peak.speed for other in distinct):
                distinct.append(peak)
        around = np.array([one.speed for one in distinct])[:, None] * np.array([1.0 - _BESIDE, 1.0 + _BESIDE])
        inside = np.any([(around >= band.low) & (around <= band.high) for band in drive.bands], axis=0)
        beside = np.where(inside, response(around), -np.inf).max(axis=1)
        tops = [one for one, other in zip(distinct, beside, strict=True) if one.value * (1.0 + _EVEN) >= other]
        return tops or distinct[:1]


def edges(bands: Iterable[Band]) -> list[float]:
    """Both ends of each band [rad/s]."""
    return [end for band in bands for end in (band.low, band.high)]


def frozen(band: Band, knots: FloatArray) -> FloatArray:
    """Spins at which the coefficients say where the response to an unbalance is singular; none at one speed."""
    if band.is_point:
        return np.zeros(0)
    inside = knots[(knots > band.low) & (knots < band.high)]
    if not len(knots):
        return np.array([band.high])
    ends = np.array([band.low, *inside, band.high])
    middles = 0.5 * (ends[1:] + ends[:-1])
    return np.unique(np.concatenate([ends, middles, np.linspace(band.low, band.high, _FROZEN)]))
