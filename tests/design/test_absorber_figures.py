"""What is drawn and said of absorbers, against numbers found in other ways."""

from collections.abc import Callable
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

from texts import DAMPING_RATIO, absorber, best, swayed, table
from vibopt.answer.answer_page import html
from vibopt.report.absorber_parts import modes, parts_of, stroke_bars, strokes
from vibopt.report.adjust import adjusting
from vibopt.report.curves import panels
from vibopt.report.design_plane import Plane, absorbers_with_map, plane
from vibopt.report.figures import below, plane_figure, response_figure, saved
from vibopt.scene.read import from_text
from vibopt.scene.scene import Design
from vibopt.solve import solve

FAN = swayed(
    "fan", "1..60 Hz",
    absorber("tmd", "fan", None, mass_ratio=0.05, tuning="{ from = 0.7, to = 1.2 }", damping_ratio=DAMPING_RATIO),
    table("limits.travel", response="stroke", of="tmd", at_most="10 mm"),
    best(minimise="displacement", of="fan"), title="Fan",
)  # fmt: skip

SKID = """
title = "Skid"
[bodies.skid]
mass = "800 kg"
[links.mounts]
between = ["skid", "ground"]
stiffness = "95 MN/m"
damping_ratio = 0.01
[absorbers.low]
on = "skid"
mass = "9 kg"
frequency = "59 Hz"
damping_ratio = 0.02
[absorbers.high]
on = "low"
mass = "5 kg"
frequency = "46 Hz"
[excitations.grid50]
kind = "unbalance"
on = "skid"
unbalance = "2000 g mm"
speed = "2850..3000 rpm"
[excitations.grid60]
kind = "unbalance"
on = "skid"
unbalance = "2000 g mm"
speed = "3420..3600 rpm"
[limits.v60]
response = "velocity"
of = "skid"
due_to = ["grid60"]
at_most = "2.8 mm/s rms"
[limits.stroke_low]
response = "stroke"
of = "low"
due_to = ["grid60"]
at_most = "1 mm"
"""


@cache
def _solved(text: str) -> Design:
    return solve(from_text(text))


@pytest.fixture
def fan() -> Design:
    return _solved(FAN)


@cache
def mapped() -> Plane:
    """The map of the fan."""
    drawn = plane(_solved(FAN))
    assert drawn is not None
    return drawn


def amplitudes(tuning: float, damping: float, hertz: np.ndarray, stiffer: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Motion of the fan and stroke of its absorber [m], by the textbook's two equations."""
    w = 2.0 * np.pi * hertz
    m, k, ma = 100.0, 1e6, 5.0
    own = tuning * 100.0
    ka, ca = ma * own**2 * stiffer, 2.0 * damping * ma * own
    link = ka + 1j * w * ca
    absorber = link - ma * w**2
    fan = 100.0 * absorber / ((k - m * w**2) * absorber - ma * w**2 * link)
    moved = link / absorber * fan
    return np.abs(fan), np.abs(moved - fan)


def x_of(design: Design) -> tuple[float, float]:
    return design.x[0], design.x[1]


def test_the_goal_has_a_panel_with_the_machine_before_and_after(fan: Design) -> None:
    panel = panels(fan)[-1]
    assert panel.title == "Displacement of fan"
    after, before = panel.curves
    assert (after.label, after.before) == ("with absorbers", False)
    assert before.label == "without absorbers: worst infinite at 15.92 Hz"
    here = (before.x > 2.0) & (before.x < 14.0)
    alone = 1e3 * 100.0 / np.abs(1e6 - 100.0 * (2.0 * np.pi * before.x[here]) ** 2)
    assert before.y[here] == pytest.approx(alone, rel=1e-9)
    assert after.y == pytest.approx(1e3 * amplitudes(*x_of(fan), after.x)[0], rel=1e-9)


def test_the_equal_peaks_are_marked_where_a_fine_grid_has_them(fan: Design) -> None:
    panel = panels(fan)[-1]
    grid = np.linspace(5.0, 30.0, 400_001)
    y = 1e3 * amplitudes(*x_of(fan), grid)[0]
    tops = grid[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])]
    assert [one.x for one in panel.equal] == pytest.approx(tops.tolist(), rel=1e-4)
    assert all(one.y == pytest.approx(y.max(), rel=1e-3) for one in panel.equal)
    assert panel.equal[0].words == "0.6408 mm pk at 14.31 Hz"
    (mark,) = panel.marks
    assert mark.words.startswith("goal 0.6408 mm pk at ")


def test_a_stroke_has_no_before() -> None:
    drawn = {one.title: one for one in panels(_solved(SKID))}
    assert len(drawn["Stroke of low"].curves) == 1
    assert len(drawn["Velocity of skid"].curves) == 2


def test_the_map_has_level_lines_of_the_worst_amplitude(fan: Design) -> None:
    drawn = mapped()
    assert drawn.goal is not None
    assert drawn.levels
    assert drawn.goal_label == "equal displacement [mm], less is better"
    grid = np.linspace(1.0, 60.0, 60_001)
    for row, column in ((5, 10), (40, 30), (60, 60)):
        tuning, damping = float(drawn.x.values[column]), float(drawn.y.values[row])
        found = 1e3 * amplitudes(tuning, damping, grid)[0].max()
        assert drawn.goal[row, column] == pytest.approx(found, rel=1e-5)
    assert drawn.best == pytest.approx(x_of(fan))
    row, column = (
        int(np.argmin(np.abs(one.values - b))) for one, b in zip((drawn.y, drawn.x), drawn.best[::-1], strict=True)
    )
    assert drawn.goal[row, column] == pytest.approx(drawn.goal.min(), rel=1e-6)


def test_a_map_of_one_absorber_keeps_the_other_variables() -> None:
    text = FAN.replace("mass_ratio = 0.05", "mass_ratio = { from = 0.02, to = 0.05 }")
    design = _solved(text)
    assert plane(design) is None
    assert absorbers_with_map(design) == ["tmd"]
    drawn = plane(design, "tmd")
    assert drawn is not None
    assert drawn.x.label == "tuning of tmd"
    assert drawn.title == "Where every limit holds: absorber tmd (the other variable as chosen)"
    assert plane(_solved(SKID), "low") is None


def test_what_to_build_says_every_part(fan: Design) -> None:
    (part,) = parts_of(fan)
    tuning, damping = x_of(fan)
    values = {key: one.value for key, one in part.numbers.items()}
    own = 100.0 * tuning
    assert values == pytest.approx(
        {
            "mass": 5.0,
            "stiffness": 5.0 * own**2,
            "damping": 2.0 * damping * 5.0 * own,
            "own_frequency": own,
            "tuning": tuning,
            "damping_ratio": damping,
        }
    )
    assert part.words.startswith("on fan: mass 5 kg, stiffness 45.3")
    assert "What to build\n  tmd  on fan: mass 5 kg" in fan.report()
    assert fan.to_json()["build"]["tmd"]["numbers"]["mass"]["value"] == pytest.approx(5.0)


def test_the_adjusting_range_ends_where_the_goal_is_five_percent_worse(fan: Design) -> None:
    (one,) = adjusting(fan)
    grid = np.linspace(5.0, 30.0, 400_001)
    worst = amplitudes(*x_of(fan), grid)[0].max()
    for end, inside in ((one.low, 0.99), (one.high, 0.99)):
        assert end.because == "the goal"
        at = amplitudes(*x_of(fan), grid, 1.0 + end.stiffness)[0].max()
        assert at == pytest.approx(1.05 * worst, rel=1e-6)
        assert amplitudes(*x_of(fan), grid, 1.0 + inside * end.stiffness)[0].max() < 1.05 * worst
    # c stays as built, so a stiffer spring is less damped: the two ends differ
    assert one.words == "spring -1.54 % to +1.59 % (tuning -0.771 % to +0.791 %), ended by the goal"


def test_a_limit_at_its_bound_leaves_no_room() -> None:
    text = FAN.replace('minimise = "displacement"\nof = "fan"', 'minimise = "absorber_mass"')
    text = text.replace("mass_ratio = 0.05", "mass_ratio = { from = 0.001, to = 0.2 }")
    text += '\n[limits.shake]\nresponse = "displacement"\nof = "fan"\nat_most = "0.8 mm"\n'
    design = _solved(text)
    (one,) = adjusting(design)
    assert one.broken_by == 0.05
    assert one.words.startswith("no room, shake at the bound; spring -")
    assert one.words.endswith("breaks it by 5 %")


def test_strokes_are_those_of_the_equations(fan: Design) -> None:
    (bar,) = stroke_bars(fan)
    found = amplitudes(*x_of(fan), np.linspace(1.0, 60.0, 600_001))[1].max()
    assert bar.value == pytest.approx(found, rel=1e-8)
    assert bar.limit == 0.01
    drawn = strokes(fan)
    assert drawn is not None
    assert drawn.label == "stroke [mm pk]"
    assert drawn.words == ("2.167 mm pk at 16.42 Hz",)


def test_every_absorber_has_a_bar_for_each_excitation() -> None:
    bars = stroke_bars(_solved(SKID))
    assert [(one.absorber, one.excitation, one.limit) for one in bars] == [
        ("low", "grid50", None),
        ("low", "grid60", 0.001),
        ("high", "grid50", None),
        ("high", "grid60", None),
    ]


def test_modes_stand_in_the_unit_of_the_speeds() -> None:
    drawn = modes(_solved(SKID))
    assert drawn is not None
    assert drawn.label == "natural frequency [rpm]"
    assert drawn.before == pytest.approx([np.sqrt(95e6 / 800.0) * 30.0 / np.pi])
    k1, k2 = 9.0 * (118.0 * np.pi) ** 2, 5.0 * (92.0 * np.pi) ** 2
    mass = np.diag([800.0, 9.0, 5.0])
    stiffness = np.array([[95e6 + k1, -k1, 0.0], [-k1, k1 + k2, -k2], [0.0, -k2, k2]])
    found = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)) * 30.0 / np.pi
    assert drawn.after == pytest.approx(found.tolist())
    assert [one.words for one in drawn.bands] == ["grid50 2850 to 3000 rpm", "grid60 3420 to 3600 rpm"]


@pytest.mark.parametrize("text", [FAN, pytest.param(SKID, marks=pytest.mark.slow)], ids=["fan", "skid"])
def test_the_whole_figure_is_the_same_every_time(text: str) -> None:
    design = _solved(text)

    def drawn() -> bytes:
        return saved(response_figure(panels(design), "title", below(design)), "svg")

    ElementTree.fromstring(drawn())
    assert drawn() == drawn()


def test_the_map_is_drawn_the_same_every_time() -> None:
    one, two = (saved(plane_figure(mapped()), "svg") for _ in range(2))
    assert one == two


def test_the_page_has_the_parts_and_the_figures(fan: Design) -> None:
    page = html(fan, also=[("What to build", [("tmd", "twice")]), ("What if", [("tmd lost", "trouble")])])
    assert page.count("<figure>") == 6
    assert "trouble" in page
    assert "twice" not in page
    assert "on fan: mass 5 kg" in page
    assert "absorbers.tmd" in page


def test_without_absorbers_nothing_is_said_of_them(solved: Callable[[str], Design]) -> None:
    design = solved("rao_9_34")
    assert parts_of(design) == ()
    assert adjusting(design) == ()
    assert strokes(design) is None
    assert modes(design) is None
    assert below(design) == []
    assert "build" not in design.to_json()


def test_an_excitation_of_another_machine_has_no_bar() -> None:
    other = '[bodies.other]\nmass = "1 kg"\n[links.far]\nbetween = ["other", "ground"]\nstiffness = "1 kN/m"\n'
    push = '[excitations.away]\nkind = "force"\non = "other"\namplitude = "1 N"\nspeed = "1..60 Hz"\n'
    text = FAN.replace("[excitations.push]", f"{other}{push}[excitations.push]")
    text = text.replace('of = "tmd"\n', 'of = "tmd"\ndue_to = ["push"]\n')
    text = text.replace(
        'minimise = "displacement"\nof = "fan"\n', 'minimise = "displacement"\nof = "fan"\ndue_to = ["push"]\n'
    )
    assert [one.excitation for one in stroke_bars(_solved(text))] == ["push"]


def test_a_spring_that_must_be_exact_is_said() -> None:
    text = FAN.replace('"1..60 Hz"', '"16 Hz"').replace("damping_ratio = { from = 0.01, to = 0.5 }\n", "")
    said = [one.words for one in adjusting(_solved(text))]
    assert said == ["no room at all: the goal does not hold, or is zero and grows with the least drift"]
