"""What would give a job without a design one: each value named does, a third digit less of the change does not.

The second route is a dense grid of formulas for one mass, on which a change helps or does not.
"""

from __future__ import annotations

import json
import re
from math import copysign, floor, log10, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from texts import ANY_DAMPING, ANY_STIFFNESS, STIFFEST, moves, press
from texts import floor as floor_of
from vibopt.cli.main import main
from vibopt.jobs import answer, fact_at, from_text, open_job, with_changes
from vibopt.study.nearest import with_nearest
from vibopt.study.remedies import Remedies, remedies
from vibopt.units import to_unit

PROBLEMS = Path(__file__).parents[2] / "problems"
STIFFNESS, DAMPING = np.geomspace(1e5, 1e8, 401)[:, None], np.geomspace(1e3, 1e6, 301)[None, :]


def pressed(floor: float, run_up: float, soft: int | None = None) -> str:
    """A press held on the floor [N] and on its way up [m], by a soft limit or not."""
    asked = floor_of(f"{floor!r} N"), moves("press", f"{run_up!r} m", "run_up", "start-up", soft=soft), STIFFEST
    return press(ANY_STIFFNESS, ANY_DAMPING, *asked)


def missed(floor: float, run_up: float, mass: float, force: float, rpm: float) -> float:
    """By which factor the worst limit is missed at least, over a dense grid of mounts."""
    top, k, c = rpm * pi / 30.0, STIFFNESS, DAMPING
    spring = k + 1j * top * c
    into = force * np.abs(spring / (spring - mass * top**2))
    peak = np.sqrt(np.maximum(k / mass - c**2 / (2.0 * mass**2), 0.0)).clip(max=top)
    there = np.maximum.reduce([force / np.abs(k + 1j * w * c - mass * w**2) for w in (0.0 * k, peak, top + 0.0 * peak)])
    return float(np.maximum(into / floor, there / run_up).min())


@settings(max_examples=8)
@given(st.floats(4e3, 8.5e3), st.floats(3e-3, 9e-3))
def test_what_helps_a_mount_is_what_a_dense_grid_says(floor: float, run_up: float) -> None:
    found = remedies(from_text(pressed(floor=floor, run_up=run_up), "press.toml"))
    assert found.found.status == "infeasible"
    facts = {"bodies.press.mass": 300.0, "excitations.punch.amplitude": 30e3, "excitations.punch.speed": 3000.0}
    for place, path in enumerate(facts):
        row = next(row for row in found.rows if row.path == path)
        if row.then is None:
            for times in (0.1, 0.2, 0.5, 2.0, 5.0, 10.0):
                given = (value * (times if k == place else 1.0) for k, value in enumerate(facts.values()))
                assert missed(floor, run_up, *given) > 1.0
            continue
        then = row.then.value * (30.0 / pi if path.endswith("speed") else 1.0)
        now = facts[path]
        ahead, behind = (
            missed(floor, run_up, *(one if k == place else value for k, value in enumerate(facts.values())))
            for one in (then, then - 0.06 * (then - now))
        )
        assert ahead <= 1.03  # the grid is a few percent wide
        assert behind > 1.0 or np.isclose(then, now, rtol=0.02)
    least = min(found.helpful, key=lambda row: row.change)
    assert found.helpful[0] == least


def checked(found: Remedies) -> int:
    """Every value that is named has a design, one whose change is a third digit less has none; how many there are."""
    assert found.helpful
    for row in found.helpful:
        assert row.then is not None
        fact = fact_at(found.job, row.path)
        text: str | float = row.then.shown if row.then.unit else fact.text(row.then.value)
        if fact.place:
            text = fact.text(row.then.value)
        made = with_changes(found.job, {fact.path: text})
        assert answer(made, explain=False).status in ("optimal", "feasible"), row.path
        number = float(to_unit(row.then.value, fact.unit, fact.dimension) if fact.unit else row.then.value)
        now = float(to_unit(fact.value, fact.unit, fact.dimension) if fact.unit else fact.value)
        size = max(min(abs(number), abs(number - now)), 1e-300)
        step = 1.0 if fact.dimension == "count" else 10.0 ** (floor(log10(size * (1.0 - 1e-9))) - 2)
        less = number + (1.0 if fact.dimension == "count" else 1.001) * copysign(step, row.now.value - row.then.value)
        value = fact.read(f"{less!r} {fact.unit}") if fact.unit else less
        assert row.then.value == row.now.value or _none(found, fact, value), row.path
    return len(found.helpful)


def _none(found: Remedies, fact: Any, value: float) -> bool:
    return answer(with_changes(found.job, fact.changes(value)), explain=False).status not in ("optimal", "feasible")


@pytest.mark.parametrize(
    ("file", "changes", "wanted"),
    [
        ("isolation/rao_9_34.toml", {"limits.start_up.at_most": "8 mm"}, ("bodies.", "excitations.", "limits.")),
        ("balancing/rao_9_7_holes.toml", {}, ("planes.",)),
        ("balancing/rao_9_14_b_capped.toml", {}, ("masses.", "planes.", "shaft.")),
        ("balancing/engine_share_capped.toml", {}, ("engine.",)),
    ],
)
def test_of_every_kind_of_job_what_is_named_helps_and_a_step_less_does_not(
    file: str, changes: dict[str, str], wanted: tuple[str, ...]
) -> None:
    limits = {
        "rao_9_7_holes": '[limits.all]\nresponse = "residual"\nat_most = "0.005 mm"',
        "rao_9_14_b_capped": '[limits.bearings]\nresponse = "bearing_reaction"\nat_most = "2 N"',
        "engine_share_capped": '[limits.first]\nresponse = "primary_force"\nat_most = "900 N"',
    }
    name = Path(file).stem
    text = (PROBLEMS / file).read_text(encoding="utf-8").partition("[[expected]]")[0]
    if name in limits:
        head, *tables = text.split("\n[limits.")
        text = head + "".join(f"\n[{one.partition(chr(10) + '[')[2]}" for one in tables if "\n[" in one)
        text += f"\n{limits[name]}\n"
    found = remedies(with_changes(from_text(text, f"{name}.toml"), changes))
    assert checked(found) >= 3
    for family in wanted:
        assert any(row.path.startswith(family) for row in found.helpful), family


@pytest.mark.slow
def test_a_tolerance_that_leaves_no_design_is_named() -> None:
    text = pressed(floor=10e3, run_up=16e-3).replace('"300 kg"', '{ value = "300 kg", tolerance = "30 %" }')
    job = from_text(text, "press.toml")
    assert answer(with_changes(job, {"bodies.press.mass.tolerance": "1 %"}), explain=False).status == "optimal"
    found = remedies(job, found=answer(job, explain=False), only=["bodies.press.mass.tolerance"])
    assert len(found.rows) == 1
    row = next(row for row in found.helpful if row.path == "bodies.press.mass.tolerance")
    assert row.then is not None
    assert 0.03 < row.then.value < 0.3


def test_a_soft_limit_comes_first() -> None:
    plain, soft = (remedies(from_text(pressed(floor=8e3, run_up=8e-3, soft=one), "press.toml")) for one in (None, 20))
    assert plain.helpful[0].path == "excitations.punch.amplitude"
    assert soft.helpful[0].path == "limits.run_up.at_most"
    assert {row.path: row.then for row in plain.rows} == {row.path: row.then for row in soft.rows}
    assert plain.first.startswith("The least change of one number: excitations.punch.amplitude 30 kN pk -> ")
    assert not any("Ranked" in one for one in plain.notes)
    weighed = "The least change of one number, by the weights of soft limits: limits.run_up.at_most "
    assert soft.first.startswith(weighed)
    assert "Ranked by the change divided by the weight of a soft limit (soft: run_up 20)." in soft.notes


def test_a_change_of_a_thousandth_is_said_as_that() -> None:
    """The force of a spring without damping is in closed form: so much less, and the limit holds."""
    spring, inertia = 6.99e6, 300.0 * (3000.0 * pi / 30.0) ** 2
    handed_on = 30e3 * spring / (inertia - spring)
    wanted = handed_on * 0.9987
    text = pressed(floor=wanted, run_up=1.0).replace('"10 kN/m"', '"6.99 MN/m"')
    text = text.replace('{ from = "10 N s/m", to = "1 MN s/m" }', '"0 N s/m"')
    text = text.partition("[limits.run_up]")[0] + "[goal]" + text.partition("[goal]")[2]
    found = remedies(from_text(text, "press.toml"))
    changes = {row.path: row for row in found.helpful}
    force, limit = (changes[path].then for path in ("excitations.punch.amplitude", "limits.floor.at_most"))
    assert force is not None
    assert limit is not None
    assert 0.0 <= 30e3 * 0.9987 - force.value <= 0.01 * 30e3 * 0.0013
    assert 0.0 <= limit.value - handed_on <= 0.01 * (handed_on - wanted)
    assert [row.change for row in found.helpful] == sorted(row.change for row in found.helpful)


def test_a_bound_of_nothing_is_loosened_by_no_part_of_it() -> None:
    """No factor widens 0 N; what the floor takes at least is the remedy that the answer itself names."""
    job = from_text(pressed(floor=0.0, run_up=20e-3), "press.toml")
    found = remedies(job, found=with_nearest(vo.solve(job)), only=["limits.floor.at_most"])
    conflict, near, (row,) = found.found.conflict, found.found.nearest, found.helpful
    assert conflict is not None
    assert near is not None
    assert row.then is not None
    assert (near.together, near.limits["floor"].margin_shown, row.part) == ((), "", "")
    assert [then for _, _, then in conflict.loosenings] == [row.then]
    assert missed(row.then.value, 20e-3, 300.0, 30e3, 3000.0) < 1.03
    assert missed(0.97 * row.then.value, 20e-3, 300.0, 30e3, 3000.0) > 1.0


def test_what_the_work_ends_is_never_called_useless() -> None:
    """What helps alone helps, or was left out, whatever the work that may be done."""
    job = from_text(pressed(floor=8e3, run_up=8e-3), "press.toml")
    helps = {row.path for row in vo.remedies(job).helpful}
    assert helps
    for most in (0.0, 0.3, 3.0, 30.0, 300.0):
        for row in vo.remedies(job, most=most).rows:
            left_out = row.why == "left out because of the work"
            assert row.path not in helps or row.then is not None or left_out, (most, row.path)


def test_what_is_left_out_is_said_and_a_job_with_a_design_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = pressed(floor=8e3, run_up=8e-3)
    job = from_text(text, "press.toml")
    found = vo.remedies(job, most=0.0)
    assert found.found.conflict is not None
    known = found.found.conflict.by_size  # solved beside the answer
    assert known
    assert [row.path for row in found.helpful] == [f"limits.{name}.at_most" for name, *_ in known]
    without = remedies(job, found=answer(job, explain=False), most=0.0)
    assert not without.helpful
    assert without.first == "Whether a limit, range or fact, changed alone, gives a design was not looked at."
    assert without.notes[0].startswith("Not looked at because of the work: limits.floor.at_most, ")
    assert without.notes[0].endswith(". `vibopt whatif FILE --thorough` looks at all.")
    error = refused(remedies, open_job(PROBLEMS / "isolation" / "rao_9_34.toml"))
    words = "rao_9_34.toml: is optimal, so there is nothing to mend. See vibopt whatif FILE."
    assert error.messages == (words,)
    file = tmp_path / "press.toml"
    file.write_text(text, encoding="utf-8")
    assert main(["whatif", str(file)]) == 3
    shown = capsys.readouterr().out
    assert "What would help, each by itself" in shown
    assert re.search(r"excitations.punch.amplitude +30 kN pk -> 23.15 kN pk +-22.8 %", shown)
    assert "The nearest design" in shown
    assert main(["whatif", str(file), "--json"]) == 3
    data = json.loads(capsys.readouterr().out)
    assert data["rows"][0]["path"] == "excitations.punch.amplitude"
    assert data["answer"]["status"] == "infeasible"
