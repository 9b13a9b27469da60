"""A response about standstill, by orders of the frequency: forces that fade away against motion that has no end.

What floats free moves as 1/w^2, and a base whose acceleration is given moves as 1/w^2 too, while what is read may
see no more of it than w^2.  The response is therefore written as a series in w, taken from its values on a circle
round w = 0 on which all motion is elastic, and its powers are joined with those of the amplitude before any
number is put in.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.signals import Amplitude, Piece

_POINTS = 64
_RING = 0.4
"""Radius of the circle over the distance of the nearest pole that is not at zero."""
_REACH = 0.25
"""Part of the radius within which the series is taken."""
_ORDERS = np.arange(-2, 21)
_BEYOND = np.arange(-12, -2)
"""Orders that no mechanical system has: what is found of them is rounding."""
_ROUNDING = 1e-9
_NOISE = 30.0


@dataclass(frozen=True, slots=True)
class Orders:
    """h = sum_k coefficients_k w^orders_k for 0 <= w < reach [rad/s]."""

    orders: IntArray
    coefficients: ComplexArray
    reach: float

    def times(self, amplitude: Amplitude, order: float, speed: FloatArray) -> ComplexArray:
        """h(order * speed) times the amplitude at speeds (n,) [rad/s]; infinite at rest where it has no end."""
        sizes = self.coefficients * order ** self.orders.astype(float)

        def product(piece: Piece, at: FloatArray) -> ComplexArray:
            total = np.zeros(at.shape, dtype=complex)
            for more, factor in enumerate((piece.constant, piece.slope)):
                for size, power in zip(factor * sizes, self.orders + piece.power + more, strict=True):
                    if size:
                        total = total + size * at ** float(power)
            return np.where(np.isnan(total), np.inf, total)

        return amplitude.by_piece(speed, product)


def orders_of(steady: Callable[[ComplexArray], ComplexArray], machine: Machine) -> Orders:
    """The orders of a response of a machine.

    Parameters
    ----------
    steady
        The response to unit amplitude at complex frequencies (n,) [rad/s].
    machine
        What is shaken.
    """
    radius = _RING * _nearest(machine)
    turns = np.exp(2j * np.pi * (np.arange(_POINTS) + 0.5) / _POINTS)
    values = steady(radius * turns)
    noise = float(np.abs(_parts(values, turns, _BEYOND)).max())
    parts = _parts(values, turns, _ORDERS)
    floor = max(_ROUNDING * float(np.abs(parts).max()), _NOISE * noise)
    kept = np.abs(parts) > floor
    kept |= _ORDERS[kept].min(initial=_ORDERS[-1]) < _ORDERS
    orders = _ORDERS[kept]
    return Orders(orders, parts[kept] / radius ** orders.astype(float), _REACH * radius)


def _parts(values: ComplexArray, turns: ComplexArray, orders: IntArray) -> ComplexArray:
    """What each order adds on the circle."""
    found: ComplexArray = values @ turns[:, None] ** -orders.astype(float) / len(turns)
    return found


def _nearest(machine: Machine) -> float:
    """Distance of the nearest pole that is not at zero [rad/s]; one where there is none."""
    return float(np.abs(machine.held_poles()[:1]).max(initial=0.0)) or 1.0
