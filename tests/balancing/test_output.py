"""What a balancing answer looks like: text, picture, page."""

from __future__ import annotations

from datetime import date
from math import atan2, tau
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import pytest

from rotor_jobs import FAN
from vibopt.answer.answer import Answer
from vibopt.answer.answer_page import html
from vibopt.answer.text import blocks_of, text_of, verdict
from vibopt.balancing import is_rotor
from vibopt.balancing.figures import figure_of
from vibopt.balancing.figures.rotor_figure import disc
from vibopt.jobs import answer, is_scene, open_job

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibopt.balancing import BalancingJob

PROBLEMS = Path(__file__).parents[2] / "problems" / "balancing"
HOLES = 'radius = "150 mm"\nholes = 24\nshelf = ["5 g", "10 g", "20 g"]\nmost_weights = 2\n[[runs]]\nname = "as found"'


Answers: TypeAlias = "Callable[[str], tuple[Answer[Any], BalancingJob]]"
"""A text as answer and job."""


@pytest.fixture
def solved(tmp_path: Path) -> Answers:
    """A text as answer and job."""

    def solve(text: str) -> tuple[Answer, BalancingJob]:
        file = tmp_path / "fan.toml"
        file.write_text(text, encoding="utf-8")
        job = open_job(file)
        assert not is_scene(job)
        return answer(job), job

    return solve


def test_the_plan_reads_well_at_80_columns(solved: Answers) -> None:
    limited = FAN + '[limits.running]\nresponse = "residual"\nat_most = "2 mil pp"\n'
    shown = text_of(solved(limited.replace('radius = "150 mm"\n[[runs]]\nname = "as found"', HOLES))[0])
    assert max(map(len, shown.splitlines())) <= 80
    assert shown.startswith("Two-plane fan\noptimal: least root mean square of the residuals is 0.03073 mil pp\n")
    assert (
        "Weights\n"
        "  Plane  Weight   Angle      Hole  Radius\n"
        "  left   10.72 g  326.5 deg        150 mm\n"
        "  right  10 g     90 deg     7     150 mm\n"
        "  right  5 g      300 deg    21    150 mm\n"
    ) in shown
    assert (
        "What will be left\n"
        "  Sensor  Speed     As found              After           At most   Margin\n"
        "  a       1200 rpm  8.6 mil pp @ 63 deg   0.01534 mil pp  2 mil pp  99.2 %\n"
        "  b       1200 rpm  6.5 mil pp @ 206 deg  0.04067 mil pp  2 mil pp  98 %\n"
    ) in shown


def test_conventions_are_repeated_and_the_scatter_gives_bands(solved: Answers) -> None:
    shown = text_of(solved('scatter = { amplitude = "3 %", angle = "2 deg" }\n' + FAN)[0], width=100)
    assert "After (95 % band)" in shown
    assert "Angles of weights are counted against rotation from zero, which is at: reflective tape." in shown
    assert "The angle of a reading is how far the vibration lags the reference pulse." in shown


def test_rounding_is_shown_as_zero(solved: Answers) -> None:
    plan, _ = solved(FAN)
    assert verdict(plan) == "optimal: least root mean square of the residuals is 0 mil pp"


def test_an_infeasible_job_says_the_way_out_and_has_a_page_without_picture(solved: Answers) -> None:
    caps = FAN.replace('radius = "150 mm"', 'radius = "150 mm"\nweight = { from = "0 g", to = "3 g" }')
    plan, _ = solved(caps + '[limits.running]\nresponse = "residual"\nat_most = "0.5 mil pp"\n')
    assert verdict(plan) == "infeasible: no weights keep all limits"
    assert "Smallest loosening of one: running 0.5 mil pp -> 5.275 mil pp." in text_of(plan, width=100)
    assert figure_of(plan) is None
    assert "<svg" not in html(plan)


def test_planes_almost_alike_are_a_warning_above_what_is_to_do(solved: Answers) -> None:
    alike = FAN.replace("12 g @ 180 deg", "10 g @ 270 deg").replace("6.2 mil @ 36 deg", "5.901 mil @ 123 deg")
    alike = alike.replace("10.4 mil @ 162 deg", "4.501 mil @ 228 deg")
    plan, _ = solved(alike)
    titles = [one.title for one in blocks_of(plan)]
    assert titles[0] == "Warning"
    assert "Planes almost alike: the ways round, side by side" in titles
    assert '<p class="warning"><b>Warning.</b> Planes left and right act almost alike' in html(plan)


def test_two_answers_without_phase_ask_for_a_run_before_anything_is_fitted(solved: Answers) -> None:
    plan, _ = solved(
        '[conventions]\nangles = "with rotation"\ndetector = "rms"\nzero = "key"\n[planes.fan]\nradius = "200 mm"\n'
        '[[runs]]\nspeed = "1500 rpm"\nreadings = { a = "6 mm/s" }\n'
        '[[runs]]\nspeed = "1500 rpm"\nweights = { fan = "10 g @ 0 deg" }\nreadings = { a = "4.2 mm/s" }\n'
        '[[runs]]\nspeed = "1500 rpm"\nweights = { fan = "10 g @ 90 deg" }\nreadings = { a = "5.1 mm/s" }\n'
    )
    todo, either = blocks_of(plan)[:2]
    assert [line.split(" with ")[0] for line in todo.lines] == ["Make one more run"]
    assert [line.partition(":")[0] for line in either.lines] == ["Answer 1", "Answer 2"]
    assert figure_of(plan) is not None


@pytest.mark.parametrize(("angles", "sense"), [("with rotation", 1), ("against rotation", -1)])
def test_a_weight_is_drawn_at_the_angle_written_in_the_sense_of_the_file(
    solved: Answers, angles: str, sense: int
) -> None:
    plan, _ = solved(FAN.replace("against rotation", angles))
    drawn = disc(plan.job.conventions, plan.job.planes[0], plan.plan.planes[0])
    assert drawn.sense == sense
    assert drawn.spots[0].angle == pytest.approx(plan.plan.planes[0].angle.value)
    figure = figure_of(plan)
    assert figure is not None
    discs = [axes for axes in figure.axes if any(one.get_text() == "angles" for one in axes.texts)]
    [(x, y)] = [line.get_xydata()[0] for line in discs[0].lines if line.get_marker() == "o"]
    assert sense * atan2(-x, y) % tau == pytest.approx(plan.plan.planes[0].angle.value % tau)


def test_the_page_has_a_box_to_tick_an_empty_column_and_a_place_to_sign(solved: Answers) -> None:
    plan, _ = solved(FAN)
    page = html(plan, changes=["limits.x=1"], on=date(2025, 1, 2), sheet=True)
    assert page.count("<li>") == 3
    assert page.count('<td class="blank">') == 2
    for words in ("Fitted by (name)", "Date", "2025-01-02", "limits.x=1", "counted against rotation", "<svg"):
        assert words in page
    assert "http" not in page.partition("<svg")[0]


@pytest.mark.parametrize("name", ["shaft_holes", "rao_9_14_a", "engine_lanchester", "engine_phasing_four"])
@pytest.mark.parametrize("compact", [False, True])
def test_known_masses_and_engines_are_drawn(name: str, compact: bool) -> None:
    job = open_job(PROBLEMS / f"{name}.toml")
    assert not is_scene(job)
    found = answer(job)
    assert not is_rotor(found.job)
    assert figure_of(found, compact=compact) is not None
    if compact:
        assert "Done by (name)" in html(found, sheet=True)


def test_beside_a_trim_pictures_and_tables_say_that_they_show_the_whole_weight(solved: Answers) -> None:
    """Whoever fits a whole weight to what is on spoils the rotor."""
    text = (PROBLEMS / "fan_verification_run.toml").read_text(encoding="utf-8")
    trimmed, fresh = solved(text)[0], solved(text.replace("verification = true\n", ""))[0]
    titles = [block.title for block in blocks_of(trimmed)]
    assert "Whole weights, all others taken off" in titles
    assert "Weights" not in titles
    words = {}
    for name, plan in (("trimmed", trimmed), ("fresh", fresh)):
        figure = figure_of(plan)
        assert figure is not None
        [legend] = figure.legends
        words[name] = [one.get_text() for one in (legend.get_title(), *legend.get_texts())]
    assert "whole weight" in words["trimmed"]
    assert "fit here" not in words["trimmed"]
    assert "The discs show whole weights, all others taken off: the trim stands in the plan." in words["trimmed"][0]
    assert "fit here" in words["fresh"]
