"""What a peak in time of one mass is no less than on boxes of stiffness, damping and mass, however wide they are.

What is read, y, of m z'' + c z' + k z = load is known through weights t in time: n being the load as y feels it,

    max |y| >= |integral of n t| / integral of |m t'' - c t' + k t|,

and both are what is affine in the coefficients, one of it in size: on a box the quotient is least at a corner.  Two
kinds of weights are taken.  The answer h of some machine of the box to an impulse, backwards in time, whose own peak is
reached; for others, off by dk and dc, the integral below is 1 + that of |dk h + dc h'|.  And waves 1 + cos, for mounts
that are stiff: of one that is longer than about a turn of the mount, all below has one sign, and what is read is no
less than a mean of the load.  Of another mass everything counts per kilogram, and the load of a base goes by it; where
it is open alone, the quotient is least at an end, too, for k / m and c / m go straight by 1 / m.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS

if TYPE_CHECKING:
    from vibopt.forms.peak_in_time import PeakInTime
    from vibopt.forms.per_mass import PerMass
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.transient import Transient

_MOST, _TIMES, _LOW, _GRID, _WIDTHS, _BEHIND, _STAYS = 4, 48, 1e-3, 256, 14, 1.25, 1e6
"""Coefficients that may vary; times of a box that are tried; part of the middle of a side that its lower end is at
least; steps of the load, widths of waves on them, and how often its length what ends, or stays for ever, is weighed."""
_ALIKE, _ROUNDING, _CRITICAL = 1e-12, 1e-9, 1e-6
"""Parts: below which numbers are the same, that rounding may take of a floor, and from critical damping."""


def floors(form: PeakInTime, model: Model) -> Floors | None:
    """Of a peak in time; None where more moves than one mass under one load, or varies otherwise than `per_mass`."""
    output, own, held, lone = form.output, model.vectors[:, 0], model.kinds != INERTIA, form.per_mass(model)
    varies, blown = model.exponents.any(axis=1), any(segment.blows.any() for segment in form.segments)
    if (
        model.n_free != 1
        or form.segments[0].released is not None
        or not 0 < np.count_nonzero(varies) <= _MOST
        or (lone is None and not (held | ~varies).all())
        or not own[held].all()
        or (output.signs.any() and (output.power or output.signs[~held].any()))
        or (output.shared_by and model.counts[output.shared_by].exponents)
    ):
        return None
    moved, heavy = form.loads[1:], model.scales * own * ~held
    rides = -(model.vectors[held, 1:] @ moved) / own[held, None]  # the base's acceleration for each signal
    if np.ptp(rides, axis=0).max() > _ALIKE * np.abs(rides).max():
        return None
    load = form.loads[0] - heavy @ (own[:, None] * rides[0] + model.vectors[:, 1:] @ moved)
    parts = np.vstack([output.row[:1, None] * rides[:1], output.row[1:, None] * moved])
    led = np.where(np.abs(parts.sum(axis=0)) > _ALIKE * np.abs(parts).sum(axis=0), parts.sum(axis=0), 0.0)
    share, row = float(led @ load / max(load @ load, 1e-300)), float(output.row[0])  # of the base in what is read
    left = row + share * float(heavy @ own)
    if led.any() and (output.power != 2 or np.abs(led - share * load).max() > _ALIKE * np.abs(led).max()):
        return None
    if output.power == 2 and abs(left) > _ALIKE * abs(row):
        return None if blown else Floors(form, model, lone, share, None)
    return Floors(form, model, lone, share, (row * (output.power == 0), row * (output.power == 1)))


class Floors:
    """Floors of one peak.

    lone
        How it goes by the mass, where this is open.
    share
        What is read follows the acceleration of the base as so much of the load.
    plain
        What is read of position and velocity beside forces, by which waves weigh; None where more is read.
    """

    def __init__(
        self, form: PeakInTime, model: Model, lone: PerMass | None, share: float, plain: tuple[float, float] | None
    ) -> None:
        from vibopt.mechanics.harmonic import mount_count
        from vibopt.mechanics.readout import Reading

        self.form, self.model, self.plain = form, model, plain
        own, stiff, damped = model.vectors[:, 0], model.kinds == STIFFNESS, model.kinds == DAMPING
        ways, any_, heavy = form.output.signs + share * own, np.ones(model.n_vars), ~(stiff | damped)
        self.weights = np.array([stiff * own, damped * own, stiff * ways, damped * ways, heavy * own]) * own
        """Of coefficients: stiffness and damping, those of what is read, and the mass, (5, n_terms)."""
        self.shared, self.mass = mount_count(model, form.output, any_), float(model.scales @ self.weights[4])
        base = model.vectors[stiff | damped][0] / own[stiff | damped][0]
        self.moves = Reading(base, 0.0 * base, 0.0 * base), Reading(0.0 * base, base, 0.0 * base)
        self.factor = np.zeros(model.n_vars) if lone is None else lone.exponents
        self.motion, self.per_load = (0.0 if lone is None else lone.motion), bool(share)
        self.waves = self._waves(np.where(stiff | damped, 0.0, model.values(any_)))

    def on(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """On boxes low, high (n, n_vars): the floor (n,), zero where nothing is known, and about what part of it is
        lost for each variable's sake (n, n_vars).
        """
        corners = self._numbers(_corners(self.model, low, high))
        least, lost, middle = self._stiff(corners), high - low, 0.5 * (low + high)
        soft = np.where(self.factor > 0.0, high, np.maximum(low, _LOW * middle))
        p = self.model.values(soft if self.weights[2:4].any() else middle)
        good = np.flatnonzero(p @ self.weights[0] > 0.0)
        if len(good):
            found, lost[good] = self._about(p[good], corners[good], self._moved(low[good], high[good]))
            least[good] = np.maximum(least[good], found)
        return least * (1.0 - _ROUNDING) / self.shared, lost

    def _numbers(self, p: FloatArray) -> FloatArray:
        """Stiffness, damping, those of what is read and the mass at coefficients (..., n_terms), (..., 5)."""
        found = p @ self.weights.T
        if self.per_load:  # as much of a load that goes by the mass
            found[..., 2:4] *= self.mass / found[..., 4:]
        return np.asarray(found)

    def _moved(self, low: FloatArray, high: FloatArray) -> dict[int, FloatArray]:
        """How far variables move stiffness and damping on boxes, in parts of the most that one does, (n, n_vars)."""
        model, found = self.model, {}
        spread = np.abs(model.values(high) - model.values(low)) * np.abs(self.weights[:2]).sum(axis=0)
        heavier = np.abs(self.factor) * np.log(high / np.maximum(low, 1e-300))
        for kind in (STIFFNESS, DAMPING):
            own = model.kinds == kind
            each = spread[:, own] @ (model.exponents[own] != 0.0)
            each += (
                heavier
                * (model.values(0.5 * (low + high))[:, own] @ np.abs(self.weights[:2, own]).sum(axis=0))[:, None]
            )
            found[kind] = each / np.maximum(each.max(axis=1, keepdims=True, initial=0.0), 1e-300)
        return found

    def _about(
        self, p: FloatArray, corners: FloatArray, shares: dict[int, FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """By machines of coefficients p (n, n_terms), from others (n, n_corners, 5); what is lost goes by `shares`."""
        here, rows = self._numbers(p), np.arange(len(p))
        machine, reading = self.form.transient(self.model, p)
        behind = np.pi * np.sqrt(here[:, 4] / here[:, 0])
        times, (y, *z) = machine.few_samples([reading, *self.moves], behind, _TIMES)
        heavier = corners[..., 4] / here[:, None, 4]
        k, c = np.moveaxis(corners[..., :2] / heavier[..., None] - here[:, None, :2], -1, 0)
        read, rate = np.moveaxis(corners[..., 2:4] - here[:, None, 2:4], -1, 0)
        numbers = y[:, None] + read[..., None] * z[0][:, None] + rate[..., None] * z[1][:, None]
        numbers = numbers * (heavier**self.motion)[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            found = numbers * np.sign(y)[:, None] / (1.0 + self._variation(here, k, c, times))
            found = np.nan_to_num(found.min(axis=1))
            best = rows, found.argmax(axis=1)
            lost = np.zeros((len(p), self.model.n_vars))
            for kind, off, more, move in ((STIFFNESS, k, read, z[0]), (DAMPING, c, rate, z[1])):
                one = np.abs(off).max(axis=1)[:, None]
                pair = (one, 0.0 * one) if kind == STIFFNESS else (0.0 * one, one)
                part = self._variation(here, *pair, times[best][:, None])[:, 0, 0]
                part += np.abs(more).max(axis=1) * np.abs(move[best] / y[best])
                lost += part[:, None] * shares[kind]
            if self.motion:
                lost += (np.ptp(heavier, axis=1) * (self.factor != 0.0).T[:, None]).T
        return np.maximum(found[best], 0.0), np.nan_to_num(lost)

    def _variation(self, here: FloatArray, dk: FloatArray, dc: FloatArray, times: FloatArray) -> FloatArray:
        """Integral of |dk h + dc h'| from 0 to times (n, n_times), with dk, dc (n, n_corners); (n, n_corners, n_times).

        It is how much the answer dk (to a step) + dc (to an impulse) goes up and down altogether: between its turning
        points, which below the critical damping come at even steps, each swing a like part of the one before.
        """
        k, c, m = here.T[[0, 1, 4], :, None, None]
        dk, dc, last = dk[..., None], dc[..., None], times[:, None]
        decay = 0.5 * c / m
        rest = decay**2 - k / m
        rate, swings = np.maximum(np.sqrt(np.abs(rest)), _CRITICAL * np.sqrt(k / m)), rest < 0.0
        slow, fast = -k / m / (decay + rate), -(decay + rate)

        def at(t: FloatArray) -> FloatArray:
            fall, ea, eb = np.exp(-decay * t), np.exp(slow * t), np.exp(fast * t)
            sine = np.where(swings, fall * np.sin(rate * t), 0.5 * (ea - eb)) / rate
            cosine = np.where(swings, fall * np.cos(rate * t), 0.5 * (ea + eb))
            return np.asarray(dk * (1.0 - cosine - decay * sine) / k + dc * sine / m)

        lead, half = (dk - decay * dc) / rate, np.pi / rate
        turn = np.mod(-np.arctan2(dc, lead), np.pi)
        with np.errstate(divide="ignore"):
            once = np.arctanh(np.clip(-dc / np.where(lead == 0.0, 1e-300, lead), -1.0, 1.0))
        first = np.where(swings, np.where(turn > 0.0, turn, np.pi), np.where(once > 0.0, once, np.inf)) / rate
        begin = np.minimum(first, last)
        count = np.where(swings, np.maximum(np.floor((last - begin) / half), 0.0), 0.0)
        some = np.where(swings, first, 0.0)
        each, swing = -decay * half, np.abs(at(some + half) - at(some))
        alike = np.abs(each) <= _ALIKE
        swung = swing * np.where(alike, count, np.expm1(each * count) / np.expm1(np.where(alike, -1.0, each)))
        return np.asarray(
            np.abs(at(begin)) + np.where(count > 0.0, swung, 0.0) + np.abs(at(last) - at(begin + count * half))
        )

    def _waves(self, p: FloatArray) -> FloatArray:
        """Half-widths [s], and integrals of the load times the wave and its slope where that says most, (3, n).

        From the mass of coefficients p alone under the load, and on a spring with which it would swing once in a
        width: they are differences of positions and velocities.
        """
        still, _ = self.form.transient(self.model, p)
        ends, segments, last = self.moves[0].row, self.form.segments, self.form.segments[-1]
        long = _BEHIND if not last.endless else 1.0 if (last.rates @ last.start).any() else _STAYS
        times = np.linspace(0.0, long * sum(float(segment.length) for segment in segments), _GRID + 1)

        def swung(rate: float) -> Transient:
            return replace(still, stiffness=self.mass * rate**2 * np.outer(ends, ends))

        place, speed = self.moves
        free, found = swung(0.0).history(speed, times), []
        for many in np.unique(np.geomspace(1, _GRID // 2, _WIDTHS).astype(int)):
            rate = np.pi / times[many]
            machine = swung(rate)
            even = 0.5 * self.mass * _across(free - machine.history(speed, times), 2 * many)
            slope = -0.5 * self.mass * rate**2 * _across(machine.history(place, times), 2 * many)
            at = np.abs(even).argmax()
            found.append((times[many], even[at], slope[at]))
        return np.array(found).T

    def _stiff(self, corners: FloatArray) -> FloatArray:
        """By waves, at coefficients (n, n_corners, 5)."""
        if self.plain is None:
            return np.zeros(len(corners))
        width, even, slope = self.waves
        fixed = np.array([0.0, 0.0, *self.plain, 0.0])
        k, c, read, rate, mass = np.moveaxis(corners + fixed, -1, 0)[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            swing = np.hypot(k - mass * (np.pi / width) ** 2, c * np.pi / width)
            turn = np.arccos(np.clip(-k / swing, -1.0, 1.0))  # where what is k + swing cos changes its sign
            size = width * (k * (2.0 * turn - np.pi) + 2.0 * swing * np.sin(turn)) / np.pi
            number = (read * even - rate * slope) * (mass / self.mass) ** (1.0 + self.motion)
            least = (number * np.sign(number[:, :1]) / size).min(axis=1).max(axis=1)
        return np.asarray(np.maximum(np.nan_to_num(least), 0.0))


def _across(values: FloatArray, many: int) -> FloatArray:
    """How much values (n,) have changed over so many steps, from zero before the first."""
    return np.concatenate([values[:many], values[many:] - values[:-many]])


def _corners(model: Model, low: FloatArray, high: FloatArray) -> FloatArray:
    """Coefficients at the corners of what they may be on boxes, (n, n_corners, n_terms)."""
    exponents, varies = model.exponents, np.flatnonzero(model.exponents.any(axis=1))
    ups: BoolArray = np.zeros((2 ** len(varies), len(exponents)), dtype=bool)
    ups[:, varies] = list(product([False, True], repeat=len(varies)))
    x = np.where((ups[..., None] == (exponents > 0.0)), high[:, None, None], low[:, None, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(model.scales * np.prod(x**exponents, axis=-1))
