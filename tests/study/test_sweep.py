"""Sweeps answer many points together; each is what the scene alone would have been answered."""

# ruff: noqa: E501 - one scene a line
from __future__ import annotations

from importlib import import_module
from math import inf, isfinite
from pathlib import Path

import numpy as np
import pytest

from vibopt.errors import InputError
from vibopt.report.figures import strips_figure
from vibopt.scene.read import from_text, read
from vibopt.scene.scene import Scene
from vibopt.study.points import Points
from vibopt.study.sweep import Sweep, sweep
from vibopt.study.sweep_series import strips

FILE = "problems/isolation/rao_9_34.toml"
SAME = 1e-9

FORCE = """
[bodies.press]
mass = "300 kg"
[links.mount]
between = ["press", "ground"]
{mount}
[excitations.press]
kind = "{kind}"
on = "press"
{shaken}
speed = "{speed}"
{more}
"""
BASE = """
[bodies.unit]
mass = "25 kg"
[bases.floor]
[links.mount]
between = ["unit", "floor"]
{mount}
[excitations.floor]
kind = "base_motion"
on = "floor"
{shaken}
speed = "{speed}"
{more}
"""
BOTH = 'stiffness = { from = "1 kN/m", to = "100 MN/m" }\ndamping = { from = "1 N s/m", to = "1 MN s/m" }'
TIED = 'stiffness = { from = "1 kN/m", to = "100 MN/m" }\ndamping_ratio = 0.08'
LOSSY = 'stiffness = { from = "1 kN/m", to = "100 MN/m" }\nloss_factor = 0.1'
HELD = 'stiffness = { from = "1 kN/m", to = "100 MN/m" }\ndamping = "900 N s/m"'
DAMPER = 'stiffness = "4 MN/m"\ndamping = { from = "1 N s/m", to = "1 MN s/m" }'
UNDAMPED = 'stiffness = { from = "1 kN/m", to = "100 MN/m" }'


FLAT = ("sag",)
"""Here the peak is level with a limit at speed zero: rounding alone leaves the damping free in its fifth digit."""

BOUGHT = """
[bodies.comp]
mass = "260 kg"
[links.feet]
between = ["comp", "ground"]
part = { catalogue = "feet.csv" }
count = 4
[excitations.rotor]
kind = "unbalance"
on = "comp"
unbalance = "20 kg mm"
speed = "1480 rpm"
[goal]
minimise = "transmitted_force"
into = "ground"
"""


def limit(name: str, response: str, bound: str) -> str:
    return f'[limits.{name}]\nresponse = "{response}"\n{bound}\n'


def goal(sense: str, what: str, of: str = 'of = "mount"') -> str:
    return f'[goal]\n{sense} = "{what}"\n{of}\n'


FLOOR = limit("floor", "transmitted_force", 'into = "ground"\nat_most = "9 kN"')
RUN_UP = limit("run_up", "displacement", 'of = "press"\nover = "start-up"\nat_most = "20 mm"')
FAST = limit("fast", "acceleration", 'of = "press"\nover = "500..3000 rpm"\nat_most = "120 m/s^2"')
STIFF = goal("maximise", "stiffness")
UNBALANCE = {"kind": "unbalance", "shaken": 'unbalance = "0.3 kg m"', "speed": "3000 rpm"}
CONSTANT = {"kind": "force", "shaken": 'amplitude = "30 kN"\nvaries = "constant"', "speed": "3000 rpm"}
SHAKEN = {"shaken": 'displacement = "0.5 mm"\nvaries = "constant"', "speed": "5..60 Hz"}
SECOND = '[links.pipe]\nbetween = ["press", "ground"]\nstiffness = "80 kN/m"\n'

SCENES: dict[str, tuple[str, str, str]] = {
    "both": (FORCE.format(mount=BOTH, **CONSTANT, more=FLOOR + RUN_UP + STIFF), "bodies.press.mass", "250 kg..400 kg"),
    "speed": (FORCE.format(mount=BOTH, **CONSTANT, more=FLOOR + RUN_UP + STIFF), "excitations.press.speed", "1500..4000 rpm"),
    "unbalance": (
        FORCE.format(mount=BOTH, **UNBALANCE, more=FLOOR + RUN_UP + FAST + STIFF),
        "excitations.press.unbalance",
        "0.1 kg m..0.6 kg m",
    ),
    "force on the way up": (
        FORCE.format(mount=BOTH, **UNBALANCE, more=limit("f", "transmitted_force", 'into = "ground"\nover = "0..3000 rpm"\nat_most = "9 kN"') + STIFF),
        "limits.f.at_most",
        "3 kN..60 kN",
    ),
    "least damping": (
        FORCE.format(mount=BOTH, **CONSTANT, more=FLOOR + RUN_UP + goal("minimise", "damping")),
        "limits.run_up.at_most",
        "10 mm..40 mm",
    ),
    "most damping": (
        FORCE.format(mount=BOTH, **CONSTANT, more=FLOOR + RUN_UP + goal("maximise", "damping")),
        "limits.floor.at_most",
        "2 kN..29 kN",
    ),
    "frequency": (
        FORCE.format(
            mount=BOTH,
            **CONSTANT,
            more=RUN_UP
            + limit("soft", "natural_frequency", 'at_most = "20 Hz"')
            + limit("calm", "damping_ratio", "at_least = 0.1")
            + STIFF,
        ),
        "limits.calm.at_least",
        "0.05..0.4",
    ),
    "sag": (
        FORCE.format(
            mount=BOTH,
            **CONSTANT,
            more=RUN_UP + limit("sag", "static_deflection", 'of = "mount"\nat_most = "2 mm"') + goal("minimise", "stiffness"),
        ),
        "limits.sag.at_most",
        "0.1 mm..20 mm",
    ),
    "two links": (
        FORCE.format(mount=BOTH, **CONSTANT, more=SECOND + FLOOR + RUN_UP + STIFF),
        "links.pipe.stiffness",
        "10 kN/m..900 kN/m",
    ),
    "tied": (FORCE.format(mount=TIED, **CONSTANT, more=FLOOR + STIFF), "links.mount.damping_ratio", "0.01..0.3"),
    "lossy": (FORCE.format(mount=LOSSY, **CONSTANT, more=FLOOR + STIFF), "links.mount.loss_factor", "0.01..0.3"),
    "held": (FORCE.format(mount=HELD, **CONSTANT, more=FLOOR + STIFF), "links.mount.damping", "100 N s/m..9 kN s/m"),
    "damper": (FORCE.format(mount=DAMPER, **CONSTANT, more=RUN_UP + goal("minimise", "damping")), "links.mount.stiffness", "1 MN/m..9 MN/m"),
    "undamped": (FORCE.format(mount=UNDAMPED, **CONSTANT, more=FLOOR + STIFF), "limits.floor.at_most", "1 kN..40 kN"),
    "isolation": (
        FORCE.format(mount=BOTH, **CONSTANT, more=limit("i", "isolation", 'into = "ground"\nat_least = "60 %"') + RUN_UP + STIFF),
        "limits.i.at_least",
        "50 %..95 %",
    ),
    "base": (
        BASE.format(
            mount=BOTH,
            **SHAKEN,
            more=limit("motion", "displacement", 'of = "unit"\nat_most = "0.9 mm"')
            + limit("shock", "acceleration", 'of = "unit"\nover = "30..60 Hz"\nat_most = "4 m/s^2"')
            + STIFF,
        ),
        "limits.shock.at_most",
        "1 m/s^2..30 m/s^2",
    ),
    "rattle": (
        BASE.format(
            mount=BOTH,
            **SHAKEN,
            more=limit("rattle", "relative_displacement", 'across = "mount"\nat_most = "1.2 mm"')
            + limit("into", "transmitted_force", 'into = "floor"\nat = "60 Hz"\nat_most = "90 N"')
            + STIFF,
        ),
        "excitations.floor.displacement",
        "0.1 mm..0.8 mm",
    ),
    "tied base": (
        BASE.format(mount=TIED, **SHAKEN, more=limit("t", "transmissibility", 'of = "unit"\nover = "20..60 Hz"\nat_most = 0.5') + STIFF),
        "limits.t.at_most",
        "0.1..3",
    ),
    "bands that move": (
        BASE.format(
            mount=TIED,
            **SHAKEN,
            more=limit("t", "acceleration", 'of = "unit"\nat_most = "5 m/s^2"') + STIFF,
        ).replace('kind = "base_motion"', 'kind = "road"').replace('displacement = "0.5 mm"\nvaries = "constant"', 'amplitude = "50 mm"\nwavelength = "5 m"').replace('"5..60 Hz"', '"60..120 km/h"'),
        "excitations.floor.wavelength",
        "2 m..20 m",
    ),
    "amplifier": (
        FORCE.format(mount=TIED, **CONSTANT, more=limit("a", "transmissibility", 'into = "ground"\nat_least = 2') + goal("minimise", "stiffness")),
        "limits.a.at_least",
        "1.2..9",
    ),
    "levels": (
        FORCE.format(mount=TIED, **CONSTANT, more=limit("a", "transmissibility", 'into = "ground"\nat_least = "6 dB"') + goal("minimise", "stiffness")),
        "limits.a.at_least",
        "2..19 dB",
    ),
}  # fmt: skip


def alone(scene: Scene, path: str, low_high: str, points: int, keep: bool, monkeypatch: pytest.MonkeyPatch) -> Sweep:
    """The same sweep, one point after the other."""
    with monkeypatch.context() as patch:
        patch.setattr(import_module("vibopt.study.many"), "FEWEST_TOGETHER", inf)
        return sweep(scene, path, low_high, points, keep_design=keep)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("keep", [False, True], ids=["chosen", "kept"])
@pytest.mark.parametrize("name", SCENES)
def test_points_answered_together_are_those_answered_alone(
    name: str, keep: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, path, low_high = SCENES[name]
    scene = from_text(text)
    many = sweep(scene, path, low_high, 40, keep_design=keep)
    assert isinstance(many.points, Points)
    ends = [variable.high for variable in scene.variables] if scene.goal and not keep else []
    told = [[one.value for one in point.variables.values()] for point in many.points.single.values()]
    rest = sum(not any(np.isclose(value, ends).any() for value in values) for values in told)
    assert rest < 12, "these points were not answered together"  # the goal says not all of a design at its end
    for together, one in zip(many.points, alone(scene, path, low_high, 40, keep, monkeypatch).points, strict=True):
        assert together.status == one.status
        assert together.value == one.value
        assert together.variables.keys() == one.variables.keys()
        near = 1e-4 if name in FLAT else SAME
        for key, value in one.variables.items():
            assert together.variables[key].value == pytest.approx(value.value, rel=near)
        assert together.margins == pytest.approx(dict(one.margins), rel=near, abs=near)
        assert (together.goal is None) == (one.goal is None)
        if together.goal is not None and one.goal is not None:
            assert together.goal.value == pytest.approx(one.goal.value, rel=SAME)
        assert list(together.results) == list(one.results)
        assert [worst.value for worst in together.results.values()] == pytest.approx(
            [worst.value for worst in one.results.values()], rel=near
        )


def test_points_with_tables_of_amplitudes_are_answered_one_by_one() -> None:
    table = {**CONSTANT, "shaken": 'amplitude = "30 kN"\nvaries = [["0 rpm", 0.2], ["3000 rpm", 1.0]]'}
    scene = from_text(FORCE.format(mount=BOTH, **table, more=FLOOR + STIFF))
    found = sweep(scene, "limits.floor.at_most", "5 kN..10 kN", 14)
    assert isinstance(found.points, Points)
    assert len(found.points.single) == 14
    assert found.complete


def test_points_can_be_counted_sliced_and_read_from_the_end() -> None:
    found = sweep(read(FILE), "limits.start_up.at_most", "5 mm..30 mm", 100)
    assert len(found.points) == 100
    assert found.points[-1].value.shown == "30 mm pk"
    assert [one.value for one in found.points[10:13]] == [found.points[index].value for index in (10, 11, 12)]
    with pytest.raises(IndexError):
        found.points[100]


def test_a_sweep_over_the_edge_of_feasibility_says_so_on_both_sides() -> None:
    found = sweep(read(FILE), "limits.start_up.at_most", "5 mm..30 mm", 400)
    words = [point.status for point in found.points]
    edge = words.index("optimal")
    assert words == ["infeasible"] * edge + ["optimal"] * (400 - edge)
    assert 0 < edge < 400
    assert found.complete


def test_a_kept_design_breaks_its_limit_where_the_limit_falls_below_it() -> None:
    found = sweep(read(FILE), "limits.start_up.at_most", "10 mm..30 mm", 21, keep_design=True)
    assert [point.status for point in found.points] == ["violated"] * 10 + ["met"] * 11
    assert found.points[0].variables == {}
    assert found.points[20].margins["start_up"] == pytest.approx(1.0 / 3.0, rel=1e-9)


@pytest.mark.parametrize("points", [6, 26], ids=["one by one", "together"])
def test_a_range_in_decibels_is_evenly_spaced_in_decibels(points: int) -> None:
    found = sweep(from_text(SCENES["levels"][0]), "limits.a.at_least", "0.1 dB..30.1 dB", points)
    assert [point.value.shown for point in found.points[:: (points - 1) // 5]] == [f"{n}.1 dB" for n in range(0, 31, 6)]
    drawn = strips(found)
    swept = [0.1 + 30 * n / (points - 1) for n in range(points)]
    assert all(min(abs(drawn.x - one)) <= 1e-9 for one in swept)
    assert all(min(abs(drawn.x - mark)) <= 1e-4 for mark, _ in drawn.marks)
    assert (drawn.x_label, drawn.log_x) == ("limit a, at least [dB]", False)
    ((low, high, words),) = drawn.shaded
    assert 12.0 < low < high == pytest.approx(30.1)
    assert words == "no design meets all limits"
    strips_figure(drawn)


def test_a_range_over_a_factor_of_more_than_a_hundred_has_equal_ratios() -> None:
    found = sweep(read(FILE), "limits.start_up.at_most", "0.1 mm..100 mm", 4)
    assert [point.value.shown for point in found.points] == ["0.1 mm pk", "1 mm pk", "10 mm pk", "100 mm pk"]
    assert strips(found).log_x


def test_the_unit_of_the_range_is_the_unit_of_the_points() -> None:
    scene = from_text(SCENES["levels"][0])
    assert strips(sweep(scene, "limits.a.at_least", "120 %..300 %", 3)).x_label == "limit a, at least [%]"
    with pytest.raises(InputError, match=r'"0 %\.\.6 dB" begins at a ratio that has no dB\. Write "5 dB\.\.30 dB"\.'):
        sweep(scene, "limits.a.at_least", "0 %..6 dB", 3)


def test_a_goal_in_decibels_is_drawn_in_decibels() -> None:
    goal_in_db = """
[goal]
minimise = "transmissibility"
into = "ground"
unit = "dB"
"""
    scene = from_text(FORCE.format(mount=TIED, **CONSTANT, more=FLOOR + goal_in_db))
    found = sweep(scene, "bodies.press.mass", "200 kg..400 kg", 3)
    strip = strips(found).strips[0]
    assert strip.label.endswith("[dB]")
    for point, y in zip(found.points, strip.lines[0].y, strict=True):
        assert point.goal is not None
        assert float(point.goal.shown.removesuffix(" dB")) == pytest.approx(y, rel=1e-3)


def test_of_a_bought_part_only_numbers_of_the_machine_are_drawn(tmp_path: Path) -> None:
    (tmp_path / "feet.csv").write_text(
        "part,rated load min [N],rated load max [N],stiffness [N/mm],dynamic to static,loss factor,price [EUR]\n"
        "C40,200,700,80,1.3,0.08,12.50\nC55,300,1100,150,1.4,0.10,14.00\n"
    )
    (tmp_path / "iso.toml").write_text(BOUGHT)
    found = sweep(read(tmp_path / "iso.toml"), "excitations.rotor.speed", "1200 rpm..1800 rpm", 2)
    labels = [one.label.split("\n")[0] for one in strips(found).strips]
    assert labels == ["transmitted force into ground", "stiffness of feet", "loss factor of feet"]
    assert all(isfinite(y) for one in strips(found).strips for line in one.lines for y in line.y)


def test_an_unreadable_range_is_refused_in_words() -> None:
    with pytest.raises(InputError, match=r'"30 mm" is no range\. Write "5 mm\.\.30 mm", a list "10, 12, 15 mm",'):
        sweep(read(FILE), "limits.start_up.at_most", "30 mm")
    with pytest.raises(InputError, match=r"sweep over \['bodies'\]: write a path and its range, or"):
        sweep(read(FILE), ["bodies"])
    with pytest.raises(InputError, match=r"--points 1 is not between 2 and 100000\."):
        sweep(read(FILE), "limits.start_up.at_most", "5 mm..30 mm", 1)


def test_no_words_are_looked_for_that_no_point_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> str:
        raise AssertionError("a sweep shows no reasons")

    for words in ("hopeless_words", "physical_words"):
        monkeypatch.setattr(import_module("vibopt.solve.impasse"), words, never)
    found = sweep(read(FILE), "limits.start_up.at_most", "5 mm..6 mm", 3)
    assert [point.status for point in found.points] == ["infeasible"] * 3


def test_a_machine_that_is_only_measured_is_swept_by_its_measures() -> None:
    text = FORCE.format(
        mount='stiffness = "1 MN/m"\ndamping = "5 kN s/m"',
        kind="force",
        shaken='amplitude = "30 kN"\nvaries = "constant"',
        speed="3000 rpm",
        more="",
    )
    text += '[measures.floor]\nresponse = "transmitted_force"\ninto = "ground"\n[measures.own]\nresponse = "natural_frequency"\n'
    found = sweep(from_text(text), "links.mount.stiffness", "0.1 MN/m..4 MN/m", points=40)
    drawn = strips(found)
    assert [strip.label for strip in drawn.strips] == ["floor\n[kN]", "own\n[Hz]"]
    stiffness, omega = np.array([point.value.value for point in found.points]), 100.0 * np.pi
    moved = 30e3 / np.abs(stiffness - 300.0 * omega**2 + 5e3j * omega)
    assert drawn.strips[0].lines[0].y == pytest.approx(1e-3 * moved * np.abs(stiffness + 5e3j * omega), rel=1e-9)
    assert drawn.strips[1].lines[0].y == pytest.approx(np.sqrt(stiffness / 300.0) / (2.0 * np.pi), rel=1e-9)


@pytest.mark.parametrize("vary", [{"bodies.press.mass": "250..350 kg"}, {"limits.floor_force.at_most": "8..12 kN"}])
def test_of_a_kept_design_goal_and_worst_values_are_told_together_as_alone(vary: dict[str, str]) -> None:
    points = sweep(read(FILE), vary, points=15, keep_design=True).points
    few = sweep(read(FILE), vary, points=2, keep_design=True).points
    for together, alone in ((points[0], few[0]), (points[-1], few[-1])):
        assert list(together.results) == ["limits.floor_force", "limits.amplitude", "limits.start_up"]
        assert list(together.results) == list(alone.results)
        assert together.goal is not None
        assert alone.goal is not None
        assert together.goal.shown == alone.goal.shown == "6957 kN/m"
        for path, entry in together.results.items():
            assert entry.shown == alone.results[path].shown
            assert entry.value == pytest.approx(alone.results[path].value, rel=1e-9)


def test_where_the_only_variable_is_held_its_goal_has_a_column() -> None:
    text = FORCE.format(
        mount='stiffness = { from = "50 kN/m", to = "5 MN/m" }\ndamping = "400 N s/m"',
        kind="force",
        shaken='amplitude = "1 kN"',
        speed="3000 rpm",
        more='[limits.moves]\nresponse = "displacement"\nof = "press"\nat_most = "1 mm"\n[goal]\nminimise = "transmitted_force"\ninto = "ground"',
    )
    found = sweep(from_text(text), "links.mount.stiffness", "100..900 kN/m", 3)
    assert found.goal == "transmitted_force"
    goals = [point.goal.value for point in found.points if point.goal is not None]
    mass, turn, damper = 300.0, 100.0 * np.pi, 400.0j * 100.0 * np.pi
    springs = np.array([1e5, 5e5, 9e5])
    assert goals == pytest.approx(np.abs((springs + damper) / (springs + damper - mass * turn**2)) * 1e3, rel=1e-9)
