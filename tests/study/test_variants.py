"""Variants beside each other in one table."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import vibopt as vo
from refusals import refused
from texts import MIDDLE, best, permitted, plane, reaction, shaft
from vibopt.jobs import answer, kept_plan
from vibopt.jobs import from_text as job_of
from vibopt.scene.read import from_text, read, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.study.rounded import rounded
from vibopt.study.variant_cells import Row
from vibopt.study.variants import Variants, compare
from vibopt.verify.as_built import machine_of

PROBLEMS = Path(__file__).parents[2] / "problems"
PRESS = PROBLEMS / "isolation" / "rao_9_34.toml"
GENSET = PROBLEMS / "mounts" / "genset_front_and_rear.toml"


def _row(result: Variants, name: str) -> Row:
    (found,) = (one for one in result.rows if one.name == name)
    return found


def _values(row: Row) -> list[float | None]:
    return [None if one is None else one.value for one in row.cells]


def _best(row: Row) -> list[bool]:
    return [one is not None and one.best for one in row.cells]


@pytest.fixture(scope="module")
def presses() -> Variants:
    design = solve(read(PRESS), explain=False)
    return compare(
        {
            "new": design.scene,
            "saved": frozen(design.scene, design.x),
            "drawn": rounded(design, ["2"]).kept,
            "strict": with_changes(design.scene, {"limits.start_up.at_most": "5 mm"}),
        }
    )


def test_verdicts_stand_first_and_a_variant_that_fails_keeps_its_reason(presses: Variants) -> None:
    assert [one and one.text for one in presses.rows[0].cells] == ["optimal", "met", "met", "infeasible"]
    why = _row(presses, "why")
    assert [one is None for one in why.cells] == [True, True, True, False]
    assert why.cells[3] is not None
    assert why.cells[3].text == "cannot hold together: floor_force, start_up"
    assert presses.exit_code == 0
    assert [one.text if one else "-" for one in _row(presses, "start_up").cells][3] == "-"


def test_the_goal_is_measured_on_saved_designs_too_and_the_best_is_marked(presses: Variants) -> None:
    row = _row(presses, "greatest stiffness of mount")
    assert _values(row) == [pytest.approx(6956917.16, rel=1e-8), pytest.approx(6956917.16, rel=1e-8), 6.9e6, None]
    assert _best(row) == [True, True, False, False]


def test_margins_and_frequencies_are_those_of_each_machine_by_hand(presses: Variants) -> None:
    stiffness, damping = 6.9e6, _values(_row(presses, "links.mount.damping"))[2]
    assert damping is not None
    omega = 100.0 * math.pi
    force = 30e3 * math.hypot(stiffness, damping * omega) / math.hypot(stiffness - 300.0 * omega**2, damping * omega)
    assert _values(_row(presses, "floor_force"))[2] == pytest.approx(1.0 - force / 10e3, rel=1e-9)
    assert _values(_row(presses, "natural frequency 1"))[2] == pytest.approx(math.sqrt(stiffness / 300.0), rel=1e-12)


def test_the_most_room_of_a_limit_is_marked(presses: Variants) -> None:
    row = _row(presses, "floor_force")
    values = [one for one in _values(row) if one is not None]
    assert _best(row).index(True) == values.index(max(values))


def test_parts_prices_and_ratings_of_bought_variants(tmp_path: Path) -> None:
    cheap = solve(read(GENSET), explain=False)
    other = with_changes(cheap.scene.asked or cheap.scene, {"mounts.front.part.only": ["R100-60", "S100-45"]})
    result = compare({"A": frozen(cheap.scene, cheap.x), "B": other})
    parts = _row(result, "mounts.front.part")
    assert [one and one.text for one in parts.cells] == [cheap.places["mounts.front.part"].value, "R100-60"]
    price = _row(result, "least price")
    for scene, found, value in zip(
        (frozen(cheap.scene, cheap.x), frozen(result.designs[1].scene, result.designs[1].x)),
        result.designs,
        _values(price),
        strict=True,
    ):
        machine = machine_of(scene, {})
        assert value == pytest.approx(sum(mount.price for mount in machine.mounts))
        assert found.exit_code == 0
    assert _best(price) == [True, False]
    assert not [one for one in result.rows if one.kind == "price"]
    assert len([one for one in result.rows if one.kind == "frequency"]) == 6


def test_what_differs_between_files_without_choices_is_shown() -> None:
    press = solve(read(PRESS), explain=False)
    kept = frozen(press.scene, press.x)
    heavier = with_changes(kept, {"bodies.press.mass": "310 kg", "links.mount.stiffness": "6.5 MN/m"})
    result = compare({"A": kept, "B": heavier})
    assert _values(_row(result, "bodies.press.mass")) == [300.0, 310.0]
    assert _values(_row(result, "links.mount.stiffness"))[1] == 6.5e6
    assert not [one for one in result.rows if one.name == "links.mount.damping"]


def test_limits_of_some_files_only_are_left_empty_in_the_others() -> None:
    press = read(PRESS)
    document = {**press.document, "limits": {"floor_force": press.document["limits"]["floor_force"]}}
    del document["expected"]
    from vibopt.scene.read import from_dict

    result = compare({"A": press, "B": from_dict(document)})
    assert [one is None for one in _row(result, "start_up").cells] == [False, True]


def test_variants_that_break_a_limit_never_have_the_best_goal() -> None:
    press = solve(read(PRESS), explain=False)
    kept = frozen(press.scene, press.x)
    stiffer = with_changes(kept, {"links.mount.stiffness": "8 MN/m"})
    result = compare({"A": kept, "B": stiffer})
    assert _best(_row(result, "greatest stiffness of mount")) == [True, False]
    assert result.designs[1].status == "violated"


@pytest.mark.parametrize(
    ("scenes", "text"),
    [
        (
            {"A": read(PRESS)},
            "compare needs at least two variants. Name two problem files or saved designs.",
        ),
        (
            {"A": read(PRESS), "B": from_text(permitted())},
            "B: find_all answers with speeds, which compare does not set beside each other.",
        ),
    ],
)
def test_what_cannot_be_compared_is_refused(scenes: dict[str, Scene], text: str) -> None:
    assert str(refused(compare, scenes)) == text


SHAFT = shaft(
    MIDDLE.replace("middle", "pulley"), plane("drive", "100 mm"), reaction("A", "300 N"), best(minimise="correction")
)


def test_a_shaft_without_an_answer_has_no_weights_in_the_table() -> None:
    job = job_of(SHAFT, "shaft.toml")
    result = compare({"wide": job, "tight": vo.with_changes(job, {"planes.drive.weight.to": "10 g"})})
    assert [one.status for one in result.designs] == ["optimal", "infeasible"]
    chosen = [row for row in result.rows if row.kind == "chosen"]
    assert chosen
    assert all(row.cells[0] is not None and row.cells[1] is None for row in chosen)


def test_a_saved_plan_stands_beside_the_one_that_chooses() -> None:
    """Its weights are facts, those of the other are chosen: both are in one row."""
    job = job_of((PROBLEMS / "balancing/rao_9_6_capped.toml").read_text())
    bought = kept_plan(job, answer(job))
    shown = {
        row.name: [cell and cell.text for cell in row.cells] for row in compare({"made": bought, "anew": job}).rows
    }
    assert shown["planes.wheel.mass"] == ["0.05 kg", "0.05 kg"]
    assert shown["planes.wheel.angle"] == ["243.3 deg", "243.3 deg"]
    assert not any(".weight." in name for name in shown)
