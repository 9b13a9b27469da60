"""A base whose displacement is white noise: Lyapunov's equation, adding up over frequencies, and hand-written forms."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import vibopt as vo
from vibopt.program.pose import on_needed, pose
from vibopt.scene.read import from_dict

few = settings(derandomize=True, database=None, deadline=None, max_examples=15)
ASKED: tuple[dict[str, Any], ...] = (
    {"response": "rms_displacement", "of": "a"},
    {"response": "rms_displacement", "of": "b"},
    {"response": "rms_velocity", "of": "a"},
    {"response": "rms_velocity", "of": "b"},
    {"response": "rms_acceleration", "of": "a"},
    {"response": "rms_acceleration", "of": "b"},
    {"response": "rms_relative_displacement", "across": "low"},
    {"response": "rms_relative_displacement", "across": "high"},
    {"response": "rms_force", "through": "high"},
    {"response": "rms_force", "through": "low"},
    {"response": "rms_force", "into": "ground"},
)


def _document(ratios: tuple[float, float, float], springs: tuple[float, float], tied: bool) -> dict[str, Any]:
    """Two bodies over a moving base, the upper one perhaps held to the ground as well; a ratio of zero is no damper."""
    first, second, third = ratios
    links: dict[str, Any] = {
        "low": {"between": ["floor", "a"], "stiffness": f"{springs[0]!r} N/m"},
        "high": {"between": ["a", "b"], "stiffness": f"{springs[1]!r} N/m"},
    }
    if tied:
        links["side"] = {"between": ["b", "ground"], "stiffness": "3 kN/m"}
    for name, ratio in (("low", first), ("high", second), ("side", third)):
        if name in links and ratio:
            links[name]["damping"] = f"{2.0 * ratio * (10.0 * springs[0]) ** 0.5!r} N s/m"
    return {
        "bodies": {"a": {"mass": "10 kg"}, "b": {"mass": "3 kg"}},
        "bases": {"floor": {}},
        "links": links,
        "excitations": {"noise": {"kind": "white_noise", "on": "floor", "density": "0.02 mm²/Hz"}},
    }


def _by_frequencies(document: dict[str, Any], asked: dict[str, Any]) -> float:
    """The root mean square from matrices written here, the squared response integrated over all frequencies."""
    index = {"a": 0, "b": 1, "floor": 2}
    stiff, dash = np.zeros((3, 3)), np.zeros((3, 3))
    rows = {}
    for name, link in document["links"].items():
        row = np.zeros(3)
        for end, sign in zip(link["between"], (-1.0, 1.0), strict=True):
            if end in index:
                row[index[end]] = sign
        k, c = float(link["stiffness"].split()[0]), float(link.get("damping", "0 N s/m").split()[0])
        k *= 1e3 if "kN" in link["stiffness"] else 1.0
        stiff, dash = stiff + k * np.outer(row, row), dash + c * np.outer(row, row)
        rows[name] = row, k, c
    mass = np.diag([10.0, 3.0])

    def squared(omega: float) -> float:
        whole = stiff + 1j * omega * dash
        moved = np.linalg.solve(whole[:2, :2] - omega**2 * mass, -whole[:2, 2])
        u = np.append(moved, 1.0)
        if "of" in asked:
            power = ("rms_displacement", "rms_velocity", "rms_acceleration").index(asked["response"])
            return float(abs(u[index[asked["of"]]]) ** 2 * omega ** (2 * power))
        if "across" in asked:
            return float(abs(rows[asked["across"]][0] @ u) ** 2)
        row, k, c = rows[asked.get("through", "side")]
        return float(abs((k + 1j * omega * c) * (row @ u)) ** 2)

    state = np.block(
        [[np.zeros((2, 2)), np.eye(2)], [-np.linalg.inv(mass) @ stiff[:2, :2], -np.linalg.inv(mass) @ dash[:2, :2]]]
    )
    marks = sorted({abs(one) * part for one in np.linalg.eigvals(state) for part in (0.9, 0.98, 1.0, 1.02, 1.1)})
    edges = [0.0, *marks]
    total = sum(quad(squared, a, b, limit=200, epsrel=1e-11)[0] for a, b in pairwise(edges))
    total += quad(lambda one: squared(1.0 / one) / one**2, 0.0, 1.0 / edges[-1], limit=200, epsrel=1e-11)[0]
    return float(np.sqrt(total * 0.02e-6 / (2.0 * np.pi)))


@given(
    ratios=st.tuples(*[st.sampled_from([0.0, 0.02, 0.1, 0.6])] * 3),
    springs=st.tuples(st.floats(1e3, 5e4), st.floats(1e3, 5e4)),
    tied=st.booleans(),
)
@few
def test_what_is_finite_agrees_on_three_roads_and_the_rest_is_refused_or_said_to_be_infinite(
    ratios: tuple[float, float, float], springs: tuple[float, float], tied: bool
) -> None:
    ratios = ratios if ratios[0] or ratios[1] else (0.0, 0.05, ratios[2])
    springs = (float(f"{springs[0]:.4g}"), float(f"{springs[1]:.4g}"))
    document = _document(ratios, springs, tied)
    falls = {"a": 1 if ratios[0] else 2}
    falls["b"] = falls["a"] + (1 if ratios[1] else 2)
    for asked in ASKED:
        if asked.get("into") == "ground" and not tied:
            continue
        if "of" in asked:
            power = ("rms_displacement", "rms_velocity", "rms_acceleration").index(asked["response"])
            finite = falls[asked["of"]] - power >= 1
        else:
            link = asked.get("across") or asked.get("through") or "side"
            damped = "across" not in asked and bool(ratios[("low", "high", "side").index(link)])
            finite = {"low": 0, "high": falls["a"], "side": falls["b"]}[link] - damped >= 1
        whole = {**document, "measures": {"x": asked}}
        if not finite:
            with pytest.raises(vo.InputError, match="is infinite whatever the design: a base whose displacement"):
                from_dict(whole)
            continue
        scene = from_dict(whole)
        found = vo.solve(scene).measures["x"].value.value
        model, form = on_needed(scene, pose(scene).model, scene.measures["x"])
        assert form.value(model, np.zeros(0)) == pytest.approx(found, rel=1e-8)
        assert found == pytest.approx(_by_frequencies(whole, asked), rel=1e-6)


def test_a_mass_on_a_spring_and_a_damper_moves_as_the_closed_form_says() -> None:
    """Mean square S (k/c + c/m) / 4 for a one-sided density S per hertz."""
    document = _document((0.1, 0.0, 0.0), (1e4, 1e4), False)
    del document["bodies"]["b"], document["links"]["high"]
    document["measures"] = {"x": {"response": "rms_displacement", "of": "a"}}
    found = vo.solve(from_dict(document)).measures["x"].value.value
    c = 2.0 * 0.1 * (10.0 * 1e4) ** 0.5
    assert found == pytest.approx(np.sqrt(0.02e-6 * (1e4 / c + c / 10.0) / 4.0), rel=1e-12)


def test_a_mass_on_a_damper_alone_follows_slowly_and_an_undamped_mode_that_is_shaken_has_no_end() -> None:
    document = _document((0.1, 0.0, 0.0), (1e4, 1e4), False)
    del document["bodies"]["b"], document["links"]["high"], document["links"]["low"]["stiffness"]
    document["measures"] = {"x": {"response": "rms_displacement", "of": "a"}}
    c = 2.0 * 0.1 * (10.0 * 1e4) ** 0.5
    found = vo.solve(from_dict(document)).measures["x"].value
    assert found.value == pytest.approx(np.sqrt(0.02e-6 * (c / 10.0) / 4.0), rel=1e-9)
    bare = _document((0.0, 0.0, 0.0), (1e4, 1e4), False)
    bare["measures"] = {"x": {"response": "rms_displacement", "of": "b"}}
    assert vo.solve(from_dict(bare)).measures["x"].value.shown == "infinite"


@given(stiffness=st.floats(2e3, 4e4), damping=st.floats(5.0, 500.0))
@few
def test_slopes_are_those_of_differences(stiffness: float, damping: float) -> None:
    document = _document((0.1, 0.05, 0.0), (1e4, 1e4), False)
    document["links"]["low"] |= {
        "stiffness": {"from": "1 kN/m", "to": "50 kN/m"},
        "damping": {"from": "1 N s/m", "to": "1 kN s/m"},
    }
    document["goal"] = {"minimise": "rms_displacement", "of": "b"}
    program = pose(from_dict(document))
    assert program.aim is not None
    x = np.array([stiffness, damping])
    slope = program.aim.form.slope(program.aim.model, x)
    for i in range(2):
        ends = [program.aim.form.value(program.aim.model, x * np.exp(step * np.eye(2)[i])) for step in (-1e-5, 1e-5)]
        assert np.ravel(slope)[i] == pytest.approx(np.log(ends[1] / ends[0]) / 2e-5, rel=1e-5, abs=1e-8)


def test_a_suspension_is_designed_and_the_limit_holds_on_the_built_machine() -> None:
    document = _document((0.1, 0.05, 0.0), (1e4, 1e4), False)
    document["links"]["low"]["damping"] = {"from": "1 N s/m", "to": "1 kN s/m"}
    document["goal"] = {"minimise": "rms_displacement", "of": "b"}
    design = vo.solve(from_dict(document))
    assert design.status == "optimal"
    assert design.goal is not None
    for c in np.geomspace(1.0, 1e3, 40):
        frozen = {**document, "measures": {"x": {"response": "rms_displacement", "of": "b"}}}
        frozen["links"] = {**document["links"], "low": {**document["links"]["low"], "damping": f"{c:.9g} N s/m"}}
        frozen.pop("goal")
        assert vo.solve(from_dict(frozen)).measures["x"].value.value >= design.goal[1].value * (1.0 - 1e-9)


STEEPEST = {"half sine": np.pi, "versed sine": np.pi, "sine": 2.0 * np.pi, "triangle": 2.0}
"""Greatest velocity of a base that goes to and fro by one in a second."""


@pytest.mark.parametrize("shape", sorted(STEEPEST))
@pytest.mark.parametrize("ratio", [0.0, 0.05, 1.0, 5.0])
def test_a_base_that_goes_and_comes_at_once_leaves_the_mass_in_its_place(shape: str, ratio: float) -> None:
    """Its mount pulls then with k x and c v of the base alone; at critical damping poles meet."""
    rate, mass, far, long = 100.0, 10.0, 0.01, 6e-8
    mount = {"between": ["unit", "base"], "stiffness": f"{mass * rate**2} N/m"}
    mount |= {"damping": f"{2.0 * ratio * mass * rate} N s/m"} if ratio else {}
    struck = {"kind": "pulse", "on": "base", "shape": shape, "displacement": f"{far} m", "duration": f"{long} s"}
    answer = vo.solve(
        vo.from_dict(
            {
                "title": "a unit on a base that is struck",
                "bases": {"base": {}},
                "bodies": {"unit": {"mass": f"{mass} kg"}},
                "links": {"mount": mount},
                "excitations": {"blow": struck},
                "measures": {"felt": {"response": "peak_acceleration", "of": "unit"}},
            }
        )
    )
    assert answer.status == "met", answer.claim
    right = 2.0 * ratio * rate * far * STEEPEST[shape] / long if ratio else rate**2 * far
    assert answer.measures["felt"].value.value == pytest.approx(right, rel=3e-4)
