"""Permissible residual unbalance from a balance quality G, and the grade that what remains has earned.

G = e omega, so a rotor of mass m may keep U = m G / omega.  The number G is the user's; no table is shipped.
The bearing planes share U by the lever rule, as the static loads do; with the centre of mass outside the bearings
(outboard, overhung) the nearer bearing carries more than U, and the farther one is loaded the other way.
What correction planes may keep is such that the bearing planes hold their share whatever the angles are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from math import inf

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import dataclass
from vibopt.values.grade import permissible_unbalance


@dataclass(frozen=True)
class Quality:
    """What the user asks of the rotor.

    grade
        G [m/s].
    mass, speed
        Of the rotor [kg], its highest service speed [rad/s].
    bearings
        The two bearings by name and place along the shaft [m].
    centre_of_mass
        Its place [m].
    planes
        Correction planes by name and place [m]; empty: the bearing planes themselves.
    measurement_error
        Greatest error of a measured residual unbalance, per plane [kg m].
    residual
        Measured unbalances left, by plane name, internal phasors [kg m]; empty: taken from the balancing plan.
    least_share, most_share
        Bounds of a bearing's share of U, where the user's rules have some.
    """

    grade: float
    mass: float
    speed: float
    bearings: tuple[tuple[str, float], tuple[str, float]]
    centre_of_mass: float
    planes: Mapping[str, float] = field(default_factory=dict)
    measurement_error: float = 0.0
    residual: Mapping[str, complex] = field(default_factory=dict)
    least_share: float = 0.0
    most_share: float = inf

    @property
    def ends(self) -> tuple[float, float]:
        """Places of both bearings."""
        return self.bearings[0][1], self.bearings[1][1]

    @property
    def places(self) -> Mapping[str, float]:
        """Places of the correction planes by name, of the bearings where none are given."""
        return self.planes or dict(self.bearings)


@dataclass(frozen=True)
class Permitted:
    """Permissible unbalances [kg m].

    whole
        m G / omega.
    eccentricity
        G / omega [m].
    at_bearings
        Per bearing plane.
    at_planes
        Per correction plane by name, at any angles.
    to_measure
        The same less the measurement error: what the instrument may show; negative where the error eats it all.
    outboard
        Whether the centre of mass lies outside the bearings.
    """

    whole: float
    eccentricity: float
    at_bearings: Mapping[str, float]
    at_planes: Mapping[str, float]
    to_measure: Mapping[str, float]
    outboard: bool

    @property
    def swallowed(self) -> tuple[str, ...]:
        """Planes of which the measurement error leaves nothing that may be measured."""
        return tuple(name for name, value in self.to_measure.items() if value <= 0.0)


@dataclass(frozen=True)
class Earned:
    """Unbalances left in the bearing planes [kg m], and the grade G [m/s] they earn, measurement error included."""

    at_bearings: Mapping[str, float]
    grade: float
    met: bool
    worst_at: str


def permitted(quality: Quality) -> Permitted:
    """What the rotor may keep."""
    whole = permissible_unbalance(quality.grade, quality.mass, quality.speed)
    allowed = whole * shares(quality)
    carried = _carried(quality, allowed)
    return Permitted(
        whole,
        whole / quality.mass,
        dict(zip(dict(quality.bearings), allowed.tolist(), strict=True)),
        carried,
        {name: value - quality.measurement_error for name, value in carried.items()},
        not min(quality.ends) <= quality.centre_of_mass <= max(quality.ends),
    )


def shares(quality: Quality) -> FloatArray:
    """Part of U that each bearing plane may keep, (2,)."""
    lever = np.abs(levers(*quality.ends, np.array([quality.centre_of_mass])))[:, 0]
    return np.asarray(np.clip(lever, quality.least_share, quality.most_share), dtype=float)


def levers(first: float, second: float, places: FloatArray) -> FloatArray:
    """Unbalance in the planes of bearings at `first` and `second` per unit in planes at `places` (n,), (2, n)."""
    return np.stack([second - places, places - first]) / (second - first)


def earned(quality: Quality, left: Mapping[str, complex]) -> Earned:
    """The grade of the unbalances `left` [kg m, phasors] in the correction planes by name."""
    names = [name for name in left if name in quality.places]
    K = levers(*quality.ends, np.array([quality.places[name] for name in names]))
    phasors: ComplexArray = np.array([left[name] for name in names], dtype=complex)
    error = quality.measurement_error * np.abs(K).sum(axis=1)
    found = np.abs(K @ phasors) + error
    part = found / (permissible_unbalance(quality.grade, quality.mass, quality.speed) * shares(quality))
    worst = int(np.argmax(part))
    bearings = [name for name, _ in quality.bearings]
    grade = float(part[worst]) * quality.grade
    return Earned(
        dict(zip(bearings, found.tolist(), strict=True)), grade, grade <= quality.grade * (1 + 1e-9), bearings[worst]
    )


def _carried(quality: Quality, allowed: FloatArray) -> dict[str, float]:
    """Per correction plane a part of what its nearest bearing plane may keep, the greatest that all angles allow."""
    ends, places = np.array(quality.ends), quality.places
    K = np.abs(levers(*quality.ends, np.array(list(places.values()))))
    reference = np.array([allowed[int(np.argmin(np.abs(ends - place)))] for place in places.values()])
    with np.errstate(divide="ignore", invalid="ignore"):
        most = np.where(K @ reference > 0.0, allowed / (K @ reference), inf).min()
    return {name: float(most * value) for name, value in zip(places, reference, strict=True)}
