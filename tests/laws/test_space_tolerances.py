"""Machines in space within tolerances: factors are what they say, nothing within is worse, and what is proven holds."""

from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from space_machine import Plant
from vibopt.program.vicinity import Vicinity
from vibopt.program.worst_case import around, hit
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve import solve
from vibopt.solve.proof import settled, worst_machines
from vibopt.verify.as_built import machine_of
from vibopt.verify.certify import measure_on
from vibopt.work import Budget

_settings = settings(derandomize=True, database=None, deadline=None, max_examples=8)
_seeds = st.integers(0, 10**6)
REACH = np.array([0.05, 0.03, 0.08])


def plant_document(plant: Plant, *, centre: bool) -> dict[str, Any]:
    """The plant with tolerances of its body and of two of its mounts."""
    document: dict[str, Any] = deepcopy(plant.document())
    body = document["bodies"]["body"]
    body["tolerance"] = "8 %"
    if centre:
        body["centre_tolerance"] = [f"{one} m" for one in REACH.tolist()]
    for name in ("m0", "m1"):
        document["mounts"][name]["tolerance"] = "20 %"
    return document


def scattered(plant: Plant, *, centre: bool = True, over: str = "40..90 rad/s") -> Scene:
    """The plant with tolerances of its body and of its mounts, and limits that never break."""
    document = plant_document(plant, centre=centre)
    eye = {"response": "displacement", "of": "eye", "direction": plant.way.tolist(), "over": over, "at_most": "1 m"}
    floor = {"response": "transmitted_force", "into": "ground", "direction": "y", "over": over, "at_most": "1 MN"}
    single = {"response": "transmitted_force", "through": "m2", "direction": [0, 0.6, 0.8], "over": over}
    document["limits"] = {
        "eye": eye,
        "floor": floor,
        "single": {**single, "at_most": "1 MN"},
        "load": {"response": "static_load", "of": "m0", "at_most": "1 MN", "at_least": "0 N"},
        "sag": {"response": "static_deflection", "of": "eye", "direction": "x", "at_most": "1 m"},
        "low": {"response": "natural_frequency", "at_most": "1000 Hz"},
        "share": {"response": "energy_share", "of": "body", "axis": "x", "at_most": 1.0},
        "slide": {"response": "energy_share", "of": "body", "direction": "y", "at_most": 1.0},
        "speed": {"response": "velocity", "of": "body", "direction": "x", "over": over, "at_most": "10 m/s"},
    }
    return from_dict(document)


def off_plant(plant: Plant, off: dict[str, float]) -> Plant:
    """The same machine with numbers off, by hand; coordinates about the centre as built."""
    other = Plant(0, len(plant.at))
    other.__dict__.update(deepcopy(plant.__dict__))
    other.mass *= off["bodies.body.mass"]
    other.tensor = other.tensor * off["bodies.body.inertia"]
    for k, axis in enumerate("xyz"):
        other.centre[k] += 2.0 * (off.get(f"bodies.body.centre.{axis}", 1.0) - 1.0) * REACH[k]
    for i in (0, 1):
        other.k[i] *= off[f"mounts.m{i}.stiffness"]
        other.c[i] *= off[f"mounts.m{i}.damping"]
    return other


def some_factors(scene: Scene, seed: int) -> dict[str, float]:
    random = np.random.default_rng(seed)
    return {one.path: 1.0 + one.tolerance * float(random.uniform(-1.0, 1.0)) for one in uncertain(scene)}


@_settings
@given(_seeds)
def test_a_machine_that_is_off_moves_as_newton_and_euler_say(seed: int) -> None:
    plant = Plant(seed)
    scene = scattered(plant, over="55 rad/s")
    off = some_factors(scene, seed)
    program = around(scene, np.zeros(0))
    limit = next(one for one in program.limits if one.name == "eye")
    value = limit.form.worst(limit.model, np.array(list(off.values()))).value
    assert value == pytest.approx(off_plant(plant, off).response(np.array([55.0]))[0], rel=1e-9)
    low = next(one for one in program.limits if one.name == "low")
    first = low.form.worst(low.model, np.array(list(off.values()))).value
    assert first == pytest.approx(off_plant(plant, off).frequencies()[0], rel=1e-8)
    load = next(one for one in program.limits if one.name == "load")
    carried = load.form.worst(load.model, np.array(list(off.values()))).value
    assert carried == pytest.approx(float(off_plant(plant, off).loads()[0] @ plant.axes[0][2]), rel=1e-7)


@_settings
@given(_seeds)
def test_the_model_in_factors_and_the_machine_as_built_agree_on_every_response(seed: int) -> None:
    scene = scattered(Plant(seed))
    off = some_factors(scene, seed)
    program = around(scene, np.zeros(0))
    built = replace(scene, off=off)
    machine = machine_of(built, {})
    for limit in program.limits:
        least = limit.side == "at_least"
        value = limit.form.worst(limit.model, np.array(list(off.values())), least_wanted=least).value
        found = measure_on(built, machine, scene.limits[limit.name], limit.side).value
        assert value == pytest.approx(found, rel=1e-7), limit.name


@_settings
@given(_seeds)
def test_nothing_within_the_tolerances_is_worse_than_what_was_found(seed: int) -> None:
    plant = Plant(seed)
    scene = scattered(plant)
    program = around(scene, np.zeros(0))
    limit = next(one for one in program.limits if one.name == "eye")
    found = hit(limit, program.axes).value
    omega = np.linspace(40.0, 90.0, 400)
    for trial in range(40):
        off = some_factors(scene, seed + trial)
        off = (
            {
                path: 1.0 + np.sign(one - 1.0) * width
                for (path, one), width in zip(off.items(), _widths(scene), strict=True)
            }
            if trial % 2
            else off
        )
        assert off_plant(plant, off).response(omega).max() <= found * (1.0 + 1e-9)


def _widths(scene: Scene) -> list[float]:
    return [one.tolerance for one in uncertain(scene)]


@_settings
@given(_seeds, st.booleans(), st.floats(-0.05, 0.4))
def test_what_is_proven_of_all_machines_holds_for_each(seed: int, centre: bool, over: float) -> None:
    plant = Plant(seed)
    scene = scattered(plant, centre=centre)
    program = around(scene, np.zeros(0))
    for limit in program.limits:
        if limit.name in ("share", "slide"):
            continue
        least = limit.side == "at_least"
        values = []
        for trial in range(25):
            factors = np.array(list(some_factors(scene, 31 * seed + trial).values()))
            values.append(limit.form.worst(limit.model, factors, least_wanted=least).value)
        reached = min(values) if least else max(values)
        level = reached - abs(reached) * over if least else reached + abs(reached) * over
        proven = Vicinity(limit, program.axes, level, least).proven(Budget(30, "batches"))
        assert not (proven and over < 0.0), limit.name


@_settings
@given(_seeds)
def test_the_worst_machine_that_is_called_proven_is_worst_among_many(seed: int) -> None:
    plant = Plant(seed)
    scene = scattered(plant, centre=False)
    program = around(scene, np.zeros(0))
    rest = tuple(one for one in program.limits if one.name in ("eye", "load", "sag"))
    program = replace(program, limits=rest)
    hits, undecided = settled(program, worst_machines(program, {}))
    for index, limit in enumerate(rest):
        least = limit.side == "at_least"
        for trial in range(30):
            factors = np.array(list(some_factors(scene, 17 * seed + trial).values()))
            value = limit.form.worst(limit.model, factors, least_wanted=least).value
            room = 1e-3 * abs(hits[index].value) if limit.name not in undecided else np.inf
            assert (value >= hits[index].value - room) if least else (value <= hits[index].value + room), limit.name


@_settings
@given(_seeds, st.booleans())
def test_a_band_that_is_proven_free_of_modes_is_free_on_every_machine(seed: int, centre: bool) -> None:
    plant = Plant(seed)
    rates = plant.frequencies() / (2.0 * np.pi)
    which = int(np.argmax(np.diff(rates) / rates[:-1]))
    low, high = rates[which : which + 2]
    for part in (0.2, 0.6, 1.2):
        middle, half = np.sqrt(low * high), 0.5 * part * (high - low)
        document = plant_document(plant, centre=centre)
        band = f"{float(max(middle - half, 0.1))!r}..{float(middle + half)!r} Hz"
        document["limits"] = {"free": {"response": "natural_frequency", "outside": band}}
        scene = from_dict(document)
        limit = around(scene, np.zeros(0)).limits[0]
        proven = Vicinity(limit, around(scene, np.zeros(0)).axes, 0.0).proven(
            Budget(600 if part == 0.2 and not centre else 60, "batches")
        )
        met = [
            bool(((found > limit.bound) & (found < limit.upper)).any())
            for trial in range(40)
            for found in (off_plant(plant, some_factors(scene, 7 * seed + trial)).frequencies(),)
        ]
        assert not (proven and any(met))
        assert proven or centre or part > 0.2 or any(met)


@given(st.floats(0.91, 1.09), st.booleans())
@_settings
def test_a_level_that_the_mode_of_some_machine_has_is_not_proven(off: float, least: bool) -> None:
    """Halved often enough, a box around that machine is so narrow that rounding hides it."""
    rate = np.sqrt(1e6 / 300.0)
    scene = from_dict(
        {
            "bodies": {"press": {"mass": "300 kg"}},
            "links": {"mount": {"between": ["press", "ground"], "stiffness": {"value": "1 MN/m", "tolerance": "10 %"}}},
            "limits": {"mode": {"response": "natural_frequency", "at_most": f"{float(rate)!r} rad/s"}},
        }
    )
    program = around(scene, np.zeros(0))
    level = float(rate * np.sqrt(off))
    proof = Vicinity(program.limits[0], program.axes, level, least)
    assert not proof.proven(Budget(100, "batches"))
    assert proof.witness is None or (proof.witness[0] < off if least else proof.witness[0] > off)
    sure = rate * np.sqrt(0.899 if least else 1.101)
    assert Vicinity(program.limits[0], program.axes, float(sure), least).proven(Budget(100, "batches"))


def test_each_mount_by_itself_is_worse_than_all_alike() -> None:
    document: dict[str, Any] = {
        "bodies": {
            "box": {"mass": "400 kg", "shape": {"box": ["1 m", "0.8 m", "0.6 m"]}, "centre": ["0 m", "0 m", "0.5 m"]}
        },
        "mounts": {
            "foot": {
                "between": ["box", "ground"],
                "at": [
                    ["0.5 m", "0.4 m", "0 m"],
                    ["0.5 m", "-0.4 m", "0 m"],
                    ["-0.5 m", "0.4 m", "0 m"],
                    ["-0.5 m", "-0.4 m", "0 m"],
                ],
                "stiffness": "300 kN/m",
                "shear_ratio": 0.6,
                "loss_factor": 0.1,
                "tolerance": "20 %",
            }
        },
        "limits": {"load": {"response": "static_load", "of": "foot", "at_most": "5 kN"}},
    }
    alike = solve(from_dict(document))
    document["mounts"]["foot"]["tolerance_of"] = "mount"
    each = solve(from_dict(document))
    quarter = 100.0 * 9.80665
    assert alike.limits["load"].value.value == pytest.approx(quarter, rel=1e-9)
    # two mounts on one diagonal 20 % stiffer than the two on the other take 1.2 / (1.2 + 0.8) of half the weight
    assert each.limits["load"].value.value == pytest.approx(1.2 * quarter, rel=1e-9)
    assert each.claim.endswith("for every machine within the tolerances, proven")
