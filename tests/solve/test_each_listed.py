"""Listed values beside many continuous variables: each of them is solved, and the best of all is the answer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.cli.main import main
from vibopt.forms.bounds import FormBounds
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.solve.global_search import BranchAndBound

MASSES = {"80 kg": 80.0, "100 kg": 100.0, "125 kg": 125.0}
SPEED = 157.07963267948966
FORCE = 0.02 * SPEED**2
"""Of an unbalance of 0.02 kg m at 1500 rpm [N]."""


def _press(mass: Any, floor: str = "80 N") -> Scene:
    """A machine on four springs that may be chosen each by itself."""
    names = ("a", "b", "c", "d")
    spring = {"between": ["m", "ground"], "stiffness": {"from": "5 kN/m", "to": "500 kN/m"}}
    return from_dict(
        {
            "bodies": {"m": {"mass": mass}},
            "links": {name: dict(spring) for name in names},
            "excitations": {"e": {"kind": "unbalance", "on": "m", "unbalance": "0.02 kg m", "speed": "1500 rpm"}},
            "limits": {"floor": {"response": "transmitted_force", "into": "ground", "at_most": floor}},
            "goal": {"maximise": "stiffness", "of": "a"},
        }
    )


def _stiffest(mass: float, floor: float) -> float:
    """The stiffest spring beside the three softest with which F k / (m w^2 - k) is no more than the floor may get."""
    return floor * mass * SPEED**2 / (FORCE + floor) - 15e3


def test_the_answer_is_the_best_of_the_answers_with_each_listed_value() -> None:
    design = solve(_press({"one_of": list(MASSES)}))
    assert design.method == "each_listed"
    assert design.claim.endswith(" boxes of all variables: nothing is better by more than 1e-06 of the goal")
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(_stiffest(125.0, 80.0), rel=1e-6)
    assert design.x[0] == 125.0
    alone = solve(_press("100 kg"), explain=False)
    assert alone.goal is not None
    assert alone.goal[1].value == pytest.approx(_stiffest(100.0, 80.0), rel=1e-6)


def test_where_no_listed_value_will_do_nothing_is_claimed_possible() -> None:
    design = solve(_press({"one_of": list(MASSES)}, "0.5 N"), explain=False)
    assert design.status in ("infeasible", "unproven")
    assert design.x == ()


def test_one_listed_variable_with_a_mean_square_is_decided() -> None:
    """Poles and mean squares have no bounds on boxes; a list of values is measured one by one."""
    document: dict[str, Any] = {
        "bodies": {"m": {"mass": "100 kg"}},
        "links": {
            "s": {
                "between": ["m", "ground"],
                "stiffness": {"one_of": ["10 kN/m", "40 kN/m", "90 kN/m"]},
                "damping": "90 N s/m",
            }
        },
        "excitations": {"w": {"kind": "white_noise", "on": "m", "density": "100 N²/Hz"}},
        "limits": {"sway": {"response": "rms_displacement", "of": "m", "at_most": "1 mm"}},
        "goal": {"minimise": "stiffness", "of": "s"},
    }
    design = solve(from_dict(document))
    # mean square S / (4 c k), S one-sided per hertz
    fine = [k for k in (10e3, 40e3, 90e3) if (100.0 / (4.0 * 90.0 * k)) ** 0.5 <= 1e-3]
    assert design.status == ("optimal" if fine else "infeasible")
    assert not fine or design.x == (pytest.approx(min(fine)),)
    loose = solve(with_changes(from_dict(document), {"limits.sway.at_most": "2.7 mm"}))
    assert (loose.status, loose.x) == ("optimal", (pytest.approx(40e3),))


@pytest.mark.parametrize("sense", ["minimise", "maximise"])
def test_listed_values_of_which_bounds_say_nothing_are_measured_one_by_one(
    sense: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a structure whose mean square has no bounds: each of four was halved without end, and none proven."""
    monkeypatch.setattr(FormBounds, "on", lambda _, low, high: (np.zeros(len(low)), np.full(len(high), np.inf)))
    listed = [1e4 * 1.3**k for k in range(30)]
    spring = {"between": ["m", "ground"], "stiffness": {"one_of": [f"{k!r} N/m" for k in listed]}}
    document = dict(_press("100 kg").document) | {"links": {"mount": spring}, "limits": {}}
    document["goal"] = {sense: "transmitted_force", "into": "ground"}
    found = BranchAndBound().solve(pose(from_dict(document)))
    forces = [FORCE * k / abs(k - 100.0 * SPEED**2) for k in listed]
    assert found.status == "optimal"
    assert found.details["boxes"] <= 2 * (2 * len(listed) - 1)  # each list and each value, for two gaps
    assert found.details["goal"] == pytest.approx({"minimise": min, "maximise": max}[sense](forces), rel=1e-9)


def test_an_answer_over_listed_values_is_printed_reported_and_saved(tmp_path: Path) -> None:
    file = tmp_path / "tank.toml"
    file.write_text(
        'title = "Tank"\n[bodies.t]\nmass = { one_of = ["100 kg", "140 kg"] }\n[links.l]\nbetween = ["t", "ground"]\n'
        'stiffness = { from = "10 kN/m", to = "1 MN/m" }\ndamping = { from = "10 N s/m", to = "9 kN s/m" }\n'
        '[bodies.r]\nmass = "9 kg"\n[links.s]\nbetween = ["r", "t"]\nstiffness = "9 kN/m"\ndamping = "40 N s/m"\n'
        '[excitations.e]\nkind = "force"\non = "t"\namplitude = "100 N"\nspeed = "10 Hz"\nvaries = "constant"\n'
        '[limits.x]\nresponse = "damping_ratio"\nmode = 2\nat_least = "9 %"\n[goal]\nminimise = "total_mass"\n',
        encoding="utf-8",
    )
    assert main(["solve", str(file)]) == 0
    assert main(["report", str(file), "-o", str(tmp_path / "page.html")]) == 0
    assert main(["solve", str(file), "--save", str(tmp_path / "design.toml")]) == 0
    found = vo.solve(vo.read(file))
    assert (found.status, found.method) == ("optimal", "each_listed")
    assert "the listed values alone decide the goal" in found.claim
