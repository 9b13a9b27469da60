"""Invariant points: speeds at which a response has one value, whatever the spring and the damper of the chosen link.

(n0 + n1 kappa) / (d0 + d1 kappa) does not depend on kappa where n0 d1 = n1 d0.  For the stroke of an
absorber n1 is zero, and d1 is zero where the machine with the absorber locked resonates.
"""

from __future__ import annotations

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.bracketing import halved
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Band
from vibopt.solve.plane.link_plane import LinkPlane

_POINTS = 400
_REAL = 1e-9


@dataclass(frozen=True, slots=True)
class Invariant:
    """A limit that no spring and damper of the link can meet.

    speed
        Where the response cannot be changed [rad/s].
    value
        Its value there [SI].
    """

    limit: Limit
    speed: float
    value: float


def hopeless(program: Program) -> Invariant | None:
    """The limit missed most at a speed where the design has no say; None where there is none, or a third variable."""
    plane = LinkPlane.of(program)
    if plane is None or plane.other >= 0:
        return None
    found = []
    for limit in program.limits:
        form = limit.form
        if form.drives and limit.side == "at_most" and plane.accepts(limit):
            for band in form.drives[0].bands:
                found += _in_band(plane, limit, band)
    worst = max(found, key=lambda invariant: invariant.value / invariant.limit.bound, default=None)
    return worst if worst is not None and worst.value > worst.limit.bound * (1.0 + TOLERANCE) else None


def _in_band(plane: LinkPlane, limit: Limit, band: Band) -> list[Invariant]:
    if band.is_point or not np.isfinite(band.high) or limit.bound <= 0.0:
        return []
    speeds = np.linspace(band.low, band.high, _POINTS)
    bent, size = _difference(plane, limit, speeds)
    bent = bent * np.exp(-1j * np.angle(bent[np.abs(bent).argmax()]))
    if np.abs(bent.imag).max() > _REAL * size.max():
        return []
    turns = np.flatnonzero(np.sign(bent.real[:-1]) * np.sign(bent.real[1:]) < 0.0)
    found = []
    for i in turns:
        speed = _root(plane, limit, float(speeds[i]), float(speeds[i + 1]))
        n0, n1, d0, d1 = (abs(moebiu[0]) for moebiu in plane.moebius(limit, np.array([speed])))
        if d0 > 0.0 and n0 > 0.0 and max(n1 * d0, d1 * n0) <= 1e-6 * size.max():
            found.append(Invariant(limit, speed, float(n0 / d0)))
    return found


def _difference(plane: LinkPlane, limit: Limit, speeds: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """n0 d1 - n1 d0, on one line through zero where nothing else damps, and the size of its parts."""
    n0, n1, d0, d1 = plane.moebius(limit, speeds)
    return n0 * d1 - n1 * d0, np.abs(n0 * d1) + np.abs(n1 * d0)


def _root(plane: LinkPlane, limit: Limit, low: float, high: float) -> float:
    """Where the difference turns its sign, to the last digit."""
    left = _difference(plane, limit, np.array([low]))[0][0]

    def before(speed: float) -> bool:
        return bool((_difference(plane, limit, np.array([speed]))[0][0] * np.conj(left)).real > 0.0)

    return 0.5 * sum(halved(before, low, high))
