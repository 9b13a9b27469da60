"""A run of both weights of a pair tells what the pair does, and nothing of its planes alone."""

from __future__ import annotations

import cmath
from math import degrees, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from vibopt.balancing import is_rotor
from vibopt.balancing.influence import identify
from vibopt.cli.main import main
from vibopt.study.rounded_plan import drawn

HEAD = """
title = "Fan with a pair of planes"

[conventions]
phase = "lead"
readings = "phase"
angles = "with rotation"
detector = "pk"
zero = "mark"

[planes.left]
radius = "RADIUS"
weight = { from = "0 g", to = "80 g" }

[planes.right]
radius = "150 mm"
weight = { from = "0 g", to = "80 g" }

[pairs.both]
kind = "KIND"
planes = ["left", "right"]

[goal]
minimise = "residual"
"""
Run = tuple[complex, complex, str]


def _amount(weight: complex, unit: str) -> str:
    return f"{abs(weight):.15g} {unit} @ {degrees(cmath.phase(weight)):.15g} deg"


class Rotor:
    """Two planes and as many sensors as y0 has; a weight [g] in a plane at 150 mm adds H times it [um]."""

    def __init__(self, seed: int, n: int = 3) -> None:
        dice = np.random.default_rng(seed)
        self.H = dice.normal(size=(n, 2)) + 1j * dice.normal(size=(n, 2))
        self.y0 = 40.0 * (dice.normal(size=n) + 1j * dice.normal(size=n))

    def run(self, left: complex, right: complex, part: float = 1.0) -> str:
        """One run, the weights as told in grams where the left radius is `part` of 150 mm."""
        read = self.y0 + self.H @ np.array([left, right])
        weights = {"left": left / part, "right": right}
        fitted = ", ".join(f'{name} = "{_amount(one, "g")}"' for name, one in weights.items() if one)
        readings = ", ".join(f's{k} = "{_amount(complex(one), "um")}"' for k, one in enumerate(read))
        told = f"weights = {{ {fitted} }}\n" if fitted else ""
        return f'[[runs]]\nspeed = "900 rpm"\n{told}readings = {{ {readings} }}\n'

    def text(self, *runs: tuple[complex, complex], kind: str = "couple", part: float = 1.0) -> str:
        head = HEAD.replace("KIND", kind).replace("RADIUS", f"{150.0 * part:.15g} mm")
        return head + "".join(self.run(*weights, part) for weights in ((0j, 0j), *runs))


ROTOR = Rotor(1)
COUPLE = (10.0 + 0j, -10.0 + 0j)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from(("couple", "static")), st.floats(0.3, 3.0), st.floats(0.0, 6.28))
def test_one_run_of_a_pair_tells_what_a_run_in_each_plane_does(seed: int, kind: str, part: float, angle: float) -> None:
    """By formula, too: one number h per sensor, the pair's reading less that as found over its weight."""
    rotor, ratio, trial = Rotor(seed), 1.0 if kind == "static" else -1.0, cmath.rect(12.0, angle)
    each = vo.solve(vo.from_text(rotor.text((trial, 0j), (0j, trial), kind=kind, part=part), name="each.toml"))
    both = vo.solve(vo.from_text(rotor.text((trial, ratio * trial), kind=kind, part=part), name="both.toml"))
    assert each.status == both.status == "optimal"
    assert both.goal is not None
    assert each.goal is not None
    h = rotor.H @ np.array([1.0, ratio])
    x = complex(-np.vdot(h, rotor.y0) / np.vdot(h, h))
    most = 80.0 * min(part, 1.0)
    x *= min(most / abs(x), 1.0)
    left = float(np.sqrt(np.mean(np.abs(rotor.y0 + h * x) ** 2)))
    for answer in (each, both):
        assert answer.goal is not None
        assert 1e6 * answer.goal[1].value == pytest.approx(left, rel=1e-7)
        fitted = [complex(one.u) / 0.15 * 1000.0 for one in answer.plan.fittings[0].planes]
        assert fitted == pytest.approx([x, ratio * x], rel=1e-4, abs=1e-4 * abs(x))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 6.28), st.floats(0.0, 6.28), st.floats(0.3, 3.0))
def test_further_runs_of_the_pair_are_spare_for_both_routes(seed: int, angle: float, other: float, part: float) -> None:
    """As many runs as unknowns of both planes, alike up to rounding, left a matrix that told nothing."""
    rotor, trials = Rotor(seed), [cmath.rect(12.0, angle), cmath.rect(7.0, other)]
    text = rotor.text(*((one, -one) for one in trials), part=part)
    answer = vo.solve(vo.from_text(text, name="fan.toml"))
    assert (answer.status, answer.proven) == ("optimal", True)
    assert answer.details["put_back"]["greatest_difference"] < 1e-9


def test_nothing_is_told_of_a_plane_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = vo.from_text(ROTOR.text(COUPLE, (3j, -3j)), name="fan.toml")
    assert is_rotor(job)
    learnt = identify(job).learnt[0]
    assert (learnt.alone, learnt.spare) == ((), 1)
    answer = vo.solve(job)
    assert not [path for path in answer.entries() if path.startswith("influence.")]
    assert (
        answer.notes[-1]
        == "What weights in left and right do is known as they were fitted together, not of each alone."
    )
    file = tmp_path / "fan.toml"
    file.write_text(ROTOR.text(COUPLE), encoding="utf-8")
    assert main(["solve", str(file), "--save-coefficients", str(tmp_path / "known.toml")]) == 2
    assert capsys.readouterr().err.strip() == (
        f"{file.name}: the runs tell what weights in left and right do together, not what one does alone. Add a run "
        "with a weight in left alone, or leave --save-coefficients out."
    )


def test_a_third_plane_with_a_run_of_its_own_has_its_coefficient() -> None:
    text = ROTOR.text(COUPLE).replace("[pairs.both]", '[planes.hub]\nradius = "90 mm"\n\n[pairs.both]')
    hub = ROTOR.run(2.0 + 0j, 1j).replace("left = ", "hub = ").replace(', right = "1 g @ 90 deg"', "")
    answer = vo.solve(vo.from_text(text + hub, name="fan.toml"))
    told = {path.split(".")[2] for path in answer.entries() if path.startswith("influence.")}
    assert told == {"hub"}


def test_a_saved_pair_is_a_job_of_its_own_and_other_weights_are_refused(tmp_path: Path) -> None:
    """What the runs say nothing of is told as a mistake, never predicted: also where one weight is changed later."""
    file, saved = tmp_path / "fan.toml", tmp_path / "saved.toml"
    file.write_text(ROTOR.text(COUPLE), encoding="utf-8")
    before = vo.solve(vo.read(file))
    assert main(["solve", str(file), "--save", str(saved)]) == 0
    job = vo.read(saved)
    again = vo.solve(job)
    assert before.goal is not None
    assert again.status == "met"
    path = "measures.minimised.value" if "measures.minimised.value" in again.entries() else "goal"
    assert float(again.find(path).value) == pytest.approx(before.goal[1].value, rel=1e-9)
    both = {"planes.left.weight": "7 g @ 30 deg", "planes.right.weight": "7 g @ 210 deg"}
    assert vo.solve(vo.with_changes(job, both)).status == "met"
    error = refused(vo.with_changes, job, {"planes.left.weight.mass": "7 g"})
    assert str(error).startswith("saved.toml: fewer runs than planes: to learn what a weight does in left and right")


def test_rounded_weights_of_a_pair_stay_one() -> None:
    job = vo.from_text(ROTOR.text(COUPLE), name="fan.toml")
    answer = vo.solve(job)
    done = drawn(job, answer, ["0.5 g", "5 deg"])
    left, right = (one.weights[0] for one in done.design.plan.fittings[0].planes)
    assert left.mass == right.mass == pytest.approx(round(2000.0 * left.mass) / 2000.0)
    assert abs(left.angle - right.angle) == pytest.approx(pi)
    assert str(refused(drawn, job, answer, ["3"])) == (
        "fan.toml: no rounded value lies within the range that was given. Round finer."
    )


@pytest.mark.parametrize(("kind", "where"), [("couple", "on opposite sides"), ("static", "at the same angle")])
def test_too_few_runs_are_told_that_one_is_enough_for_a_pair(kind: str, where: str) -> None:
    rotor = ROTOR.text((10.0 + 0j, (1.0 if kind == "couple" else -1.0) * 10.0), kind=kind)
    assert str(refused(vo.from_text, rotor, name="fan.toml")) == (
        "fan.toml line 25: fewer runs than planes: to learn what a weight does in left and right, 2 runs with weights "
        "are needed at 900 rpm, and there is 1 run with weights. Add a run with a weight in right, write keep = true "
        "in [planes.right], or give ready coefficients in [[influence]]. For pairs.both one run is enough in which "
        f"left and right have equal unbalances {where}."
    )
