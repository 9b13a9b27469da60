"""Pulses of unlike shapes at once, one of them perhaps of unknown duration: both routes agree, and a search by hand."""

from __future__ import annotations

from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from vibopt.verify import simulated

LINES, WAVES = ("triangle", "falling sawtooth"), ("half sine", "versed sine")


def shaken(first: str, second: str, on: str = "base", **given: str) -> dict[str, Any]:
    size = {"acceleration": "200 m/s²"} if on == "base" else {"amplitude": "90 N"}
    return {
        "title": "instrument that is struck twice",
        "bases": {"base": {}},
        "bodies": {"unit": {"mass": "10 kg"}},
        "links": {"mount": {"between": ["unit", "base"], "stiffness": "13811 N/m", "damping": "40 N s/m"}},
        "excitations": {
            "bump": {"kind": "pulse", "on": on, "shape": first, **size, **(given or {"duration": "12 ms"})},
            "push": {"kind": "pulse", "on": "unit", "shape": second, "amplitude": "150 N", "duration": "40 ms"},
        },
        "measures": {
            "a": {"response": "peak_acceleration", "of": "unit"},
            "x": {"response": "peak_relative_displacement", "across": "mount"},
        },
    }


def measured(document: dict[str, Any]) -> dict[str, float]:
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


def by_steps(first: str, second: str) -> dict[str, float]:
    """The same by small steps, exact for loads that are straight on each."""
    m, k, c, step = 10.0, 13811.0, 40.0, 1e-5
    shapes = {
        "half sine": lambda s: np.sin(np.pi * s), "versed sine": lambda s: 0.5 * (1.0 - np.cos(2.0 * np.pi * s)),
        "triangle": lambda s: 1.0 - abs(2.0 * s - 1.0), "falling sawtooth": lambda s: 1.0 - s,
    }  # fmt: skip
    t = np.arange(0.0, 0.6, step)
    base = np.where(t <= 12e-3, 200.0 * shapes[first](t / 12e-3), 0.0)
    push = np.where(t <= 40e-3, 150.0 * shapes[second](t / 40e-3), 0.0)
    load, x, v, across = push / m - base, 0.0, 0.0, []
    for here, then in pairwise(load):  # Newmark's mean acceleration
        middle = (0.5 * (here + then) - c / m * v - k / m * (x + 0.5 * step * v)) / (
            1.0 + 0.5 * step * c / m + 0.25 * step**2 * k / m
        )
        x, v = x + step * v + 0.5 * step**2 * middle, v + step * middle
        across.append((x, push[len(across) + 1] / m - c / m * v - k / m * x))
    moved, felt = np.abs(across).max(axis=0)
    return {"a": felt, "x": moved}


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("first", "second"), [*product(WAVES, LINES), *product(LINES, WAVES)])
def test_a_sine_and_a_straight_pulse_at_once_are_as_small_steps_show(first: str, second: str) -> None:
    found, right = measured(shaken(first, second)), by_steps(first, second)
    assert found == pytest.approx(right, rel=2e-3)


@pytest.mark.parametrize(
    ("first", "second"), [pytest.param("half sine", "triangle", marks=pytest.mark.slow), ("rectangle", "rectangle")]
)
def test_a_pulse_of_unknown_duration_leaves_the_duration_of_another_alone(first: str, second: str) -> None:
    """As the greatest of known durations, each a file of its own."""
    found = measured(shaken(first, second, "unit", duration_up_to="30 ms"))
    every = [measured(shaken(first, second, "unit", duration=f"{one} ms")) for one in np.linspace(3.0, 30.0, 10)]
    for name, value in found.items():
        most = max(one[name] for one in every)
        assert most * (1.0 - 1e-9) <= value <= most * 1.05


def test_a_pulse_of_unknown_duration_beside_a_force_that_stays_is_refused_with_what_to_write() -> None:
    document = shaken("rectangle", "rectangle", "unit", duration_up_to="12 ms")
    document["excitations"]["push"] = {
        "kind": "force", "on": "unit", "amplitude": "150 N", "speed": "4 Hz", "begins": "suddenly"
    }  # fmt: skip
    del document["measures"]["a"]
    assert list(refused(vo.from_dict, document).messages) == [
        "scene: measures.x counts a pulse of unknown duration, excitations.bump, beside excitations.push, which goes "
        'on for ever. Write its duration, name one: due_to = ["bump"], or add up the greatest of each: combine = "sum".'
    ]
    for more in ({"due_to": ["bump"]}, {"combine": "sum"}):
        assert measured({**document, "measures": {"x": {**document["measures"]["x"], **more}}})["x"] > 0.0


def test_isolation_on_a_mount_that_rubs_is_what_does_not_come_through() -> None:
    mount = {"between": ["pump", "ground"], "stiffness": "300 kN/m", "damping": "500 N s/m", "friction_force": "400 N"}
    asked = {"into": "ground", "due_to": ["shaker"]}
    found = measured(
        {
            "title": "pump on a mount that rubs",
            "bodies": {"pump": {"mass": "200 kg"}},
            "links": {"mount": mount},
            "excitations": {"shaker": {"kind": "force", "on": "pump", "amplitude": "1 kN", "speed": "900 rpm"}},
            "measures": {
                "kept": {"response": "isolation", **asked}, "through": {"response": "transmissibility", **asked}
            },
        }
    )  # fmt: skip
    assert found["kept"] == pytest.approx(1.0 - found["through"], rel=1e-9)
    assert 0.0 < found["kept"] < 1.0


def test_what_stays_below_the_greatest_is_left_out_of_closer_looks_without_loss(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    documents = [shaken("half sine", "triangle"), shaken("rectangle", "half sine", duration="300 ms")]
    briefly = [measured(one) for one in documents]
    monkeypatch.setattr(simulated, "_LOWER", 1.0)
    whole = [measured(one) for one in documents]
    assert briefly == [pytest.approx(one, rel=1e-14) for one in whole]
