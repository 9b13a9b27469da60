"""Listed values beside ranges, against every combination of them measured by equations of its own."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.solve.global_search import BranchAndBound
from vibopt.solve.relaxed import _Relaxed
from vibopt.solve.round_and_exchange import RoundAndExchange

MASSES = (120.0, 80.0)
SPEEDS = 2.0 * np.pi * np.array([4.0, 11.0])
FORCE = 100.0
Lists = dict[str, list[float]]


def _lists(seed: int, many: int) -> Lists:
    """Values of the springs below and between, the damper below, and an absorber's spring and damper, in order."""
    draw, size = np.random.default_rng(seed), many ** np.ones(5, dtype=int)
    middle = (120e3, 90e3, 400.0, 12e3, 60.0)
    return {
        name: sorted(float(f"{m * 10.0**e:.4g}") for e in draw.uniform(-0.5, 0.5, n))
        for name, m, n in zip(("lower", "upper", "oil", "tuned", "pot"), middle, size, strict=True)
    }


def _document(lists: Lists, **ranges: Any) -> dict[str, Any]:
    def chosen(name: str, unit: str) -> Any:
        return ranges.get(name) or {"one_of": [f"{value!r} {unit}" for value in lists[name]]}

    return {
        "title": "a frame on a frame with an absorber",
        "bodies": {"low": {"mass": "120 kg"}, "top": {"mass": "80 kg"}},
        "links": {
            "lower": {"between": ["low", "ground"], "stiffness": chosen("lower", "N/m"),
                      "damping": chosen("oil", "N s/m")},
            "upper": {"between": ["top", "low"], "stiffness": chosen("upper", "N/m"), "damping": "50 N s/m"},
        },
        "absorbers": {"tuned": {"on": "top", "mass": "5 kg", "stiffness": chosen("tuned", "N/m"),
                                "damping": chosen("pot", "N s/m")}},
        "excitations": {"push": {"kind": "force", "on": "low", "amplitude": "100 N", "speed": ["4 Hz", "11 Hz"],
                                 "varies": "constant"}},
        "limits": {"low": {"response": "displacement", "of": "low", "at_most": "2 mm"}},
        "goal": {"minimise": "displacement", "of": "top"},
    }  # fmt: skip


def _motion(lower: float, upper: float, oil: float, tuned: float, pot: float) -> tuple[float, float]:
    """Greatest amplitudes of the lower and of the upper frame at both speeds [m]."""
    worst = []
    for w in SPEEDS:
        a, b, c = lower + 1j * w * oil, upper + 50j * w, tuned + 1j * w * pot
        stiff = np.array([[a + b, -b, 0.0], [-b, b + c, -c], [0.0, -c, c]]) - w**2 * np.diag([*MASSES, 5.0])
        worst.append(np.abs(np.linalg.solve(stiff, [FORCE, 0.0, 0.0])))
    low, top, _ = np.max(worst, axis=0)
    return float(low), float(top)


def _least(lists: Lists) -> float:
    every = (_motion(*one) for one in product(*lists.values()))
    return min((top for low, top in every if low <= 2e-3), default=np.inf)


@pytest.mark.parametrize("seed", range(4))
def test_nothing_among_all_combinations_is_better(seed: int) -> None:
    """By boxes that split lists, which proves it, and by exchange, which does not."""
    lists = _lists(seed, 3)
    job, least = from_dict(_document(lists)), _least(lists)
    for method in (BranchAndBound(), RoundAndExchange()):
        found = method.solve(pose(job))
        if least == np.inf:
            assert found.status == ("infeasible" if isinstance(method, BranchAndBound) else "unproven")
            continue
        assert found.x is not None
        goal = vo.solve(job, method=method.name).goal
        assert goal is not None
        assert goal[1].value == pytest.approx(least, rel=1e-9, abs=0.0)


def test_more_combinations_than_can_be_measured_are_answered_no_worse_than_a_sample_of_them() -> None:
    """Of 6^5 combinations; a thousand of them at random, and all that differ from the answer in one value."""
    lists = _lists(9, 6)
    design = vo.solve(vo.from_dict(_document(lists)), explain=False)
    assert design.status in ("optimal", "feasible"), design.claim
    assert design.goal is not None
    chosen = [design.variables[path].value.value for path in PATHS]
    values = list(lists.values())
    assert all(value in row for value, row in zip(chosen, values, strict=True))
    draw = np.random.default_rng(1)
    sample = [[float(draw.choice(row)) for row in values] for _ in range(1000)]
    sample += [[*chosen[:i], value, *chosen[i + 1 :]] for i, row in enumerate(values) for value in row]
    good = [top for low, top in (_motion(*one) for one in sample) if low <= 2e-3]
    assert design.goal[1].value == pytest.approx(_motion(*chosen)[1], rel=1e-9, abs=0.0)
    assert design.goal[1].value <= min(good) * (1.0 + 1e-9)


PATHS = (
    "links.lower.stiffness", "links.upper.stiffness", "links.lower.damping", "absorbers.tuned.stiffness",
    "absorbers.tuned.damping",
)  # fmt: skip


def test_lists_beside_more_ranges_than_boxes_take_are_answered() -> None:
    """Four springs in ranges beside 343 combinations; the stiffest of them stands under the heaviest machine."""
    spring = {"between": ["m", "ground"], "stiffness": {"from": "5 kN/m", "to": "500 kN/m"}}
    weights = {"one_of": [f"{value} kg" for value in (60, 70, 80, 90, 100, 110, 125)]}
    dampers = {"one_of": [f"{value} N s/m" for value in (0, 1, 2, 4, 8, 16, 32)]}
    job = vo.from_dict(
        {
            "title": "four springs",
            "bodies": {"m": {"mass": weights}},
            "links": {name: dict(spring) for name in "abcd"}
            | {name: {"between": ["m", "ground"], "damping": dampers} for name in "ef"},
            "excitations": {"e": {"kind": "unbalance", "on": "m", "unbalance": "0.02 kg m", "speed": "1500 rpm"}},
            "limits": {"floor": {"response": "transmitted_force", "into": "ground", "at_most": "80 N"}},
            "goal": {"maximise": "stiffness", "of": "a"},
        }
    )
    design = vo.solve(job, explain=False)
    speed = 157.07963267948966
    force = 0.02 * speed**2
    assert design.method == "round_and_exchange"
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(80.0 * 125.0 * speed**2 / (force + 80.0) - 15e3, rel=1e-6)


def test_rows_without_end_beside_a_resonance_are_no_warning() -> None:
    """Boxes that hold an absorber's resonance have rows of infinite size, which say nothing."""
    design = vo.solve(
        vo.from_dict(
            {
                "title": "one machine with an absorber",
                "bodies": {"m": {"mass": "531.4 kg"}},
                "links": {"s": {"between": ["m", "ground"], "damping": "296.1 N s/m",
                                "stiffness": {"one_of": ["65.28 kN/m", "193.8 kN/m", "728.6 kN/m", "1583 kN/m"]}}},
                "absorbers": {"a": {"on": "m", "mass": {"one_of": ["5.715 kg", "11.43 kg", "22.86 kg"]},
                                    "frequency": {"from": "1.0082 Hz", "to": "5.041 Hz"},
                                    "damping_ratio": {"from": 0.01, "to": 0.5}}},
                "excitations": {"e": {"kind": "force", "on": "m", "amplitude": "100 N", "speed": "2.011..4.779 Hz",
                                      "varies": "constant"}},
                "limits": {"s": {"response": "stroke", "of": "a", "at_most": "32.47 mm"}},
                "goal": {"minimise": "displacement", "of": "m"},
            }
        ),
        explain=False,
    )  # fmt: skip
    assert design.status == "optimal"


def _bought(folder: Path, seed: int) -> tuple[dict[str, Any], float]:
    """A machine whose mass may be filled up on three to six bought mounts, and the least force on the floor [N].

    The force falls with the mass, which one of the load, the sag and the range ends.
    """
    draw = np.random.default_rng(seed)
    heads = (
        "part;rated load min [N];rated load max [N];stiffness [N/mm];static stiffness [N/mm];loss factor;price [EUR]"
    )
    rows, least = [heads], np.inf
    for i in range(40):
        load, stiff, static, loss = (
            float(f"{one:.5g}")
            for one in (
                10.0 ** draw.uniform(2.7, 3.6),
                10.0 ** draw.uniform(1.6, 3.0),
                draw.uniform(0.6, 1.0),
                draw.uniform(0.02, 0.3),
            )
        )
        static = float(f"{static * stiff:.5g}")
        rows.append(f"P{i};{0.1 * load:.5g};{load:.5g};{stiff:.5g};{static:.5g};{loss:.5g};10".replace(".", ","))
        for count in (3, 4, 5, 6):
            mass = min(700.0, count * load / 9.80665, count * static * 1e3 * 5e-3 / 9.80665)
            if mass >= max(300.0, count * float(f"{0.1 * load:.5g}") / 9.80665):
                k, w = count * stiff * 1e3 * (1.0 + 1j * loss), 1200.0 * np.pi / 30.0
                least = min(least, 0.1 * w**2 * abs(k / (k - mass * w**2)))
    (folder / "shelf.csv").write_text("\n".join(rows), encoding="utf-8")
    feet = {
        "between": ["set", "ground"],
        "count": {"from": 3, "to": 6, "whole": True},
        "part": {"catalogue": str(folder / "shelf.csv")},
    }
    return {
        "title": "filled up",
        "bodies": {"set": {"mass": {"from": "300 kg", "to": "700 kg"}}},
        "links": {"feet": feet},
        "excitations": {"e": {"kind": "unbalance", "on": "set", "unbalance": "0.1 kg m", "speed": "1200 rpm"}},
        "limits": {"sag": {"response": "static_deflection", "of": "set", "at_most": "5 mm"}},
        "goal": {"minimise": "transmitted_force", "into": "ground"},
    }, least


@pytest.mark.parametrize("seed", range(3))
def test_parts_of_a_catalogue_beside_a_range_are_the_best_of_all(seed: int, tmp_path: Path) -> None:
    document, least = _bought(tmp_path, seed)
    design = vo.solve(from_dict(document), explain=False)
    assert (design.status, design.method) == ("feasible", "round_and_exchange")
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(least, rel=1e-6)
    assert design.variables["bodies.set.mass"].value.value <= 700.0


def test_parts_with_tolerances_stand_beside_no_range(tmp_path: Path) -> None:
    document, _ = _bought(tmp_path, 0)
    document["bodies"]["set"]["mass"] = {"from": "300 kg", "to": "700 kg"}
    document["links"]["feet"]["tolerance"] = "10 %"
    assert str(refused(vo.solve, from_dict(document))) == (
        "bodies.set.mass may be any value of a range, and links.feet.stiffness has a tolerance: parts of a catalogue "
        "are chosen beside one of the two. Write one value, or one_of = [...], or no tolerance."
    )


def test_parts_beside_a_range_are_chosen_by_one_method_alone(tmp_path: Path) -> None:
    job = from_dict(_bought(tmp_path, 0)[0])
    assert str(refused(vo.solve, job, method="catalogue")) == (
        "--method catalogue: parts of a catalogue beside a range are chosen by --method round_and_exchange alone."
    )


@pytest.mark.parametrize("seed", range(3))
def test_boxes_of_single_designs_are_bounded_by_what_these_do(seed: int) -> None:
    """Limits may leave one value of a range as of a list: nothing is left to split, and the goal bounds itself."""
    lists = _lists(seed, 2)
    program = pose(from_dict(_document(lists)))
    assert program.aim is not None
    chosen = tuple(row[0] for row in lists.values())
    known = dict(zip(PATHS, chosen, strict=True))
    single = replace(
        program,
        axes=tuple(
            replace(one, low=known[one.path], high=known[one.path], values=(known[one.path],)) for one in program.axes
        ),
        limits=(),
    )
    goal = float(np.log(_motion(*chosen)[1]))
    assert _Relaxed(single, program.aim.pieces).search(goal + 1.0) == pytest.approx(goal, abs=1e-6)
