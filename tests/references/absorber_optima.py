"""Least greatest amplitudes of absorbers on chains of masses: equal peaks in forty digits.

Imports nothing of the project.  A chain of masses stands on the ground, link i below mass i (damping ratio
against that mass); a force of one acts on mass `on`, mass `of` is read, absorbers (host, mass ratio to the
host, tuning to the chain's lowest frequency, damping ratio) hang on masses.  At the optimum some peaks (or ends
of bands) are equally high and a mean of their slopes vanishes; Newton solves these conditions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import mp, mpc, mpf

DIGITS = 40
Real = Any


@dataclass(frozen=True)
class Chain:
    """Masses [kg], stiffnesses [N/m] and damping ratios from the ground up; force and reading by mass number."""

    masses: tuple[float, ...]
    springs: tuple[float, ...]
    ratios: tuple[float, ...]
    on: int
    of: int
    hosts: tuple[int, ...]
    mu: tuple[float, ...]
    fixed: tuple[float, ...] = ()
    """Ends of bands [rad/s] that are as high as the peaks."""

    def lowest(self) -> Real:
        """Lowest undamped frequency of the bare chain [rad/s], polished in full precision."""
        mp.dps = DIGITS + 15
        n = len(self.masses)
        stiff = np.zeros((n, n))
        for i, k in enumerate(self.springs):
            stiff[i, i] += k
            if i:
                stiff[i - 1, i - 1] += k
                stiff[i, i - 1] -= k
                stiff[i - 1, i] -= k
        root = 1.0 / np.sqrt(np.array(self.masses))
        square = mpf(float(np.linalg.eigvalsh(root[:, None] * stiff * root)[0]))
        return mp.sqrt(mp.findroot(self._undamped, (square, square * (1 + mpf(10) ** -9)), tol=mpf(10) ** -80))

    def _undamped(self, square: Real) -> Real:
        """Determinant of K - w^2 M by its three-term recursion, each row divided by its spring."""
        before, now = mpf(0), mpf(1)
        n = len(self.masses)
        for i in reversed(range(n)):
            above = mpf(self.springs[i + 1]) if i + 1 < n else mpf(0)
            own = mpf(self.springs[i]) + above - square * mpf(self.masses[i])
            before, now = now, (own * now - (above * above * before if above else 0)) / mpf(self.springs[i])
            before = before / mpf(self.springs[i])
        return now

    def amplitude(self, omega: Real, design: Sequence[Real], lowest: Real) -> Real:
        """Amplitude of mass `of` under a force of one on mass `on` [m/N]; design is tuning and ratio by absorber."""
        n = len(self.masses)
        s = mpc(0, 1) * omega
        links = [
            mpf(k) + s * 2 * mpf(z) * mp.sqrt(mpf(k) * mpf(m))
            for k, z, m in zip(self.springs, self.ratios, self.masses, strict=True)
        ]
        own = [links[i] + (links[i + 1] if i + 1 < n else 0) - omega**2 * mpf(self.masses[i]) for i in range(n)]
        for a, host in enumerate(self.hosts):
            mass = mpf(self.mu[a]) * mpf(self.masses[host])
            alone = design[2 * a] * lowest
            spring = mass * alone**2 + s * 2 * design[2 * a + 1] * mass * alone
            own[host] += -(omega**2) * mass * spring / (spring - omega**2 * mass)
        right = [mpc(0)] * n
        right[self.on] = mpc(1)
        for i in range(1, n):
            factor = links[i] / own[i - 1]
            own[i] -= factor * links[i]
            right[i] += factor * right[i - 1]
        u = [mpc(0)] * n
        for i in reversed(range(n)):
            u[i] = (right[i] + (links[i + 1] * u[i + 1] if i + 1 < n else 0)) / own[i]
        return abs(u[self.of])


def equal_peaks(chain: Chain, design: Sequence[float], peaks: Sequence[float]) -> tuple[Real, list[Real]]:
    """The optimum near a design and its peaks [rad/s]: log-stationary, in `DIGITS` digits.

    Returns the amplitude [m/N] and the design.
    """
    mp.dps = DIGITS + 15
    lowest = chain.lowest()
    n, free = len(design), len(peaks)
    marks = [mpf(w) for w in chain.fixed]
    step = mpf(10) ** -18

    def height(omega: Real, x: Sequence[Real]) -> Real:
        return mp.log(chain.amplitude(omega, x, lowest))

    def slopes(omega: Real, x: list[Real]) -> list[Real]:
        found = []
        for i in range(n):
            up, down = list(x), list(x)
            up[i] += step
            down[i] -= step
            found.append((height(omega, up) - height(omega, down)) / (2 * step))
        return found

    def residuals(unknown: list[Real]) -> list[Real]:
        x, moving, weights, level = unknown[:n], unknown[n : n + free], unknown[n + free : -1], unknown[-1]
        speeds = [*moving, *marks]
        rows = [height(w, x) - level for w in speeds]
        rows += [(height(w * (1 + step), x) - height(w * (1 - step), x)) / (2 * step) for w in moving]
        tilts = [slopes(w, x) for w in speeds]
        rows += [sum(weight * tilt[i] for weight, tilt in zip(weights, tilts, strict=True)) for i in range(n)]
        return [*rows, sum(weights) - 1]

    x = [mpf(v) for v in design]
    level = mp.log(max(chain.amplitude(mpf(w), x, lowest) for w in [*peaks, *chain.fixed]))
    tilts = np.array([[float(v) for v in slopes(mpf(w), x)] for w in [*peaks, *chain.fixed]])
    table = np.vstack([tilts.T / max(np.abs(tilts).max(), 1e-300), np.ones(len(tilts))])
    guess = np.linalg.lstsq(table, np.append(np.zeros(n), 1.0), rcond=None)[0]
    unknown = [*x, *[mpf(w) for w in peaks], *[mpf(float(v)) for v in guess], level]
    unknown = _newton(residuals, unknown)
    weights = unknown[n + free : -1]
    if min(weights) < -(mpf(10) ** -8):
        raise ArithmeticError("not a minimum: a weight is negative")
    return mp.e ** unknown[-1], unknown[:n]


def _newton(residuals: Any, unknown: list[Real]) -> list[Real]:
    size, step = len(unknown), mpf(10) ** -14
    for _ in range(40):
        here = residuals(unknown)
        jacobian = mp.matrix(size, size)
        for j in range(size):
            moved = list(unknown)
            room = step * max(abs(unknown[j]), mpf(1))
            moved[j] += room
            there = residuals(moved)
            for i in range(size):
                jacobian[i, j] = (there[i] - here[i]) / room
        change = mp.lu_solve(jacobian, mp.matrix(here))
        unknown = [value - change[i] for i, value in enumerate(unknown)]
        if max(abs(change[i]) / max(abs(unknown[i]), mpf(1)) for i in range(size)) < mpf(10) ** -25:
            return unknown
    raise ArithmeticError("Newton did not settle")
