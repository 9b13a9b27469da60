"""No passive device beats the bound of any passive device, and the bound of a mass on a spring has a closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.solve.method import Found
from vibopt.solve.passive import Device, hung, with_bound
from vibopt.solve.solve import solve

few = settings(derandomize=True, database=None, deadline=None, max_examples=10)
RANGES = {"frequency": {"from": "1 Hz", "to": "60 Hz"}, "damping_ratio": {"from": 0.001, "to": 1}}
QUIET = {"quiet": {"response": "displacement", "of": "b0", "at_most": "1.5 mm"}}


def document(masses: list[float], springs: list[float], dampers: list[float], **more: Any) -> dict[str, Any]:
    """A chain on the ground, b0 the lowest, in kg, N/m and N s/m."""
    names = [f"b{i}" for i in range(len(masses))]
    links = {
        f"l{i}": {
            "between": [name, names[i - 1] if i else more.get("foot", "ground")],
            "stiffness": f"{k!r} N/m",
            "damping": f"{c!r} N s/m",
        }
        for i, (name, k, c) in enumerate(zip(names, springs, dampers, strict=True))
    }
    bodies = {name: {"mass": f"{m!r} kg"} for name, m in zip(names, masses, strict=True)}
    force = {"kind": "force", "on": "b0", "amplitude": "100 N", "speed": "3 Hz..30 Hz"}
    if "foot" in more:
        more["bases"] = {more.pop("foot"): {}}
    rest = {"excitations": {"e": force}, "goal": {"minimise": "displacement", "of": "b0"}}
    return {"title": "t", "bodies": bodies, "links": links, **rest, **more}


def absorbers(masses: list[float], on: str = "b0", *, series: bool = False) -> dict[str, Any]:
    return {
        f"a{i}": {"on": f"a{i - 1}" if series and i else on, "mass": f"{m!r} kg", **RANGES}
        for i, m in enumerate(masses)
    }


@pytest.mark.parametrize("ratio", [0.003, 0.05, 0.4])
def test_of_a_mass_on_a_spring_it_is_known_in_closed_form(ratio: float) -> None:
    """sqrt(1 + 1 / mu), which Den Hartog's sqrt(1 + 2 / mu) stays above."""
    scene = from_dict(document([100.0], [4e5], [0.0], absorbers=absorbers([100.0 * ratio])))
    aim = pose(scene).aim
    assert aim is not None
    host = hung(aim)
    assert host is not None
    found = Device(host).least(100.0 * ratio) / (100.0 / 4e5)
    assert found <= np.sqrt(1.0 + 1.0 / ratio) * (1.0 + 1e-9)
    assert found == pytest.approx(np.sqrt(1.0 + 1.0 / ratio), rel=2e-3)


@st.composite
def hosts(draw: st.DrawFn) -> tuple[dict[str, Any], int]:
    """A chain, shaken somewhere, with a device to hang on one of its bodies."""
    n = draw(st.integers(1, 3))
    masses = [draw(st.floats(20.0, 200.0)) for _ in range(n)]
    springs = [m * (2.0 * np.pi * draw(st.floats(4.0, 20.0))) ** 2 for m in masses]
    part = draw(st.sampled_from([0.0, 1e-4, 4e-4]))
    place = draw(st.integers(0, n - 1))
    shaken = draw(st.sampled_from(["force", "base_motion", "unbalance"]))
    asked = draw(st.sampled_from(["displacement", "velocity", "acceleration"]))
    one: dict[str, Any] = {"kind": shaken, "speed": "2 Hz..40 Hz"}
    if shaken == "base_motion":
        one |= {"on": "floor", "displacement": "1 mm"}
    else:
        one["on"] = f"b{draw(st.integers(0, n - 1))}"
        one |= {"amplitude": "10 N"} if shaken == "force" else {"unbalance": "1 kg mm"}
    goal = {"minimise": asked, "of": f"b{place}"}
    foot = {"foot": "floor"} if shaken == "base_motion" else {}
    made = document(masses, springs, [part * k for k in springs], excitations={"e": one}, goal=goal, **foot)
    return made, place


def least_by_trials(made: dict[str, Any], place: int, total: float, seed: int) -> float:
    """The least greatest response with many devices of two or three masses, by matrices of its own."""
    rng, n = np.random.default_rng(seed), len(made["bodies"])
    m = np.array([float(one["mass"].split()[0]) for one in made["bodies"].values()])
    k, c = ([float(one[word].split()[0]) for one in made["links"].values()] for word in ("stiffness", "damping"))
    w = 2.0 * np.pi * np.geomspace(2.0, 40.0, 500)
    size = n + 3
    fixed = np.zeros((len(w), size, size), dtype=complex)
    for i in range(n):
        z = k[i] + 1j * w * c[i]
        fixed[:, i, i] += z - w**2 * m[i]
        if i:
            fixed[:, i - 1, i - 1] += z
            fixed[:, i, i - 1] -= z
            fixed[:, i - 1, i] -= z
    one = made["excitations"]["e"]
    load = np.zeros((len(w), size), dtype=complex)
    if one["kind"] == "base_motion":
        load[:, 0] = 1e-3 * (k[0] + 1j * w * c[0])
    else:
        load[:, int(one["on"][1:])] = 10.0 if one["kind"] == "force" else 1e-3 * w**2
    power = ["displacement", "velocity", "acceleration"].index(made["goal"]["minimise"])
    bare = np.linalg.solve(fixed[:, :n, :n], load[:, :n, None])[:, place, 0]
    best, chosen, spread = np.inf, False, 0.4
    middle = np.r_[np.log(w[np.argmax(np.abs(bare))]) * np.ones(3), np.log(0.1) * np.ones(3), np.zeros(3)]
    for turn in range(260):
        y = middle + spread * 0.985**turn * rng.normal(size=9)
        share = np.exp(y[6:]) / np.exp(y[6:]).sum() * total
        series = rng.random() < 0.5 if turn < 20 else chosen
        matrix = fixed.copy()
        for j in range(3):
            own = np.exp(y[j])
            z, a = share[j] * own**2 + 2j * np.exp(y[3 + j]) * share[j] * own * w, n + j
            b = place if j == 0 or not series else a - 1
            matrix[:, a, a] += z - share[j] * w**2
            matrix[:, b, b] += z
            matrix[:, a, b] -= z
            matrix[:, b, a] -= z
        top = float((np.abs(np.linalg.solve(matrix, load[..., None])[:, place, 0]) * w**power).max())
        if top < best:
            best, middle, chosen = top, y, series
    return best


@few
@given(hosts(), st.floats(0.01, 0.3), st.integers(0, 999))
def test_no_device_beats_it(drawn: tuple[dict[str, Any], int], ratio: float, seed: int) -> None:
    """Whatever hangs on a body: the bound comes from impedances, the devices are measured by matrices of their own."""
    made, place = drawn
    total = ratio * float(made["bodies"][f"b{place}"]["mass"].split()[0])
    aim = pose(from_dict({**made, "absorbers": absorbers([0.5 * total] * 2, f"b{place}")})).aim
    assert aim is not None
    host = hung(aim)
    assert host is not None
    assert Device(host).least(total) <= least_by_trials(made, place, total, seed) * (1.0 + 1e-9)


def test_two_in_series_come_near_it() -> None:
    """The bound is no empty one: 5.021 times the static motion is a twelfth above sqrt(21); boxes know none better."""
    scene = from_dict(document([100.0], [4e5], [0.0], absorbers=absorbers([4.5, 0.5], series=True)))
    found, whole = solve(scene, method="nlp"), solve(scene)
    assert found.status == "feasible"
    assert whole.goal is not None
    assert 0.99 * whole.goal[1].value < whole.details["bound"] <= whole.goal[1].value
    assert found.goal is not None
    assert found.goal[1].value / 2.5e-4 == pytest.approx(5.032, rel=2e-3)
    assert "at most 9.8 % above what any passive device of the same mass could reach" in found.claim
    assert found.details["bound"] == pytest.approx(np.sqrt(21.0) * 2.5e-4, rel=1e-3)


def test_a_least_mass_has_one_too() -> None:
    """The mass whose bound is the limit: 1 / (r^2 - 1) of the host where r is the limit over the static motion."""
    masses = {"mass": {"from": "0.1 kg", "to": "20 kg"}}
    two = {name: {**one, **masses} for name, one in absorbers([1.0, 1.0]).items()}
    made = document([100.0], [4e5], [0.0], absorbers=two, limits=QUIET, goal={"minimise": "absorber_mass"})
    program, least = pose(from_dict(made)), 100.0 / (6.0**2 - 1.0)
    found = with_bound(program, Found("feasible", np.array([2.5, 62.0, 0.1] * 2), "found", "nlp"))
    heavy = with_bound(program, Found("feasible", np.array([20.0, 62.0, 0.1] * 2), "found", "nlp"))
    assert heavy.claim == "found"  # of a design fourteen times as heavy the bound says next to nothing
    assert heavy.bound < 40.0 / 3.0
    assert 0.95 * least < found.bound <= least * (1.0 + 1e-9)
    above = 100.0 * (5.0 / found.bound - 1.0)
    expected = (
        f"found; at most {above:.2g} % above what any passive device of the least mass would weigh, however it is made"
    )
    assert found.claim == expected


@pytest.mark.parametrize(
    "change",
    [
        {"goal": {"minimise": "stroke", "of": "a0"}},  # of what hangs
        {"goal": {"minimise": "displacement", "of": "b1"}},  # of another body than that on which it hangs
        {"links": {"tie": {"between": ["a0", "ground"], "stiffness": "10 N/m", "damping": "1 N s/m"}}},
    ],
)
def test_elsewhere_there_is_none(change: dict[str, Any]) -> None:
    made = document([100.0, 50.0], [4e5, 2e5], [0.0, 0.0], absorbers=absorbers([2.0, 3.0]))
    made = {**made, **change, "links": {**made["links"], **change.get("links", {})}}
    aim = pose(from_dict(made)).aim
    assert aim is not None
    assert hung(aim) is None
