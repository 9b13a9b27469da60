"""Every number of an answer has two routes, and an answer whose routes do not agree is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from vibopt.cli.main import main
from vibopt.devices.link import LinkTable
from vibopt.devices.symbols import Symbols
from vibopt.document.toml_writing import document_toml
from vibopt.errors import RoutesDiffer
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.lone import LoneMachine
from vibopt.scene.read import from_dict
from vibopt.solve import solve
from vibopt.study.nearest import with_nearest
from vibopt.study.window import window
from vibopt.verify.checked import Built


def pump(**asked: Any) -> dict[str, Any]:
    return {
        "title": "pump",
        "bodies": {"pump": {"mass": "120 kg"}},
        "links": {"mount": {"between": ["pump", "ground"], "stiffness": "200 kN/m", "damping": "1 kN s/m"}},
        "excitations": {
            "rotor": {
                "kind": "force",
                "on": "pump",
                "amplitude": "300 N",
                "speed": "5..30 Hz",
                "varies": "constant",
            }
        },
        **asked,
    }


MEASURES = {
    "motion": {"response": "displacement", "of": "pump"},
    "force": {"response": "transmitted_force", "into": "ground"},
    "sag": {"response": "static_deflection", "of": "pump"},
    "mode": {"response": "natural_frequency"},
    "decay": {"response": "decay_rate"},
}


def without_damper(monkeypatch: pytest.MonkeyPatch) -> None:
    """Links whose damper only the machine as built has."""
    add_to = LinkTable.add_to

    def half(self: LinkTable, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        add_to(self.model_copy(update={"damping": None}), builder, name, symbols)

    monkeypatch.setattr(LinkTable, "add_to", half)


def test_a_damper_that_only_one_route_has_is_caught_in_an_analysis(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = from_dict(pump(measures=MEASURES))
    assert solve(scene).status == "met"
    without_damper(monkeypatch)
    design = solve(scene)
    assert design.status == "check_failed"
    assert design.claim == (
        "the two routes to an answer do not agree: motion (displacement of pump) is 0.072 m in the model, "
        "0.00738704 m on the machine as built, at 6.429 Hz of rotor; force (transmitted_force into ground) is "
        "14994 N in the model, 1507.26 N on the machine as built, at 6.432 Hz of rotor; decay (decay_rate) is 0 "
        "1/s in the model, 4.16667 1/s on the machine as built"
    )
    assert design.exit_code == 6


def test_a_spring_that_one_route_counts_twice_is_caught_in_what_is_static(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = from_dict(pump(measures=MEASURES))
    sag = LoneMachine.sag
    monkeypatch.setattr(LoneMachine, "sag", lambda self: {name: 0.5 * down for name, down in (sag(self) or {}).items()})
    design = solve(scene)
    assert design.status == "check_failed"
    assert design.claim.endswith(
        "agree: sag (static_deflection of pump) is 0.00588399 m in the model, 0.002942 m on the machine as built"
    )


def test_a_goal_of_two_values_is_no_goal(monkeypatch: pytest.MonkeyPatch) -> None:
    document = pump(goal={"minimise": "displacement", "of": "pump"})
    document["links"]["mount"]["stiffness"] = {"from": "100 kN/m", "to": "300 kN/m"}
    assert solve(from_dict(document)).status == "optimal"
    without_damper(monkeypatch)
    design = solve(from_dict(document))
    assert design.status == "check_failed"
    assert design.claim.startswith("the two routes to an answer do not agree: displacement (displacement of pump) is ")


def held(most: str) -> dict[str, Any]:
    """Some stiffness keeps what is asked with its damper, none without."""
    limits = {"still": {"response": "displacement", "of": "pump", "at_most": most}}
    document = pump(limits=limits, goal={"minimise": "stiffness", "of": "mount"})
    document["links"]["mount"]["stiffness"] = {"from": "100 kN/m", "to": "300 kN/m"}
    return document


def test_no_window_is_told_of_a_model_from_which_the_machine_as_built_differs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Neither ends nor, where the model has no permitted design, that there is none."""
    file = tmp_path / "pump.toml"
    file.write_text(document_toml(held("9 mm")), encoding="utf-8")
    assert main(["window", str(file)]) == 0
    without_damper(monkeypatch)
    for most in ("9 mm", "1 m"):
        with pytest.raises(RoutesDiffer) as caught:
            window(from_dict(held(most)))
        assert str(caught.value).startswith(
            "scene: no window is told: the two routes to an answer do not agree: still (displacement of pump) is "
        )
    capsys.readouterr()
    assert main(["window", str(file), "--json"]) == 6
    assert json.loads(capsys.readouterr().out)["status"] == "check_failed"


def test_that_there_is_no_design_is_not_told_of_a_model_that_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    """The nearest design is measured on the machine as built, and breaks the limit there, too."""
    document = held("5 mm")
    assert with_nearest(solve(from_dict(document), explain=False)).status == "infeasible"
    without_damper(monkeypatch)
    design = with_nearest(solve(from_dict(document), explain=False))
    assert design.status == "check_failed"
    assert design.claim.startswith("the two routes to an answer do not agree: still (displacement of pump) is ")


def test_the_worst_machine_within_tolerances_is_compared_too(monkeypatch: pytest.MonkeyPatch) -> None:
    document = pump(limits={"still": {"response": "displacement", "of": "pump", "at_most": "9 mm"}})
    document["links"]["mount"]["damping"] = {"value": "1 kN s/m", "tolerance": "10 %"}
    assert solve(from_dict(document)).status == "met"
    without_damper(monkeypatch)
    assert solve(from_dict(document)).status == "check_failed"


@pytest.mark.parametrize("damping", ["0 N s/m", "1e-9 N s/m", "1e-3 N s/m"])
def test_routes_to_a_sharp_resonance_agree_within_their_rounding(damping: str) -> None:
    document = pump(measures=MEASURES)
    document["links"]["mount"]["damping"] = damping
    assert solve(from_dict(document)).status == "met"


@pytest.mark.parametrize("soft", ["1 N/m", "1e-3 N/m"])
def test_routes_through_very_different_springs_agree_within_their_rounding(soft: str) -> None:
    document = pump(measures=MEASURES)
    document["bodies"]["frame"] = {"mass": "3000 kg"}
    document["links"]["mount"]["between"] = ["pump", "frame"]
    document["links"]["soft"] = {"between": ["frame", "ground"], "stiffness": soft}
    assert solve(from_dict(document)).status == "met"


def test_the_load_of_a_bought_mount_is_compared_with_the_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "parts.csv").write_text("part,stiffness [N/mm],loss factor,rated load max [N]\nM1,100,0.1,1600\n")
    document = pump(measures={"mode": {"response": "natural_frequency"}})
    part = {"catalogue": str(tmp_path / "parts.csv"), "name": "M1"}
    document["links"]["mount"] = {"between": ["pump", "ground"], "count": 2, "part": part}
    scene = from_dict(document)
    assert solve(scene).status == "met"
    monkeypatch.setattr("vibopt.verify.rated.load_of", lambda machine, joint: 300.0)
    assert solve(scene).claim == (
        "the two routes to an answer do not agree: mount: rated load (static_load of mount) is 588.399 N in the model, "
        "300 N on the machine as built"
    )


def test_an_isolation_of_next_to_nothing_is_known_to_rounding_of_what_comes_through() -> None:
    """Just above the root of two times the natural frequency, where all but 1e-11 of the force comes through."""
    asked = {"limits": {"isolated": {"response": "isolation", "into": "ground", "at_least": "1e-9 %"}}}
    document = pump(**asked, goal={"maximise": "stiffness", "of": "mount"})
    document["links"]["mount"] = {"between": ["pump", "ground"], "stiffness": {"from": "1 kN/m", "to": "100 MN/m"}}
    document["bodies"]["pump"]["mass"] = "100 kg"
    document["excitations"]["rotor"]["speed"] = "600 rpm"
    design = solve(from_dict(document))
    assert design.status == "optimal", design.claim
    assert design.goal[1].value == pytest.approx(50.0 * (20.0 * 3.141592653589793) ** 2, rel=1e-9)


def test_a_resonance_beside_does_not_reach_what_it_does_not_move() -> None:
    """An undamped machine that is shaken at its resonance, and another on the same floor, which that leaves at rest."""
    document = {
        "bases": {"floor": {}},
        "bodies": {"frame": {"mass": "5657.3 kg"}, "fan": {"mass": "12472 lb"}},
        "links": {
            "mount": {
                "between": ["frame", "floor"],
                "stiffness": {"from": "216.2 kN/m", "to": "194.58 MN/m"}, "damping": "11444 N s/m",
            },
            "feet": {"between": ["fan", "floor"], "stiffness": "727.42 N/mm"},
        },
        "excitations": {
            "fan": {"kind": "unbalance", "on": "fan", "speed": "44..119 rpm", "unbalance": "598090 g mm"},
            "street": {"kind": "base_motion", "on": "floor", "speed": "180 rpm", "displacement": "0.1 mm"},
        },
        "limits": {
            "gap": {"response": "relative_displacement", "across": "mount", "combine": "rss", "at_most": "0.3 mm"}
        },
        "goal": {"minimise": "transmitted_force", "through": "mount", "due_to": ["street"]},
    }  # fmt: skip
    design = solve(from_dict(document))
    assert design.status == "optimal", design.claim
    w, mass, damper, stiff = 6.0 * 3.141592653589793, 5657.3, 11444.0, float(design.x[0])
    gap = 1e-4 * mass * w**2 / abs(stiff - mass * w**2 + 1j * damper * w)
    assert design.limits["gap"].value.value == pytest.approx(gap, rel=1e-9)
    own = {"response": "displacement", "of": "fan", "due_to": ["fan"], "at_most": "1 m"}
    document["limits"] = {"swing": own}
    assert solve(from_dict(document)).status == "infeasible"  # what it does move has no end


@pytest.mark.parametrize(("short", "off", "met"), [(0.0, 5e-9, True), (2e-9, 5e-9, False), (0.0, 5e-7, False)])
def test_a_limit_that_one_route_keeps_is_kept_by_both_where_they_agree(short: float, off: float, met: bool) -> None:
    """Friction is followed to 1e-7: a limit at which a search ends lies within that, and is no broken one."""
    document: dict[str, Any] = pump(measures={"motion": MEASURES["motion"]})
    document["links"]["mount"]["friction_force"] = "150 N"
    document["excitations"]["rotor"]["speed"] = "9 Hz"
    kept = solve(from_dict(document)).measures["motion"].value.value
    document["limits"] = {"motion": {**document.pop("measures")["motion"], "at_most": f"{kept * (1.0 - short)!r} m"}}
    scene = from_dict(document)
    built = Built(scene, {})
    response = scene.limits["motion"]
    row, measured = built.row("motion", response, "at_most")
    row = replace(row, margin=row.margin - off)
    assert not row.met
    assert built.compared(row, replace(measured, value=measured.value * (1.0 + off))).met is met
