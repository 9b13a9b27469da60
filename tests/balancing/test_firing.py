"""Cranks that are written, that share a throw, or that a firing order gives: against firing by trial of every turn."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, permutations, product
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from vibopt.balancing.engine.throws import fires_evenly, fires_in

GRID = 30
"""Degrees between the tops that are drawn."""


def orders(tops: Sequence[int], strokes: int) -> dict[tuple[int, ...], bool]:
    """Every order in which cylinders can fire, begun with cylinder 1, and whether it can be even; tops in whole GRIDs.

    What fires together with cylinder 1 comes after it or before it.
    """
    turn, many = 360 // GRID, len(tops)
    cycle = turn * strokes // 2
    found: dict[tuple[int, ...], bool] = {}
    for later, lasts in product(product(*[range(0, cycle, turn)] * many), product((0, 1), repeat=many - 1)):
        times = [top + more - tops[0] - later[0] for top, more in zip(tops, later, strict=True)]
        times = [
            0,
            *((one - 1) % cycle + 1 if last else one % cycle for one, last in zip(times[1:], lasts, strict=True)),
        ]
        for order in permutations(range(1, many)):
            whole = (0, *order)
            if all(times[a] <= times[b] for a, b in pairwise(whole)):
                even = all(times[one] * many == k * cycle for k, one in enumerate(whole))
                key = tuple(one + 1 for one in whole)
                found[key] = found.get(key, False) or even
    return found


@settings(max_examples=60, deadline=None)
@given(tops=st.lists(st.integers(0, 360 // GRID - 1), min_size=1, max_size=5), strokes=st.sampled_from([2, 4]))
def test_what_can_fire_is_what_some_turns_show(tops: list[int], strokes: int) -> None:
    right, turned = orders(tops, strokes), [GRID * one * 3.141592653589793 / 180.0 for one in tops]
    for order in permutations(range(2, len(tops) + 1)):
        assert fires_in((1, *order), turned, strokes) == ((1, *order) in right)
    assert fires_evenly(turned, strokes) == any(right.values())


def engine(*cylinders: dict[str, Any], **more: Any) -> dict[str, Any]:
    table = {"stroke": "80 mm", "rod": "140 mm", "speed": "3000 rpm", "reciprocating": "0.4 kg", "spacing": "90 mm"}
    return {"engine": {**table, **more}, "cylinders": list(cylinders)}


def shown(document: dict[str, Any]) -> tuple[list[int], str, str]:
    """Cranks [deg], firing order, and whether it is even."""
    answer = vo.solve(vo.from_dict(document, name="engine.toml"))
    cranks = [answer.find(f"cylinders.{k + 1}.crank").value for k in range(len(document["cylinders"]))]
    assert all(isinstance(one, float) for one in cranks)
    degrees = [round(float(one) * 180.0 / 3.141592653589793) % 360 for one in cranks]
    return degrees, str(answer.find("firing.order").value), str(answer.find("firing.even").value)


@settings(max_examples=40, deadline=None)
@given(
    tops=st.lists(st.integers(0, 360 // GRID - 1), min_size=2, max_size=5), strokes=st.sampled_from([2, 4]),
    data=st.data(),
)  # fmt: skip
def test_an_order_that_is_said_is_one_that_the_cranks_allow(tops: list[int], strokes: int, data: st.DataObject) -> None:
    order = [1, *data.draw(st.permutations(range(2, len(tops) + 1)))]
    written = engine(*({"crank": f"{-GRID * one % 360} deg"} for one in tops), firing_order=order, strokes=strokes)
    right = orders(tops, strokes)
    if tuple(order) not in right:
        assert "is not how these cranks can fire" in str(refused(vo.from_dict, written))
        return
    assert shown(written)[1:] == ("-".join(map(str, order)), "yes" if right[tuple(order)] else "no")


def test_a_written_crank_holds_for_all_on_its_throw_and_the_order_is_counted_from_it() -> None:
    vee = {"throw": "a", "crank": "0 deg", "bank": "-30 deg"}, {"throw": "a", "bank": "30 deg"}
    assert shown(engine(*vee, firing_order=[1, 2]))[0] == [0, 0]
    assert shown(engine({"crank": "10 deg"}, {}, {}, firing_order=[1, 2, 3], strokes=2)) == (
        [10, 250, 130], "1-2-3", "yes",
    )  # fmt: skip
    shared = {"throw": "a", "crank": "choose"}, {"throw": "a"}
    assert shown(engine(*shared, {}, firing_order=[1, 2, 3], cranks=["90 deg"]))[0][:2] == [90, 90]


def test_cranks_are_chosen_among_those_that_fire_as_is_said() -> None:
    free = engine(*[{"crank": "choose"}] * 4, cranks=["0 deg", "90 deg", "180 deg", "270 deg"], strokes=2)
    free["goal"] = {"minimise": "primary_couple"}
    for order in ([1, 2, 3, 4], [1, 3, 2, 4], [1, 4, 3, 2]):
        free["engine"]["firing_order"] = order
        cranks, said, even = shown(free)
        first = [(cranks[0] - cranks[one - 1]) % 360 for one in order]
        assert (first, said, even) == ([0, 90, 180, 270], "-".join(map(str, order)), "yes")
    free["engine"] |= {"firing_order": [1, 2, 3, 4], "cranks": ["0 deg", "90 deg", "180 deg", "200 deg"]}
    free["engine"]["even_firing"] = True
    answer = vo.solve(vo.from_dict(free))
    assert (answer.status, answer.claim) == (
        "infeasible", "no setting of the cranks fires in the order 1-2-3-4 at equal distances",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (
            engine({"throw": "a", "crank": "0 deg"}, {"throw": "a", "crank": "40 deg"}),
            'engine.toml: cylinders[2] has crank = "40 deg", but cylinders[1], on the same throw "a", has crank = '
            '"0 deg". Write the crank of a throw once, or leave throw out.',
        ),
        (
            engine({"throw": "a", "crank": "0 deg"}, {"throw": "a", "crank": "choose"}, cranks=["0 deg"]),
            'engine.toml: cylinders[2] has crank = "choose", but cylinders[1], on the same throw "a", has crank = '
            '"0 deg". Write the crank of a throw once, or leave throw out.',
        ),
        (
            engine({"throw": "a", "bank": "-30 deg"}, {"throw": "a", "bank": "30 deg"}, firing_order=[1, 2]),
            "engine.toml: engine.firing_order has the crank of cylinders[1] at 330 deg and that of cylinders[2] at 30 "
            'deg, but they share throw "a". Write its crank.',
        ),
        (
            engine({"crank": "0 deg"}, {"crank": "240 deg"}, {"crank": "120 deg"}, firing_order=[1, 3, 2], strokes=2),
            "engine.toml: engine.firing_order = [1, 3, 2] is not how these cranks can fire. They can as [1, 2, 3], for "
            "example; or leave firing_order out.",
        ),
        (
            engine({"crank": "0 deg"}, {"crank": "180 deg"}, even_firing=True),
            "engine.toml: engine.even_firing = true, but these cranks cannot fire at equal distances. Change them, or "
            "leave even_firing out.",
        ),
    ],
)
def test_cranks_that_contradict_each_other_are_refused(document: dict[str, Any], message: str) -> None:
    assert message in str(refused(vo.from_dict, document, name="engine.toml"))
