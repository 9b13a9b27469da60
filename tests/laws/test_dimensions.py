"""Every response has the dimension that it says: in a world of other kilograms and seconds its value goes with it.

Lengths go with the square of times, so that gravity stays what it is.
"""

from __future__ import annotations

import re
from typing import Any

import pytest

from every_question import answerable, machine, questions
from vibopt.responses import KINDS, RandomResponse, TransientResponse
from vibopt.scene.read import from_dict
from vibopt.solve import solve
from vibopt.units import DIMENSIONS
from vibopt.units.spelling import expression, factor_and_dimensionality

HEAVIER, SLOWER = 3.0, 1.25
_SIZES = {"[mass]": HEAVIER, "[length]": SLOWER**2, "[time]": SLOWER}
_QUANTITY = re.compile(r"(-?[\d.]+(?:e-?\d+)?) (\S.*)")


def size_of(unit: str) -> float:
    """How many times as great a quantity of a unit is in the other world."""
    written = expression(unit) if unit else None
    powers = () if written is None else factor_and_dimensionality(written)[1]
    size = 1.0
    for base, power in powers:
        size *= _SIZES.get(base, 1.0) ** power
    return size


def other_world(said: Any) -> Any:
    """The same document there."""
    if isinstance(said, dict):
        return {key: other_world(one) for key, one in said.items()}
    if isinstance(said, list):
        return [other_world(one) for one in said]
    match = _QUANTITY.fullmatch(said) if isinstance(said, str) else None
    return f"{float(match[1]) * size_of(match[2])!r} {match[2]}" if match else said


def steady(motion: str) -> dict[str, Any]:
    """The machine of everything, asked all that it can be."""
    asked = {}
    for number, one in enumerate(questions(KINDS)):
        if KINDS[one["response"]].harmonic:
            turns = {"disc", "shaft"} & {word for word in one.values() if isinstance(word, str)}
            one |= {"due_to": ["torque" if turns else "shaker"], "at": "15 Hz"}
        asked[f"q{number}"] = one
    return {**machine(motion, opened=False), "measures": asked}


def unsteady(kind: type) -> dict[str, Any]:
    """Two bodies under what is random, or comes once."""
    beam = {"kind": "cantilever", "length": "1 m", "modulus": "207 GPa", "diameter": "50 mm"}
    asked = [one for one in questions(_of(kind)) if not {"direction", "axis"} & {*one}]
    return {
        "title": "unsteady",
        "bodies": {"pump": {"mass": "120 kg"}, "floor": {"mass": "900 kg"}},
        "links": {
            "foot": {"between": ["pump", "floor"], "stiffness": "200 kN/m", "damping": "2 kN s/m"},
            "girder": {"between": ["floor", "ground"], "beam": beam, "damping": "5 kN s/m"},
        },
        "excitations": {"shaker": SHAKERS[kind]},
        "measures": {f"q{number}": one for number, one in enumerate(asked)},
    }


def mounts_unsteady(kind: type) -> dict[str, Any]:
    """Mounts of the machine of everything under the same, in space."""
    asked = [one for one in questions(_of(kind)) if one["response"].endswith("travel")]
    shaker = {**SHAKERS[kind], "direction": [0.6, 0, 0.8]}
    measures = {f"q{number}": one for number, one in enumerate(asked)}
    return {**machine("space", opened=False), "excitations": {"shaker": shaker}, "measures": measures}


def _of(kind: type) -> dict[str, Any]:
    return {name: one for name, one in KINDS.items() if issubclass(one, kind)}


SHAKERS: dict[type, dict[str, Any]] = {
    RandomResponse: {"kind": "white_noise", "on": "pump", "density": "100 N²/Hz"},
    TransientResponse: {
        "kind": "pulse", "on": "pump", "shape": "half sine", "amplitude": "2 kN", "duration": "20 ms"
    },
}  # fmt: skip


ASKED = {
    "space": steady("space"),
    "line": steady("line"),
    "random": unsteady(RandomResponse),
    "in time": unsteady(TransientResponse),
    "random in space": mounts_unsteady(RandomResponse),
    "in time in space": mounts_unsteady(TransientResponse),
}


@pytest.mark.parametrize("name", ASKED)
def test_every_value_goes_with_the_dimension_that_it_says(name: str) -> None:
    scene = answerable(ASKED[name])
    here, there = (solve(one, explain=False) for one in (scene, from_dict(other_world(scene.document))))
    assert here.status == there.status == "met", (here.claim, there.claim)
    for measure, one in here.measures.items():
        kind = DIMENSIONS[KINDS[one.response].dimension]
        right = one.value.value * size_of(kind.si)
        said = f"{one.response} {one.place} says that it is {kind.noun}"
        assert there.measures[measure].value.value == pytest.approx(right, rel=1e-6, abs=1e-15), said


ELSEWHERE = [
    "amplification_factor",
    "critical_speed",
    "free_displacement",
    "friction_force",
    "gear_torque",
    "insertion_loss",
    "loss_factor",
    "mode_ratio",
    "price",
    "stability_threshold",
]
"""Responses that none of these machines has."""


def test_every_response_is_asked_of_some_machine() -> None:
    asked = {one.response for document in ASKED.values() for one in answerable(document).measures.values()}
    missing = set(KINDS) - asked - set(ELSEWHERE)
    assert not missing, f"no machine here has any {', '.join(missing)}: put into one what it needs"


@pytest.mark.parametrize(("response", "dimension"), [("displacement", "velocity"), ("mass_ratio", "mass")])
def test_a_response_of_another_dimension_than_it_says_is_caught(
    response: str, dimension: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(KINDS[response], "dimension", dimension)
    with pytest.raises(AssertionError, match=f"{response} of .* says that it is {DIMENSIONS[dimension].noun}"):
        test_every_value_goes_with_the_dimension_that_it_says("line")
