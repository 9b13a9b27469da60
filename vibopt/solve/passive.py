"""What no passive device of a given mass can do, however it is made: a bound beside absorbers that many starts found.

What hangs on one coordinate of a host, and on nothing else, answers its velocity through an impedance Y(s) that is
positive real, and for real s > 0 no greater than M s, M being its mass: stuck to the host it would move as one with it.
So the mobility W = 1 / (1 / W0 + Y) of the host is positive real too, is known at rest and at high speed, and at any
real s lies between 1 / (1 / W0 + M s) and W0.  Let F(s) be real on the imaginary axis but for a window (w1, w2) within
the range, not positive outside it, and analytic in the right half plane but for a pole at one real s.  Residues give

    integral of Re(W F) over w > 0  =  pi / 2 (F(inf) [s W](inf) + [-s^2 F](0) [W / s](0) + R W(s) / s).

Outside the window the integrand takes away.  Inside, |W| <= h / g where the response g |W| is no greater than h; so h
is at least the right side over the integral of |F| / g.  Any such F gives a true bound, and the best of a family of
them is looked for.  Of a mass on an undamped spring it is sqrt(1 + 1 / mu) of the static motion, where the best
absorber of one mass reaches sqrt(1 + 2 / mu).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.bracketing import halved
from vibopt.forms import Monomials
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Band
from vibopt.solve.boundable import FAR
from vibopt.solve.method import Found

_NODES, _FINAL = 48, 400
"""Points of an integral over a window: while the window is looked for, and for the bound itself."""
_SAFETY = 1e-6
"""Part of a bound that the integrals and rounding may take."""
_REALS = (0.03, 0.3, 1.0)
"""Real s to begin with, in parts of a natural frequency; at less of it digits would be lost."""
_ROUNDS, _TURNS, _MODES = 400, 3, 3
_NEAR = 1e-9
_HUNDRED = 99.5
"""Percent from which on they are whole numbers."""
_LIGHTEST, _COARSE, _FINE = 0.02, 0.008, 1e-15
"""Part of its mass down to which a lighter device is looked for, to which it is known, and to which a level is."""


@dataclass(frozen=True, slots=True)
class Hung:
    """A response of the coordinate of a host on which everything hangs that can be chosen.

    mass, damping, stiffness
        Of the host alone, each (n, n).
    place
        Of the coordinate among those of the host.
    shaken
        Response per mobility at frequencies (n,) [rad/s], shape (n,).
    bands
        Frequencies at which it counts [rad/s].
    carried
        Per term of the model how much of its inertia moves with the coordinate, shape (n_terms,).
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    place: int
    shaken: Callable[[FloatArray], FloatArray]
    bands: tuple[Band, ...]
    carried: FloatArray

    @property
    def damper(self) -> float:
        """Of a host that is one mass: it is taken into account by itself [N s/m]."""
        return float(self.damping[0, 0]) if len(self.mass) == 1 else 0.0

    def mobility(self, s: float) -> float:
        """Of the bare host at a real s, the damper of a lone mass left out."""
        damping = self.damping if len(self.mass) > 1 else 0.0 * self.damping
        return s * self._at(self.stiffness + s * damping + s * s * self.mass)

    @property
    def ends(self) -> tuple[float, float]:
        """Mobility times s at high speed, and over s at rest."""
        return self._at(self.mass), self._at(self.stiffness)

    @property
    def modes(self) -> list[tuple[float, float]]:
        """Natural frequency [rad/s] and modal mass at the coordinate, of modes that move it."""
        half = np.linalg.inv(np.linalg.cholesky(self.mass))
        values, shapes = np.linalg.eigh(half @ self.stiffness @ half.T)
        parts = (half.T @ shapes)[self.place] ** 2
        found = [(float(np.sqrt(v)), 1.0 / float(p)) for v, p in zip(values, parts, strict=True) if p > 0.0]
        return sorted(found, key=lambda one: one[1])[:_MODES]

    def _at(self, matrix: FloatArray) -> float:
        return float(np.linalg.inv(matrix)[self.place, self.place])


def hung(part: Limit | Aim) -> Hung | None:
    """A response as that of a coordinate on which all that can be chosen hangs; None where it is anything else."""
    form, model = part.form.harmonic, part.model
    line = None if form is None else form.line
    if form is None or line is None or part.least_wanted or form.endless or (model.kinds == HYSTERETIC).any():
        return None
    n, row = model.n_free, form.output.row
    at = np.flatnonzero(row)
    if form.output.signs.any() or form.output.shared_by or len(at) != 1 or at[0] >= n or line.order <= 0.0:
        return None
    free = _hanging(model, int(at[0]))
    if free is None or not free.any() or line.vector[:n][free].any():
        return None
    owned = (model.vectors[:, :n][:, free] != 0.0).any(axis=1)
    host, values = ~free, np.where(owned, 0.0, model.scales)
    whole = [model.matrix(kind, values)[:n][host] for kind in (INERTIA, DAMPING, STIFFNESS)]
    m, c, k = (one[:, :n][:, host] for one in whole)
    if min(np.linalg.eigvalsh(one)[0] / max(float(np.abs(one).max()), 1e-300) for one in (m, k)) <= _NEAR:
        return None
    place = int(host[: at[0]].sum())

    def shaken(w: FloatArray) -> FloatArray:
        s = 1j * w[:, None, None]
        stiff = s**2 * whole[0] + s * whole[1] + whole[2]
        load = line.vector[:n][host] - stiff[:, :, n:] @ line.vector[n:]
        unit = np.broadcast_to(np.eye(len(m))[place], load.shape)
        moved = np.linalg.solve(stiff[:, :, :n][:, :, host], np.stack([load, unit], axis=-1))[:, place]
        size = abs(row[at[0]]) * np.abs(line.amplitude.at(w / line.order)) * w ** (form.output.power - 1.0)
        return np.asarray(size * np.abs(moved[:, 0] / moved[:, 1]))

    bands = tuple(
        Band(line.order * band.low, line.order * band.high) for band in form.drives[0].bands if not band.is_point
    )
    stuck = model.vectors[:, :n] @ free + model.vectors[:, at[0]]
    carried = np.where((model.kinds == INERTIA) & owned, stuck**2, 0.0)
    return Hung(m, c, k, place, shaken, bands, carried)


def _hanging(model: Model, place: int) -> BoolArray | None:
    """Free coordinates (n_free,) that hang on one and on nothing else; None where anything else can be chosen."""
    n, touched = model.n_free, model.vectors != 0.0
    free = np.zeros(n, dtype=bool)
    variable = model.exponents.any(axis=1)
    for t in np.flatnonzero(variable):
        free |= touched[t, :n]
    free[place] = False
    others = np.arange(touched.shape[1]) != place
    for _ in range(n):
        reached = touched[:, :n][:, free].any(axis=1)
        if touched[reached][:, n:].any():
            return None
        grown = free | (touched[reached][:, :n].any(axis=0) & others[:n])
        if (grown == free).all():
            break
        free = grown
    owned = touched[:, :n][:, free].any(axis=1)
    stuck = model.vectors[:, :n] @ (free | ~others[:n])
    size = np.abs(model.vectors).max(axis=1)
    holds = model.across | (model.kinds != INERTIA)
    if (variable & ~owned).any() or (np.abs(stuck[owned & holds]) > _NEAR * size[owned & holds]).any():
        return None
    weighs = owned & ~holds & touched[:, place]
    return None if weighs.any() else free


@dataclass(frozen=True, slots=True)
class _Window:
    """F = ((z - z1) (z2 - z) + i b (z - z0) sqrt((z - z1) (z2 - z))) / (z (z + s^2)), z = w^2, within the window."""

    z1: float
    z2: float
    z0: float
    b: float
    s: float

    @classmethod
    def of(cls, logs: FloatArray, band: Band) -> _Window | None:
        """From log w1, log w2, log s, log b and where z0 lies; None where nothing is left of it in the band."""
        z1, z2 = np.clip(np.exp(2.0 * np.clip(logs[:2], -50.0, 50.0)), band.low**2, band.high**2)
        if not z2 > 1.0001 * z1:
            return None
        z0 = z1 + (z2 - z1) / (1.0 + np.exp(-np.clip(logs[4], -30.0, 30.0)))
        s = max(np.exp(np.clip(logs[2], -50.0, 50.0)), _REALS[0] * np.sqrt(z1))
        return cls(float(z1), float(z2), float(z0), float(np.exp(np.clip(logs[3], -30.0, 10.0))), float(s))

    def cap(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Frequencies (count,) [rad/s] and the weight of each in the integral of |F|."""
        t = (np.arange(count) + 0.5) * np.pi / count
        half = 0.5 * (self.z2 - self.z1)
        z, side = 0.5 * (self.z1 + self.z2) - half * np.cos(t), half * np.sin(t)
        f = np.hypot(side**2, self.b * (z - self.z0) * side) / (z * (z + self.s**2))
        return np.sqrt(z), f * side * (np.pi / count) / (2.0 * np.sqrt(z))

    def known(self, host: Hung, mass: float) -> float:
        """What the integral of Re(W F) is no less than, with a device of so much mass."""
        z1, z2, z0, b, s = self.z1, self.z2, self.z0, self.b, self.s
        fast, slow = host.ends
        bare, z = host.mobility(s), -s * s
        residue = ((z - z1) * (z2 - z) + b * (z - z0) * np.sqrt((z1 - z) * (z2 - z))) / z
        there = bare / (1.0 + bare * mass * s) if residue > 0.0 else bare
        rest = -(z1 * z2 + b * z0 * np.sqrt(z1 * z2)) / s**2
        return float(0.5 * np.pi * (-(1.0 + b) * fast + rest * slow + residue * there / s))


@dataclass(frozen=True, slots=True)
class Device:
    """The best bound of a response of a host, whatever hangs on it."""

    host: Hung

    def least(self, mass: float) -> float:
        """The greatest response is no less than this with any passive device of so much mass; 0 if nothing is known."""
        return max((self._least(mass, *one) for one in self._begun(mass)), default=0.0)

    def never_keeps(self, bound: float, mass: float) -> bool:
        """Whether the response is known to be more than a bound with any passive device of so much mass."""
        return any(self._least(mass, *one, bound) > bound for one in self._begun(mass))

    def _begun(self, mass: float) -> Iterator[tuple[Band, FloatArray]]:
        for band in self.host.bands:
            for w, own in self.host.modes:
                mu = mass / own
                middle, product = (1.0 + 2.0 * mu) / (1.0 + mu), (1.0 + mu) ** -2
                z = middle + np.sqrt(max(middle**2 - product, 0.0)) * np.array([-1.0, 1.0])
                if w * np.sqrt(z[1]) > band.low and w * np.sqrt(z[0]) < band.high:
                    for part in _REALS[: None if self.host.damping.any() and not self.host.damper else 1]:
                        yield band, np.array([*(0.5 * np.log(z) + np.log(w)), np.log(part * w), 0.0, 0.0])

    def _least(self, mass: float, band: Band, begun: FloatArray, enough: float = np.inf) -> float:
        """The best bound near a window, or the first that is more than `enough`."""
        from scipy.optimize import minimize

        def falling(y: FloatArray, level: float) -> float:
            return -self._linear(_Window.of(y, band), mass, level)

        best = 0.0
        options: Any = {"maxfev": _ROUNDS, "xatol": 1e-5, "fatol": 1e-12}
        for _ in range(_TURNS if self.host.damper else 1):
            found: Any = minimize(partial(falling, level=best), begun, method="Nelder-Mead", options=options)
            begun = found.x
            best = max(best, (1.0 - _SAFETY) * self._proven(_Window.of(begun, band), mass))
            if best > enough:
                break
        return best

    def _linear(self, window: _Window | None, mass: float, level: float) -> float:
        """The bound with the damper of the host taken as at a level of the response."""
        return 0.0 if window is None else window.known(self.host, mass) / self._cap(window, level, _NODES)

    def _cap(self, window: _Window, level: float, count: int) -> float:
        """Integral of |F| / g; a damper c of the host itself leaves 1 / (g - c h)."""
        w, weights = window.cap(count)
        with np.errstate(divide="ignore"):
            room = self.host.shaken(w) - self.host.damper * level
            return float((weights / np.where(room > 0.0, room, 0.0)).sum())

    def _proven(self, window: _Window | None, mass: float) -> float:
        """The greatest level h that h times the integral leaves proven."""
        if window is None:
            return 0.0
        known = window.known(self.host, mass)
        high = max(known / self._cap(window, 0.0, _FINAL), 0.0)
        if not self.host.damper:
            return high
        return halved(lambda level: level * self._cap(window, level, _FINAL) <= known, 0.0, high, _FINE)[0]


def with_bound(program: Program, found: Found) -> Found:
    """An answer that is not proven with the bound of any passive device in its place, where one is known."""
    aim = program.aim
    if found.status != "feasible" or found.x is None or aim is None or aim.others or aim.sense < 0.0 or program.ties:
        return found
    value = aim.form.value(aim.model, found.x)
    least = _least_mass(program, aim, value) if aim.form.powers is not None else _least_response(program, aim)
    known = found.bound if np.isfinite(found.bound) else 0.0
    if not max(known, 0.0) < least < value < np.inf:
        return found
    if value > least * np.exp(FAR):
        return replace(found, bound=least, details={**found.details, "bound": least})
    what = "same mass could reach" if aim.form.powers is None else "least mass would weigh"
    part = 100.0 * (value / least - 1.0)
    above = f"at most {part:{'.2g' if part < _HUNDRED else '.0f'}} % above what any passive device of the {what}"
    claim = f"{found.claim}; {above}, however it is made"
    return replace(found, claim=claim, bound=least, details={**found.details, "bound": least})


def _least_response(program: Program, aim: Aim) -> float:
    host = hung(aim)
    return 0.0 if host is None else Device(host).least(_most(program, aim.model, host.carried))


def _least_mass(program: Program, aim: Aim, value: float) -> float:
    """The goal, which counts the mass of what hangs, is no less than this where a limit on the host is to hold."""
    best, powers = 0.0, aim.form.powers
    assert powers is not None
    for limit in program.limits:
        host = hung(limit) if limit.side == "at_most" and (powers.scale >= 0.0).all() else None
        share = 0.0 if host is None else _counted(powers, limit.model, host.carried).min()
        if host is None or not share > 0.0:
            continue
        low, high = value / share * _LIGHTEST, value / share

        def too_light(mass: float, host: Hung = host, bound: float = limit.bound) -> bool:
            return Device(host).never_keeps(bound, mass)

        if too_light(low):
            best = max(best, halved(too_light, low, high, _COARSE, by_ratios=True)[0] * share)
    return best


def _counted(powers: Monomials, model: Model, carried: FloatArray) -> FloatArray:
    """By how much of its value each different part of the mass that hangs is counted in a sum of powers; (n_parts,)."""
    rows, which = model.alike
    own = np.bincount(which, carried * model.scales, len(rows))
    counted = np.array([powers.scale[(powers.exponents == row).all(axis=1)].sum() for row in rows])
    return np.asarray(counted[own > 0.0] / own[own > 0.0])


def _most(program: Program, model: Model, carried: FloatArray) -> float:
    """The greatest mass that may hang: by the ranges, or by a limit that counts all of it."""
    most = float(carried @ model.extent(program.low, program.high)[1])
    for limit in program.limits:
        powers = limit.form.powers
        if powers is None or limit.side != "at_most" or (powers.scale < 0.0).any():
            continue
        share = float(_counted(powers, model, carried).min())
        most = min(most, limit.bound / share) if share > 0.0 else most
    return most
