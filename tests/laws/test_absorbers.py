"""An absorber is a body on a spring and a damper, however it is said; torsion is the same in other units."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from absorber_machine import Drawn, Table, machines
from vibopt.forms.bounds import FormBounds
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.verify.certify import measure

few = settings(derandomize=True, database=None, deadline=None, max_examples=12, suppress_health_check=list(HealthCheck))


def questions(drawn: Drawn, *, twin: bool) -> dict[str, Table]:
    """The same questions to both, in the words of each."""
    many = len(drawn.document["bodies"]) + len(drawn.numbers)
    asked: dict[str, Table] = {"mode": {"response": "natural_frequency", "mode": many, "at_least": "1e-9 Hz"}}
    asked["total"] = {"response": "total_mass", "at_most": "1 t"}
    shaken = reached(drawn)
    for name in [*drawn.document["bodies"], *drawn.numbers]:
        if name not in shaken:
            continue
        asked[f"at_{name}"] = {"response": "displacement", "of": name, "at_most": "1 m"}
        asked[f"acc_{name}"] = {"response": "acceleration", "of": name, "at_most": "1 m/s2", "at": "7 Hz"}
        asked[f"into_{name}"] = {"response": "transmitted_force", "into": name, "at_most": "1 N", "at": "7 Hz"}
    for name in drawn.numbers:
        link = f"{name}_link" if twin else name
        if name in shaken:
            stroke = (
                {"response": "relative_displacement", "across": link} if twin else {"response": "stroke", "of": name}
            )
            asked[f"stroke_{name}"] = {**stroke, "at_most": "1 m"}
            asked[f"across_{name}"] = {
                "response": "relative_displacement",
                "across": link,
                "at_most": "1 m",
                "at": "7 Hz",
            }
            asked[f"through_{name}"] = {
                "response": "transmitted_force",
                "through": link,
                "at_most": "1 N",
                "at": "7 Hz",
            }
        asked[f"mass_{name}"] = {"response": "mass", "of": name, "at_most": "1 t"}
        if drawn.numbers[name][1]:
            asked[f"stiffness_{name}"] = {"response": "stiffness", "of": link, "at_most": "1 GN/m"}
        if drawn.numbers[name][3]:
            asked[f"loss_{name}"] = {"response": "loss_factor", "of": link, "at_most": 1.0}
    return asked


def reached(drawn: Drawn) -> set[str]:
    return {*drawn.document["bodies"], *drawn.numbers}


def read(document: Table, limits: dict[str, Table]) -> Scene:
    whole = {**document, "limits": limits}
    return from_dict({**whole, "goal": {"minimise": "total_mass"}} if _has_choice(document) else whole)


def _has_choice(value: Any) -> bool:
    if isinstance(value, dict):
        return "from" in value or any(_has_choice(one) for one in value.values())
    return False


@given(drawn=machines())
@few
def test_an_absorber_is_the_same_as_a_body_and_a_link(drawn: Drawn) -> None:
    scene = read(drawn.document, questions(drawn, twin=False))
    twin = read(drawn.twin, questions(drawn, twin=True))
    x = np.array([drawn.chosen[variable.path] for variable in scene.variables])
    full, small, other = pose(scene, reduce=False), pose(scene), pose(twin, reduce=False)
    for name in scene.limits:
        right = measure(twin, {}, twin.limits[name]).value
        assert measure(scene, drawn.chosen, scene.limits[name]).value == pytest.approx(right, rel=1e-11), name
        believed = [
            limit.form.worst(limit.model, at).value
            for program, at in ((full, x), (small, x), (other, np.zeros(0)))
            for limit in program.limits
            if limit.name == name
        ]
        assert believed == pytest.approx([right] * 3, rel=1e-8), name


@given(drawn=machines())
@few
def test_own_numbers_of_absorbers_are_those_of_plain_arithmetic(drawn: Drawn) -> None:
    limits: dict[str, Table] = {}
    right = {"weight": sum(one[0] for one in drawn.numbers.values())}
    limits["weight"] = {"response": "absorber_mass", "at_most": "1 t"}
    for name, (m, k, c, _) in drawn.numbers.items():
        limits[f"ratio_{name}"] = {"response": "mass_ratio", "of": name, "at_most": 1.0}
        right[f"ratio_{name}"] = m / drawn.bases[name]
        if k:
            limits[f"own_{name}"] = {"response": "own_frequency", "of": name, "at_most": "1 Hz"}
            right[f"own_{name}"] = np.sqrt(k / m)
        if k and c:
            limits[f"damped_{name}"] = {"response": "damping_ratio", "of": name, "at_most": 1.0}
            right[f"damped_{name}"] = c / (2.0 * np.sqrt(k * m))
        if c:
            limits[f"damper_{name}"] = {"response": "damping", "of": name, "at_most": "1 N s/m"}
            right[f"damper_{name}"] = c
        if name in drawn.references:
            limits[f"tuned_{name}"] = {"response": "tuning", "of": name, "at_most": 1.0}
            right[f"tuned_{name}"] = np.sqrt(k / m) / drawn.references[name]
    scene = read(drawn.document, limits)
    program = pose(scene)
    x = np.array([drawn.chosen[variable.path] for variable in scene.variables])
    for limit in program.limits:
        assert limit.form.worst(limit.model, x).value == pytest.approx(right[limit.name], rel=1e-12), limit.name
        measured = measure(scene, drawn.chosen, scene.limits[limit.name]).value
        assert measured == pytest.approx(right[limit.name], rel=1e-12), limit.name


@given(drawn=machines(), data=st.data())
@few
def test_bounds_on_boxes_hold_for_powers_of_any_sign(drawn: Drawn, data: Any) -> None:
    scene = read(drawn.document, questions(drawn, twin=False))
    if not 1 <= len(scene.variables) <= 3:
        return
    rng = np.random.default_rng(data.draw(st.integers(0, 1000)))
    program = pose(scene)
    low = program.low * (program.high / program.low) ** rng.uniform(0.0, 0.5, len(program.low))
    high = low * (program.high / low) ** rng.uniform(0.1, 1.0, len(low))
    inside = low * (high / low) ** rng.uniform(0.0, 1.0, (20, len(low)))
    for limit in program.limits[:6]:
        bounds = FormBounds(limit.model, limit.form, np.sqrt(low * high))
        bounds.add({"shaker": 2.0 * np.pi * 7.0})
        lower, upper = bounds.on(low[None], high[None])
        for x in inside:
            value = limit.form.worst(limit.model, x).value
            assert lower[0] <= value * (1.0 + 1e-9), limit.name
            if limit.name.startswith(("mass", "stiffness", "mode", "total")):
                assert value <= upper[0] * (1.0 + 1e-9), limit.name


TURNED = {
    "kg": "kg m2",
    "N/m": "N m/rad",
    "N s/m": "N m s/rad",
    "N": "N m",
    "m": "rad",
}
KEYS = {"mass": "inertia", "stiffness": "torsional_stiffness", "damping": "torsional_damping"}


def turned(document: Table) -> Table:
    """The same numbers about an axis."""
    made = copy.deepcopy(document)
    for family in ("bodies", "links", "absorbers"):
        for table in made.get(family, {}).values():
            for key in list(table):
                if key in KEYS:
                    table[KEYS[key]] = _unit(table.pop(key))
    shaker = made["excitations"]["shaker"]
    shaker["kind"], shaker["amplitude"] = "moment", _unit(shaker["amplitude"])
    return made


def _unit(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _unit(one) for key, one in value.items()}
    number, _, unit = value.partition(" ")
    return f"{number} {TURNED[unit]}"


@given(drawn=machines())
@few
def test_torsion_is_the_same_mechanics_with_other_units(drawn: Drawn) -> None:
    if any("length" in one for one in drawn.document["absorbers"].values()):
        return
    along: dict[str, Table] = {"w": {"response": "natural_frequency", "at_least": "1e-9 Hz"}}
    around = copy.deepcopy(along)
    for name in ("a", *drawn.numbers):
        along[f"x_{name}"] = {"response": "displacement", "of": name, "at_most": "1 m"}
        around[f"x_{name}"] = {"response": "rotation", "of": name, "at_most": "1 rad"}
        along[f"f_{name}"] = {"response": "transmitted_force", "into": name, "at_most": "1 N"}
        around[f"f_{name}"] = {"response": "transmitted_moment", "into": name, "at_most": "1 N m"}
        along[f"m_{name}"] = {"response": "mass", "of": name, "at_most": "1 kg"}
        around[f"m_{name}"] = {"response": "inertia", "of": name, "at_most": "1 kg m2"}
    for name in ("s0", *(one for one, numbers in drawn.numbers.items() if numbers[1])):
        along[f"d_{name}"] = {"response": "relative_displacement", "across": name, "at_most": "1 m"}
        around[f"d_{name}"] = {"response": "twist", "across": name, "at_most": "1 rad"}
        along[f"t_{name}"] = {"response": "transmitted_force", "through": name, "at_most": "1 N"}
        around[f"t_{name}"] = {"response": "transmitted_moment", "through": name, "at_most": "1 N m"}
        along[f"k_{name}"] = {"response": "stiffness", "of": name, "at_most": "1 N/m"}
        around[f"k_{name}"] = {"response": "torsional_stiffness", "of": name, "at_most": "1 N m/rad"}
    along["c"] = {"response": "damping", "of": "s0", "at_most": "1 N s/m"}
    around["c"] = {"response": "torsional_damping", "of": "s0", "at_most": "1 N m s/rad"}
    first = read(drawn.document, along)
    document = turned(drawn.document)
    limits = {**document, "limits": around}
    second = from_dict({**limits, "goal": {"minimise": "inertia", "of": "a"}} if _has_choice(document) else limits)
    chosen = {".".join(KEYS.get(step, step) for step in path.split(".")): x for path, x in drawn.chosen.items()}
    for name in along:
        value = measure(first, drawn.chosen, first.limits[name]).value
        assert measure(second, chosen, second.limits[name]).value == pytest.approx(value, rel=1e-12), name
    x = np.array([chosen[variable.path] for variable in second.variables])
    for limit in pose(second).limits:
        value = measure(second, chosen, second.limits[limit.name]).value
        loose = 1e-4 if limit.name == "w" else 0.0  # a mass on a damper alone has a frequency of zero, but for rounding
        assert limit.form.worst(limit.model, x).value == pytest.approx(value, rel=1e-8, abs=loose), limit.name
