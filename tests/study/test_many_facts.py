"""Sweeps over several facts, lists, ratios, parts and samples; and what lies between their points."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from texts import STIFFEST, choice, floor, shaken_fan, table
from vibopt.answer.jsonable import json_text
from vibopt.report.figures import map_figure
from vibopt.scene.read import from_text, read
from vibopt.study.edges import CLOSE
from vibopt.study.points import Points
from vibopt.study.sweep import Sweep, sweep
from vibopt.study.sweep_series import change_words, map_of, strips

PRESS = Path(__file__).parents[2] / "problems" / "isolation" / "rao_9_34.toml"
ABSORBER = PRESS.parents[1] / "absorbers" / "rao_9_51.toml"
START_UP, FLOOR, MASS = "limits.start_up.at_most", "limits.floor_force.at_most", "bodies.press.mass"
SPEED, FORCE, SPRING, DAMPER = (
    "excitations.press.speed", "excitations.press.amplitude", "links.mount.stiffness", "links.mount.damping",
)  # fmt: skip
TOGETHER: tuple[dict[str, str], ...] = (
    {START_UP: "8 mm..30 mm", MASS: "200 kg..400 kg"},
    {SPEED: "2000 rpm..4000 rpm", FORCE: "-20 %..+20 %"},
    {FLOOR: "8, 9, 10, 15 kN", START_UP: "1 mm..100 mm log"},
    {DAMPER: "2 kN s/m..20 kN s/m", FLOOR: "5 kN..30 kN"},
    {SPRING: "1 MN/m..9 MN/m", DAMPER: "2 kN s/m..20 kN s/m"},
    {START_UP: "8 mm..30 mm", MASS: "200 kg..400 kg", FORCE: "-10 %..10 %"},
)


@pytest.mark.parametrize("ranges", TOGETHER, ids=lambda one: " ".join(path.rpartition(".")[2] for path in one))
def test_points_over_several_facts_are_those_answered_alone(
    ranges: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, count = read(PRESS), 4 if len(ranges) == 2 else 3
    many = sweep(scene, ranges, points=count)
    assert isinstance(many.points, Points)
    assert len(many.points.single) < 8, "these points were not answered together"
    with monkeypatch.context() as patch:
        patch.setattr(import_module("vibopt.study.many"), "FEWEST_TOGETHER", inf)
        single = sweep(scene, ranges, points=count)
    for together, one in zip(many.points, single.points, strict=True):
        assert (together.status, together.varied) == (one.status, one.varied)
        for key, value in one.variables.items():
            assert together.variables[key].value == pytest.approx(value.value, rel=1e-9)
        assert together.margins == pytest.approx(dict(one.margins), rel=1e-9, abs=1e-9)


def test_a_grid_has_the_first_fact_slowest_and_each_point_is_the_answer_there() -> None:
    scene = read(PRESS)
    found = sweep(scene, {START_UP: "10, 12.5, 30 mm", MASS: "250, 350 kg"})
    where = [(one.varied[START_UP].shown, one.varied[MASS].shown) for one in found.points]
    assert where == [(f"{a} mm pk", f"{b} kg") for a in ("10", "12.5", "30") for b in (250, 350)]
    alone = vo.solve(vo.with_changes(scene, {START_UP: "30 mm", MASS: "250 kg"}))
    assert found.points[4].goal is not None
    assert alone.goal is not None
    assert found.points[4].goal.value == pytest.approx(alone.goal[1].value, rel=1e-9)
    assert list(found.table()[0])[:3] == [f"{START_UP} [m]", f"{MASS} [kg]", "status"]


def test_parts_of_a_chosen_variable_are_parts_of_what_is_chosen() -> None:
    scene = read(PRESS)
    best = vo.solve(scene).variables[DAMPER].value.value
    found = sweep(scene, DAMPER, "-10 %..10 %", 3)
    assert [one.value.value / best for one in found.points] == pytest.approx([0.9, 1.0, 1.1], rel=1e-9)
    assert found.held == (DAMPER,)


@pytest.mark.parametrize("sample", ["sobol", "latin"])
def test_a_sample_is_the_same_each_time_within_its_ranges_and_even(sample: Any) -> None:
    scene, ranges = read(PRESS), {START_UP: "15 mm..30 mm", MASS: "200 kg..400 kg"}
    first, again = (sweep(scene, ranges, points=64, sample=sample) for _ in range(2))
    values = np.array([[one.value for one in point.varied.values()] for point in first.points])
    assert [one.varied for one in first.points] == [one.varied for one in again.points]
    for column, (low, high) in zip(values.T, ((0.015, 0.03), (200.0, 400.0)), strict=True):
        assert low <= column.min() < column.max() <= high
        counts = np.histogram(column, bins=8, range=(low, high))[0]
        assert counts.max() - counts.min() <= 2
    assert first.boundaries == ()


VERDICTS = (
    (PRESS, {START_UP: "5 mm..30 mm"}), (PRESS, {FLOOR: "1 kN..60 kN"}), (PRESS, {SPEED: "1000 rpm..4000 rpm"}),
    (PRESS, {START_UP: "5, 10, 30 mm", FLOOR: "5 kN..25 kN"}),
)  # fmt: skip


def _states(sweep: Sweep, values: dict[str, str]) -> tuple[str, frozenset[str]]:
    answer = vo.solve(vo.with_changes(sweep.job, values), explain=False)
    return answer.status, frozenset(name for name, one in answer.limits.items() if abs(one.margin) <= 1e-8)


@pytest.mark.parametrize(("file", "ranges"), VERDICTS, ids=["start_up", "floor", "speed", "two"])
def test_a_boundary_is_where_solve_changes_its_answer(file: Path, ranges: dict[str, str]) -> None:
    found = sweep(read(file), ranges, points=9)
    assert found.boundaries
    spans = {one.fact.path: one.high - one.low for one in found.varied}
    for one in found.boundaries[:: max(1, len(found.boundaries) // 6)]:
        fact = next(each for each in found.facts if each.path == one.path)
        texts = {each.path: each for each in found.facts}
        rest = {path: texts[path].text(each.value) for path, each in one.others.items()}
        sides = [_states(found, {one.path: fact.text(each.value), **rest}) for each in (one.below, one.above)]
        assert sides[0] != sides[1], one
        assert 0.0 < one.above.value - one.below.value <= CLOSE * spans[one.path]


def test_where_a_known_limit_takes_over_is_found() -> None:
    """A spring may be as stiff as the sag or the force on the floor at 3 w_n allows: both are equal at one mass."""
    natural = table("limits.natural", response="natural_frequency", at_most="20 Hz")
    text = shaken_fan({"stiffness": choice("1 kN/m", "10 MN/m")}, floor("20 N"), natural, STIFFEST)
    # T = 1 / (r^2 - 1) with r = 50 Hz / f at f = 20 Hz: force at_most = 100 / (6.25 - 1) N
    found = sweep(from_text(text), "limits.floor.at_most", "10 N..30 N", 13)
    (one,) = found.boundaries
    assert one.before[1] == ("floor",)
    assert one.after[1] == ("natural",)
    assert one.at == pytest.approx(100.0 / 5.25, abs=2e-5)
    ((x, words),) = strips(found).marks
    assert x == pytest.approx(100.0 / 5.25, abs=2e-5)
    assert words == "natural becomes active, floor no longer active"


def test_a_point_on_a_boundary_is_told_as_one_place() -> None:
    """Two things that change within the width to which each is known change at one place, of one number."""
    job, path = read(ABSORBER), "limits.low.at_most"
    for one in sweep(job, path, "-60 %..+150 %", points=6).boundaries[::2]:
        place = one.at * 30.0 / np.pi
        found = sweep(job, path, f"{0.9 * place!r}, {place!r}, {1.1 * place!r} rpm")
        assert found.boundaries
        for other in found.boundaries:
            ends = other.precise.removeprefix("between ").split(" and ")
            assert len(set(ends)) == len(ends), other.precise


def test_where_nothing_is_proven_designs_are_not_said_to_end() -> None:
    (first, *_) = sweep(read(PRESS), START_UP, "5 mm..30 mm", points=6).boundaries
    assert change_words(first) == "designs begin; below, no design meets all limits"
    unsure = "unproven", (), ()
    assert change_words(replace(first, before=unsure)) == "answers begin; below, nothing found, nothing proven"
    turned = replace(first, before=first.after, after=unsure)
    assert change_words(turned) == "answers end; beyond, nothing found, nothing proven"


def test_a_map_draws_the_edge_where_it_is() -> None:
    found = sweep(read(PRESS), {START_UP: "5 mm..30 mm", FLOOR: "5 kN..25 kN"}, points=6)
    drawn = map_of(found)
    assert drawn.values.shape == drawn.good.shape == (6, 6)
    ends = [one for one in drawn.sides if one.ends]
    assert len(ends) >= 5
    along = next(one for one in ends if one.across)
    at_ten = vo.sweep(vo.with_changes(read(PRESS), {FLOOR: f"{along.y:.12g} kN"}), START_UP, "5 mm..30 mm", 50)
    assert 1e3 * at_ten.boundaries[0].at == pytest.approx(along.x, abs=5e-5)
    map_figure(drawn)


def test_two_processes_write_the_same_bytes_as_one() -> None:
    job = vo.read(Path(__file__).parents[2] / "problems" / "balancing" / "rao_9_3.toml")
    ranges = {"masses.one.mass": "-10 %..10 %", "masses.one.radius": "-10 %..10 %"}
    one, two = (sweep(job, ranges, points=3, workers=n) for n in (1, 2))
    assert json_text(list(one.points)) == json_text(list(two.points))


@pytest.mark.parametrize(
    ("ranges", "how", "words"),
    [
        ({START_UP: "5..6 kN"}, {}, "--vary limits.start_up.at_most=\"5..6 kN\" "),
        ({START_UP: "12 mm, 12 mm"}, {}, '"12 mm, 12 mm" names one value. Write "5 mm..30 mm", a list'),
        ({START_UP: "0 mm..6 mm log"}, {}, 'from zero on there are no equal ratios. Leave "log" out.'),
        ({START_UP: "5, 6 mm", MASS: "1..2 kg"}, {"sample": "sobol"},
         "--sample sobol draws from ranges, and limits.start_up.at_most is a list. Leave --sample out."),
        ({START_UP: "5..6 mm", MASS: "1..2 kg"}, {"points": 40_000},
         "1600000000 points are 1600000000 answers, some 2 h 40 min of work, more than the 100000 that are answered "
         "unasked. Take fewer --points, or add --yes."),
        ({f"limits.{one}.at_most": "1..2 mm" for one in "abcd"}, {},
         "--vary is given 4 times. A sweep varies one, two or three facts: leave some out."),
        ({"limits.startup.at_most": "5..6 mm"}, {},
         "there is no fact called limits.startup.at_most. Did you mean \"limits.start_up.at_most\"?"),
    ],
)  # fmt: skip
def test_what_cannot_be_varied_is_said(ranges: dict[str, str], how: dict[str, Any], words: str) -> None:
    assert words in str(refused(lambda: sweep(read(PRESS), ranges, **how)))


@pytest.mark.parametrize(
    ("text", "shown"),
    [("11,12.5,15 mm", ["11 mm pk", "12.5 mm pk", "15 mm pk"]), ("11 mm,15 mm", ["11 mm pk", "15 mm pk"])],
)
def test_a_list_needs_no_blanks(text: str, shown: list[str]) -> None:
    job = read(PRESS)
    assert [one.value.shown for one in sweep(job, START_UP, text).points] == shown


def test_thousands_set_off_are_no_list() -> None:
    job = read(PRESS)
    assert str(refused(sweep, job, START_UP, "100,200 mm")) == (
        '--vary limits.start_up.at_most="100,200 mm" is no range. Write "5 mm..30 mm", a list "10, 12, 15 mm", or '
        'parts of what it is now, "-20 %..+20 %".'
    )


def test_percentages_of_a_ratio_are_parts_where_one_has_a_sign() -> None:
    """The rule of `vibopt.values.part_of_now`; a share may be 20 % itself, and below zero it is written as a number."""
    document = PRESS.read_text(encoding="utf-8")
    lossy = from_text(document.replace('damping = { from = "10 N s/m", to = "1 MN s/m" }', "loss_factor = 0.2"))
    isolation = '[limits.isolation]\nresponse = "isolation"\ninto = "ground"\nat_least = "60 %"\n'
    kept, floor = from_text(document + isolation), "limits.isolation.at_least"
    for scene, path, text, values in (
        (lossy, "links.mount.loss_factor", "-20 %..+20 %", [0.16, 0.24]),
        (lossy, "links.mount.loss_factor", "10 %..20 %", [0.1, 0.2]),
        (kept, floor, "-10 %..10 %", [0.54, 0.66]),
        (kept, floor, "-10 %..-5 %", [0.54, 0.57]),
        (kept, floor, "-10 %, +10 %", [0.54, 0.66]),
        (kept, floor, "-0.1..0.1", [-0.1, 0.1]),
    ):
        assert [one.varied[path].value for one in sweep(scene, {path: text}, points=2).points] == pytest.approx(values)


def test_parts_of_any_other_number_need_a_sign() -> None:
    """80 % of 20 mm, or 80 % more: as behind --set, nobody knows."""
    assert str(refused(sweep, read(PRESS), START_UP, "80 %..120 %")) == (
        '--vary limits.start_up.at_most="80 %..120 %": a part needs its sign. Write "+80 %..+120 %".'
    )
