"""Reciprocating engines: what is recorded, what the moving pistons show, and what the messages say."""

from __future__ import annotations

import copy
import tomllib
from itertools import permutations
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.answer.text import blocks_of
from vibopt.balancing.engine import EngineJob, read_engine, solve_engine
from vibopt.balancing.engine.choose_weights import Balanced, balance
from vibopt.balancing.engine.engine_answer import simulated
from vibopt.balancing.engine.firing import best_firing, classes, is_even
from vibopt.balancing.engine.shaking import arms, exact_orders, of_order, peak, truncated_orders
from vibopt.document.locate import Locator
from vibopt.document.mistakes import Mistakes

PROBLEMS = Path(__file__).parents[2] / "problems" / "balancing"
FILES = sorted(path for path in PROBLEMS.glob("*.toml") if "[engine]" in path.read_text(encoding="utf-8"))


def engine(at: list[str], spacing: str = "90 mm", **more: Any) -> dict[str, Any]:
    """An engine in line; `more` are keys of [engine]."""
    table = {"stroke": "90 mm", "rod": "150 mm", "speed": "6000 rpm", "reciprocating": "0.5 kg", "spacing": spacing}
    return {"engine": {**table, "orders": 12, **more}, "cylinders": [{"crank": one} for one in at]}


def job_of(document: dict[str, Any]) -> EngineJob:
    return read_engine(copy.deepcopy(document), Mistakes("engine.toml"))


def solved(document: dict[str, Any]) -> Answer[EngineJob]:
    return solve_engine(job_of(document))


def test_one_class_of_cranks_is_one() -> None:
    answer = solved(engine(["choose", "choose"], cranks=["0 deg", "180 deg"]) | {"goal": {"minimise": "primary_force"}})
    assert answer.claim == "all 2 settings of the cranks, 1 class"


@pytest.mark.parametrize("radius", ["1 mm", "1e-3 mm", "1e-9 mm"])
def test_a_crank_that_is_short_beside_its_rod_turns_as_its_orders_say(radius: str) -> None:
    """The stroke was lost in the digits of the rod: `check_failed` below a hundred-thousandth of it."""
    document = engine(["0 deg", "120 deg"], rod="200 mm", stroke=None, crank_radius=radius)
    document["engine"].pop("stroke")
    answer = solved(document)
    assert answer.status == "met"
    size = 0.5 * float(radius.split()[0]) * 1e-3 * (6000.0 * pi / 30.0) ** 2
    assert number_at(answer, "orders.1.force") == pytest.approx(size, rel=1e-9)  # two of 120 deg add up to one


def number_at(answer: Answer[EngineJob], path: str) -> float:
    """A number of the answer."""
    value = answer.find(path).value
    assert isinstance(value, float)
    return value


@settings(max_examples=40, deadline=None)
@given(ratio=st.floats(0.02, 0.97))
def test_series_is_that_of_the_moving_piston(ratio: float) -> None:
    turn = np.arange(4096) * 2.0 * pi / 4096
    path = np.cos(turn) + np.sqrt(1.0 - (ratio * np.sin(turn)) ** 2) / ratio
    measured = np.fft.rfft(path).real / 2048.0 * np.arange(2049) ** 2
    assert np.allclose(exact_orders(ratio, 12), measured[:13], rtol=1e-9, atol=1e-9)


def test_short_series_is_the_limit_of_long_rods() -> None:
    assert exact_orders(1e-3, 4) == pytest.approx(truncated_orders(1e-3, 4), abs=1e-9)
    assert exact_orders(0.4, 2)[2] == pytest.approx(0.4 + 0.4**3 / 4 + 15 * 0.4**5 / 128, rel=2e-3)


@settings(max_examples=30, deadline=None)
@given(
    cranks=st.lists(st.floats(0.0, 359.0), min_size=1, max_size=6),
    banks=st.lists(st.floats(-60.0, 60.0), min_size=6, max_size=6),
    share=st.floats(0.0, 1.0),
)
def test_orders_add_up_to_what_the_turning_engine_shows(cranks: list[float], banks: list[float], share: float) -> None:
    document = engine([], counterweight_share=f"{share:.6f}", rotating="0.3 kg", orders=20)
    document["cylinders"] = [
        {"crank": f"{c:.6f} deg", "bank": f"{b:.6f} deg"} for c, b in zip(cranks, banks, strict=False)
    ]
    document["balance_shafts"] = {
        "a": {"order": 2, "turns": "against rotation", "at": "10 mm", "unbalance": "900 g mm", "angle": "40 deg"},
        "b": {"order": 1, "turns": "with rotation", "at": "50 mm", "unbalance": "700 g mm", "angle": "10 deg"},
    }
    job = job_of(document)
    found = balance(job)
    here = arms(job, found.cranks).at(found.x)
    for couple in (False, True):
        size = max(peak(here, False) * (0.3 if couple else 1.0), 1.0)
        assert np.abs(simulated(job, found, couple)).max() == pytest.approx(peak(here, couple), abs=2e-5 * size)


def test_of_all_settings_of_the_cranks_none_is_better() -> None:
    angles = [0.0, 72.0, 144.0, 216.0, 288.0]
    document = engine(["choose"] * 5, cranks=[f"{one} deg" for one in angles])
    document["goal"] = {"minimise": "primary_couple", "then": ["secondary_couple"]}
    job = job_of(document)
    found = balance(job)
    best = of_order(arms(job, found.cranks).at(found.x), True, 1)
    every = [of_order(arms(job, np.radians(one).tolist()).constant, True, 1) for one in permutations(angles)]
    assert best == pytest.approx(min(every), rel=1e-12)


@settings(max_examples=12)
@given(
    steps=st.lists(st.sampled_from([0, 30, 90, 120, 150, 180, 210, 270]), min_size=2, max_size=4),
    vee=st.booleans(), even=st.booleans(), response=st.sampled_from(["primary_couple", "primary_force", "couple"]),
)  # fmt: skip
def test_of_any_offered_angles_the_best_order_is_found(steps: list[int], vee: bool, even: bool, response: str) -> None:
    """Also of those that turning does not take into each other: throw 1 may then need another than the first."""
    many = len(steps)
    document = engine(["choose"] * many, cranks=[f"{one} deg" for one in steps], even_firing=even)
    document["goal"] = {"minimise": response}
    for k, cylinder in enumerate(document["cylinders"]):
        cylinder["bank"] = f"{(-45 if k % 2 else 45) * vee} deg"
    job = job_of(document)
    every = [np.radians(one).tolist() for one in permutations(steps)]
    kept = [one for one in every if not even or is_even(best_firing(job, one))]
    found = balance(job)
    if not kept:
        assert found.status == "infeasible"
        return
    couple, order = response.endswith("couple"), 0 if response == "couple" else 1
    values = [of_order(arms(job, one).constant, couple, order) for one in kept]
    best = of_order(arms(job, found.cranks).constant, couple, order)
    assert best == pytest.approx(min(values), rel=1e-9, abs=1e-6 * max(values) + 1e-9)
    assert sorted(np.degrees(found.cranks).round(6)) == sorted(map(float, steps))


def test_classes_of_a_search_miss_no_couple_and_hold_none_twice() -> None:
    angles = [0.0, 90.0, 180.0, 270.0]
    job = job_of({**engine(["choose"] * 4, cranks=[f"{one} deg" for one in angles])})
    members = list(classes(job))
    assert len(members) == 3

    def marks(cranks: tuple[float, ...]) -> tuple[float, ...]:
        found = arms(job, cranks).constant
        return tuple(round(of_order(found, True, order), 6) for order in (1, 2, 4))

    every = {marks(tuple(np.radians(one).tolist())) for one in permutations(angles)}
    assert {marks(one) for one in members} == every


@pytest.mark.parametrize(
    ("cranks", "order", "even"),
    [
        ([0, 180, 180, 0], "1-2-4-3", True),
        ([0, 120, 240, 240, 120, 0], "1-4-2-6-3-5", True),
        ([0, 180], "1-2", False),
        ([0, 240, 120], "1-3-2", True),
    ],
)
def test_firing_order_follows_from_the_cranks(cranks: list[int], order: str, even: bool) -> None:
    job = job_of(engine([f"{one} deg" for one in cranks]))
    firing = best_firing(job, [one * pi / 180.0 for one in cranks])
    assert (firing.text, is_even(firing)) == (order, even)


def test_cranks_follow_from_the_firing_order() -> None:
    document = engine([], firing_order=[1, 3, 4, 2])
    document["cylinders"] = [{}, {}, {}, {}]
    answer = solved(document)
    cranks = [round(number_at(answer, f"cylinders.{k}.crank") * 180.0 / pi, 6) for k in (1, 2, 3, 4)]
    assert cranks == [0.0, 180.0, 180.0, 0.0]
    assert answer.find("firing.order").value == "1-3-4-2"


def test_no_other_weights_of_capped_shafts_leave_less() -> None:
    document = engine(["0 deg", "180 deg", "180 deg", "0 deg"])
    shaft = {"order": 2, "at": "20 mm", "unbalance": {"from": "0 g mm", "to": "3 kg mm"}}
    document["balance_shafts"] = {
        "left": {**shaft, "turns": "with rotation"},
        "right": {**shaft, "turns": "against rotation"},
    }
    document["goal"] = {"minimise": "secondary_force"}
    document["limits"] = {"rock": {"response": "secondary_couple", "at_most": "400 N m"}}
    job = job_of(document)
    answer, found = solve_engine(job), balance(job)
    left = number_at(answer, "goal")
    assert answer.status == "optimal"
    assert number_at(answer, "limits.rock.value") <= 400.0 * (1.0 + 1e-6)
    generator = np.random.default_rng(5)
    here = arms(job, found.cranks)
    for _ in range(3000):
        x = found.x + generator.normal(scale=2e-4, size=(2, 2)) @ (1.0, 1j)
        now = here.at(x)
        if np.abs(x).max() <= 3e-3 and of_order(now, True, 2) <= 400.0:
            assert of_order(now, False, 2) >= left * (1.0 - 1e-7)


def test_limit_that_no_weight_can_hold_is_infeasible_with_a_certificate() -> None:
    document = engine(["0 deg"], counterweight_share={"from": "0 %", "to": "100 %"})
    document["goal"] = {"minimise": "primary_force"}
    document["limits"] = {"floor": {"response": "primary_force", "at_most": "100 N"}}
    answer = solved(document)
    assert (answer.status, answer.exit_code, answer.goal) == ("infeasible", 3, None)
    least = 0.5 * 0.5 * 0.045 * (6000.0 * pi / 30.0) ** 2  # half of the primary force is left at a share of one half
    assert answer.claim.startswith(
        "no correction keeps the limits: with the weights that are allowed, those on what is "
    )
    assert float(answer.claim.split()[-4]) == pytest.approx(least / 100.0, rel=1e-3)


def test_greatest_force_over_a_turn_can_be_the_goal() -> None:
    document = engine(["0 deg"], counterweight_share={"from": "0 %", "to": "100 %"})
    document["goal"] = {"minimise": "force"}
    job = job_of(document)
    answer = solve_engine(job)
    share = number_at(answer, "counterweight_share")
    here = arms(job, (0.0,))
    sizes = [peak(here.at(np.array([one])), False) for one in (share - 0.01, share, share + 0.01)]
    assert sizes[1] <= min(sizes) * (1.0 + 1e-9)
    assert answer.status == "optimal"


@pytest.mark.parametrize("bound", ["1500 N", "1531 N", "1990 N", "2200 N"])
def test_a_limit_on_all_orders_together_is_kept_between_the_degrees_of_a_turn(bound: str) -> None:
    """Held at every degree alone it is broken by 4e-5; the best of a dense look at the two numbers is no better."""
    document = engine(["0 deg", "90 deg"], rod="140 mm", speed="3000 rpm", stroke="80 mm")
    document["balance_shafts"] = {
        "b": {"order": 1, "turns": "against rotation", "at": "20 mm", "unbalance": {"from": "0 g mm", "to": "50 kg mm"}}
    }
    document["limits"] = {"f": {"response": "force", "at_most": bound}}
    document["goal"] = {"minimise": "primary_couple"}
    job = job_of(document)
    answer, most = solve_engine(job), float(bound.removesuffix(" N"))
    assert answer.status == "optimal"
    assert most * (1.0 - 1e-6) <= number_at(answer, "limits.f.value") <= most * (1.0 + 1e-9)
    here, x = arms(job, balance(job).cranks), balance(job).x
    generator, best = np.random.default_rng(3), of_order(here.at(x), True, 1)
    for one in x + generator.normal(scale=1e-5, size=(300, 1, 2)) @ (1.0, 1j):
        if peak(here.at(one), False) <= most:
            assert of_order(here.at(one), True, 1) >= best * (1.0 - 1e-6)


@pytest.mark.parametrize(("table", "more"), [
    ("limits", {"at_most": "1 MN"}), ("measures", {}), ("measures", {"kinematics": "exact"}),
])  # fmt: skip
def test_an_order_beyond_those_shown_is_told_as_it_is(table: str, more: dict[str, str]) -> None:
    document = engine(["0 deg"])
    tenth = solved({**document, "engine": {**document["engine"], "orders": 10}}).find("orders.10.force").value
    asked = {"x": {"response": "force", "order": 10, **more}}
    answer = solved({**document, "engine": {**document["engine"], "orders": 8}, table: asked})
    assert answer.find(f"{table}.x.value").value == tenth > 0.0


def test_the_angle_of_a_balance_shaft_is_that_at_the_cranks_as_they_are_written() -> None:
    """A cylinder at 60 deg: fitted as told, nothing of the second order is left."""
    document = engine(["60 deg"])
    shaft = {"order": 2, "at": "0 mm", "unbalance": {"from": "0 g mm", "to": "50 kg mm"}}
    document["balance_shafts"] = {"a": {**shaft, "turns": "with rotation"}, "b": {**shaft, "turns": "against rotation"}}
    document["goal"] = {"minimise": "secondary_force"}
    answer = solved(document)
    said = "The angle of a balance shaft is that of its weight when the crank of cylinder 1 stands at 60 deg."
    assert said in answer.notes
    for name, one in document["balance_shafts"].items():
        size, angle = (number_at(answer, f"balance_shafts.{name}.{word}") for word in ("unbalance", "angle"))
        one |= {"unbalance": f"{size!r} kg m", "angle": f"{angle!r} rad"}
    del document["goal"]
    left, alone = solved(document), solved(engine(["60 deg"]))
    assert number_at(left, "orders.2.force") <= 1e-9 * number_at(alone, "orders.2.force")


def test_engine_alone_is_met_or_violated() -> None:
    document = engine(["0 deg"])
    document["limits"] = {"floor": {"response": "force", "at_most": "1 N"}}
    assert solved(document).status == "violated"
    document["limits"]["floor"]["at_most"] = "1 MN"
    assert solved(document).status == "met"


def test_notes_say_what_two_terms_hide() -> None:
    notes = solved(engine(["0 deg", "180 deg", "90 deg", "270 deg"])).notes
    assert any("Two orders alone show" in note and "all of it" in note for note in notes)


def test_check_refuses_what_the_turning_engine_does_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(job: EngineJob, found: Balanced, couple: bool) -> float:
        return 1e6

    monkeypatch.setattr("vibopt.balancing.engine.engine_answer.simulated", wrong)
    assert solved(engine(["0 deg"])).status == "check_failed"


TEXT = """
[engine]
stroke = "90 mm"
rod = "150 mm"
speed = "6000 rpm"
reciprocating = "0.5 kg"
spacing = "90 mm"

[[cylinders]]
crank = "0 deg"

[[cylinders]]
crank = "180 deg"
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'stroke = "90 mm"',
            "",
            'engine.toml line 2: engine needs stroke or crank_radius, one of the two. Write stroke = "86 mm".',
        ),
        (
            'rod = "150 mm"',
            'rod = "40 mm"',
            "engine.toml line 2: engine has a rod that is not longer than the crank radius: such a crank cannot turn. "
            "Write a longer rod.",
        ),
        (
            'rod = "150 mm"',
            'rod = "45.001 mm"',
            "engine.toml line 2: engine has a rod that is longer than the crank radius by less than 0.01 %: its piston "
            "is thrown about without end at half a stroke. Write a longer rod.",
        ),
        (
            'rod = "150 mm"',
            'rod = "150 mm"\norders = 30',
            "engine.toml line 2: engine has orders = 30. Write a number from 2 to 20.",
        ),
        (
            'crank = "180 deg"',
            "",
            'engine.toml line 12: cylinders[2] has no crank. Write crank = "90 deg", or crank = "choose".',
        ),
        (
            'crank = "180 deg"',
            'crank = "choose"',
            'engine.toml line 2: engine has no cranks for 1 throw that chooses. Write cranks = ["0 deg", '
            '"180 deg", ...], one angle each.',
        ),
        (
            'spacing = "90 mm"',
            "",
            'engine.toml line 2: the cylinders have no places. Write spacing = "100 mm" in [engine].',
        ),
        (
            'reciprocating = "0.5 kg"',
            "",
            "engine.toml line 9: cylinders[1] has no reciprocating mass. Add it to [engine].",
        ),
        (
            'spacing = "90 mm"',
            'spacing = "90 mm"\nfiring_order = [1, 1]',
            "engine.toml line 8: engine.firing_order = [1, 1] does not name each cylinder once.",
        ),
        (
            "[[cylinders]]",
            '[balance_shafts.a]\norder = 2\nturns = "with rotation"\nat = "0 mm"\nunbalance = "5 g mm"\n[[cylinders]]',
            'engine.toml line 9: balance_shafts.a has a given unbalance but no angle. Add angle = "180 deg", '
            "or a range { from, to } to choose.",
        ),
        (
            "[[cylinders]]",
            '[goal]\nminimise = "force"\n[[cylinders]]',
            'engine.toml line 9: there is a goal but nothing to choose. Write crank = "choose", or leave [goal] out.',
        ),
        (
            "[[cylinders]]",
            '[limits.a]\nresponse = "primary_force"\norder = 4\nat_most = "5 N"\n[[cylinders]]',
            'engine.toml line 9: limits.a has an order, but primary_force says its own. Write response = "force".',
        ),
        (
            "[[cylinders]]",
            '[limits.a]\nresponse = "force"\norder = -2\nat_most = "5 N"\n[[cylinders]]',
            "engine.toml line 9: limits.a has order = -2. Write a number from 1 to 20.",
        ),
        (
            "[[cylinders]]",
            'kinematics = "truncated"\n[limits.a]\nresponse = "force"\norder = 4\nat_most = "5 N"\n[[cylinders]]',
            "engine.toml line 12: limits.a.order = 4, but truncated kinematics ends at 2. Write kinematics = "
            '"exact" in [engine].',
        ),
        (
            "[[cylinders]]",
            '[measures.a]\nresponse = "force"\norder = 4\nkinematics = "truncated"\n[[cylinders]]',
            "engine.toml line 11: measures.a.order = 4, but truncated kinematics ends at 2. Write kinematics = "
            '"exact" in [measures.a].',
        ),
        (
            "[[cylinders]]",
            '[goal]\nminimise = "primary_force"\norder = 4\n[[cylinders]]',
            'engine.toml line 9: goal has an order, but primary_force says its own. Write minimise = "force".',
        ),
        (
            "[[cylinders]]",
            '[limits.a]\nresponse = "force"\n[[cylinders]]',
            "engine.toml line 9: limits.a has no bound. Write at_most, or move it to [measures.a].",
        ),
        (
            "[[cylinders]]",
            "counterweight_share = { one_of = [0.1, 0.5] }\n[[cylinders]]",
            "engine.toml line 9: engine.counterweight_share = { one_of = [0.1, 0.5] } is a list, but what balances an "
            "engine is chosen from a range. Write { from = ..., to = ... }; vibopt sweep FILE --vary "
            'PATH="ONE, OTHER" answers each value.',
        ),
        (
            "[[cylinders]]",
            "counterweight_share = { from = 0.1 }\n[[cylinders]]",
            "engine.toml line 9: engine.counterweight_share = { from = 0.1 } has no upper end. Write "
            "{ from = 0, to = 1 }.",
        ),
        (
            "[[cylinders]]",
            'rotating_share = { value = 0.5, tolerance = "3 %" }\n[[cylinders]]',
            'engine.toml line 9: engine.rotating_share = { value = 0.5, tolerance = "3 %" } has a tolerance, but what '
            "balances an engine is taken as it is said. Write it without; vibopt sweep FILE --keep-design --vary "
            'PATH="-3 %..+3 %" shows what being off does.',
        ),
        (
            "[[cylinders]]",
            '[counterweights.a]\nat = "0 mm"\nunbalance = { from = "1 g mm", to = "5 g mm" }\n[[cylinders]]',
            'engine.toml line 11: counterweights.a.unbalance = { from = "1 g mm", to = "5 g mm" } does not start at '
            "zero. No weight at all is always possible: write from zero.",
        ),
        (
            "[[cylinders]]",
            'cranks = ["0 deg"]\n[[cylinders]]',
            "engine.toml line 9: engine.cranks offers angles, but no throw chooses one. Write crank = "
            '"choose" in [[cylinders]], or leave cranks out.',
        ),
        (
            "[[cylinders]]",
            "counterweight_share = { from = 0, to = 1 }\n[goal]\n"
            'minimise = "primary_force"\nthen = ["force"]\n[[cylinders]]',
            "engine.toml line 12: goal has then, which decides between settings of the cranks, and these are given. "
            "Leave then out, or limit what it names.",
        ),
        (
            "[[cylinders]]",
            '[measures.a]\nresponse = "force"\nat_most = "5 N"\n[[cylinders]]',
            "engine.toml line 11: measures.a has a bound (at_most), but a measure has none. Move it to [limits.a].",
        ),
    ],
)
def test_mistake_is_said_with_its_place_and_the_way_out(old: str, new: str, message: str) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    assert message in refused(read_engine, tomllib.loads(text), Mistakes("engine.toml", Locator(text))).messages


def test_places_are_said_as_the_file_counts_them() -> None:
    shaft = {"order": 2, "turns": "with rotation", "at": "0 mm", "unbalance": {"from": "0 g mm", "to": "50 kg mm"}}
    document = engine(["0 deg", "180 deg", "180 deg", "0 deg"])
    document |= {"balance_shafts": {"a": shaft}, "goal": {"minimise": "secondary_force"}}
    job = job_of(document)
    answer = solve_engine(job)
    row = next(one for one in blocks_of(answer) if one.title == "Weights").rows[0]
    assert row[-2:] == ("0 mm", "-135 mm")
    assert (
        "Places are counted from cylinder 1 at 0 mm; the last cylinder is at 270 mm, the middle of all at 135 mm."
    ) in answer.notes
    document["balance_shafts"]["a"]["at"] = "135 mm"
    assert number_at(solved(document), "orders.2.couple") < 1e-6 * number_at(answer, "orders.2.couple")


def test_orders_that_were_left_out_are_not_called_small() -> None:
    job = job_of(engine(["0 deg", "180 deg", "180 deg", "0 deg"], kinematics="truncated"))
    answer = solve_engine(job)
    lines = next(one for one in blocks_of(answer) if one.title == "Besides").lines
    assert lines[0] == 'Orders above 2 are left out, as kinematics = "truncated" says.'
    assert "orders.4.force" not in answer.values
    full = solved(engine(["0 deg", "180 deg", "180 deg", "0 deg"]))
    assert number_at(full, "orders.4.force") > 100.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'crank = "180 deg"',
            'crank = "choose"\n[[cylinders]]\ncrank = "choose"',
            "engine.toml line 8: engine.cranks offers 1 angle (120 deg) for 2 throws that choose. Each throw takes one "
            'of them and each is taken once: add 1 angle, or change the number of cylinders with crank = "choose".',
        ),
        (
            'crank = "180 deg"',
            'crank = "choose"',
            "engine.toml line 8: engine.cranks offers 3 angles (0 deg, 120 deg, 240 deg) for 1 throw that chooses. "
            "Each throw takes one of them and each is taken once: leave out 2 angles (those of throws that do not "
            'choose), or change the number of cylinders with crank = "choose".',
        ),
        (
            "[[cylinders]]",
            '[balance_shafts.a]\norder = 3\nturns = "with rotation"\nat = "0 mm"\nunbalance = "5 g mm"\n'
            'angle = "0 deg"\n[[cylinders]]',
            "engine.toml line 11: balance_shafts.a.order = 3 is none of the values that order may have. Write 1 or 2.",
        ),
        (
            'rod = "150 mm"',
            'rod = "150 mm"\nkinematics = "short"',
            'engine.toml line 5: engine.kinematics = "short" is none of the values that kinematics may have. Write '
            '"exact" or "truncated".',
        ),
    ],
)
def test_cranks_and_words_are_answered_in_the_words_of_the_file(old: str, new: str, message: str) -> None:
    many = '["0 deg", "120 deg", "240 deg"]' if "3 angles" in message else '["120 deg"]'
    text = TEXT.replace(old, new, 1).replace('spacing = "90 mm"', f'spacing = "90 mm"\ncranks = {many}')
    assert refused(read_engine, tomllib.loads(text), Mistakes("engine.toml", Locator(text))).messages == (message,)


def block(answer: Answer[EngineJob], title: str) -> Any:
    return next(one for one in blocks_of(answer) if one.title == title)


@settings(max_examples=15, deadline=None)
@given(
    cranks=st.lists(st.integers(0, 3599), min_size=1, max_size=4),
    vee=st.booleans(),
    shares=st.tuples(*[st.just(0.0) | st.floats(1e-9, 1.0)] * 2),
)
def test_counterweights_as_said_do_what_their_shares_do(
    cranks: list[int], vee: bool, shares: tuple[float, float]
) -> None:
    """Weights typed from the answer's own table, in place of the shares, leave the same force and couple."""
    document = engine([], rotating="0.35 kg", counterweight_share=shares[0], rotating_share=shares[1])
    for k, angle in enumerate(cranks):
        for bank in ("-30 deg", "30 deg") if vee else ("0 deg",):
            crank = {} if bank == "30 deg" else {"crank": f"{angle / 10} deg"}
            document["cylinders"].append({**crank, "throw": f"p{k}", "bank": bank, "at": f"{90 * k} mm"})
    answer = solved(document)
    rows = block(answer, "Weights").rows
    assert len(rows) == len(cranks)
    for name in ("counterweight_share", "rotating_share"):
        del document["engine"][name]
    document["counterweights"] = {
        f"w{k}": {"unbalance": row[1], "angle": row[2], "at": row[4]}
        for k, row in enumerate(rows)
        if not row[1].startswith("0 ")
    }
    other = solved(document)
    size = 0.5 * 0.045 * (6000.0 * pi / 30.0) ** 2 * len(document["cylinders"])
    for order in (1, 2, 4):
        for word, lever in (("force", 1.0), ("couple", 0.3)):
            path = f"orders.{order}.{word}"
            assert number_at(other, path) == pytest.approx(number_at(answer, path), abs=2e-3 * size * lever)


def test_what_to_build_of_an_engine_is_said_word_for_word() -> None:
    document = engine(["0 deg"], rotating="0.4 kg", counterweight_share={"from": 0, "to": 1})
    document["goal"] = {"minimise": "force"}
    assert block(solved(document), "What to build").lines == (
        "opposite crank 1: a counterweight of 31.58 kg mm (mass times radius): 0.6035 of the reciprocating and all of "
        "the rotating mass.",
    )
    document = engine(["0 deg", "180 deg"])
    free = {"from": "0 g mm", "to": "50 kg mm"}
    document["counterweights"] = {"front": {"at": "-40 mm", "unbalance": free}}
    document["balance_shafts"] = {"a": {"order": 1, "turns": "against rotation", "at": "45 mm", "unbalance": free}}
    document["goal"] = {"minimise": "primary_force"}
    assert block(solved(document), "What to build").lines == ("front: no weight.", "a: no weight.")
    document = engine(["0 deg", "180 deg", "180 deg", "0 deg"])
    document["balance_shafts"] = {"a": {"order": 2, "turns": "with rotation", "at": "135 mm", "unbalance": free}}
    document["goal"] = {"minimise": "secondary_force"}
    assert block(solved(document), "What to build").lines == (
        "a: 3454 g mm (mass times radius) at 135 mm, 180 deg from zero (shaft turns 2 x, with the crank).",
    )


def test_a_couple_that_balances_to_nothing_is_zero_and_no_step_is_sold_for_its_rounding() -> None:
    """Three cranks at 120 degrees and one shaft that turns against them: the rotating pair of couples cancels."""
    lines = [f'[[cylinders]]\ncrank = "{crank} deg"' for crank in (0, 240, 120)]
    shafts = [
        f'[balance_shafts.{name}]\norder = 1\nturns = "against rotation"\nat = "{at} mm"\n'
        'unbalance = { from = "0 g mm", to = "9 kg mm" }'
        for name, at in (("front", -60), ("back", 220))
    ]
    engine = (
        'title = "Three in line"\n[engine]\nstroke = "74 mm"\nrod = "128 mm"\nspeed = "5200 rpm"\n'
        'reciprocating = "0.42 kg"\nrotating = "0.3 kg"\nspacing = "82 mm"\n'
        'counterweight_share = { from = "0 %", to = "80 %" }\n'
    )
    document = tomllib.loads("\n".join([engine, *lines, *shafts, '[goal]\nminimise = "primary_couple"']))
    for key, value in (("speed", "5200 rpm"), ("speed", "4700 rpm"), ("stroke", "66.6 mm"), ("rod", "140 mm")):
        document["engine"][key] = value
        answer = solve_engine(job_of(document))
        assert answer.goal is not None
        assert (answer.status, answer.goal[1].value) == ("optimal", 0.0)
        back = answer.values["balance_shafts.back.unbalance"]
        assert isinstance(back, Entry)
        assert back.value == 0.0


@pytest.mark.parametrize("seed", range(6))
def test_a_weight_that_helps_nothing_is_zero_and_every_other_one_is_said(seed: int) -> None:
    """Three cranks at 120 degrees: only couples are left, and of single weights most shake more than they help."""
    rng = np.random.default_rng(seed)
    document = engine(["0 deg", "240 deg", "120 deg"], rotating="0.4 kg", counterweight_share={"from": 0, "to": 1})
    free = [{"from": "0 g mm", "to": f"{most:.3g} kg mm"} for most in rng.uniform(1.0, 20.0, 3)]
    document["counterweights"] = {
        f"c{k}": {"at": f"{at:.4g} mm", "unbalance": one}
        for k, (at, one) in enumerate(zip(rng.uniform(-60.0, 240.0, 2), free, strict=False))
    }
    document["balance_shafts"] = {
        "b": {"order": 1, "turns": "against rotation", "at": "90 mm", "unbalance": free[2]},
    }
    document["goal"] = {"minimise": str(rng.choice(["couple", "primary_couple", "force"]))}
    answer = solved(document)
    lines = dict(line.split(": ", 1) for line in block(answer, "What to build").lines)
    for path in ("counterweights.c0", "counterweights.c1", "balance_shafts.b"):
        size = number_at(answer, f"{path}.unbalance")
        assert size == 0.0 or size > 1e-8 * 3.0 * 0.9 * 0.045
        assert (lines[path.partition(".")[2]] == "no weight.") == (size == 0.0)


def test_a_weight_without_an_upper_end_is_said_as_it_is(recwarn: pytest.WarningsRecorder) -> None:
    document = engine(["0 deg"], rotating="0.4 kg")
    document["counterweights"] = {"front": {"at": "0 mm", "unbalance": {"from": "0 g mm"}}}
    document["goal"] = {"minimise": "primary_force"}
    said = block(solved(document), "What to build").lines
    assert said == (
        "front: 29250 g mm (mass times radius) at 0 mm, 180 deg from zero.",
    )  # half of the mass that slides
    assert not recwarn.list


def test_forces_are_said_as_the_file_may_say_them() -> None:
    """The greatest over a turn: "N pk" is refused in a file."""
    document = engine(["0 deg"], counterweight_share={"from": 0, "to": 1})
    document["limits"] = {"floor": {"response": "force", "at_most": "20 kN"}}
    document["goal"] = {"minimise": "force"}
    answer = solved(document)
    assert answer.goal is not None
    row = answer.limits["floor"]
    assert row.limit is not None
    said = (answer.goal[1].shown, row.value.shown, row.limit.shown, answer.values["all_orders.force"].shown)
    assert not any("pk" in one for one in said)


def test_limits_that_would_have_to_be_endlessly_wide_are_told() -> None:
    document = engine(["0 deg"], counterweight_share=1e30)
    document["counterweights"] = {"front": {"at": "0 mm", "unbalance": {"from": "0 g mm", "to": "1 kg mm"}}}
    document["limits"] = {"floor": {"response": "force", "at_most": "400 N"}}
    document["goal"] = {"minimise": "force"}
    assert solved(document).status == "infeasible"


def test_the_gap_that_is_claimed_holds_for_the_weights_that_are_told() -> None:
    """They may be lighter than the best by a hair of the goal: the same engine in other masses shows how much."""
    values, gaps = [], []
    for size in (1.0, 1e-3, 1e-9, 1e6):
        masses = {"reciprocating": f"{0.45 * size!r} kg", "rotating": f"{0.5 * size!r} kg"}
        share = {"counterweight_share": {"from": 0, "to": 1}, "rotating_share": 1.0}
        document = engine(["0 deg", "240 deg", "120 deg"], "88 mm", **masses, **share)
        document["counterweights"] = {
            "c": {"at": "-40 mm", "unbalance": {"from": "0 g mm", "to": f"{8 * size!r} kg mm"}}
        }
        document["limits"] = {"first": {"response": "primary_couple", "at_most": f"{670 * size!r} N m"}}
        document["goal"] = {"minimise": "couple"}
        answer = solved(document)
        assert answer.goal is not None
        values.append(answer.goal[1].value / size)
        gaps.append(float(answer.claim.split("gap ")[1].split()[0]))
    assert all(value <= min(values) * (1.0 + gap + 1e-10) for value, gap in zip(values, gaps, strict=True))
