"""Every picture can be read: words cover neither each other nor holes and spokes."""

from math import tau
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from pictures import covered, struck

from vibopt.arrays import FloatArray
from vibopt.balancing.figures import figure_of
from vibopt.balancing.figures.dials import Dial, Disc, Phasor, Spot, rows_of
from vibopt.balancing.figures.drawing import page
from vibopt.balancing.figures.rotor_figure import beside_each_other
from vibopt.jobs import answer, is_scene, open_job
from vibopt.report.curves import panels
from vibopt.report.figures import response_figure
from vibopt.report.figures.canvas import spread
from vibopt.report.figures.paper import WIDTH, legend, sheet
from vibopt.report.machine_parts import sketch_of
from vibopt.report.series import Panel
from vibopt.report.sketch import levels
from vibopt.report.space_views import MOUNT, machine_figure, views_figure
from vibopt.scene.read import from_dict
from vibopt.verify.as_built import machine_of

PROBLEMS = Path(__file__).parents[2] / "problems"
BALANCING = sorted((PROBLEMS / "balancing").glob("*.toml"))
MACHINES = sorted(one for one in PROBLEMS.rglob("*.toml") if "balancing" not in one.parts)
QUICK = ("assignment_2", "engine_lanchester", "engine_v_twin", "feese_two_speeds", "shaft_three_planes")


def slower(files: list[Path]) -> list[object]:
    """All files, those that are not quick only on demand."""
    return [pytest.param(one, id=one.stem, marks=() if one.stem in QUICK else pytest.mark.slow) for one in files]


@st.composite
def discs(draw: st.DrawFn) -> list[Disc]:
    """One to four planes of 3 to 36 holes with up to six weights in them."""
    found = []
    for k in range(draw(st.integers(1, 4))):
        count = draw(st.integers(3, 36))
        taken = draw(st.lists(st.integers(0, count - 1), max_size=min(count, 6), unique=True))
        grams = draw(st.lists(st.floats(0.01, 9999.0), min_size=len(taken), max_size=len(taken)))
        spots = [
            Spot(tau * hole / count, f"{mass:.4g} g\nhole {hole + 1}\n{360.0 * hole / count:.4g}°")
            for hole, mass in zip(taken, grams, strict=True)
        ]
        holes = tuple(tau * hole / count for hole in range(count))
        found.append(Disc(f"Plane {k}", draw(st.sampled_from((1, -1))), tuple(spots), holes))
    return found


@given(discs(), st.integers(2, 4))
@settings(max_examples=12)
def test_weights_in_holes_cover_no_words_no_holes_and_no_spokes(shown: list[Disc], columns: int) -> None:
    figure = page(rows_of(shown, columns, WIDTH), "Title")
    assert covered(figure) == []
    assert struck(figure, "hole") == []
    assert struck(figure, "spoke") == []


ANGLES = st.floats(0.0, tau)


@given(st.lists(st.tuples(ANGLES, st.floats(0.35, 1.0), st.text("abcdefgh_0123456789", min_size=1, max_size=14)),
                min_size=1, max_size=10))  # fmt: skip
@settings(max_examples=12)
def test_masses_anywhere_on_a_disc_have_their_names_beside_it(given_: list[tuple[float, float, str]]) -> None:
    shown = Disc(
        "Known masses", 1, tuple(Spot(angle, name, "there", part) for angle, part, name in given_), turns=False
    )
    figure = page(rows_of([shown], 3, WIDTH), "")
    assert covered(figure) == []


@given(st.lists(st.tuples(ANGLES, st.floats(0.1, 10.0), ANGLES, st.floats(0.0, 10.0)), min_size=1, max_size=6))
@settings(max_examples=12)
def test_readings_at_several_speeds_are_told_apart(given_: list[tuple[float, float, float, float]]) -> None:
    phasors = tuple(Phasor(f"{1800 + 300 * k} rpm", (a, b), (c, d)) for k, (b, a, d, c) in enumerate(given_))
    assert covered(page(rows_of([Dial("Sensor a [mil pp]", 1, phasors)] * 2, 2, WIDTH), "")) == []


@given(st.lists(st.tuples(st.floats(-5.0, 5.0), st.floats(0.1, 2.0)), max_size=8))
def test_boxes_spread_apart_touch_nowhere_and_stay_where_there_is_room(given_: list[tuple[float, float]]) -> None:
    ordered = sorted(given_, key=lambda one: -one[0])
    wanted, tall = [one for one, _ in ordered], [one for _, one in ordered]
    found = spread(wanted, tall)
    for k in range(1, len(found)):
        assert found[k - 1] - found[k] >= 0.5 * (tall[k - 1] + tall[k]) - 1e-9
    if all(wanted[k - 1] - wanted[k] >= 0.5 * (tall[k - 1] + tall[k]) for k in range(1, len(wanted))):
        assert found == pytest.approx(wanted)


SKETCHED = ("footbridge_marching", "frame_three_storeys", "generator_set", "rao_9_58", "pump_with_inerter")


@pytest.mark.parametrize(
    "file", [pytest.param(one, id=one.stem, marks=() if one.stem in SKETCHED else pytest.mark.slow) for one in MACHINES]
)
def test_no_words_of_a_sketch_cover_others(file: Path) -> None:
    job = open_job(file)
    assert is_scene(job)
    found = answer(job)
    figure = machine_figure(found, found.title)
    if figure is not None:
        assert covered(figure) == []


@pytest.mark.parametrize("file", slower(BALANCING))
def test_no_words_of_a_balancing_picture_cover_others(file: Path) -> None:
    job = open_job(file)
    assert not is_scene(job)
    found = answer(job)
    for compact in (False, True):
        figure = figure_of(found, compact=compact)
        if figure is not None:
            assert covered(figure) == []
            assert struck(figure, "spoke") == []


@pytest.mark.parametrize("planes", range(1, 7))
@pytest.mark.parametrize("sensors", range(1, 9))
def test_planes_and_sensors_are_drawn_beside_each_other(planes: int, sensors: int) -> None:
    above, below = beside_each_other(planes, sensors)
    assert (len(above), len(below)) == (planes, sensors)
    assert below == sorted(below)
    assert all(0.0 < one < 1.0 for one in below)
    assert min(abs(one - other) for one in above for other in below) >= 0.03


STACK = {
    "bodies": {
        name: {"mass": "500 kg", "centre": ["0 m", "0 m", z], "inertia": ["90 kg m2", "90 kg m2", "90 kg m2"]}
        for name, z in (("set", "0.9 m"), ("block", "0.3 m"))
    },
    "mounts": {
        name: {
            "between": two,
            "at": [[f"{x} m", f"{y} m", z] for x in (-0.6, 0.6) for y in (-0.4, 0.4)],
            "stiffness": "1 MN/m",
            "shear_ratio": 0.5,
        }
        for name, two, z in (("pad", ["set", "block"], "0.5 m"), ("foot", ["block", "ground"], "0 m"))
    },
    "excitations": {"it": {"kind": "force", "on": "set", "amplitude": "1 N", "direction": "x", "speed": "900 rpm"}},
    "measures": {"first": {"response": "natural_frequency"}},
}  # fmt: skip


def test_mounts_stand_between_bodies_and_on_ground() -> None:
    """From the front and from the side no mount is inside a body, and under the lowest there is ground."""
    scene = from_dict(STACK)
    figure = views_figure(machine_of(scene, {}), scene)
    assert figure is not None
    assert covered(figure) == []
    for axes in figure.axes[1:3]:
        boxes = [one.get_xy() for one in axes.patches if len(one.get_xy()) == 5]
        assert len(boxes) == 2
        marks = [one for one in axes.lines if one.get_marker() in ("o", "s") and len(one.get_xdata()) == 4]
        heights = {float(y) for one in marks for y in one.get_ydata()}
        assert len(heights) == 2
        assert not any(box[:, 1].min() <= y <= box[:, 1].max() for box in boxes for y in heights)
        ground = [one for one in axes.lines if one.get_linewidth() == 1.2]
        assert {float(one.get_ydata()[0]) for one in ground} == {min(heights) - MOUNT}


def test_a_sketch_says_how_many_and_what_each_is() -> None:
    link = {"between": ["fan", "ground"], "stiffness": "80 kN/m", "damping_ratio": 0.05, "count": 4}
    limit = {"response": "transmitted_force", "into": "ground", "at_most": "3 N"}
    force = {"kind": "force", "on": "fan", "amplitude": "1 N", "speed": "900 rpm"}
    scene = from_dict(
        {"bodies": {"fan": {"mass": "90 kg"}}, "links": {"feet": link}, "excitations": {"it": force},
         "limits": {"floor": limit}}
    )  # fmt: skip
    sketch = sketch_of(answer(scene))
    assert [one.words for one in sketch.links] == ["feet\n4 x 80 kN/m each\ndamping ratio 0.05"]
    figure = machine_figure(answer(scene))
    assert figure is not None
    assert [one for one in figure.axes[-1].lines if one.get_marker() == "o"], "no circle on the ground"


def test_a_crank_is_drawn_with_its_counterweight_opposite() -> None:
    """The web of a counterweight lies a half turn from its pin."""
    figure = figure_of(answer(open_job(PROBLEMS / "balancing" / "engine_v_twin.toml")))
    assert figure is not None
    [wedge] = [one for one in figure.axes[0].patches if one.get_hatch() == "...."]
    assert wedge.get_xy()[:, 1].min() < -0.2
    assert wedge.get_xy()[:, 1].max() == pytest.approx(0.0)


SEEN = ("press_on_rubber", "footbridge_detuned", "rao_9_34", "rao_9_39", "rao_9_35")


def off_the_curve(figure: Any, drawn: list[Panel]) -> list[tuple[str, float]]:
    """Marks farther than two pixels from every curve of their panel, or below a least by as much."""
    figure.draw_without_rendering()
    axes = list(figure.findobj(Axes))[: len(drawn)]
    found = []
    for each, panel in zip(axes, drawn, strict=True):
        lines = [each.transData.transform(np.column_stack([one.x, one.y])) for one in panel.curves]
        for mark in panel.marks:
            if not panel.y_span[0] <= mark.y <= panel.y_span[1]:
                continue  # shown at the edge of the paper, as an arrow
            point = each.transData.transform((mark.x, mark.y))
            known = [line[np.isfinite(line).all(axis=1)] for line in lines]
            if [one.label for one in panel.curves] == ["least that any isolator could reach"]:
                gap = float(np.interp(point[0], *known[0].T) - point[1])
            else:
                gap = min(_distance(point, line) for line in known)
            found += [(mark.words, gap)] if gap > 2.0 else []
    return found


def _distance(point: FloatArray, line: FloatArray) -> float:
    """Pixels from a point to a polyline."""
    start, step = line[:-1], np.diff(line, axis=0)
    part = ((point - start) * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-300)
    nearest = start + np.clip(part, 0.0, 1.0)[:, None] * step
    return float(np.hypot(*(nearest - point).T).min())


@pytest.mark.parametrize(
    "file", [pytest.param(one, id=one.stem, marks=() if one.stem in SEEN else pytest.mark.slow) for one in MACHINES]
)
def test_the_worst_lies_on_a_curve_that_is_drawn(file: Path) -> None:
    """With tolerances that is the curve of the worst machine."""
    job = open_job(file)
    assert is_scene(job)
    drawn = panels(answer(job))
    if drawn:
        assert off_the_curve(response_figure(drawn), drawn) == []


@pytest.mark.parametrize(
    "words", [("of b", "of c"), ("without absorbers of b0: worst 0.0003569 m/s² pk at 27.07 rad/s",) * 2]
)
def test_a_legend_stays_on_the_paper_however_long_its_words(words: tuple[str, str]) -> None:
    """Two beside each other where there is room, else below each other, and lines broken."""
    for longer in (1, 3):
        figure = sheet(WIDTH, 4.0)
        axes = figure.subplots()
        for index, one in enumerate(words):
            axes.plot([0.0, 1.0], [0.0, 1.0], label=" ".join([one] * longer) + f" {index}")
        legend(figure, axes)
        figure.draw_without_rendering()
        [made] = figure.legends
        box = made.get_window_extent()
        assert 0.0 <= box.x0 < box.x1 <= figure.bbox.width


def test_what_is_asked_at_standstill_alone_is_drawn_up_to_the_first_resonance() -> None:
    still = {
        "bodies": {"press": {"mass": "500 kg"}},
        "links": {"mount": {"between": ["press", "ground"], "stiffness": "45 kN/m"}},
        "excitations": {"held": {"kind": "force", "on": "press", "amplitude": "500 N", "speed": "0 rpm"}},
        "measures": {"deflection": {"response": "displacement", "of": "press"}},
    }
    [panel] = panels(answer(from_dict(still)))
    first = np.sqrt(45e3 / 500.0) * 30.0 / np.pi
    assert panel.x_span == pytest.approx((0.0, 1.3 * first))
    assert off_the_curve(response_figure([panel]), [panel]) == []


def test_gears_stand_between_the_bodies_that_they_join() -> None:
    """What is driven hangs on what drives it, and two circles touch between them."""
    line = {
        "bodies": {
            "engine": {"inertia": "2 kg m2"},
            "wheel": {"inertia": "3 kg m2", "geared_to": "engine", "speed_ratio": -0.5},
        },
        "links": {"brake": {"between": ["wheel", "ground"], "torsional_stiffness": "9 kN m/rad"}},
        "measures": {"first": {"response": "natural_frequency"}},
    }
    design = answer(from_dict(line))
    assert levels(sketch_of(design)) == {"ground": 0, "wheel": 1, "engine": 2}
    figure = machine_figure(design)
    assert figure is not None
    assert covered(figure) == []
    words = [one.get_text() for one in figure.axes[-1].texts]
    assert "gears\nwheel turns -0.5 x" in words
    first, second = (
        one.get_xy() for one in figure.axes[-1].patches if isinstance(one, Polygon) and len(one.get_xy()) > 9
    )
    assert np.ptp(first, axis=0) == pytest.approx(np.ptp(second, axis=0))
    assert min(abs(first[:, 1].min() - second[:, 1].max()), abs(second[:, 1].min() - first[:, 1].max())) < 1e-9
