"""What resists a free whirl at one spin: each sense of whirl by itself, and the few stretches that couple them.

Forward and backward motion of a shaft meet in bearings and dampers alone, so that it takes a system of each sense, and
one of their stretches, to solve for both.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.orbits import Half, Spun
from vibopt.records import cached_property

_BESIDE, _TRIED, _SETTLED, _FALLS = 1e-6, 12, 1e-14, 0.3
"""Part of a frequency by which what is solved stands beside it; steps; part of the frequency by which one is the last;
and of the one before that it is at most."""


class Resistance:
    """Dynamic stiffness still + w first + w^2 second of a rotor at a spin [rad/s], over the motions of `Spun`."""

    def __init__(self, rotor: Spun, spin: float) -> None:
        self.rotor, self.spin = rotor, spin
        self.senses = (rotor.known,) if isinstance(rotor, Half) else (1.0, -1.0)

    @cached_property
    def powers(self) -> tuple[ComplexArray, ComplexArray, FloatArray]:
        """The three matrices."""
        return self.rotor.dynamic(0.0, self.spin), *self.rotor.powers(self.spin)

    @cached_property
    def _scaled(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """Stiffness, mass, polar inertia (n, n) and rows (r, n) of either sense by the size of each motion (n,)."""
        known: dict[str, tuple[FloatArray, ...]] = vars(self.rotor)
        if "scaled" not in known:
            rotor = self.rotor
            size = np.sqrt(np.diagonal(rotor.held))
            scale = np.outer(size, size)
            known["scaled"] = rotor.held / scale, rotor.mass / scale, rotor.polar / scale, rotor.rows / size, size
        held, mass, polar, rows, size = known["scaled"]
        return held, mass, polar, rows, size

    @cached_property
    def _coupled(self) -> tuple[ComplexArray, ComplexArray]:
        """What acts between stretches, and what more per frequency."""
        at, r = np.array([self.spin]), len(self.rotor.rows)
        still, more = (self.rotor.coupling(one, at)[0] for one in (np.zeros(1), np.ones(1)))
        own = np.arange(2 * r) if len(self.senses) > 1 else np.arange(r) + (r if self.senses[0] < 0.0 else 0)
        return still[np.ix_(own, own)], (more - still)[np.ix_(own, own)]

    def _on(self, way: ComplexArray) -> ComplexArray:
        """What the three powers of the frequency do to a motion (n_senses, n), (n_senses, 3, n)."""
        held, mass, polar, rows, _ = self._scaled
        parts = np.concatenate([way.real, way.imag])
        by_held, by_mass, by_polar = (
            ahead + 1j * aside for ahead, aside in (np.split(parts @ one, 2) for one in (held, mass, polar))
        )
        stretch = (way @ rows.T).ravel()
        pulls = [(one @ stretch).reshape(len(way), len(rows)) @ rows for one in self._coupled]
        turned = self.spin * np.array(self.senses)[:, None] * by_polar
        return np.stack([by_held + pulls[0], turned + pulls[1], -by_mass], axis=1)

    def _inverse(self, rate: complex) -> Callable[[ComplexArray], ComplexArray]:
        """What solves for motions (n_senses, m, n) at a frequency."""
        from scipy.linalg import lapack

        held, mass, polar, rows, _ = self._scaled
        each = [
            lapack.zgetrf((held - rate**2 * mass + sense * rate * self.spin * polar).T, overwrite_a=True)
            for sense in self.senses
        ]

        def apart(loads: ComplexArray) -> ComplexArray:
            both = zip(each, loads, strict=True)
            return np.array([lapack.zgetrs(*one[:2], own.T)[0].T for one, own in both], dtype=complex)

        bent = apart(np.broadcast_to(rows, (len(self.senses), *rows.shape)).astype(complex))  # (n_senses, r, n)
        acts, r = self._coupled[0] + rate * self._coupled[1], len(rows)
        flexible = np.zeros_like(acts)
        for k, one in enumerate(bent):
            flexible[k * r : (k + 1) * r, k * r : (k + 1) * r] = rows @ one.T
        back = acts @ np.linalg.inv(np.eye(len(acts)) + flexible @ acts)

        def solve(loads: ComplexArray) -> ComplexArray:
            alone = apart(loads)
            stretch = np.swapaxes(alone @ rows.T, 0, 1).reshape(loads.shape[1], len(acts))
            pulled = (stretch @ back.T).reshape(loads.shape[1], len(loads), r)
            return np.asarray(alone - np.swapaxes(pulled, 0, 1) @ bent)

        return solve

    def freed(self, rate: complex, way: ComplexArray) -> tuple[complex, ComplexArray] | None:
        """A frequency at which a motion is resisted no more and that motion, near some; None where it does not settle.

        What is left is solved for at one frequency beside it (residual inverse iteration; Neumaier, 1985).
        """
        size = self._scaled[-1]
        moved = way.reshape(len(self.senses), -1) * size
        moved /= np.linalg.norm(moved)
        read, before = moved.conj(), np.inf
        with np.errstate(all="ignore"), suppress(np.linalg.LinAlgError):
            solve = self._inverse(rate * (1.0 + _BESIDE))
            for _ in range(_TRIED):
                still, first, second = np.swapaxes(self._on(moved), 0, 1)
                left = still + rate * (first + rate * second)
                left, slope = np.swapaxes(solve(np.stack([left, first + 2.0 * rate * second], axis=1)), 0, 1)
                change = complex(-(read * left).sum() / (read * slope).sum())
                if not np.isfinite(change):
                    return None
                rate, moved = rate + change, moved - left - change * slope
                if abs(change) <= _SETTLED * abs(rate):
                    return rate, (moved / size).ravel()
                if abs(change) > _FALLS * before:
                    return (rate, (moved / size).ravel()) if abs(change) <= 1e2 * _SETTLED * abs(rate) else None
                before = abs(change)
        return None
