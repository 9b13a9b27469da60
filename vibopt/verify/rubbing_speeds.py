"""Steady motion with dry friction of the machine as built over ranges of speeds: a rough look, then closer at the best.

The second route's own search: it knows at each speed what one simulation says, and looks closely near the natural
frequencies of what slips and of what holds, and behind the speeds at which what holds lets go.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations import Excitation
from vibopt.mechanics.machine import Machine
from vibopt.responses import HarmonicResponse
from vibopt.signals import Band
from vibopt.verify.over_bands import Reached
from vibopt.verify.stick_slip import Rubbed

_COARSE, _LOOKED, _SPEEDS, _FREED = 9, 2, 400, (1.01, 1.1, 1.18, 1.25, 1.33, 1.45)
"""Speeds of a rough look at a range; best ones that are looked at more closely; speeds among which those are looked for
at which what holds first slips, and parts of these."""


def rubbing(
    machine: Machine, response: HarmonicResponse, excitation: Excitation, bands: tuple[Band, ...], *, least: bool
) -> Reached:
    """Greatest value of a response over speeds [rad/s], or the least; and the speed of it."""
    [line] = excitation.lines(np.ones(1))
    last: list[tuple[float, ...]] = [(0.0,)]

    def made(speed: float, part: float = 1e-11) -> Rubbed:
        amplitude = float(abs(line.vector[0] * line.amplitude.at(np.array([speed]))[0]))
        force, base = (amplitude, 0.0) if excitation.family == "bodies" else (0.0, amplitude)
        return Rubbed(machine, force, base, line.order * speed, excitation.on, part, last[0])

    def at(speed: float, part: float = 1e-11) -> float:
        rubbed = made(speed, part)
        amplitude = rubbed.force + rubbed.base
        ratio = amplitude if response.normalised else 1.0
        if not 0.0 < amplitude < np.inf:
            return 1.0 if response.normalised else amplitude
        if not speed:
            return rubbed.at_rest(response) / ratio
        if _endless(rubbed):
            return float("inf")
        value = rubbed.greatest(response) / ratio
        last[0] = rubbed.started
        return value

    sign = -1.0 if least else 1.0
    found = [Reached(at(band.low), band.low) for band in bands if band.is_point]
    for band in bands:
        if not band.is_point:
            grid = np.geomspace(max(band.low, 1e-3 * band.high), band.high, _SPEEDS)
            slips = np.array([one.push > one.joint.friction for one in map(made, grid.tolist())])
            freed = grid[1:][slips[1:] & ~slips[:-1]]
            found += _over(at, band, made(band.high).naturals / line.order, freed, sign)
    return max(found, key=lambda one: sign * one.value if one.value == one.value else np.inf)


def _endless(rubbed: Rubbed) -> bool:
    """Whether the force gives more in a cycle than friction takes, at an undamped resonance."""
    if len(rubbed.naturals) > 1 or any(joint.damping for joint in rubbed.machine.joints):
        return False
    tuned = abs(rubbed.omega - rubbed.naturals[0]) <= 1e-14 * rubbed.omega
    return tuned and 4.0 * rubbed.joint.friction <= np.pi * rubbed.push


def _over(at: Callable[..., float], band: Band, naturals: FloatArray, freed: FloatArray, sign: float) -> list[Reached]:
    """Both ends and the best inside a band, after a rough look at it, and closer behind where what holds is `freed`."""
    from scipy.optimize import minimize_scalar

    low = max(band.low, 5e-2 * min(float(naturals[0]), band.high))
    near = np.outer(naturals, [0.6, 0.8, 0.9, 0.96, 1.0, 1.04, 1.1, 1.3]).ravel()
    near = np.concatenate([near, np.outer(freed, _FREED).ravel()])
    speeds = np.unique(np.concatenate([np.geomspace(low, band.high, _COARSE), near[(near > low) & (near < band.high)]]))
    rough = sign * np.array([at(speed, 1e-6) for speed in speeds])
    rough = np.where(np.isnan(rough), -np.inf, rough)
    found = [Reached(at(value), value) for value in (low, band.high)]
    after = np.append(rough[1:], -np.inf)
    tops = (rough >= np.append(-np.inf, rough[:-1])) & (rough >= after + 1e-9 * np.abs(rough))  # not where all holds
    hopeful = np.flatnonzero(tops & (rough >= (1.0 - 0.2 * sign) * rough.max()))
    for i in hopeful[np.argsort(-rough[hopeful])][:_LOOKED]:
        ends = speeds[max(i - 1, 0)], speeds[min(i + 1, len(speeds) - 1)]
        if np.isinf(rough[i]):
            return [Reached(sign * float(rough[i]), float(speeds[i]))]
        room: Any = {"xatol": 1e-6 * ends[1]}
        top: Any = minimize_scalar(lambda one: -sign * at(one), bounds=ends, method="bounded", options=room)
        found.append(Reached(-sign * float(top.fun), float(top.x)))
    return found
