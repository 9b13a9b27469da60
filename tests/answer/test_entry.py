"""Numbers and rows of an answer: one meaning of met, of active, and of what is shown."""

from __future__ import annotations

from dataclasses import replace
from math import tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibopt.answer.answer import EXIT_CODES, OPEN, Answer
from vibopt.answer.entry import TOLERANCE, Entry, at_most, direction, in_one_unit
from vibopt.errors import NotProven

POSITIVE = st.floats(1e-9, 1e9)


@given(bound=POSITIVE, over=st.sampled_from([-2.0, -0.5, 0.0, 0.5]))
def test_a_limit_is_met_that_is_missed_by_less_than_the_tolerance(bound: float, over: float) -> None:
    value = Entry(bound * (1.0 + over * TOLERANCE), "force")
    row = at_most("floor", "force", "into ground", value, Entry(bound, "force"))
    assert row.met
    assert row.active


@given(bound=POSITIVE, over=st.floats(2.0, 1e6))
def test_a_limit_is_broken_beyond_it(bound: float, over: float) -> None:
    value = Entry(bound * (1.0 + over * TOLERANCE), "force")
    row = at_most("floor", "force", "into ground", value, Entry(bound, "force"))
    assert not row.met
    assert row.state == "BROKEN"
    assert row.margin == pytest.approx(-over * TOLERANCE, rel=1e-5)


@given(bound=POSITIVE, times=st.floats(2.0, 1e6))
def test_rounding_of_a_measured_rotor_is_a_part_of_its_greatest_reading(bound: float, times: float) -> None:
    greatest = bound * times
    for over, met in ((0.5, True), (2.0, False)):
        value = Entry(bound + over * TOLERANCE * greatest, "length")
        row = at_most("a", "residual", "", value, Entry(bound, "length"), greatest)
        assert row.met is met
    assert at_most("a", "residual", "", value, Entry(bound, "length"), 0.1 * bound).met is (2.0 * times <= 1.0)


@given(turn=st.floats(0.0, tau))
def test_a_direction_is_shown_below_a_full_turn(turn: float) -> None:
    number = float(direction(turn).shown.removesuffix(" deg"))
    assert 0.0 <= number < 360.0


def test_a_measure_is_neither_active_nor_broken() -> None:
    row = at_most("sag", "static_deflection", "of mount", Entry(1e-3, "length", "mm"), None)
    assert (row.met, row.active, row.state, row.margin_shown) == (True, False, "", "")
    assert row.to_json()["shown"] == "1 mm"
    assert "limit" not in row.to_json()


class Job:
    name, title, kind = "fan", "a fan", "rotor"


@pytest.mark.parametrize("status", EXIT_CODES)
def test_only_what_is_proven_passes(status: str) -> None:
    said: Answer[Job] = Answer(Job(), status, "as it is")
    assert said.exit_code == EXIT_CODES[status]
    assert said.proven is (status not in OPEN)
    if status in OPEN:
        with pytest.raises(NotProven, match=f"^fan: {status}: as it is$"):
            said.require_proof()
    else:
        assert said.require_proof() is said


@given(st.lists(st.floats(1e-9, 1e9), min_size=1, max_size=6))
def test_a_column_shows_one_unit_and_the_same_values(sizes: list[float]) -> None:
    column: list[str | Entry] = [
        "",
        *(Entry(one, "force", amplitude=True) for one in sizes),
        Entry(2.0, "length", "mm"),
    ]
    told = in_one_unit(column)
    forces = [one for one in told if isinstance(one, Entry) and one.dimension == "force"]
    assert len({one.shown.split(" ", 1)[1] for one in forces}) == 1
    assert [one.value for one in forces] == sizes
    longest = max(len(one.shown) for one in forces)
    for unit in {one.shown.split(" ")[1] for one in column if isinstance(one, Entry) and one.dimension == "force"}:
        assert longest <= max(len(replace(one, unit=unit).shown) for one in forces)
    assert told[0] == ""
    assert told[-1] == column[-1]
