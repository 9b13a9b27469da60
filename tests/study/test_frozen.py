"""A design that is bought: saved as a file, and followed under other facts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from texts import best, choice, moves, one_mass, table
from vibopt import jobs
from vibopt.scene.facts import fact_at, facts
from vibopt.scene.read import from_dict, from_text, read, with_changes
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.study.margins import Margins
from vibopt.study.saved import saved_text
from vibopt.study.sweep import sweep
from vibopt.study.thresholds import thresholds
from vibopt.study.whatif import whatif

PROBLEMS = Path(__file__).parents[2] / "problems"
SAVED = [
    "isolation/rao_9_34.toml",
    "isolation/press_on_rubber.toml",
    "mounts/generator_set.toml",
    "mounts/pump_flange.toml",
    "mounts/pump_with_absorber.toml",
    "mounts/genset_front_and_rear.toml",
    "mounts/inertia_base.toml",
    "absorbers/footbridge_marching.toml",
    "absorbers/frame_three_storeys.toml",
    "absorbers/gallery_girder.toml",
]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", SAVED)
def test_a_saved_design_solved_again_measures_the_same(name: str, tmp_path: Path) -> None:
    design = solve(read(PROBLEMS / name), explain=False)
    target = tmp_path / "deep" / "design.toml"
    target.parent.mkdir()
    target.write_text(saved_text(design.scene, design, target), encoding="utf-8")
    again = solve(read(target))
    assert again.status == "met"
    assert again.scene.is_analysis
    rows = {**design.limits, **design.measures}
    for key, row in {**again.limits, **again.measures}.items():
        if key in rows:
            assert row.value.value == pytest.approx(rows[key].value.value, rel=1e-12)
    assert set(rows) <= {*again.limits, *again.measures}
    if design.goal is not None and design.tolerances is None:
        (goal,) = (again.measures[key] for key in ("minimised", "maximised") if key in again.measures)
        assert goal.value.value == pytest.approx(design.goal[1].value, rel=1e-12)


PUSHED = one_mass(
    "fan", "100 kg", {"stiffness": "400 kN/m", "damping": choice("200 N s/m", "9 kN s/m")},
    {"kind": "pulse", "shape": "half sine", "amplitude": "5 kN", "duration": "30 ms"},
    table("measures.speed", response="peak_velocity", of="fan"), best(minimise="peak_acceleration", of="fan"),
)  # fmt: skip


@pytest.mark.parametrize("detector", ["", " pk", " pp", " rms"])
@pytest.mark.parametrize("combine", ["sum", "rss", "peak"])
def test_a_goal_of_several_harmonics_is_saved_in_a_unit_that_fits_how_they_add_up(combine: str, detector: str) -> None:
    """The limit speaks of one harmonic: its unit may be in pp or rms."""
    machine = {
        "bodies": {"fan": {"mass": "100 kg"}},
        "links": {
            "foot": {"between": ["fan", "ground"], "stiffness": {"from": "100 N/mm", "to": "900 N/mm"},
                     "damping": "900 N s/m"},
        },
        "excitations": {
            "one": {"kind": "force", "on": "fan", "amplitude": "90 N", "speed": "30 Hz"},
            "two": {"kind": "harmonics", "on": "fan", "speed": "20 Hz",
                    "harmonics": [{"order": 1, "amplitude": "50 N"}, {"order": 2, "amplitude": "20 N"}]},
        },
        "limits": {"slow": {"response": "displacement", "of": "fan", "due_to": ["one"], "at_most": f"9 mm{detector}"}},
        "goal": {"minimise": "displacement", "of": "fan", "due_to": ["two"], "combine": combine},
    }  # fmt: skip
    design = solve(from_dict(machine), explain=False)
    again = solve(from_dict(frozen(design.scene, design.x).document))
    goal, measured = design.goal[1], again.measures["minimised"].value
    assert measured.value == pytest.approx(goal.value, rel=1e-12)
    assert measured.unit == goal.unit
    fits = {"sum": " pp", "rss": " rms"}.get(combine)
    assert goal.unit == "mm" + (detector if detector in ("", " pk", fits) else "")


@pytest.mark.parametrize("limit", ["", table("limits.far", response="peak_displacement", of="fan", at_most="30 mm")])
def test_where_every_choice_is_given_a_value_what_was_made_best_is_measured(limit: str) -> None:
    scene = from_text(PUSHED + limit)
    design = solve(scene, explain=False)
    set_to = {path: f"{one.value.value!r} N s/m" for path, one in design.variables.items()}
    assert list(set_to) == ["links.mount.damping"]
    there = jobs.with_changes(scene, set_to)
    again = solve(there, explain=False)
    assert (again.status, there.is_analysis, set(there.measures)) == ("met", True, {"speed", "minimised"})
    assert design.goal is not None
    assert again.measures["minimised"].value.value == pytest.approx(design.goal[1].value, rel=1e-12)
    assert set(scene.document["measures"]) == {"speed"}
    held = {"links.mount.damping": {"one_of": ["300 N s/m", "900 N s/m"]}}
    assert jobs.with_changes(scene, held).goal is not None


def test_the_only_choice_varied_shows_what_was_made_best_against_it() -> None:
    found = sweep(from_text(PUSHED), "links.mount.damping", "300 N s/m..3 kN s/m", 3)
    best_of = [one.results["measures.minimised"].value for one in found.points]
    for point, least in zip(found.points, best_of, strict=True):
        given = jobs.with_changes(from_text(PUSHED), {"links.mount.damping": f"{point.value.value!r} N s/m"})
        assert solve(given).measures["minimised"].value.value == pytest.approx(least, rel=1e-12)
    assert len(set(best_of)) == 3


PENDULUM = """
title = "Pendulum whose mass is uncertain"
[bodies.floor]
mass = "184 kg"
[links.spring]
between = ["floor", "ground"]
stiffness = "2 MN/m"
[absorbers.bob]
on = "floor"
mass = { value = "30 kg", tolerance = "5 %" }
length = { from = "0.5 mm", to = "1 mm" }
damping_ratio = 0.07
[measures.first]
response = "natural_frequency"
mode = 1
[goal]
maximise = "damping_ratio"
mode = 1
"""


def test_a_saved_pendulum_is_pulled_back_by_its_own_weight(tmp_path: Path) -> None:
    design = solve(from_text(PENDULUM), explain=False)
    again = solve(from_text(saved_text(design.scene, design, tmp_path / "design.toml")))
    assert again.measures["first"].value.value == pytest.approx(design.measures["first"].value.value, rel=1e-9)
    assert design.goal is not None
    assert again.measures["maximised"].value.value == pytest.approx(design.goal[1].value, rel=1e-9)


def test_a_saved_design_says_where_it_comes_from(tmp_path: Path) -> None:
    design = solve(read(PROBLEMS / "isolation" / "rao_9_34.toml"))
    text = saved_text(design.scene, design, tmp_path / "x.toml", changes=["bodies.press.mass=300 kg"])
    assert text.splitlines()[:5] == [
        "# Design of rao_9_34.toml with bodies.press.mass=300 kg, saved by vibopt: nothing is left to choose.",
        "# Answer: optimal: greatest stiffness of mount is 6957 kN/m.",
        f"# Claim: {design.claim}.",
        "# Chosen: links.mount.stiffness, links.mount.damping.",
        "",
    ]
    assert "[[expected]]" not in text
    assert "from =" not in text


def test_a_catalogue_is_named_as_seen_from_where_the_design_lies(tmp_path: Path) -> None:
    shop, job = tmp_path / "shop", tmp_path / "jobs" / "one"
    shop.mkdir()
    job.mkdir(parents=True)
    (shop / "mounts.csv").write_text((PROBLEMS / "mounts" / "mounts.csv").read_text(encoding="utf-8"), encoding="utf-8")
    text = (PROBLEMS / "mounts" / "genset_front_and_rear.toml").read_text(encoding="utf-8")
    (shop / "genset.toml").write_text(text, encoding="utf-8")
    design = solve(read(shop / "genset.toml"), explain=False)
    saved = saved_text(design.scene, design, job / "design.toml")
    assert 'catalogue = "../../shop/mounts.csv", name = "' in saved


def test_without_a_design_nothing_is_saved(tmp_path: Path) -> None:
    scene = with_changes(read(PROBLEMS / "isolation" / "rao_9_34.toml"), {"limits.start_up.at_most": "5 mm"})
    caught = refused(lambda: saved_text(scene, solve(scene, explain=False), tmp_path / "x.toml"))
    assert str(caught) == ("rao_9_34.toml: there is no design to save: infeasible. x.toml is not written.")


def plank(mass: float, stiffness: float, damping: float, speed: float, bound: float) -> str:
    """One mass under 100 N, that may move so far."""
    mount = {"stiffness": f"{stiffness:.17g} N/m", "damping": f"{damping:.17g} N s/m"}
    shaken = {"name": "f", "amplitude": "100 N", "speed": f"{speed:.17g} rad/s", "varies": "constant"}
    return one_mass("b", f"{mass:.17g} kg", mount, shaken, moves("b", f"{bound:.17g} m"), link="k")


def _moved(mass: float, stiffness: float, damping: float, speed: float) -> float:
    """By hand: amplitude of one mass under 100 N."""
    return 100.0 / math.hypot(stiffness - mass * speed**2, damping * speed)


@given(
    speed=st.floats(5.0, 200.0),
    stiffness=st.floats(1e4, 1e6),
    ratio=st.floats(1e-3, 0.3),
    room=st.floats(1.05, 4.0),
)
@settings(max_examples=30, deadline=None)
def test_every_threshold_holds_just_inside_and_breaks_just_outside(
    speed: float, stiffness: float, ratio: float, room: float
) -> None:
    here = {"mass": 100.0, "stiffness": stiffness, "damping": 2 * ratio * math.sqrt(100.0 * stiffness), "speed": speed}
    bound = room * _moved(**here)
    scene = from_text(plank(**here, bound=bound))
    words = {"bodies.b.mass": "mass", "links.k.stiffness": "stiffness", "links.k.damping": "damping"}
    words["excitations.f.speed"] = "speed"
    for one in thresholds(scene, only=words):
        key, now = words[one.path], here[words[one.path]]
        for end, reach in ((one.below, 0.1), (one.above, 10.0)):
            last = now * reach if end is None else end.value
            between = np.geomspace(now, last, 4001)[:-1]
            worst = max(_moved(**{**here, key: float(v)}) for v in between)
            assert worst <= bound * (1.0 + 2e-9)
            if end is not None:
                assert _moved(**{**here, key: end.value * (1.0 + math.copysign(1e-9, reach - 1.0))}) > bound
                assert one.limits[int(reach > 1.0)] == "move"


def test_a_failing_stretch_between_two_values_of_the_grid_is_found() -> None:
    damping = 2 * 1e-4 * math.sqrt(100.0 * 1e5)
    here = {"mass": 100.0, "stiffness": 1e5, "damping": damping, "speed": 20.0}
    top = 100.0 / (damping * 20.0)
    scene = from_text(plank(**here, bound=0.5 * top))
    (stiffness,) = thresholds(scene, only=["links.k.stiffness"])
    resonant = 100.0 * 20.0**2
    width = math.sqrt((100.0 / (0.5 * top)) ** 2 - (damping * 20.0) ** 2)
    assert stiffness.below is not None
    assert stiffness.below.value == pytest.approx(resonant + width, rel=1e-9)
    assert width / resonant < 1e-3


@pytest.mark.slow
def test_thresholds_of_a_machine_in_space_hold_on_the_built_machine_on_both_sides() -> None:
    design = solve(read(PROBLEMS / "mounts" / "pump_flange.toml"), explain=False)
    kept = frozen(design.scene, design.x)
    paths = ("points.flange.at.y", "bodies.pump.made_of.1.mass", "mounts.foot.damping", "excitations.shaft.at.x")
    found = {one.path: one for one in thresholds(kept, only=paths)}
    looked = 0
    for path in paths:
        fact = fact_at(kept, path)
        for end in (found[path].below, found[path].above):
            if end is None or found[path].at_once(end):
                continue
            looked += 1
            inside = end.value - math.copysign(1e-7 * abs(end.value), end.value - fact.value)
            outside = end.value + math.copysign(1e-7 * abs(end.value), end.value - fact.value)
            assert solve(with_changes(kept, fact.changes(inside))).status == "met"
            assert solve(with_changes(kept, fact.changes(outside))).status == "violated"
    assert looked >= 4


def test_thresholds_over_tolerances_are_those_of_the_worst_corner() -> None:
    here = {"mass": 100.0, "stiffness": 1e5, "damping": 50.0, "speed": 100.0}
    corners = [(100.0 * (1 + a), 1e5 * (1 + b)) for a in (-0.05, 0.05) for b in (-0.2, 0.2)]
    bound = 1.2 * max(_moved(m, k, 50.0, 100.0) for m, k in corners)
    text = plank(**here, bound=bound)
    text = text.replace('"100000 N/m"', '{ value = "100000 N/m", tolerance = "20 %" }')
    text = text.replace('"100 kg"', '{ value = "100 kg", tolerance = "5 %" }')
    found = {one.path: one for one in thresholds(from_text(text))}
    stiffness = found["links.k.stiffness.value"]
    assert stiffness.above is not None
    # above resonance the lightest, stiffest machine moves most: m w^2 - k is least
    expected = (95.0 * 100.0**2 - math.sqrt((100.0 / bound) ** 2 - (50.0 * 100.0) ** 2)) / 1.2
    assert stiffness.above.value == pytest.approx(expected, rel=1e-8)


SET = """
[bodies.set]
mass = { value = "1800 kg", tolerance = "3 %" }
centre = ["0.1 m", "0 m", "0.4 m"]
inertia = ["310 kg m2", "620 kg m2", "590 kg m2"]
[mounts.foot]
between = ["set", "ground"]
at = [["0.8 m", "0.4 m", "0 m"], ["0.8 m", "-0.4 m", "0 m"], ["-0.8 m", "0.4 m", "0 m"], ["-0.8 m", "-0.4 m", "0 m"]]
stiffness = "1.5 MN/m"
shear_ratio = 0.6
rating = "1..8 kN"
[limits.load]
response = "static_load"
of = "foot"
"""


def test_in_space_the_thresholds_over_tolerances_are_those_of_the_heaviest_and_lightest_machine() -> None:
    paths = ["mounts.foot.rating.most", "mounts.foot.rating.least", "bodies.set.centre.x", "bodies.set.mass.value"]
    found = {one.path: one for one in thresholds(from_text(SET), only=paths)}
    weight = 1800.0 * 9.80665

    def load(factor: float, x: float) -> float:  # of one mount at +x, by moments about the two at -x
        return factor * weight / 4.0 * (1.0 + x / 0.8)

    ends = [(one.below, one.above) for one in found.values()]
    assert all(below is None or above is None or below.value < above.value for below, above in ends)
    most, least = found["mounts.foot.rating.most"].below, found["mounts.foot.rating.least"].above
    assert most is not None
    assert most.value == pytest.approx(load(1.03, 0.1), rel=1e-8)
    assert least is not None
    assert least.value == pytest.approx(load(0.97, -0.1), rel=1e-8)
    mass = found["bodies.set.mass.value"].above
    assert mass is not None
    assert mass.value == pytest.approx(1800.0 * 8e3 / load(1.03, 0.1), rel=1e-8)
    x = found["bodies.set.centre.x"]
    assert x.above is not None
    assert x.above.value == pytest.approx(0.8 * (8e3 / (1.03 * weight / 4.0) - 1.0), rel=1e-8)


def test_what_cannot_be_is_no_failure() -> None:
    scene = read(PROBLEMS / "mounts" / "generator_set.toml")
    design = solve(scene, explain=False)
    kept = frozen(design.scene, design.x)
    fact = fact_at(kept, "bodies.genset.inertia.y")
    assert Margins(kept, fact)(5000.0) is None
    (found,) = thresholds(kept, only=[fact.path])
    assert found.above is None or found.above.value < 900.0


def test_places_ratings_and_ends_of_ranges_are_facts() -> None:
    known = {one.path: one for one in facts(read(PROBLEMS / "mounts" / "focalised_engine.toml"))}
    assert known["mounts.left.at.2.x"].value == pytest.approx(-0.35)
    assert known["bodies.engine.centre.z"].value == pytest.approx(0.15)
    assert known["excitations.torque.speed.highest"].changes(100 * math.pi / 30) == {
        "excitations.torque.speed": "700 rpm..100 rpm"
    }
    genset = {one.path: one for one in facts(read(PROBLEMS / "mounts" / "generator_set.toml"))}
    assert genset["mounts.foot.rating.most"].changes(7000.0) == {"mounts.foot.rating": "1 kN..7 kN"}


@pytest.mark.parametrize("name", ["mounts/generator_set.toml", "isolation/rao_9_34.toml", "mounts/inertia_base.toml"])
def test_every_fact_written_back_is_the_same_scene(name: str) -> None:
    scene = read(PROBLEMS / name)
    for one in facts(scene):
        again = {other.path: other for other in facts(with_changes(scene, one.changes(one.value)))}
        assert again[one.path].value == pytest.approx(one.value, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "path", "low_high"),
    [
        ("isolation/rao_9_34.toml", "bodies.press.mass", "300 kg..310 kg"),
        pytest.param("mounts/generator_set.toml", "mounts.foot.rating.most", "6 kN..7 kN", marks=pytest.mark.slow),
        ("isolation/press_on_rubber.toml", "excitations.press.amplitude", "30 kN..31 kN"),
        ("absorbers/frame_three_storeys.toml", "bodies.first.mass", "60 t..61 t"),
    ],
)
def test_a_sweep_of_the_kept_design_says_what_whatif_says(name: str, path: str, low_high: str) -> None:
    scene = read(PROBLEMS / name)
    swept = sweep(scene, path, low_high, 2, keep_design=True)
    fact = fact_at(scene, path)
    assert swept.points[0].value.value == pytest.approx(fact.value)
    now = whatif(scene, fact.changes(fact.value), keep_design=True)
    for point, alone in ((swept.points[0], now.before), (swept.points[0], now.after)):
        assert point.status == now.after.status == "met"
        assert {*point.margins} == {*alone.limits}
        for key, margin in point.margins.items():
            assert margin == pytest.approx(alone.limits[key].margin, abs=1e-9)
    assert now.breaks == ()


def test_a_design_without_limits_can_be_kept() -> None:
    text = plank(mass=100.0, stiffness=1e5, damping=50.0, speed=20.0, bound=1.0)
    text = text[: text.index("[limits.move]")].replace('"100000 N/m"', '{ from = "50 kN/m", to = "90 kN/m" }')
    scene = from_text(text + '[goal]\nminimise = "displacement"\nof = "b"\n')
    kept = whatif(scene, {"bodies.b.mass": "120 kg"}, keep_design=True)
    assert kept.after.status == "met"
    assert kept.after.measures["minimised"].value.value == pytest.approx(_moved(120.0, 9e4, 50.0, 20.0), rel=1e-9)
