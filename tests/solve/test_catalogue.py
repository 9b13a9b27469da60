"""Parts from catalogues: the search never differs from looking at every combination."""

from __future__ import annotations

import copy
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import vibopt as vo
from vibopt.answer.answer_page import html
from vibopt.document.toml_reading import placed
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict, read, with_changes
from vibopt.scene.scene import Design, Scene
from vibopt.solve import solve
from vibopt.solve.branch import Judge
from vibopt.solve.catalogue.choices import Choices, factors_of
from vibopt.solve.catalogue.parts import Catalogue
from vibopt.study.freeze import frozen
from vibopt.study.whatif import whatif

MOUNTS = Path(__file__).parents[2] / "problems" / "mounts"
DAMPINGS = ("damping [N s/m]", "loss factor", "damping ratio")


def shelf_of(folder: Path, rng: np.random.Generator, parts: int, damper: str) -> None:
    """A random catalogue, semicolons and decimal commas."""
    heads = ["part", "rated load min [N]", "rated load max [N]", "stiffness [N/mm]", "static stiffness [N/mm]", damper]
    rows = [";".join([*heads, "price [EUR]"])]
    for index in range(parts):
        load, stiff = 10 ** rng.uniform(2.6, 4.0), 10 ** rng.uniform(1.3, 3.3)
        damping = 10 ** rng.uniform(2.0, 3.5) if "N s" in damper else rng.uniform(0.02, 0.3)
        cells = (0.2 * load, load, stiff, stiff / rng.uniform(1.0, 1.6), damping, float(rng.integers(5, 90)))
        rows.append(f"P{index};" + ";".join(f"{one:.6g}".replace(".", ",") for one in cells))
    (folder / "random.csv").write_text("\n".join(rows), encoding="utf-8")


def document_of(rng: np.random.Generator, *, two: bool, goal: str) -> dict[str, Any]:
    """One or two masses on one or two groups of parts, with limits of every kind."""
    part = {"part": {"catalogue": "random.csv"}}
    links: dict[str, Any] = {
        "a": {"between": ["machine", "ground"], "count": {"from": 3, "to": 5, "whole": True}, **part}
    }
    bodies = {"machine": {"mass": f"{rng.uniform(300, 1500):.4g} kg"}}
    if two:
        links["a"]["between"] = ["machine", "frame"] if rng.random() < 0.5 else ["machine", "ground"]
        links["b"] = {"between": ["frame", "ground"], "count": 4, "relative_to": "machine", **part}
        if links["a"]["between"][1] == "ground":
            links["b"] = {**links["a"], "relative_to": "machine"}
        else:
            bodies["frame"] = {"mass": f"{rng.uniform(300, 900):.4g} kg"}
        links["a"]["relative_to"] = "machine"
    goals = {
        "price": {"minimise": "price"},
        "force": {"minimise": "transmitted_force", "into": "ground"},
        "frequency": {"maximise": "natural_frequency"},
        "isolation": {"maximise": "isolation", "into": "ground", "at": "1500 rpm"},
    }
    return {
        "bodies": bodies,
        "links": links,
        "excitations": {
            "shaft": {
                "kind": "unbalance",
                "on": "machine",
                "unbalance": f"{rng.uniform(0.02, 0.3):.3g} kg m",
                "speed": "800..1500 rpm",
            }
        },
        "limits": {
            "floor": {"response": "transmitted_force", "into": "ground", "at_most": f"{rng.uniform(300, 6e3):.4g} N"},
            "run_up": {
                "response": "displacement",
                "of": "machine",
                "over": "start-up",
                "at_most": f"{rng.uniform(0.5, 5.0):.3g} mm",
            },
            "bounce": {"response": "natural_frequency", "at_most": f"{rng.uniform(4, 12):.3g} Hz"},
            "price": {"response": "price", "at_most": "700 EUR"},
        },
        "goal": goals[goal],
    }


def scene_of(folder: Path, seed: int, *, two: bool, goal: str, parts: int) -> Scene:
    """A random scene beside its catalogue."""
    rng = np.random.default_rng(seed)
    damper = DAMPINGS[seed % 3]
    shelf_of(folder, rng, parts, damper)
    document = document_of(rng, two=two, goal=goal)
    if "ratio" not in damper:
        for link in document["links"].values():
            link.pop("relative_to", None)
    return from_dict(placed(document, folder), name="random.toml")


def enumerated(program: Program) -> list[float]:
    """Goals of all choices that meet every limit, in the sense to be minimised, best first."""
    judge, choices = Judge(program), Choices(factors_of(program), len(program.axes))
    found = []
    for entries in product(*(range(len(one.table)) for one in choices.factors)):
        x = choices.designs(np.array([entries]))[0]
        if judge.feasible(x):
            found.append(judge.goal(x).value)
    return sorted(found)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("two", [False, True], ids=["one group", "two groups"])
@pytest.mark.parametrize("goal", ["price", "force", "frequency", "isolation"])
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10_000))
def test_the_best_are_those_of_full_enumeration(tmp_path: Path, goal: str, two: bool, seed: int) -> None:
    program = pose(scene_of(tmp_path, seed, two=two, goal=goal, parts=7 if two else 20))
    method = Catalogue()
    assert method.refuses(program) is None
    found = method.solve(program)
    wanted = enumerated(program)
    if not wanted:
        assert found.status == "infeasible"
        return
    assert found.status == "optimal"
    goals = [one["goal"] for one in found.details["picks"]]
    if found.details["mirrored"]:
        assert goals[0] == pytest.approx(wanted[0], rel=1e-12)
        assert all(any(abs(one - other) <= 1e-9 * abs(one) for other in wanted) for one in goals)
    else:
        assert goals == pytest.approx(wanted[: len(goals)], rel=1e-9)
        assert len(goals) == min(len(wanted), 10)


@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10_000), soft=st.sampled_from([{}, {"floor": 8.0}, {"run_up": 8.0}]))
def test_the_nearest_part_misses_least_by_the_weights_of_the_limits(
    tmp_path: Path, seed: int, soft: dict[str, float]
) -> None:
    """Every part as an analysis of its own; each bound is half of the least that any part has."""
    document = copy.deepcopy(dict(scene_of(tmp_path, seed, two=False, goal="price", parts=12).document))
    document["limits"] = {name: document["limits"][name] for name in ("floor", "run_up")}
    scene = from_dict(document, name="random.toml")
    choices = Choices(factors_of(pose(scene)), len(scene.variables))
    entries = product(*(range(len(one.table)) for one in choices.factors))
    every = [choices.designs(np.array([one]))[0] for one in entries]
    rows = [solve(frozen(scene, x), explain=False).limits for x in every]
    for name, unit in (("floor", "N"), ("run_up", "m")):
        document["limits"][name]["at_most"] = f"{0.5 * min(row[name].value.value for row in rows)!r} {unit}"
        document["limits"][name] |= {"soft": soft[name]} if name in soft else {}
    scene = from_dict(document, name="random.toml")
    found = Catalogue().solve(pose(scene))
    assert found.status == "infeasible"
    near = found.details["nearest"]

    def missed(x: Any) -> float:
        rows = solve(frozen(scene, x), explain=False).limits.values()
        return max(-row.margin / soft.get(row.name, 1.0) for row in rows)

    assert near["proven"]
    assert missed(near["x"]) == pytest.approx(min(map(missed, every)), rel=1e-7)


@pytest.mark.parametrize(
    "printed", [pytest.param(False, marks=pytest.mark.slow), True], ids=["one tolerance", "a column of them"]
)
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10_000), goal=st.sampled_from(["price", "force"]))
def test_over_tolerances_the_best_is_the_best_of_all_that_hold_one_by_one(
    tmp_path: Path, printed: bool, seed: int, goal: str
) -> None:
    """Every combination as an analysis of its own, with the tolerances of its parts."""
    scene = scene_of(tmp_path, seed, two=False, goal=goal, parts=5)
    document = copy.deepcopy(dict(scene.document))
    document["links"]["a"].pop("relative_to", None)
    rows = (tmp_path / "random.csv").read_text(encoding="utf-8").splitlines()
    rows = [one.replace("damping ratio", "loss factor") for one in rows]
    if printed:
        rng = np.random.default_rng(seed)
        rows = [rows[0] + ";tolerance [%]", *(f"{one};{rng.choice([0, 5, 10, 25])}" for one in rows[1:])]
    else:
        document["links"]["a"]["tolerance"] = "15 %"
    (tmp_path / "random.csv").write_text("\n".join(rows), encoding="utf-8")
    scene = from_dict(document, name="random.toml")
    design = solve(scene, explain=False)
    goals = []
    choices = Choices(factors_of(pose(scene)), len(scene.variables))
    for entries in product(*(range(len(one.table)) for one in choices.factors)):
        one = frozen(scene, choices.designs(np.array([entries]))[0])
        asked = copy.deepcopy(dict(one.document)) | {"measures": {"goal": {"response": "price"}}}
        if goal == "force":
            asked["measures"] = {"goal": {"response": "transmitted_force", "into": "ground"}}
        answer = solve(from_dict(asked))
        if answer.status == "met":
            goals.append(answer.measures["goal"].value.value)
    assert (design.x != ()) == bool(goals)
    if goals:
        assert design.goal is not None
        assert design.goal[1].value == pytest.approx(min(goals), rel=1e-7)
        assert [one["goal"] for one in design.details["picks"]] == pytest.approx(sorted(goals)[:10], rel=1e-6)


def test_two_groups_that_may_be_exchanged_are_looked_at_once(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    shelf_of(tmp_path, rng, 9, "loss factor")
    part = {"between": ["machine", "ground"], "part": {"catalogue": "random.csv"}, "count": 2}
    document = {
        "bodies": {"machine": {"mass": "700 kg"}},
        "links": {"a": part, "b": part},
        "goal": {"minimise": "price"},
    }
    program = pose(from_dict(placed(document, tmp_path), name="twins.toml"))
    found = Catalogue().solve(program)
    assert found.details["mirrored"] > 0
    single = enumerated(program)
    goals = [one["goal"] for one in found.details["picks"]]
    assert goals[0] == single[0]
    assert all(goal in single for goal in goals)


SHAKEN: dict[str, tuple[dict[str, Any], str]] = {
    "steady": ({"kind": "force", "on": "machine", "amplitude": "100 N", "speed": "300..900 rpm"}, "transmitted_force"),
    "random": ({"kind": "white_noise", "on": "machine", "density": "100 N²/Hz"}, "rms_force"),
    "transient": (
        {"kind": "pulse", "shape": "half sine", "duration": "20 ms", "on": "machine", "amplitude": "100 N"},
        "peak_force",
    ),
}


@pytest.mark.parametrize("sort", SHAKEN)
def test_which_of_two_alike_mounts_is_asked_for_does_not_matter(sort: str, tmp_path: Path) -> None:
    """They may be exchanged only where what is asked is the same then."""
    excitation, response = SHAKEN[sort]
    (tmp_path / "two.csv").write_text(
        "part,stiffness [N/mm],damping [N s/m],rated load max [N],price [EUR]\n"
        "soft,10,50,5000,10\nhard,40,200,5000,11\n",
        encoding="utf-8",
    )
    part = {"between": ["machine", "ground"], "part": {"catalogue": "two.csv"}}
    goals = []
    for mount in ("a", "b"):
        document = {
            "bodies": {"machine": {"mass": "100 kg"}},
            "links": {"a": part, "b": part},
            "excitations": {"load": excitation},
            "limits": {"stiff": {"response": "natural_frequency", "mode": 1, "at_least": "3.4 Hz"}},
            "goal": {"minimise": response, "through": mount},
        }
        program = pose(from_dict(placed(document, tmp_path), name="twins.toml"))
        found = Catalogue().solve(program)
        goals.append(found.details["picks"][0]["goal"])
        assert goals[-1] == pytest.approx(enumerated(program)[0], rel=1e-9)
    assert goals[0] == pytest.approx(goals[1], rel=1e-9)


@pytest.fixture(scope="module")
def compressor() -> Design:
    scene = read(MOUNTS / "compressor_on_bought_mounts.toml")
    return solve(with_changes(scene, {"links.feet.tolerance": "0 %", "limits.floor_force.at_most": "250 N"}))


def test_the_answer_names_what_to_order(compressor: Design) -> None:
    assert compressor.status == "optimal"
    assert compressor.places["links.feet.part"].value == "S60-60"
    text = compressor.report()
    assert "4 x S60-60 (feet)" in text
    assert "cannot carry the load" in text


def test_a_kept_design_holds_the_names_of_its_parts(compressor: Design) -> None:
    kept = frozen(compressor.scene, compressor.x)
    assert kept.is_analysis
    part = kept.document["links"]["feet"]["part"]
    assert (str(part["catalogue"]), part["name"]) == ("mounts.csv", "S60-60")
    again = solve(kept)
    assert again.status == "met"
    assert {name: one.value.value for name, one in again.limits.items()} == pytest.approx(
        {name: one.value.value for name, one in compressor.limits.items()}, rel=1e-12
    )
    heavier = whatif(compressor.scene, {"bodies.set.mass": "680 kg"}, keep_design=True)
    assert heavier.breaks == ("feet: rated load",)
    mass = next(one for one in heavier.thresholds if one.path == "bodies.set.mass")
    assert mass.above is not None
    assert mass.above.value == pytest.approx(4 * 1600.0 / 9.80665, rel=1e-6)
    assert mass.limits[1] == "feet: rated load"


def test_choices_and_parts_stand_in_the_json(compressor: Design) -> None:
    data = compressor.to_json()
    assert data["variables"]["links.feet.part"]["value"] == "S60-60"
    assert [one["parts"]["links.feet.part"] for one in data["choices"]] == ["S60-60", "S60-55", "S50-55"]
    assert data["choices"][0]["price"]["shown"] == "107.8 EUR"
    assert sum(one["combinations"] for one in data["details"]["dropped"]) == 300 - 3
    never = {one["part"]: one["limit"] for one in data["details"]["rows"]}
    assert never["R40-40"] == "feet: rated load"
    assert not {"S60-60", "S60-55", "S50-55"} & set(never)


def test_free_values_are_never_worse_than_what_is_bought() -> None:
    design = solve(read(MOUNTS / "chiller_on_two_stages.toml"))
    assert design.goal is not None
    assert design.details["free"]["goal"] < design.goal[1].value
    assert "made to order" in design.report()


def test_the_page_shows_what_to_order(compressor: Design) -> None:
    page = html(compressor)
    assert "4 x S60-60 (feet)" in page
    assert "The best 3 choices" in page


SPACE = """
[bodies.genset]
mass = "1850 kg"
motion = "space"
centre = ["0.10 m", "0.03 m", "0.45 m"]
inertia = ["310 kg m2", "620 kg m2", "590 kg m2"]

[mounts.front]
between = ["genset", "ground"]
at = [["0.9 m", "0.4 m", "0 m"], ["0.9 m", "-0.4 m", "0 m"]]
part = {part}

[mounts.rear]
between = ["genset", "ground"]
at = [["-0.8 m", "0.4 m", "0 m"], ["-0.8 m", "-0.4 m", "0 m"]]
part = {part}

[excitations.engine]
kind = "force"
on = "genset"
direction = "z"
amplitude = "2 kN"
speed = "600..1500 rpm"

[limits.sway]
response = "displacement"
of = "genset"
direction = "x"
at_most = "0.2 mm"

[limits.modes]
response = "natural_frequency"
mode = 6
at_most = "16 Hz"

[goal]
minimise = {goal}
"""
NAMES = ["R75-60", "R75-70", "S75-70", "R100-40", "R100-45", "S100-45", "R100-55", "R100-60", "R125-40"]


@pytest.mark.parametrize(
    "goal", ['"price"', '"transmitted_force"\ninto = "ground"\ndirection = "z"'], ids=["price", "force"]
)
def test_mounts_in_space_are_those_of_full_enumeration(tmp_path: Path, goal: str) -> None:
    (tmp_path / "mounts.csv").write_bytes((MOUNTS / "mounts.csv").read_bytes())
    part = f'{{ catalogue = "mounts.csv", only = {NAMES} }}'.replace("'", '"')
    (tmp_path / "genset.toml").write_text(SPACE.replace("{part}", part).replace("{goal}", goal), encoding="utf-8")
    scene = with_changes(
        read(tmp_path / "genset.toml"), {f"mounts.{one}.tolerance": "0 %" for one in ("front", "rear")}
    )
    wanted = enumerated(pose(scene))
    design = solve(scene)
    assert design.status == "optimal"
    assert [one["goal"] for one in design.details["picks"]] == pytest.approx(wanted[:10], rel=1e-9)
    kept = solve(frozen(scene, design.x))
    assert kept.status == "met"
    assert kept.scene.document["mounts"]["front"]["part"]["name"] == design.places["mounts.front.part"].value


def test_the_tolerances_that_a_catalogue_prints_count_unless_the_file_says_another() -> None:
    scene = read(MOUNTS / "compressor_on_bought_mounts.toml")
    printed = vo.solve(scene)
    assert printed.tolerances is not None
    assert printed.limits["floor_force"].off == {"links.feet.stiffness": pytest.approx(0.2)}
    none = vo.solve(with_changes(scene, {"links.feet.tolerance": "0 %"}))
    assert none.tolerances is None
    own = vo.solve(with_changes(scene, {"links.feet.tolerance": "5 %"}))
    assert own.tolerances is not None
    assert set(own.tolerances.uncertain.values()) == {0.05}


def test_where_no_parts_will_do_the_loosening_that_is_named_is_enough() -> None:
    scene = with_changes(read(MOUNTS / "compressor_on_bought_mounts.toml"), {"limits.floor_force.at_most": "200 N"})
    answer = solve(scene)
    assert answer.status == "infeasible"
    assert answer.conflict is not None
    ((name, now, enough),) = answer.conflict.loosenings
    assert (name, now.value) == ("floor_force", 200.0)
    loose = with_changes(scene, {"limits.floor_force.at_most": f"{enough.value!r} N"})
    assert solve(loose, explain=False).status == "optimal"
    tight = with_changes(scene, {"limits.floor_force.at_most": f"{0.99 * enough.value!r} N"})
    assert solve(tight, explain=False).status == "infeasible"


def test_parts_without_a_least_rating_beside_parts_with_one_are_asked_the_right_limits(tmp_path: Path) -> None:
    """A row without a least load has one limit fewer; what is learnt from it belongs to the others all the same."""
    rows = [
        "part,rated load min [N],rated load max [N],stiffness [N/mm],shear stiffness [N/mm],loss factor,price [EUR]"
    ]
    rows += [
        "A,,2600,300,150,0.1,9",
        "B,400,3100,400,200,0.1,11",
        "C,,4000,800,400,0.1,14",
        "D,900,6000,900,500,0.1,20",
    ]
    (tmp_path / "few.csv").write_text("\n".join(rows), encoding="utf-8")
    part = {"between": ["m", "ground"], "part": {"catalogue": "few.csv"}, "tolerance": "10 %"}
    document: dict[str, Any] = {
        "bodies": {
            "m": {
                "mass": "900 kg",
                "centre": ["0.05 m", "0 m", "0.4 m"],
                "centre_tolerance": ["40 mm", "20 mm", "0 m"],
                "inertia": ["76 kg m2", "128 kg m2", "127 kg m2"],
            }
        },
        "mounts": {
            name: {**part, "at": [[f"{x} m", "0.35 m", "0 m"], [f"{x} m", "-0.35 m", "0 m"]]}
            for name, x in (("a", 0.6), ("b", -0.6))
        },
        "limits": {"tilt": {"response": "tilt", "of": "m", "axis": "y", "at_most": "0.006 rad"}},
        "goal": {"minimise": "price"},
    }
    scene = from_dict(placed(document, tmp_path), name="few.toml")
    design = solve(scene, explain=False)
    goals = {}
    for a, b in product("ABCD", repeat=2):
        fixed = copy.deepcopy(dict(scene.document)) | {"measures": {"price": {"response": "price"}}}
        del fixed["goal"]
        for name, one in (("a", a), ("b", b)):
            fixed["mounts"][name]["part"]["name"] = one
        answer = solve(from_dict(fixed))
        if answer.status == "met":
            goals[a, b] = answer.measures["price"].value.value
    assert design.status == "optimal"
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(min(goals.values()), rel=1e-12)
