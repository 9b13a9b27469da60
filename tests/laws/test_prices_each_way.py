"""A price is what solving again shows: after its step, at the ends of its range, and behind them."""

from __future__ import annotations

import math
import random
from collections.abc import Collection
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from texts import best, choice, floor, moves, one_mass
from vibopt.answer.entry import Entry, Way
from vibopt.errors import InputError, UnknownName
from vibopt.jobs import answer, asks_shares, fact_at, facts, from_text, open_job, with_changes
from vibopt.study.axis import Axis, axis_of
from vibopt.study.holding import Road, State, difference, measured_by, state_of
from vibopt.study.one_way import Along
from vibopt.study.price_words import NOT_ASKED, range_rows, rows_of
from vibopt.study.prices import Prices, Ranked, priced, prices
from vibopt.study.purse import Purse
from vibopt.values.fact_at import FactAt
from vibopt.work import SpentError

PROBLEMS = Path(__file__).parent.parent.parent / "problems"
CHEAP = (
    "isolation/rao_9_34.toml", "isolation/rao_9_29_damped_force_held.toml", "isolation/rao_9_28.toml",
    "isolation/rao_9_34_printed_design.toml", "balancing/rao_9_11_capped.toml", "balancing/rao_9_14_b_capped.toml",
    "balancing/engine_share_capped.toml", "balancing/rao_9_6_capped.toml",
)  # fmt: skip
"""One or two of each kind of job, with limits, caps and facts, and an analysis."""
SLOW = pytest.param("mounts/inertia_base.toml", marks=pytest.mark.slow)


@cache
def prices_of(file: str) -> Prices:
    """Of every number of a file, answered once."""
    return prices(open_job(PROBLEMS / file))


def other(file: str, seed: int) -> Any:
    """The job of a file with three of its facts off by up to 8 %."""
    job = open_job(PROBLEMS / file)
    choice = random.Random(seed)
    usual = [
        one for one in facts(job) if one.value > 0.0 and not one.signed and one.dimension not in ("count", "ratio")
    ]
    for fact in choice.sample(usual, min(3, len(usual))):
        try:
            changed = with_changes(job, fact.changes(fact.value * choice.uniform(0.92, 1.08)))
        except InputError:
            continue
        job = changed if answer(changed, explain=False).goal is not None else job
    return job


def again(job: Any, path: str, value: float) -> Any:
    """What holds the job back with a number changed, by reading and answering anew."""
    made = with_changes(job, {path: _text(job, path, value)})
    return state_of(made, answer(made, explain=False), value)


def _text(job: Any, path: str, value: float) -> Any:
    return fact_at(job, path).text(value)


def plain_rows(found: Prices) -> list[Ranked]:
    """Rows of numbers that stand alone in the file."""
    return [one for one in found.rows if one.ways and not _part(found.job, one.path)]


def _part(job: Any, path: str) -> bool:
    return next((bool(one.place) for one in facts(job) if one.path == path), True)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("file", [*CHEAP, SLOW])
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_a_price_is_what_solving_again_shows_at_both_ends_of_its_range(file: str, seed: int) -> None:
    job = other(file, seed)
    paths = [one.path for one in plain_rows(prices(job, most=0.0, thorough=False))] or [one.path for one in facts(job)]
    limits = [one for one in paths if one.startswith(("limits", "planes", "engine", "bodies"))]
    chosen = random.Random(seed).sample(limits, min(3, len(limits)))
    found = prices(job, only=chosen)
    here = state_of(job, answer(job, explain=False), 0.0)
    for row in plain_rows(found):
        for way in row.ways:
            step = again(job, row.path, way.value.value)
            assert _same(step.measure, way.goal), (row.path, way)
            assert (step.measure is None) == (way.change is None)
            if way.until is None or abs(way.until.value) < 1e-6:  # a bound of nothing is judged by parts of itself
                continue
            last = again(job, row.path, way.until.value)
            assert _same(last.measure, way.there), (row.path, way)
            assert last.held == here.held or way.then, (row.path, way)
            behind = way.until.value + (way.until.value - row.now.value) * 1e-3
            if way.ends == way.until and way.beyond == "no design" and behind != way.until.value:
                assert again(job, row.path, behind).measure is None, (row.path, way)


def _same(one: Any, other: Any) -> bool:
    if one is None or other is None:
        return one is other
    return bool(one.value == pytest.approx(other.value, rel=2e-6, abs=1e-9))


@pytest.mark.parametrize(
    "file",
    ["isolation/rao_9_34.toml", pytest.param("balancing/rao_9_11_capped.toml", marks=pytest.mark.slow)],
)
def test_what_changes_at_the_end_of_a_range_is_what_is_said(file: str) -> None:
    job, found = open_job(PROBLEMS / file), prices_of(file)
    seen = 0
    for row in plain_rows(found):
        for way in row.ways:
            if way.until is None or way.then == "no design":
                continue
            step = 2e-3 * (way.until.value - row.now.value)
            before, after = (again(job, row.path, way.until.value + side * step) for side in (-1.0, 1.0))
            for name in after.held - before.held:
                assert name in way.then, (row.path, way)
                seen += 1
    assert seen >= 3


class Smooth(Road):
    """Answers whose room for `second` falls smoothly to nothing at an end, or of which `first` lets go there."""

    together = False
    end, bend, lets_go, blind = 0.5, 0.0, False, False

    def with_room(self, value: float, names: Collection[str] = (), by: float = 0.0) -> State:
        if names:
            return State(value, "refused", None, frozenset())
        t = math.log10(value / self.fact.value)
        left = self.end - t
        held = {"first"} if self.lets_go == (left > 0.0) else set()
        held |= set() if self.lets_go or left > 0.0 else {"second"}
        size = (-left if self.lets_go else left) * (1.0 + self.bend * t)
        room = {} if self.blind else {"first" if self.lets_go else "second": max(size, 0.0)}
        return State(value, "optimal", Entry(1.0 + t, "mass"), frozenset(held), {}, room)

    def followed(self) -> tuple[float, int]:
        """The end that was found [decades], and how many answers it took."""
        axis = axis_of(self.fact, lambda: 1.0)
        assert axis is not None
        along = Along(self, axis, self(self.fact.value), 1)
        found = along.ranged(along.stepped(1), 1)
        assert found.until is not None
        return math.log10(found.until.value / self.fact.value), len(self.known)


def test_a_place_moved_back_to_the_origin_is_there() -> None:
    """0.3 m less 0.3 m, however the ends of the shaft were said."""
    fact = next(one for one in facts(open_job(PROBLEMS / "isolation/rao_9_34.toml")) if one.dimension == "mass")
    axis = Axis(replace(fact, value=0.1 + 0.2), extent=0.3)
    assert axis.value(-1.0) == 0.0
    assert axis.value(0.5) == pytest.approx(0.45)


def smooth(end: float, bend: float, lets_go: bool, blind: bool = False) -> Smooth:
    made = Smooth(
        vo.read(PROBLEMS / "isolation" / "rao_9_34.toml"), FactAt("bodies.press.mass", 300.0, "kg", "mass"), None
    )
    made.end, made.bend, made.lets_go, made.blind = end, bend, lets_go, blind
    return made


@settings(max_examples=50, deadline=None)
@given(end=st.floats(0.02, 0.97), bend=st.floats(-0.6, 3.0), lets_go=st.booleans())
def test_the_end_of_a_range_is_found_where_the_room_of_what_takes_over_ends(
    end: float, bend: float, lets_go: bool
) -> None:
    at, answers = smooth(end, bend, lets_go).followed()
    assert end - 2.1e-5 <= at <= end * (1.0 + 1e-12)
    assert answers <= 24


class Ended(Smooth):
    """The same, of which only so many answers are had."""

    left = 24

    def with_room(self, value: float, names: Collection[str] = (), by: float = 0.0) -> State:
        if len(self.known) >= self.left:
            raise SpentError
        return super().with_room(value, names, by)


@settings(max_examples=50, deadline=None)
@given(
    end=st.floats(0.02, 0.97), bend=st.floats(-0.6, 3.0), lets_go=st.booleans(), blind=st.booleans(),
    left=st.integers(2, 24),
)  # fmt: skip
def test_a_range_whose_search_the_work_ended_is_told_as_far_as_it_was_seen_to_hold(
    end: float, bend: float, lets_go: bool, blind: bool, left: int
) -> None:
    made = Ended(
        vo.read(PROBLEMS / "isolation" / "rao_9_34.toml"), FactAt("bodies.press.mass", 300.0, "kg", "mass"), None
    )
    made.end, made.bend, made.lets_go, made.blind, made.left = end, bend, lets_go, blind, left
    axis = axis_of(made.fact, lambda: 1.0)
    assert axis is not None
    along = Along(made, axis, made(300.0), 1)
    way = along.stepped(1)
    found = along.ranged(way, 1)
    if found.until is not None:
        at = math.log10(found.until.value / 300.0)
        assert end - max(1e-3 * end, 4.1e-5) <= at <= end * (1.0 + 1e-12)
        assert found.then
    elif found.far is not None:
        assert math.log10(1.0 + 1e-12) < math.log10(found.far.value / 300.0) <= end * (1.0 + 1e-12)
        assert (found.then, found.beyond, found.ends) == ("", "", None)
    else:
        assert found == way


@pytest.mark.sampled(4)
@pytest.mark.parametrize("file", ["isolation/rao_9_28_at_resonance.toml", "absorbers/rao_9_51_tuned_freely.toml"])
@pytest.mark.parametrize("work", [40.0, 90.0, 200.0, 600.0])
def test_whatever_work_there_is_a_range_is_what_solving_again_shows(file: str, work: float) -> None:
    job = open_job(PROBLEMS / file)
    found = answer(job, explain=False)
    names = [one.name for one in found.limits.values() if one.active]
    asked = [(one, "limit") for one in facts(job) if one.path.split(".")[1] in names]
    purse = Purse(found, measured_by(job)[1])
    steps = purse.stepped(asked, math.inf, lambda k: None)
    rows = purse.ranged(steps, purse.spent + work, lambda k: None, shared=True)
    whole = purse.ranged(steps, math.inf, lambda k: None)
    assert len(rows) == 2
    for row, full in zip(rows, whole, strict=True):
        assert row.ranged or row.why == "its range was left out because of the work"
        for way, other in zip(row.ways, full.ways, strict=True):
            if (end := way.until or way.far) is None:
                continue
            last = again(job, row.path, end.value)
            assert _same(last.measure, way.there), (row.path, way)
            assert last.held == purse.here.held or way.then or way == other, (row.path, way)


@pytest.mark.parametrize(
    ("status", "words"),
    [
        ("infeasible", "no design"), ("unproven", "nothing found, nothing proven"),
        ("refused", "the file cannot have more"), ("check_failed", "nothing found, nothing proven"),
    ],
)  # fmt: skip
def test_what_is_not_proven_is_not_called_a_place_without_designs(status: str, words: str) -> None:
    here = State(1.0, "optimal", Entry(1.0, "mass"), frozenset())
    assert difference(here, State(2.0, status, None, frozenset())) == words


def test_following_what_is_left_takes_far_fewer_answers_than_halving() -> None:
    cases = [
        (end, bend, go) for end in (0.07, 0.21, 0.43, 0.77, 0.9) for bend in (-0.4, 0.7, 2.0) for go in (True, False)
    ]
    followed = sum(smooth(*case).followed()[1] for case in cases)
    halved = sum(smooth(*case, blind=True).followed()[1] for case in cases)
    assert followed < 0.65 * halved


def test_the_first_to_argue_about_buys_most_of_all_limits() -> None:
    found = prices_of("isolation/rao_9_34.toml")
    assert found.first.startswith("Argue about floor_force first: 10 kN pk -> 11 kN pk buys 9 %")
    gains = [one.gain for one in found.rows]
    assert gains == sorted(gains, reverse=True)
    one = found.find("limits.start_up.at_most")
    assert [way.beyond for way in one.ways] == ["no design", "nothing more to gain"]


def test_every_number_has_a_price_or_says_why_not() -> None:
    for file in CHEAP:
        job = open_job(PROBLEMS / file)
        found = prices(job, most=300.0)
        said = " ".join(found.notes)
        known = {one.path for one in found.rows}
        for fact in facts(job):
            measured = fact.path.split(".")[0] in ("runs", "readings", "influence", "conventions", "scatter", "quality")
            table, _, _ = fact.path.partition(".")
            told = measured and table in said and "have no price: they are data" in said
            assert fact.path in known or told, (file, fact.path)
        for row in found.rows:
            assert row.ranged or row.why, (file, row.path)
            if row.why.startswith(("left out", "its range")):
                assert row.path in said, (file, row.path)


def test_a_step_that_the_file_refuses_is_not_called_a_place_without_designs() -> None:
    beam = {"kind": "simply_supported", "length": "0.8 m", "diameter": "60 mm", "at_ratio": 0.95, "modulus": "206 GPa"}
    job = vo.from_dict({
        "bodies": {"disc": {"mass": "35 kg"}},
        "links": {"shaft": {"between": ["disc", "ground"], "beam": beam, "damping_ratio": 0.02}},
        "excitations": {"ecc": {"kind": "unbalance", "on": "disc", "unbalance": "3500 g mm", "speed": "1000 rpm"}},
        "limits": {"way": {"response": "displacement", "of": "disc", "at_most": "1 mm"}},
    })  # fmt: skip
    found = prices(job, only=["links.shaft.beam.at_ratio"])
    assert [row[1:3] for row in rows_of(found)][-1] == ("0.95 -> 1.045", "not asked")
    assert NOT_ASKED in found.notes


def test_an_answer_on_which_two_routes_do_not_agree_has_no_prices() -> None:
    job = open_job(PROBLEMS / "isolation/rao_9_34.toml")
    with pytest.raises(InputError, match="its answer is check_failed, and numbers on which two routes do not agree"):
        prices(job, found=replace(answer(job), status="check_failed"))


def test_what_a_step_of_a_limit_buys_is_told_whatever_one_answer_takes() -> None:
    """Which limit to argue about is what is asked for first: the facts and the ranges are left out before."""
    job = open_job(PROBLEMS / "isolation/rao_9_34.toml")
    found = prices(job, found=replace(answer(job), work=45_000.0))
    assert {row.sort for row in found.rows if row.ways} == {"limit"}
    assert found.first.startswith("Argue about floor_force first: 10 kN pk -> 11 kN pk buys 9 %")


@pytest.mark.sampled(2)
@pytest.mark.parametrize("file", [*CHEAP, "balancing/rao_9_13_holes.toml", "balancing/engine_phasing_four.toml"])
def test_a_table_that_ran_out_of_work_is_told_all_the_same(file: str) -> None:
    found = prices(open_job(PROBLEMS / file), most=100.0)
    told = {name for name, _ in range_rows(found)}
    for row in found.rows:
        assert row.name in told or any(row.path in note for note in found.notes)
    assert len(list(rows_of(found))) == sum(len(one.ways) for one in found.rows)
    assert found.table()
    assert found.to_json()["rows"]


def test_an_edge_of_what_frequencies_keep_out_of_has_a_price() -> None:
    design = priced(vo.solve(open_job(PROBLEMS / "shafts/pump_shaft.toml")))
    price = design.limits["critical_speed"].price
    assert price is not None
    assert price.words == "3540 rpm -> 3200 rpm: stiffness 1.924 MN/m -> 1.863 MN/m"


@pytest.mark.parametrize(("file", "ways"), [("isolation/rao_9_34.toml", [1, 1]), ("shafts/pump_shaft.toml", [-1])])
def test_no_answer_is_asked_for_that_the_price_of_a_limit_does_not_show(
    file: str, ways: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[int] = []
    stepped = Along.stepped
    monkeypatch.setattr(Along, "stepped", lambda along, way: taken.append(way) or stepped(along, way))
    assert any(row.price for row in priced(vo.solve(open_job(PROBLEMS / file))).limits.values())
    assert taken == ways


def test_tolerances_are_facts_with_a_price() -> None:
    job = open_job(PROBLEMS / "isolation/rao_9_34.toml", {"bodies.press.mass": {"value": "300 kg", "tolerance": "5 %"}})
    found = prices(job, only=["bodies.press.mass.tolerance"], most=0.0, thorough=False)
    assert found.rows[0].why == "left out because of the work"
    assert found.first == (
        f"Which number improves the {found.measure} was left out because of the work: --thorough computes it."
    )
    row = prices(job, only=["bodies.press.mass.tolerance"], most=2000.0).rows[0]
    assert row.gain > 0.0
    best: Way | None = row.best
    assert best is not None
    assert best.value.shown == "4.5 %"


@pytest.mark.parametrize(
    ("file", "words"),
    [
        (
            "isolation/rao_9_35.toml",
            "rao_9_35.toml: find_all answers with speeds, and a price is counted in a goal. Set a goal, or see how the "
            "set moves with vibopt whatif FILE --set PATH=VALUE.",
        ),
        (
            "isolation/rao_9_1.toml",
            "rao_9_1.toml: there is neither a goal nor a limit, so nothing to count a price in. Add one of them.",
        ),
    ],
)
def test_a_job_without_prices_says_so(file: str, words: str) -> None:
    assert str(refused(prices, open_job(PROBLEMS / file))) == words


def test_a_job_without_a_design_and_a_path_that_is_not_there_are_refused() -> None:
    job = open_job(PROBLEMS / "isolation/rao_9_34.toml")
    with pytest.raises(UnknownName, match=r"limits\.start_up\.at_most"):
        prices(job, only=["limits.start_upp.at_most"])
    with pytest.raises(InputError, match="there is no design whose price could be told: infeasible"):
        prices(with_changes(job, {"limits.start_up.at_most": "1 mm"}))
    job = with_changes(open_job(PROBLEMS / "balancing/engine_share_capped.toml"), {"limits.second.at_most": "500 N"})
    with pytest.raises(InputError, match="This cannot hold: second"):
        prices(job)


@pytest.mark.slow
def test_nearly_all_active_limits_of_the_problems_have_a_price_with_a_range() -> None:
    """At least 95 of 100 in the work that is done unasked, those that a probability bounds counted as without one."""
    active, have = [], []
    for file in sorted(PROBLEMS.rglob("*.toml")):
        job = open_job(file)
        found = answer(job, explain=False)
        names = [one.name for one in found.limits.values() if one.active]
        if found.goal is None or not names or found.status not in ("optimal", "feasible"):
            continue
        paths = [one.path for one in facts(job) if one.path.startswith(tuple(f"limits.{name}." for name in names))]
        rows = () if asks_shares(job) else prices(job, found=found, only=paths).rows
        for name in names:
            active.append((file.name, name))
            have += [(file.name, name)] * any(one.ranged and one.path.split(".")[1] == name for one in rows)
    assert len(active) >= 60
    assert len(have) >= 0.95 * len(active), sorted(set(active) - set(have))


@pytest.mark.parametrize(
    "file", ["rao_9_50", *(pytest.param(one, marks=pytest.mark.slow) for one in ("rao_9_49", "load_set_down"))]
)
def test_the_work_of_a_shock_is_no_more_than_it_takes_so_that_all_its_ranges_are_told(file: str) -> None:
    found = prices(open_job(PROBLEMS / f"shock/{file}.toml"))
    assert [row.why for row in found.rows if not row.ranged] == []
    assert found.notes == ()


def gap(top: float, force: float) -> vo.Scene:
    """A mount that may be soft or stiff, and no stiffness between."""
    text = one_mass(
        "machine", "100 kg", {"stiffness": choice("900 kN/m", f"{top!r} kN/m"), "damping": "100 N s/m"},
        {"name": "shaking", "amplitude": f"{force!r} N", "speed": "1500 rpm", "varies": "constant"},
        moves("machine", "0.5 mm", "way"), best(minimise="stiffness", of="mount"),
    )  # fmt: skip
    return vo.from_text(text, name="gap.toml")


@settings(max_examples=8)
@given(st.floats(1000.0, 1150.0), st.floats(150.0, 260.0))
def test_behind_a_gap_a_fact_has_designs_again_and_that_is_said(top: float, force: float) -> None:
    """The mass that falls meets the resonance of the softest mount, and is past that of the stiffest, by formula."""
    job = gap(top, force)
    found = prices(job, only=["bodies.machine.mass", "limits.way.at_most"])
    rows = {row.path: row for row in found.rows}
    down, up = rows["bodies.machine.mass"].ways
    omega = 50.0 * math.pi
    off = math.sqrt((force / 5e-4) ** 2 - (omega * 100.0) ** 2)
    assert down.ends is not None
    assert down.ends.value == pytest.approx((9e5 + off) / omega**2, rel=2e-6)
    first = (1e3 * top - off) / omega**2
    assert down.again is not None
    assert 0.8 * first <= down.again.value <= first
    assert (up.looked, up.again) == (0, None)
    assert f"no design, and one again at {down.again.shown}" in str(list(range_rows(found)))
    tight = rows["limits.way.at_most"].ways[0]
    assert (tight.beyond, tight.looked, tight.again) == ("no design", 0, None)


def test_of_a_fact_without_designs_behind_its_end_it_is_said_how_many_values_were_looked_at() -> None:
    found = prices(gap(1100.0, 200.0), only=["excitations.shaking.amplitude"])
    (row,) = found.rows
    way = row.ways[1]
    assert (way.looked, way.again) == (24, None)
    assert way.ends is not None
    assert way.far is not None
    for k in range(1, 25):  # each of them by itself
        value = way.ends.value * (way.far.value / way.ends.value) ** (k / 24)
        assert again(found.job, row.path, value).measure is None
    assert "no design at 24 values up to 2000 N" in str(list(range_rows(found)))


@pytest.mark.parametrize(("stiffness", "damping"), [("60 kN/m", True), ("30 kN/m", True), ("90 kN/m", False)])
def test_the_number_of_mounts_that_stand_beside_a_choice_ends_at_a_whole_one(stiffness: str, damping: bool) -> None:
    mount = {"stiffness": stiffness, "damping": choice("100 N s/m", "1 kN s/m"), "count": 4}
    if not damping:
        mount |= {"stiffness": choice("5 kN/m", "2 MN/m"), "damping": "300 N s/m"}
    unbalance = {"name": "turning", "kind": "unbalance", "unbalance": "6 kg mm", "speed": "1450 rpm"}
    asked = floor("40 N"), best(minimise="displacement", of="fan", over="start-up")
    text = one_mass("fan", "120 kg", mount, unbalance, *asked)
    found = prices(vo.from_text(text), only=["links.mount.count"])
    (row,) = found.rows
    up = row.ways[1]
    assert up.ends is not None
    assert up.ends.value.is_integer()
    job = vo.from_text(text)
    states = [again(job, row.path, up.ends.value + more) for more in (0.0, 1.0)]
    assert [state.good for state in states] == [True, False]
    last, words = up.ends.shown, str(list(range_rows(found)))  # the last number of mounts has a design itself
    assert (f"to {last} (no design at" if up.until == up.ends else f"beyond {last} no design at") in words


def test_data_without_a_price_are_named_with_a_way_that_works() -> None:
    job = open_job(PROBLEMS / "balancing/assignment_1.toml")
    job = with_changes(job, {"scatter": {"amplitude": "2 %", "angle": "1 deg"}})
    (said,) = [one for one in prices(job, most=0.0).notes if "have no price" in one]
    path = said.partition("--vary ")[2].partition("=")[0]
    assert path in {fact.path for fact in facts(job)}
    assert "numbers of " in said
    assert "measured have" not in said


def test_of_two_limits_that_hold_in_one_place_none_is_said_to_do_it_alone() -> None:
    """The softest spring that keeps the motion has the least natural frequency that is wanted, too."""
    job = vo.from_text("""
[bodies.m]
mass = "1 kg"
[links.k]
between = ["m", "ground"]
stiffness = { from = "100 N/m", to = "400 N/m" }
[excitations.f]
kind = "force"
on = "m"
amplitude = "1 N"
speed = "10 rad/s"
[limits.x]
response = "displacement"
of = "m"
at_most = "10 mm"
[limits.frequency]
response = "natural_frequency"
at_least = "14.142135623730951 rad/s"
[goal]
minimise = "stiffness"
of = "k"
""")
    assert prices(job).first.startswith(
        "No limit alone holds it back; of the facts bodies.m.mass first: 1 kg -> 0.9 kg "
    )


def test_a_limit_whose_steps_buy_nothing_but_that_holds_back_farther_on_is_named() -> None:
    found = prices_of("isolation/rao_9_34.toml")
    row = found.find("limits.start_up.at_most")
    flat = replace(row, ways=tuple(replace(way, change=0.0) for way in row.ways))
    facts_alone = tuple(one for one in found.rows if one.sort == "fact" and one.gain > 0.0)
    ends = row.ways[-1].ends
    assert facts_alone
    assert ends is not None
    said = replace(found, rows=(*facts_alone, flat)).first
    given = f"{row.now.shown}..{ends.shown}"
    assert said.startswith(
        f"The steps looked at of limits buy nothing, but start_up holds it back up to {ends.shown} "
        f'(vibopt sweep FILE --vary limits.start_up.at_most="{given}"); of the facts '
    )
    low, high = fact_at(found.job, "limits.start_up.at_most").ends(given)
    assert low.value < high.value
    assert replace(found, rows=facts_alone).first.startswith("No limit holds it back; of the facts ")


def test_what_a_step_costs_from_a_goal_of_zero_is_no_part_of_it() -> None:
    job = from_text(
        '[masses.cam]\nunbalance = "50 g mm"\nangle = "0 deg"\n[planes.rim]\nradius = "10 mm"\n'
        'weight = { from = "0 g", to = "5.1 g" }\n[goal]\nminimise = "static_unbalance"\n'
    )
    said = {row[1]: row[3] for row in rows_of(prices(job, only={"planes.rim.weight.to"}))}
    assert said == {"5.1 g -> 5.6 g": "nothing", "5.1 g -> 4.6 g": "−4 g mm"}
