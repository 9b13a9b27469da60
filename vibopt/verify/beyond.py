"""Beyond what values are not known: the static shape of a beam with a mass, and the threshold of a rotor that spins.

The static shape holds while the own vibration of the beam, load and supports held, is fast.

What the shape leaves out are the modes of the beam so held.  At w they add w^4 p p^T / (W^2 - w^2) each to the inertia
forces, and the sum of all p p^T is the very inertia of the shape: so the inertia of the beam lies between that of its
shape and 1 / (1 - (w / W)^2) times that, W the lowest of these frequencies.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

from vibopt.answer.entry import TOLERANCE, Entry
from vibopt.mechanics.built import Joint
from vibopt.mechanics.machine import Machine
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Scene
from vibopt.units import show

_FREQUENCIES = ("natural_frequency", "critical_speed")
_MOST = 0.01
"""Part by which what moves with the load may be heavier than its shape says."""


def heavy(machine: Machine) -> Iterator[Joint]:
    """Beams with a mass."""
    return (joint for joint in machine.joints if joint.borne is not None and joint.borne.mass)


def heavier(machine: Machine, joint: Joint, omega: float) -> float:
    """Greatest part by which what moves with the load of a beam may be heavier at a frequency [rad/s]."""
    assert joint.borne is not None
    square = (omega / joint.borne.frequency) ** 2
    if square >= 1.0:
        return float("inf")
    shaft = joint.count * joint.borne.mass * joint.borne.means[1]
    return float(shaft * square / (1.0 - square) / (machine.own(joint.ends[0]) + shaft))


def beyond_shape(machine: Machine, response: Response, limit: Entry | None, value: float, omega: float) -> str:
    """Why a value at a frequency [rad/s] is not known, as a beam does not keep its static shape; "" where it does.

    A natural frequency that must be above some limit is judged at the limit: it is no lower than that for sure.
    """
    if response.response in _FREQUENCIES:
        omega = value if limit is None else min(value, limit.value)
    for joint in heavy(machine):
        if heavier(machine, joint, omega) > _MOST:
            assert joint.borne is not None
            at, own = (show(one, "Hz", "angular_rate") for one in (omega, joint.borne.frequency))
            return (
                f"is not known: at {at} the beam of links.{joint.name} does not keep its static shape, for it vibrates "
                f"by itself from {own} on, its load and supports held. Look at lower speeds or stiffer beams"
            )
    return ""


def beyond_threshold(scene: Scene, machine: Machine, response: HarmonicResponse, threshold: float) -> str:
    """Why a steady whirl is none, as the rotor spins beyond its stability threshold [rad/s]; "" where it does not."""
    forbidden = any(limit.response == "stability_threshold" for limit in scene.limits.values())
    for name in names_for(scene, response):
        top = max((band.high for band in bands_for(scene, response, name) if isfinite(band.high)), default=0.0)
        if top > threshold * (1.0 + 2.0 * TOLERANCE):  # a limit on it holds within that
            spin, least = (show(value, "rpm", "angular_rate", digits=6) for value in (top, threshold))
            what = "where a whirl grows without end"
            if not machine.grows(top):
                what = f"from which on a whirl grows without end, though none does at {spin} itself"
            limit = f'Add a limit with response = "stability_threshold", at_least = "{spin}", or look'
            return (
                f"is not known: excitations.{name} spins the rotor up to {spin}, beyond its stability threshold of "
                f"{least}, {what}. {limit if scene.variables and not forbidden else 'Look'} at lower speeds"
            )
    return ""
