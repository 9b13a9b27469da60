"""Where no design meets every limit, the one that misses least, and what each limit could be alone, are what they say.

The second route is a dense grid of formulas for one mass, and every choice of a list by itself.
"""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import faults

from refusals import refused
from vibopt.answer.answer_page import html
from vibopt.arrays import FloatArray
from vibopt.cli.main import main
from vibopt.manual.schema import schema_of_answers
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.study.nearest import with_nearest

MASS, FORCE, TOP = 300.0, 30e3, 3000.0 * 2.0 * pi / 60.0
STIFFNESS, DAMPING = np.geomspace(1e4, 1e9, 401), np.geomspace(10.0, 1e6, 301)


def press(floor: float, start_up: float, **more: Any) -> dict[str, Any]:
    """A press of which the floor and the run-up ask for contrary things."""
    return {
        "title": "Press",
        "bodies": {"press": {"mass": "300 kg"}},
        "links": {
            "mount": {
                "between": ["press", "ground"],
                "stiffness": {"from": "10 kN/m", "to": "1 GN/m"}, "damping": {"from": "10 N s/m", "to": "1 MN s/m"},
            }
        },
        "excitations": {
            "punch": {"kind": "force", "on": "press", "amplitude": "30 kN", "speed": "3000 rpm", "varies": "constant"}
        },
        "limits": {
            "floor": {"response": "transmitted_force", "into": "ground", "at_most": f"{floor!r} N"},
            "run_up": {"response": "displacement", "of": "press", "over": "start-up", "at_most": f"{start_up!r} m"},
        },
        "goal": {"maximise": "stiffness", "of": "mount"},
        **more,
    }  # fmt: skip


def values(k: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Force into the floor at the top speed, and the greatest displacement up to it."""
    spring = k + 1j * TOP * c
    floor = FORCE * np.abs(spring / (spring - MASS * TOP**2))
    peak = np.sqrt(np.maximum(k / MASS - c**2 / (2.0 * MASS**2), 0.0)).clip(max=TOP)
    there = np.maximum.reduce([FORCE / np.abs(k + 1j * w * c - MASS * w**2) for w in (0.0 * k, peak, TOP + 0.0 * k)])
    return floor, there


def answered(document: dict[str, Any], **more: Any) -> Design:
    return with_nearest(solve(from_dict(document, name="press.toml"), **more), thorough=True)


@settings(max_examples=8)
@given(st.floats(2e3, 8.5e3), st.floats(1e-3, 11e-3))
def test_no_design_of_a_dense_grid_comes_nearer(floor: float, start_up: float) -> None:
    design = answered(press(floor, start_up), explain=False)
    assert design.status == "infeasible"
    near = design.nearest
    assert near is not None
    rows = near.limits
    worst = max(rows["floor"].value.value / floor, rows["run_up"].value.value / start_up)
    k, c = np.meshgrid(STIFFNESS, DAMPING, indexing="ij")
    forces, motions = values(k, c)
    best = float(np.maximum(forces / floor, motions / start_up).min())
    assert 1.0 < worst <= best * (1.0 + 1e-9)
    assert worst >= 0.97 * best  # the grid is a few percent wide
    mine = values(np.array([near.x[0]]), np.array([near.x[1]]))
    assert [rows["floor"].value.value, rows["run_up"].value.value] == pytest.approx([float(one[0]) for one in mine])
    for name, table in (("floor", forces), ("run_up", motions)):
        least = near.least[name]
        assert least.proven
        assert 0.97 * table.min() <= least.value.value <= table.min() * (1.0 + 1e-9)


def test_what_is_shown_of_it_is_what_an_analysis_of_it_says() -> None:
    design = answered(press(5e3, 5e-3), explain=False)
    assert design.nearest is not None
    kept = solve(frozen(design.scene, design.nearest.x, with_goal=False), explain=False)
    assert kept.status == "violated"
    for name, row in kept.limits.items():
        assert row.value.value == pytest.approx(design.nearest.limits[name].value.value, rel=1e-9)
        assert row.margin == pytest.approx(design.nearest.limits[name].margin, rel=1e-7)


def test_of_parts_with_tolerances_the_nearest_is_told(tmp_path: Path) -> None:
    """It ended in a traceback: what a catalogue has looked at has deviations behind the variables."""
    (tmp_path / "mounts.csv").write_text(
        "name,stiffness [N/mm],loss_factor,rated load max [N],price [EUR],tolerance [%]\n"
        "soft,150,0.1,9000,9,20\nhard,400,0.1,9000,10,10\n",
        encoding="utf-8",
    )
    document = press(5e3, 5e-3)
    document["links"]["mount"] = {"between": ["press", "ground"], "part": {"catalogue": str(tmp_path / "mounts.csv")}}
    document["limits"] = {"sag": {"response": "static_deflection", "of": "press", "at_most": "7.5 mm"}}
    document["goal"] = {"minimise": "price"}
    design = answered(document, explain=False)
    assert (design.status, design.method) == ("infeasible", "catalogue")
    assert design.nearest is not None
    sag = design.nearest.limits["sag"].value.value
    assert sag == pytest.approx(300.0 * 9.80665 / (0.9 * 400e3), rel=1e-9)  # the hard one, 10 % softer


def test_of_listed_values_none_comes_nearer() -> None:
    document = press(4e3, 6e-3)
    stiffness, damping = [3e5, 8e5, 2e6, 5e6, 1e7], [4e3, 9e3, 2e4, 4e4]
    document["links"]["mount"]["stiffness"] = {"one_of": [f"{one!r} N/m" for one in stiffness]}
    document["links"]["mount"]["damping"] = {"one_of": [f"{one!r} N s/m" for one in damping]}
    design = answered(document, explain=False)
    assert design.status == "infeasible"
    assert design.nearest is not None
    missed = {}
    for k, c in product(stiffness, damping):
        forces, motions = values(np.array([k]), np.array([c]))
        missed[k, c] = max(float(forces[0]) / 4e3, float(motions[0]) / 6e-3)
    assert design.nearest.x == min(missed, key=missed.__getitem__)


def test_a_false_proof_is_found_out() -> None:
    """The nearest design is a second route to the claim that there is none."""
    scene = from_dict(press(15e3, 30e-3), name="press.toml")
    right = solve(scene, explain=False)
    assert right.status == "optimal"
    false = replace(right, status="infeasible", claim="proven", goal=None, variables={}, x=(), limits={})
    found = with_nearest(false)
    assert found.status == "check_failed"
    assert "one meets every limit on the built machine" in found.claim


def test_other_answers_stay_as_they_are() -> None:
    right = solve(from_dict(press(15e3, 30e-3), name="press.toml"), explain=False)
    assert with_nearest(right) is right


def test_over_tolerances_it_misses_less_than_the_one_without() -> None:
    document = press(5e3, 5e-3)
    document["links"]["mount"]["tolerance"] = "20 %"
    design = answered(document, explain=False)
    plain = answered(press(5e3, 5e-3), explain=False)
    assert design.nearest is not None
    assert plain.nearest is not None
    worst = max(-one.margin for one in design.nearest.limits.values())
    kept = frozen(design.scene, plain.nearest.x, with_goal=False)
    other = max(-one.margin for one in solve(kept, explain=False).limits.values())
    assert worst <= other * (1.0 + 1e-6)


def test_the_reader_sees_one_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    design = answered(press(8e3, 10e-3))
    for said in (design.report(), " ".join(html(design).split())):
        words = " ".join(said.split())
        for part in (
            "The nearest design",
            "spring of 4234 kN/m, damping 22622 N s/m",
            "17.7 %",
            "Best alone",
            "proven",
        ):
            assert part in words
    data = json.loads(json.dumps(design.to_json(), allow_nan=False))
    schema = schema_of_answers()
    assert list(faults(data, schema, schema)) == []
    assert data["nearest"]["limits"]["floor"]["met"] is False
    assert data["nearest"]["least"]["run_up"]["proven"] is True
    file = tmp_path / "press.toml"
    from vibopt.document.toml_writing import document_toml

    file.write_text(document_toml(press(8e3, 10e-3)), encoding="utf-8")
    assert main(["solve", str(file)]) == 3
    assert "The nearest design" in capsys.readouterr().out
    assert main(["solve", str(file), "--no-prices"]) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "The nearest design was not looked for, nor what each limit could be alone: leave --no-prices out." in said
    assert main(["report", str(file), "--sheet", "-o", str(tmp_path / "press.html")]) == 3
    page = (tmp_path / "press.html").read_text(encoding="utf-8")
    assert "Shown is the nearest design: it misses no limit by more than 17.7 %." in page
    assert "Alone, without the other limits, at best: floor " in page
    assert "NOT FOR SIGNATURE" in page


@pytest.mark.parametrize(
    ("start_up", "floor"), [pytest.param("0.1 mm", "100 N", marks=pytest.mark.slow), ("0.09 mm", "150 N")]
)
def test_what_misses_least_misses_nothing_else_for_nothing(start_up: str, floor: str) -> None:
    """An amplitude at start-up that hangs on the damping ratio alone leaves the stiffness to the force."""
    scene = from_dict(
        {
            "bodies": {"compressor": {"mass": "450 kg"}},
            "links": {
                "mount": {
                    "between": ["compressor", "ground"],
                    "stiffness": {"from": "10 kN/m", "to": "5 MN/m"},
                    "damping_ratio": {"from": 0.01, "to": 0.5},
                    "count": 4,
                }
            },
            "excitations": {
                "crank": {"kind": "unbalance", "on": "compressor", "unbalance": "0.05 kg m", "speed": "1500 rpm"}
            },
            "limits": {
                "floor": {"response": "transmitted_force", "into": "ground", "at_most": floor},
                "start": {"response": "displacement", "of": "compressor", "over": "start-up", "at_most": start_up},
            },
            "goal": {"maximise": "stiffness", "of": "mount"},
        }
    )
    near = with_nearest(solve(scene, explain=False)).nearest
    assert near is not None
    assert near.limits["floor"].met
    missed = 0.05 / 450.0 / (2.0 * 0.5 * np.sqrt(1.0 - 0.5**2))  # greatest over all speeds, at a damping ratio of 0.5
    assert near.limits["start"].value.value == pytest.approx(missed, rel=1e-6)


@settings(max_examples=8)
@given(st.floats(2e3, 8.5e3), st.floats(1e-3, 11e-3), st.sampled_from([(1.0, 2.0), (3.0, 1.0), (0.5, 4.0)]))
def test_soft_limits_are_missed_by_their_share(floor: float, start_up: float, soft: tuple[float, float]) -> None:
    """Of a dense grid no design misses less, each part beyond its bound divided by the weight."""
    document = press(floor, start_up)
    for name, one in zip(("floor", "run_up"), soft, strict=True):
        document["limits"][name]["soft"] = one
    design = answered(document, explain=False)
    assert design.status == "infeasible"
    assert design.nearest is not None
    bounds = {"floor": floor, "run_up": start_up}
    rows = design.nearest.limits
    mine = max((rows[name].value.value / bounds[name] - 1.0) / one for name, one in zip(bounds, soft, strict=True))
    forces, motions = values(*np.meshgrid(STIFFNESS, DAMPING, indexing="ij"))
    best = float(np.maximum((forces / floor - 1.0) / soft[0], (motions / start_up - 1.0) / soft[1]).min())
    assert 0.0 < mine <= best * (1.0 + 1e-6)
    assert mine >= 0.9 * best  # the grid is a few percent wide
    wider = press(rows["floor"].value.value * (1.0 + 1e-9), rows["run_up"].value.value * (1.0 + 1e-9))
    assert solve(from_dict(wider, name="press.toml"), explain=False).status == "optimal"


@settings(max_examples=6)
@given(
    st.floats(4e3, 8.5e3), st.floats(5e6, 2e7), st.sampled_from([(1.0, 0.5), (3.0, 1.0), (1.0, 1.0), (0.5, 4.0)])
)  # fmt: skip
def test_what_is_missed_is_counted_in_parts_of_the_bound_on_either_side(
    floor: float, stiff: float, soft: tuple[float, float]
) -> None:
    """Of a dense grid no design misses less of a limit from above and of one from below, each by its weight."""
    document = press(floor, 1.0)
    document["limits"]["run_up"] = {"response": "stiffness", "of": "mount", "at_least": f"{stiff!r} N/m"}
    for name, one in zip(("floor", "run_up"), soft, strict=True):
        document["limits"][name]["soft"] = one
    design = answered(document, explain=False)
    k, c = np.meshgrid(np.geomspace(1e5, 1e8, 1601), np.geomspace(10.0, 1e4, 61), indexing="ij")
    best = float(np.maximum((values(k, c)[0] / floor - 1.0) / soft[0], (1.0 - k / stiff) / soft[1]).min())
    if design.status == "optimal":
        assert best <= 0.01
        return
    assert design.status == "infeasible"
    assert design.nearest is not None
    rows = design.nearest.limits
    mine = max(-rows[name].margin / one for name, one in zip(("floor", "run_up"), soft, strict=True))
    assert 0.0 < mine <= best * (1.0 + 1e-6)
    assert mine >= best - 0.02  # the grid is half a percent wide


def test_the_softest_loosening_is_proposed_and_a_design_is_not_touched() -> None:
    plain, soft = press(8e3, 8e-3), press(8e3, 8e-3)
    soft["limits"]["run_up"]["soft"] = 2
    hard, easy = (answered(one) for one in (plain, soft))
    assert hard.conflict is not None
    assert easy.conflict is not None
    assert [one.conflict.least[0] for one in (hard, easy) if one.conflict and one.conflict.least] == ["floor", "run_up"]
    assert hard.conflict.loosenings == easy.conflict.loosenings
    assert easy.nearest is not None
    assert easy.nearest.together == (
        "With wider limits all could hold: floor by 21 %, run_up by 42 % (soft: run_up 2).",
    )
    assert "--set limits.run_up.at_most=" in easy.report()
    schema = schema_of_answers()
    assert list(faults(json.loads(json.dumps(easy.to_json())), schema, schema)) == []
    plain, soft = press(15e3, 30e-3), press(15e3, 30e-3)
    soft["limits"]["run_up"]["soft"] = 2
    assert answered(plain).x == answered(soft).x


@pytest.mark.parametrize(
    ("family", "given", "words"),
    [
        *(
            ("limits", given, f"limits.run_up.soft = {shown} is no weight of a limit. Write a number from 0.001 to "
             "1000: with soft = 2 a loosening by 20 % counts as one by 10 %.")
            for given, shown in ((0, "0"), (-1.0, "-1.0"), ("2", '"2"'), (1e9, "1000000000.0"))
        ),
        ("measures", 2, "measures.run_up has soft, but no bound to loosen: soft weighs the loosening of a limit. "
         "Remove soft."),
        ("goal", 2, "goal has soft, but no bound to loosen: soft weighs the loosening of a limit. Remove soft."),
    ],
)  # fmt: skip
def test_a_weight_that_is_none_is_refused(family: str, given: Any, words: str) -> None:
    document = press(15e3, 30e-3)
    table = {"response": "displacement", "of": "press", "over": "start-up", "soft": given}
    if family == "goal":
        document["goal"] |= {"soft": given}
    else:
        document[family] = {"run_up": table | ({"at_most": "20 mm"} if family == "limits" else {})}
    assert refused(from_dict, document, name="press.toml").messages == (f"press.toml: {words}",)


def test_what_has_no_end_at_standstill_is_told_so_of_a_limit_alone() -> None:
    """A floor that moves at a constant rate goes ever farther as it slows down: no design helps, by itself or not."""
    document = press(15e3, 30e-3)
    document["excitations"] = {
        "street": {
            "kind": "base_motion",
            "on": "floor",
            "velocity": "1 mm/s",
            "speed": "3000 rpm",
            "varies": "constant",
        }
    }
    document["bases"] = {"floor": {}}
    document["links"]["mount"]["between"] = ["press", "floor"]
    document["bodies"]["table"] = {"mass": "40 kg"}
    document["links"]["top"] = {"between": ["table", "press"], "stiffness": "1 MN/m", "damping": "400 N s/m"}
    document["limits"] = {"far": document["limits"]["run_up"]}
    design = answered(document)
    assert design.status == "infeasible"
    assert design.nearest is not None
    alone = design.nearest.least["far"]
    assert (alone.value.value, alone.proven, alone.enough) == (np.inf, True, False)
