"""A rotor of discs as a balancing job: what a weight on each disc does, by the model instead of trial runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import degrees
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.errors import InputError
from vibopt.excitations.excitation import Excitation
from vibopt.mechanics.harmonic import motion
from vibopt.mechanics.machine import Machine
from vibopt.report.what_to_build import machine_in
from vibopt.responses import Response
from vibopt.responses.motion import Displacement
from vibopt.responses.response import HarmonicResponse
from vibopt.scene.assemble import model_of
from vibopt.scene.check_bearings import in_planes
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Design, Scene
from vibopt.signals import Band

_PARTS, _SAME, _APART = 8, 1e-8, 0.02
"""Speeds at which a range is looked at, beside its peaks; part by which two routes may differ; part by which speeds
differ, as runs of a meter at nearly one speed count as repeated."""
_TRIED, _BETWEEN, _COVERED, _MORE, _LEAST_APART = 501, 1.03, 1e-3, 24, 0.0101
"""Speeds of a range at which a bound is looked at, beside those near poles; bound from which on a speed is added, what
covers speeds between those, most that are added, and the part by which they differ."""
_SQUARES, _ROUNDING, _UNSURE, _LOOSE = 20, 1e-9, 1e9, 0.7
"""Least squares that approach a least sum, the least part of it that counts, condition from which on nothing is sure,
and the part of a limit below which it is left as it is, and said so."""
_RPM = 30.0 / np.pi
_SENSORS = 'no displacement is asked, and balancing reads one. Add a measure with response = "displacement".'
_PLANES = "no rotor has a disc that could take a weight. Add one to its discs."
_SPEEDS = "nothing says at which speeds to balance. Add an unbalance with its speed."
_ONE = "has several unbalances, and nothing says at which angles they stand. Write one, and the others in its also."
_CONVENTIONS = {
    "phase": "lead",
    "readings": "phase",
    "angles": "with rotation",
    "detector": "pk",
    "zero": "unbalances of the model",
}


def balancing_document(design: Design) -> dict[str, Any]:
    """Planes are the discs, sensors the points whose displacement is asked; as found are the unbalances of the file.

    Speeds are those at which a displacement is asked: of a range eight, where one that was asked is greatest, and those
    that keep it in hand between them.  Limits over ranges are tighter by what any weights that keep them at all of
    these speeds may do at others, so that they hold at every speed.

    Raises
    ------
    InputError
        There is no design, not one unbalance, no displacement asked, a limit that a balancing job does not have,
        bearings that differ in both planes, or a whirl without end.
    """
    scene = design.scene
    machine, sensors, planes, unbalance = _modelled(design)
    speeds, part = held_between(scene, machine, planes, sensors, _speeds(scene, machine))
    effects = {plane: _effects(scene, design, machine, plane, list(sensors), speeds) for plane in planes}
    found = sum(
        unbalance.swung * share * _effects(scene, design, machine, place, list(sensors), speeds)
        for place, share in unbalance.acts.items()
    )
    written = [f"{speed * _RPM:.15g} rpm" for speed in speeds]
    runs = [
        {
            "name": f"as modelled, {speed * _RPM:.5g} rpm",
            "speed": text,
            "readings": {point: _phasor(one, 1e3, "mm") for point, one in zip(sensors, row, strict=True)},
        }
        for speed, text, row in zip(speeds, written, np.asarray(found), strict=True)
    ]
    influence = [
        {"speed": text, "sensor": point, "plane": plane, "value": _phasor(effects[plane][i, j], 1e-3, "mm/(g mm)")}
        for i, text in enumerate(written)
        for j, point in enumerate(sensors)
        for plane in planes
    ]
    size = part if part >= _LOOSE else 1.0
    limits = {
        key: row for names in sensors.values() for name in names for key, row in _limits(scene, name, speeds, size)
    }
    told = "Limits are those of the file at the speeds of the runs; what is left between them is not known."
    if _LOOSE <= part < 1.0:
        told = f"Limits are {1e2 * (1.0 - part):.1f} % tighter here, so that they hold at every speed of their ranges."
    return {
        "title": f"Balancing of {scene.title}, modelled",
        **({"statement": told} if limits and part < 1.0 else {}),
        "conventions": _CONVENTIONS,
        "planes": {plane: {"unbalance": {"from": "0 g mm", "to": "1 kg m"}} for plane in planes},
        "runs": runs,
        "influence": influence,
        **({"limits": limits} if limits else {}),
        "goal": {"minimise": "residual", "combine": "worst"},
    }


def _modelled(design: Design) -> tuple[Machine, dict[str, list[str]], list[str], Excitation]:
    """The machine as built, its points with their limits, its discs, and the one unbalance that shakes it."""
    scene, machine = design.scene, machine_in(design)
    if machine is None:
        raise InputError(f"{scene.name}: there is no design ({design.status}), so no rotor to balance.")
    if unlike := in_planes(scene):
        raise InputError(
            f"{scene.name}: bearings.{unlike[0]} is not alike in both planes, where an unbalance moves a place along "
            "an ellipse, and a balancing job reads circles. Leave --save-coefficients out."
        )
    sensors, planes = _sensors(scene), [disc.name for rotor in scene.rotors.values() for disc in rotor.discs]
    there = {_SENSORS: sensors, _PLANES: planes, _SPEEDS: scene.excitations}
    for lacks in (words for words, collection in there.items() if not collection):
        raise InputError(f"{scene.name}: {lacks}")
    (name, excitation), *others = scene.excitations.items()
    if excitation.anywhere or len(excitation.loose) > 1:
        raise InputError(
            f"{scene.name}: excitations.{name} is an unbalance at places or angles that nobody knows, so nothing says "
            "what to take back. Leave or_on and angles out."
        )
    if others:
        raise InputError(f"{scene.name}: {_ONE}")
    return machine, sensors, planes, excitation


def _sensors(scene: Scene) -> dict[str, list[str]]:
    """Points whose displacement is asked, each with the names of its limits."""
    found: dict[str, list[str]] = {}
    for name, response in _asked(scene):
        limits = name in scene.limits
        if type(response) is Displacement and not (limits and response.at_most is None):
            found.setdefault(response.of, []).extend([name] if limits else [])
        elif limits and isinstance(response, HarmonicResponse):
            raise InputError(
                f"{scene.name}: limits.{name} asks for the {response.response}, and a balancing job limits "
                "displacements from above. Leave it out, or write the displacement that belongs to it."
            )
    return found


def _asked(scene: Scene) -> list[tuple[str, Response]]:
    goal = [] if scene.goal is None else [("", scene.goal.response)]
    return [*scene.limits.items(), *((f"measures.{key}", measure) for key, measure in scene.measures.items()), *goal]


def held_between(
    scene: Scene, machine: Machine, planes: list[str], sensors: Mapping[str, list[str]], speeds: FloatArray
) -> tuple[FloatArray, float]:
    """More speeds [rad/s], and the part of its limits to keep at all of them so that each holds at every speed.

    A whirl c(w) u at a speed between is sum_k l_k (a_k u) of those a_k u at the speeds that are listed wherever
    sum_k l_k a_k = c, so that it is at most sum_k |l_k| times what bounds these, whatever the unbalances u are.  The
    least of these sums is approached by weighted least squares, of which each is a bound; where it is greatest a speed
    is added.
    """
    ((_, imbalance),) = scene.excitations.items()
    columns = [{name: 1.0 + 0j} for name in planes] + [imbalance.acts] * (not {*imbalance.acts} <= {*planes})
    asked = [(point, _bound(scene, name), _bands(scene, name)) for point, names in sensors.items() for name in names]

    def rows(speeds: Iterable[FloatArray]) -> ComplexArray:
        """What a unit of each column does at speeds of each limit, as a part of it, (n, n_columns)."""
        found = []
        for (point, most, _), at in zip(asked, speeds, strict=True):
            each = (
                {place: np.asarray(part * at**2, dtype=complex) for place, part in column.items()} for column in columns
            )
            found.append(np.array([machine.shake(at, one, {}).points[point] for one in each]).T / most)
        return np.concatenate(found)

    tried = [_tried(bands, machine.known_poles) for _, _, bands in asked]
    if not any(map(len, tried)):
        return speeds, 1.0
    at, between, kept = np.concatenate(tried), rows(tried), speeds
    while True:
        reach = _reach(rows(kept[_within(kept, bands)] for _, _, bands in asked), between)
        apart = np.abs(at[:, None] - kept).min(axis=1) > _LEAST_APART * at
        worst = int(np.where(apart, reach, 0.0).argmax())
        if not apart[worst] or reach[worst] <= _BETWEEN or len(kept) >= len(speeds) + _MORE:
            return kept, 1.0 / (_COVERED + float(reach.max()))
        kept = np.sort([*kept, at[worst]])


def _tried(bands: list[Band], poles: ComplexArray) -> FloatArray:
    """Speeds of ranges [rad/s]: evenly, and close to each pole."""
    found = [np.linspace(band.low, band.high, _TRIED)[1:] for band in bands if not band.is_point]
    near = [pole.real + abs(pole.imag) * np.linspace(-6.0, 6.0, 41) for pole in poles]
    close = np.concatenate([*near, np.zeros(0)])
    return np.unique(np.concatenate([*found, close[_within(close, bands)]])) if found else np.zeros(0)


def _within(speeds: FloatArray, bands: list[Band]) -> BoolArray:
    inside = [(speeds >= band.low) & (speeds <= band.high) & (speeds > 0.0) for band in bands]
    return np.asarray(np.any(inside, axis=0))


def _reach(rows: ComplexArray, between: ComplexArray) -> FloatArray:
    """Bound of |c u| of each c between (n, n_columns), where |a u| <= 1 of all rows a (n_rows, n_columns).

    Infinite where the rows do not bound u; what they leave of c is counted by how far they bound it.
    """
    right, turn = np.linalg.qr(rows)
    if len(turn) < rows.shape[1] or np.linalg.cond(turn / np.linalg.norm(turn, axis=0)) > _UNSURE:
        return np.full(len(between), np.inf)
    between = np.asarray(np.linalg.solve(turn.T, between.T).T, dtype=complex)
    weight, least = np.ones((len(between), len(rows))), np.full(len(between), np.inf)
    for _ in range(_SQUARES):
        normal = np.einsum("ki,nk,kj->nij", right, weight, right.conj())
        share = weight * (np.linalg.solve(normal, between[..., None])[..., 0] @ right.conj().T)
        sums = np.abs(share).sum(axis=1)
        lost = np.linalg.norm(between - share @ right, axis=1) * np.sqrt(len(rows))
        least, weight = np.minimum(least, sums + lost), np.abs(share) + _ROUNDING * sums[:, None]
    return least


def _bands(scene: Scene, name: str) -> list[Band]:
    response = scene.limits[name]
    assert isinstance(response, Displacement)
    return [band for one in names_for(scene, response) for band in bands_for(scene, response, one)]


def _bound(scene: Scene, name: str) -> float:
    bound = scene.limits[name].at_most
    assert bound is not None
    return float(bound.value)


def _limits(scene: Scene, name: str, speeds: FloatArray, part: float) -> Iterator[tuple[str, dict[str, str]]]:
    """A part of a limit on what is left at a sensor; at each of its speeds where it does not speak of all."""
    asked = speeds[_within(speeds, _bands(scene, name))].tolist()
    most = f"{_bound(scene, name) * part * 1e3:.15g} mm pk"
    row = {"response": "residual", "at": vars(scene.limits[name])["of"], "at_most": most}
    if len(asked) == len(speeds):
        yield name, row
        return
    for one in asked:
        yield f"{name}_at_{one * _RPM:.5g}".replace(".", "_"), {**row, "speed": f"{one * _RPM:.15g} rpm"}


def _speeds(scene: Scene, machine: Machine) -> FloatArray:
    """Where a plan is looked at first [rad/s], ascending, no two of them nearly the same.

    A whirl w^2 / |(w - p)(w + p*)| of one pole p is greatest at |p|^2 / sqrt(Re p^2).
    """
    ((name, imbalance),) = scene.excitations.items()
    bands = set(imbalance.own_bands())
    for _, response in _asked(scene):
        if type(response) is Displacement:
            bands |= set(bands_for(scene, response, name))
    square = np.sort((machine.known_poles**2)[machine.known_poles.real > 0.0])
    peaks = (np.abs(square) / np.sqrt(np.maximum(square.real, 1e-300))).tolist()
    points, even = [band.low for band in bands if band.is_point], []
    for band in (one for one in bands if not one.is_point):
        points += [peak for peak in peaks if band.low < peak < band.high]
        even += np.linspace(band.low, band.high, _PARTS + 1)[::-1].tolist()
    kept: list[float] = []
    for speed in [*points, *even]:
        if speed > 0.0 and all(abs(speed - value) > _APART * value for value in kept):
            kept.append(speed)
    return np.sort(kept)


def _effects(
    scene: Scene, design: Design, machine: Machine, place: str, points: list[str], speeds: FloatArray
) -> ComplexArray:
    """Displacement of points per unbalance at a place, (n_speeds, n_points) [m per kg m], agreed on by both routes."""
    model, chosen = model_of(scene), design.scene.named(design.x)
    p = model.values(np.array([chosen[variable.path] for variable in scene.variables]))
    moved = motion(model, p, model.points[place].astype(complex), speeds)
    one = np.array([moved @ model.points[point] for point in points]).T * speeds[:, None] ** 2
    shaken = machine.shake(speeds, {place: (speeds**2).astype(complex)}, {})
    other = np.array([shaken.points[point] for point in points]).T
    if not np.all(np.isfinite(other)) or np.abs(one - other).max() > _SAME * np.abs(other).max():
        raise InputError(
            f"{scene.name}: what an unbalance on {place} does is not known: at a critical speed without damping a "
            "whirl has no end. Give the bearings a damping, or look at other speeds."
        )
    return other


def _phasor(value: complex, times: float, unit: str) -> str:
    """With all digits, its angle counted ahead in the sense of rotation."""
    return f"{abs(value) * times:.15g} {unit} @ {degrees(np.angle(value)):.15g} deg"
