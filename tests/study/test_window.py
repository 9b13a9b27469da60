"""Windows: their ends and boxes hold, and just outside of them a limit breaks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from texts import best, choice, moves, shaken_fan
from vibopt.cli.main import main
from vibopt.program.pose import pose
from vibopt.solve.ranges import closed
from vibopt.study.permitted import Window, percent
from vibopt.study.spans import Violations

ROOT = Path(__file__).parents[2] / "problems"
PRESS = ROOT / "isolation" / "rao_9_34.toml"


def one(mass: float, move: float) -> vo.Scene:
    """The softest mount of a fan that may move so far [mm]."""
    mount, goal = {"stiffness": choice("10 kN/m", "100 MN/m")}, best(minimise="stiffness", of="mount")
    return vo.from_text(shaken_fan(mount, moves("fan", f"{move} mm"), goal, mass=f"{mass} kg"))


def holds(job: vo.Scene, values: dict[str, float]) -> bool:
    """Measured as a machine without anything to choose, by the verifier."""
    document = {key: one for key, one in job.document.items() if key not in ("goal", "expected")}
    units = {"stiffness": "N/m", "damping": "N s/m", "mass": "kg", "tuning": "", "damping_ratio": ""}
    texts = {path: f"{x:.17g} {units[path.rpartition('.')[2]]}".strip() for path, x in values.items()}
    plain = {path: float(x) if x.replace(".", "").replace("e", "").replace("-", "").isdigit() else x
             for path, x in texts.items()}  # fmt: skip
    for path, value in plain.items():
        family, name, key = path.split(".")
        document[family] = {**document[family], name: {**document[family][name], key: value}}
    return vo.solve(vo.from_dict(document), explain=False).status == "met"


@pytest.fixture(scope="module")
def press() -> Window:
    return vo.window(vo.read(PRESS))


def test_corners_and_inner_designs_hold_and_beyond_the_ends_none_does(press: Window) -> None:
    job, rng = vo.read(PRESS), np.random.default_rng(2)
    paths = list(press.centre)
    middle = np.array([press.centre[path].value for path in paths])
    assert press.proven
    signs = [np.array([a, b]) for a in (-1, 1) for b in (-1, 1)] + list(rng.uniform(-1, 1, (12, 2)))
    for sign in signs:
        assert holds(job, dict(zip(paths, middle * (1.0 + press.part * sign), strict=True)))
    wider = [middle * (1.0 + 1.01 * press.part * sign) for sign in signs[:4]]
    assert not all(holds(job, dict(zip(paths, x, strict=True))) for x in wider)
    for span in press.spans:
        ((low, high),) = span.intervals
        assert span.proven
        for value in (low.value * (1.0 - 1e-5), high.value * (1.0 + 1e-5)):
            changed = {span.path: f"{value:.17g} {low.si}"}
            assert vo.solve(vo.with_changes(job, changed), explain=False).status == "infeasible"


@pytest.mark.parametrize("file", ["rao_9_34.toml", "rao_9_28.toml", "rao_9_34_speed_squared.toml"])
def test_limits_are_missed_by_as_much_in_closed_form_as_each_design_is_measured(file: str) -> None:
    program = closed(pose(vo.read(PRESS.parent / file)))
    violations = Violations(program)
    assert violations.asked is not None
    at = np.random.default_rng(4).uniform(size=(20, 2))
    designs = np.exp(np.log(program.low) + at * np.log(program.high / program.low))
    for index, limit in enumerate(program.limits):
        alone = [violations.judge.limit(limit, x)[0] for x in designs]
        assert violations(index, designs) == pytest.approx(alone, rel=1e-9, abs=1e-9)


def test_no_box_of_equal_parts_is_greater_than_those_around_designs_tried_all_over(press: Window) -> None:
    """Boxes around a fine grid of centres, halved until a corner, edge or face breaks a limit."""
    violations = Violations(pose(vo.read(PRESS)))
    (k,), (c,) = (one.intervals for one in press.spans)
    centres = np.array([
        (x, y) for x in np.geomspace(k[0].value, k[1].value, 41) for y in np.geomspace(c[0].value, c[1].value, 41)
    ])  # fmt: skip
    places = [np.array([a, b]) for a in (-1, 0, 1) for b in (-1, 0, 1)]
    good, bad = np.zeros(len(centres)), np.full(len(centres), 0.5)
    for _ in range(16):
        part = 0.5 * (good + bad)
        holds = np.max([violations.most(centres * (1.0 + part[:, None] * one)) for one in places], axis=0) <= 1e-9
        good, bad = np.where(holds, part, good), np.where(holds, bad, part)
    assert good.max() < press.part * (1.0 + 1e-4)
    assert good.max() > 0.9 * press.part


def test_the_window_of_the_press_is_as_counted_by_hand(press: Window) -> None:
    """Stiffest by the answer to the file; softest where the amplitude on the way up takes the most damping."""
    stiffness, damping = (one.intervals[0] for one in press.spans)
    best = vo.solve(vo.read(PRESS))
    assert stiffness[1].value == pytest.approx(best.variables["links.mount.stiffness"].value.value, rel=1e-9)
    # the force on the floor at 100 pi rad/s and the peak of 20 mm are met just so by the softest spring too
    omega = 100.0 * np.pi
    k, c = np.meshgrid(np.linspace(0.5e6, 8e6, 400), np.linspace(5e3, 40e3, 400))

    def through(k: np.ndarray, c: np.ndarray) -> np.ndarray:
        s = k + 1j * omega * c
        return np.abs(s / (s - 300.0 * omega**2))

    zeta = c / (2.0 * np.sqrt(k * 300.0))
    top = 3e4 / k / np.where(zeta < np.sqrt(0.5), 2.0 * zeta * np.sqrt(np.maximum(1.0 - zeta**2, 0.0)), 1.0)
    good = (3e4 * through(k, c) <= 1e4) & (top <= 0.02)
    assert stiffness[0].value == pytest.approx(k[good].min(), abs=2e4)
    assert (damping[0].value, damping[1].value) == pytest.approx((c[good].min(), c[good].max()), abs=100.0)


@pytest.mark.parametrize(("mass", "move"), [(100, 0.02), (40, 0.1), (300, 0.005)])
def test_of_one_variable_the_window_is_every_interval(mass: float, move: float) -> None:
    """|k - m w^2| >= F / x: two intervals, cut by the range."""
    job = one(mass, move)
    found = vo.window(job)
    middle, away = mass * (100.0 * np.pi) ** 2, 100.0 / (move * 1e-3)
    ends = [(max(1e4, 0.0), middle - away), (middle + away, 1e8)]
    wanted = [one for one in ends if one[0] < one[1]]
    (span,) = found.spans
    assert span.proven
    assert [(a.value, b.value) for a, b in span.intervals] == [pytest.approx(one, rel=1e-8) for one in wanted]
    x = found.centre[span.path].value
    widest = max((high - low) / (high + low) for low, high in wanted)
    assert found.part == pytest.approx(min(widest, 0.5), rel=1e-2)
    assert holds(job, {span.path: x * (1.0 - found.part)})
    assert holds(job, {span.path: x * (1.0 + found.part)})


@pytest.mark.parametrize(
    ("part", "words"), [(0.0912345, "9.12 %"), (0.3, "30 %"), (0.00456789, "0.456 %"), (0.0, "0 %")]
)
def test_a_part_is_never_rounded_up(part: float, words: str) -> None:
    assert percent(part) == words


TWO_STAGES = """
[bodies.machine]
mass = "800 kg"
[bodies.block]
mass = "2500 kg"
[links.upper]
between = ["machine", "block"]
stiffness = { from = "100 kN/m", to = "50 MN/m" }
damping = "2 kN s/m"
[links.lower]
between = ["block", "ground"]
stiffness = { from = "50 kN/m", to = "20 MN/m" }
damping = "8 kN s/m"
[excitations.turning]
kind = "unbalance"
on = "machine"
unbalance = "0.4 kg m"
speed = "900..1500 rpm"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "600 N"
[limits.shake]
response = "displacement"
of = "machine"
at_most = "1.2 mm pp"
[goal]
minimise = "displacement"
of = "machine"
"""


def test_a_gap_between_the_ends_of_two_variables_is_found_and_its_ends_are_where_the_verdict_changes() -> None:
    """Each end by solving with the value given, which leaves one variable: another method."""
    job = vo.from_text(TWO_STAGES)
    upper, lower = vo.window(job).spans
    assert [len(one.intervals) for one in (upper, lower)] == [2, 1]
    (_, below), (above, _) = upper.intervals
    for end, out in ((below.value, 1.0), (above.value, -1.0)):
        for side, status in ((-1e-5, "optimal"), (1e-5, "infeasible")):
            given = vo.with_changes(job, {upper.path: f"{end * (1.0 + out * side):.12g} N/m"})
            assert vo.solve(given, explain=False).status == status


def near_resonance(most: float) -> str:
    """The least damping of a fan at resonance, of a mount with so much at most."""
    mount = {"stiffness": choice("10 kN/m", "100 MN/m"), "damping": choice("10 N s/m", f"{most} N s/m")}
    asked = moves("fan", "0.1 mm"), best(minimise="damping", of="mount")
    return shaken_fan(mount, *asked, amplitude="1 kN", speed="300 rad/s")


@pytest.mark.parametrize("most", [1e4, 3e4])
def test_a_mount_may_be_soft_or_stiff_and_the_gap_is_as_counted_by_hand(
    most: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """(k - m w^2)^2 + (c w)^2 is no less than (F / X)^2 for some c up to its greatest."""
    resonance, reach = 100.0 * 300.0**2, np.sqrt(1e7**2 - (300.0 * most) ** 2)
    expected = [resonance + reach, 1e8]
    expected = [1e4, resonance - reach, *expected] if reach < resonance else expected
    stiffness = vo.window(vo.from_text(near_resonance(most))).spans[0]
    assert [end.value for one in stiffness.intervals for end in one] == pytest.approx(expected, rel=1e-5)
    file = tmp_path / "fan.toml"
    file.write_text(near_resonance(most))
    assert main(["window", str(file)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Variable Permitted All at once Centre" in said
    assert (
        "Permitted: over all values of the others, every interval that 24 values between the least and the greatest "
        "tell; no value outside is permitted, proven. A narrower gap may be left."
    ) in said


def test_a_window_is_a_table_and_json(press: Window) -> None:
    assert press.to_json()["spans_are"] == (
        "every interval that 24 values between the least and the greatest tell. A narrower gap may be left"
    )
    rows = press.table()
    assert [row["path"] for row in rows] == ["links.mount.stiffness", "links.mount.damping"]
    assert rows[0]["box from"] == pytest.approx(rows[0]["centre"] * (1.0 - press.part))
    assert press.to_json()["part"] == press.part
    assert "is safe" in press._repr_html_()


NONE = "rao_9_3.toml: window needs limits on what is left: without any every weight is permitted."
ORDERS = (
    "engine_share_capped.toml: window is for limits that hold one amplitude each, and the orders of an engine add up "
    "over a turn. vibopt sweep FILE --keep-design --vary PATH=RANGE shows what each share or weight may be."
)
CLASH = "rao_9_34.toml: there is no permitted design (proven). vibopt explain says which limits clash."


@pytest.mark.parametrize(
    ("file", "changes", "words"),
    [
        ("balancing/rao_9_3.toml", {}, NONE),
        ("balancing/engine_share_capped.toml", {}, ORDERS),
        ("isolation/rao_9_34.toml", {"limits.start_up.at_most": "5 mm"}, CLASH),
        ("absorbers/assignment_4a.toml", {},
         "assignment_4a.toml: window needs limits: without any every design is permitted."),
        ("isolation/rao_9_34.toml", {"links.mount.stiffness": {"one_of": ["5 MN/m", "6 MN/m"]}},
         "rao_9_34.toml: window is for variables that are chosen from a range, and links.mount.stiffness is chosen "
         "from a list or is a place. Set it to a value with --set."),
        ("mounts/compressor_on_bought_mounts.toml", {},
         "compressor_on_bought_mounts.toml: window is for variables that are chosen from a range, and links.feet.part "
         "is of a catalogue, of which each part is permitted or not. vibopt solve FILE lists the best choices; --set "
         'links.feet.part.name="..." takes one.'),
        ("isolation/rao_9_34_printed_design.toml", {},
         "rao_9_34_printed_design.toml: nothing is chosen, so nothing may go anywhere. Write a range, { from, to }."),
    ],
    ids=["balancing", "engine", "clash", "no limits", "list", "catalogue", "nothing"],
)  # fmt: skip
def test_what_has_no_window_is_said(file: str, changes: dict[str, object], words: str) -> None:
    assert str(refused(lambda: vo.window(vo.with_changes(vo.read(ROOT / file), changes)))) == words


PULSED = """
title = "pulse of any duration"
bodies.press.mass = "50 kg"
links.mount = { between = ["press","ground"], stiffness = { from = "20 kN/m", to = "400 kN/m" }, damping = "600 N s/m" }
excitations.hit = { kind = "pulse", on = "press", shape = "triangle", amplitude = "2 kN", duration_up_to = "60 ms" }
limits.moved = { response = "peak_displacement", of = "press", at_most = "15 mm" }
goal = { minimise = "stiffness", of = "mount" }
"""


def test_what_a_search_over_durations_found_is_not_called_proven(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "pulse.toml"
    file.write_text(PULSED)
    found = vo.window(vo.read(file))
    monkeypatch.setattr("vibopt.study.window.window", lambda *_, **__: found)
    assert main(["window", str(file)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    doubts = "the greatest over every duration is found by a search and not proven."
    assert f"Box: every limit was followed all over it; {doubts} Permitted: with exact ends, {doubts}" in said
    assert not found.proven
    assert not found.spans[0].proven
