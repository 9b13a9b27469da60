"""What is advised where there is no design, and what a limit is said to cost, holds when it is put into the file."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from texts import best, choice, one_mass, sags, table
from vibopt.scene.read import from_dict, from_text, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.solve.advice import _Trial
from vibopt.study.prices import priced

few = settings(derandomize=True, database=None, deadline=None, max_examples=15)


def _press(mass: dict[str, Any], floor: float, swing: float, sag: float | None, mode: float | None) -> Scene:
    """A machine under 1 kN at 100 rad/s; a limit on its sag forbids too much mass, one on its mode too little."""
    limits: dict[str, Any] = {
        "floor": {"response": "transmitted_force", "into": "ground", "at_most": f"{floor!r} N"},
        "swing": {"response": "displacement", "of": "fan", "at_most": f"{swing!r} mm"},
    }
    if sag is not None:
        limits["sag"] = {"response": "static_deflection", "of": "mount", "at_most": f"{sag!r} mm"}
    if mode is not None:
        limits["mode"] = {"response": "natural_frequency", "at_least": f"{mode!r} Hz"}
    return from_dict(
        {
            "title": "press",
            "bodies": {"fan": mass},
            "links": {
                "mount": {
                    "between": ["fan", "ground"],
                    "stiffness": {"from": "1 kN/m", "to": "10 MN/m"},
                    "damping": {"from": "10 N s/m", "to": "20 kN s/m"},
                }
            },
            "excitations": {
                "fan": {"kind": "force", "on": "fan", "amplitude": "1 kN", "speed": "100 rad/s", "varies": "constant"}
            },
            "limits": limits,
            "goal": {"maximise": "stiffness", "of": "mount"},
        }
    )


def _feasible(scene: Scene) -> bool:
    return solve(scene, explain=False).status in ("optimal", "feasible")


@given(
    mass=st.floats(20.0, 400.0),
    floor=st.floats(20.0, 600.0),
    swing=st.floats(0.02, 1.0),
    sag=st.none() | st.floats(0.3, 30.0),
    mode=st.none() | st.floats(1.0, 12.0),
    key=st.sampled_from(["mass", "weight"]),
)
@few
def test_a_mass_that_is_advised_is_enough_for_the_whole_job_and_a_step_less_is_not(
    mass: float, floor: float, swing: float, sag: float | None, mode: float | None, key: str
) -> None:
    given_ = f"{mass:.4g} kg" if key == "mass" else f"{9.80665 * mass:.4g} N"
    scene = _press({key: given_}, *(one and float(f"{one:.4g}") for one in (floor, swing, sag, mode)))
    design = solve(scene)
    found = re.search(rf"With a {key} of ([\d.]+) (kg|N) instead of ", design.reason)
    if found is None:
        assert "With a " not in design.reason
        return
    assert _feasible(with_changes(scene, {f"bodies.fan.{key}": f"{found[1]} {found[2]}"}))
    value = float(found[1])
    step = 10.0 ** (len(f"{math.ceil(value) - 1}") - 3)
    assert not _feasible(with_changes(scene, {f"bodies.fan.{key}": f"{value - step:.12g} {found[2]}"}))


def test_a_mass_that_the_balance_of_forces_alone_allows_is_not_advised() -> None:
    """With the least mass that inertia needs the floor holds, but the spring is then too soft for the sag."""
    free = solve(_press({"mass": "50 kg"}, 100.0, 0.5, None, None))
    assert "can do it with a mass below 180 kg; it is 50 kg. With a mass of " in free.reason
    tight = solve(_press({"mass": "50 kg"}, 100.0, 0.5, 1.0, None))
    assert tight.reason.endswith("No mass up to 1800 kg was found with which every limit could hold.")


@pytest.mark.parametrize("side", ["at_most", "at_least"])
@given(bound=st.floats(1.0, 10.0))
@few
def test_the_step_of_a_price_is_a_tenth_and_its_goal_is_that_of_the_step_as_shown(side: str, bound: float) -> None:
    bound = float(f"{bound:.4g}")
    if side == "at_most":
        scene = _press({"mass": "300 kg"}, 1000.0, 20.0 + bound, None, None)
        scene = with_changes(scene, {"limits.floor.at_most": f"{20.0 * bound!r} N"})
        name, unit, given_ = "floor", "N", 20.0 * bound
    else:
        scene = _press({"mass": "300 kg"}, 2000.0, 900.0, None, bound)
        scene = with_changes(scene, {"goal": {"minimise": "stiffness", "of": "mount"}})
        name, unit, given_ = "mode", "Hz", bound
    design = priced(solve(scene))
    price = design.limits[name].price
    if design.status != "optimal" or price is None:
        return
    number = float(price.loosened.shown.split()[0])
    part = abs(number - given_) / given_
    assert 0.094 <= part <= 0.106
    again = solve(with_changes(scene, {f"limits.{name}.{side}": f"{number!r} {unit}"}), explain=False)
    assert again.goal is not None
    assert again.goal[1].value == pytest.approx(price.goal.value, rel=1e-9)
    assert f"-> {price.loosened.shown}:" in price.words


def soft_or_stiff(sag: float, pitch: float) -> str:
    """A tank that may neither sag [mm] nor ring [Hz]."""
    asked = table("limits.pitch", response="natural_frequency", at_most=f"{pitch!r} Hz")
    mount, goal = {"stiffness": choice("1 N/m", "1 GN/m")}, best(minimise="stiffness", of="spring")
    return one_mass("tank", "300 kg", mount, {}, sags("spring", f"{sag!r} mm"), asked, goal, link="spring")


@settings(max_examples=12)
@given(st.floats(0.5, 80.0), st.one_of(st.floats(1.0003, 1.02), st.floats(1.02, 8.0)))
def test_a_loosening_is_what_a_formula_needs_to_a_small_part_of_the_change(sag: float, off: float) -> None:
    """Sag and frequency hang together, w^2 = g / sag, whatever the mass; either alone can give way."""
    pitch = math.sqrt(9.80665 / (1e-3 * sag)) / (2.0 * math.pi) / off
    design = solve(from_text(soft_or_stiff(sag, pitch), name="tank.toml"))
    assert design.status == "infeasible"
    assert design.conflict is not None
    least = {"sag": 1e-3 * sag * off**2, "pitch": 2.0 * math.pi * pitch * off}
    assert {name for name, _, _ in design.conflict.loosenings} == set(least)
    for name, now, then in design.conflict.loosenings:
        change = least[name] - now.value
        assert -1e-9 * least[name] <= then.value - least[name] <= 0.005 * change * (1.0 + 1e-6), (name, change)
        text = {"limits.sag.at_most": then.shown} if name == "sag" else {"limits.pitch.at_most": then.shown}
        assert solve(with_changes(design.job, text)).status == "optimal"  # as it is shown


@pytest.mark.parametrize(("least", "most_asked"), [(45.195, 2), (45.184, 4), (45.12, 8)])
def test_a_bound_that_should_do_is_brought_down_by_longer_and_longer_steps(
    monkeypatch: pytest.MonkeyPatch, least: float, most_asked: int
) -> None:
    """From where it was found, not from the middle of the way to what is too little."""
    tried: list[float] = []
    monkeypatch.setattr(_Trial, "holds", lambda _, number: tried.append(number) or number >= least)
    found = _Trial(None, None, None).least([33.87, 45.2, 47.0], fine=True)  # type: ignore[arg-type]
    assert found is not None
    assert least <= found < least + 0.0101
    assert len(tried) <= most_asked
