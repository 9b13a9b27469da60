"""Weights of which there are only so many, for all planes together: against every joint choice."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rotor_jobs import FAN, messages, read_text, solve_text
from test_rotor_plan import fan, put_back_of
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.conventions import Conventions
from vibopt.balancing.discrete import solve_discrete
from vibopt.balancing.influence import identify
from vibopt.balancing.plane_options import options_of
from vibopt.balancing.planes import Plane
from vibopt.balancing.question import Goal, Options, Question
from vibopt.errors import InputError

TURN = 2.0 * np.pi
GOALS: tuple[Goal, ...] = ("rms", "worst", "sum", "huber", "correction")
SHELF = (0.1, 0.2, 0.3)


def plane_options(holes: int, most: int) -> Options:
    plane = Plane("p", holes=tuple(TURN * k / holes for k in range(holes)), shelf=SHELF, most_weights=most)
    return options_of(plane, Conventions("", "", "with rotation", "pk", "zero"), SHELF)


def fillings(holes: int, most: int) -> list[tuple[complex, float, FloatArray]]:
    """(unbalance, mass, weights taken) of every way to fill the holes, written down by hand."""
    found = []
    for many in range(most + 1):
        for places in combinations(range(holes), many):
            for weights in product(SHELF, repeat=many):
                u = sum(m * np.exp(1j * TURN * k / holes) for k, m in zip(places, weights, strict=True))
                taken = Counter(weights)
                found.append((complex(u), sum(weights), np.array([float(taken[one]) for one in SHELF])))
    return found


@st.composite
def asked(draw: st.DrawFn, planes: int = 2) -> tuple[Question, int, int]:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, holes, most = draw(st.integers(1, 6)), draw(st.integers(2, 5)), draw(st.integers(1, 2))
    y0, H = rng.normal(size=(2, n)), rng.normal(size=(2, n, planes))
    lists = plane_options(holes, most)
    question = Question(
        y0=0.5 * (y0[0] + 1j * y0[1]), H=H[0] + 1j * H[1], importance=rng.uniform(0.2, 3.0, n),
        limits=np.where(rng.random(n) < 0.3, rng.uniform(0.4, 2.0, n), np.inf), caps=np.full(planes, np.inf),
        total_cap=float(rng.uniform(0.2, 2.0)) if draw(st.booleans()) else np.inf,
        goal=draw(st.sampled_from(GOALS)), huber=0.5, options=(lists,) * planes,
        stock=rng.choice([0.0, 1.0, 2.0, np.inf], len(SHELF)),
    )  # fmt: skip
    return question, holes, most


def best_of(question: Question, every: list[tuple[complex, float, FloatArray]]) -> float:
    best = np.inf
    for choice in product(every, repeat=question.n_planes):
        u = np.array([one[0] for one in choice])
        mass = sum(one[1] for one in choice)
        left = np.abs(question.residual(u))
        enough = bool(np.all(sum(one[2] for one in choice) <= question.stock))
        if enough and mass <= question.total_cap * (1 + 1e-9) and np.all(left <= question.limits):
            best = min(best, mass if question.goal == "correction" else float(question.measure(left)))
    return best


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(given_=asked())
def test_no_choice_from_the_stock_is_better(given_: tuple[Question, int, int]) -> None:
    """Every filling of two planes, those of one unbalance made of other weights included."""
    question, holes, most = given_
    solved, best = solve_discrete(question), best_of(question, fillings(holes, most))
    assert solved.status == ("infeasible" if best == np.inf else "optimal")
    if solved.u is not None:
        taken = sum(one.uses[k] for one, k in zip(question.options, solved.chosen, strict=True) if one is not None)
        assert np.all(taken <= question.stock)
        assert solved.value == pytest.approx(best, rel=1e-8, abs=1e-12)
        assert question.chosen_only(solved.chosen).value(solved.u) == solved.value


@settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(given_=asked(planes=3))
def test_a_free_plane_beside_a_stock_is_chosen_jointly(given_: tuple[Question, int, int]) -> None:
    question, _, _ = given_
    mixed = replace(
        question, options=(*question.options[:2], None), goal="rms", total_cap=np.inf,
        limits=np.full(question.n_readings, np.inf), caps=np.array([np.inf, np.inf, 0.4]),
    )  # fmt: skip
    solved, best = solve_discrete(mixed), np.inf
    listed = mixed.options[0]
    assert listed is not None
    u, uses = listed.u, listed.uses
    for i, j in product(range(len(u)), repeat=2):
        if np.all(uses[i] + uses[j] <= mixed.stock):
            fixed: ComplexArray = np.array([u[i], u[j], 0.0])
            inner = replace(
                mixed, y0=mixed.residual(fixed), H=mixed.H[:, 2:], caps=mixed.caps[2:], options=(), stock=np.empty(0),
            )  # fmt: skip
            best = min(best, solve_continuous(inner).value)
    assert solved.status == "optimal"
    assert solved.value == pytest.approx(best, rel=1e-6, abs=1e-7)


@settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(given_=asked(planes=2))
def test_a_plane_left_out_leaves_the_others_as_if_it_were_not_there(given_: tuple[Question, int, int]) -> None:
    """The only plane with a list is left out: what is left is a question without a stock."""
    question, _, _ = given_
    asked_ = replace(
        question, options=(question.options[0], None), caps=np.array([0.0, 0.4]),
        limits=np.full(question.n_readings, 9.0),
    )  # fmt: skip
    alone = replace(asked_, H=asked_.H[:, 1:], caps=asked_.caps[1:], options=(), stock=np.empty(0))
    solved, best = solve_discrete(asked_), solve_continuous(alone)
    assert solved.status == best.status
    if solved.u is not None:
        assert solved.u[0] == 0.0
        assert solved.value == pytest.approx(best.value, rel=1e-6, abs=1e-7)


ALIKE = """{planes}[[runs]]
speed = "1200 rpm"
readings = {{ a = "4 mil @ 20 deg" }}
[[influence]]
sensor = "a"
plane = "left"
value = "0.3 mil/g @ 20 deg"
[[influence]]
sensor = "a"
plane = "right"
value = "0.4 mil/g @ 90 deg"
"""


@pytest.mark.parametrize("left", ["", "holes = 6\nsplit = true\n"])
def test_a_box_beside_a_plane_that_acts_alike_says_what_each_buys(left: str) -> None:
    """One sensor tells two planes apart by nothing: each is left out in turn, the one with the box, too."""
    planes = FAN[: FAN.index("[planes.left]")] + f'[planes.left]\nradius = "100 mm"\n{left}'
    right = '[planes.right]\nradius = "100 mm"\nholes = 6\nshelf = ["5 g", { mass = "7 g", stock = 1 }]\n'
    plan = solve_text(ALIKE.format(planes=planes + right))
    assert [way.name for way in plan.plan.remedies] == ["as asked", "left left out", "right left out"]
    assert plan.plan.remedies[2].masses == ("left 13.33 g @ 180 deg", "right no weight")


def test_three_planes_from_one_box_are_proven() -> None:
    """13 824 000 joint choices less those for which the box does not suffice."""
    rng = np.random.default_rng(4)
    lists = plane_options(24, 1)
    H = rng.normal(size=(6, 3)) + 1j * rng.normal(size=(6, 3))
    question = Question(
        y0=0.6 * (rng.normal(size=6) + 1j * rng.normal(size=6)), H=H, importance=np.ones(6), limits=np.full(6, np.inf),
        caps=np.full(3, np.inf), goal="worst", options=(lists,) * 3, stock=np.array([1.0, 1.0, 1.0]),
    )  # fmt: skip
    solved = solve_discrete(question)
    free = solve_discrete(replace(question, stock=np.empty(0)))
    best = np.inf
    effects = lists.u[:, None, None] * H.T[None]
    for k, first in enumerate(effects[:, 0]):
        left = np.abs(question.y0 + first + effects[:, None, 1] + effects[None, :, 2]).max(axis=-1)
        uses = lists.uses[k] + lists.uses[:, None] + lists.uses[None, :]
        best = min(best, float(np.where(np.all(uses <= 1.0, axis=-1), left, np.inf).min()))
    assert solved.status == "optimal"
    assert solved.value == pytest.approx(best, rel=1e-9)
    assert solved.value > free.value * (1 + 1e-6)


def box(*weights: str) -> str:
    return f"holes = 12\nmost_weights = 2\nshelf = [{', '.join(weights)}]\n"


def test_a_plan_takes_no_more_weights_than_the_box_holds() -> None:
    """Against all fillings of both planes; the words count what is fitted."""
    shelf = box('{ mass = "5 g", stock = 1 }', '{ mass = "3 g", stock = 2 }', '"1 g"')
    text = fan(shelf, shelf)
    plan = solve_text(text)
    taken = Counter(round(weight.mass * 1e3, 9) for plane in plan.plan.planes for weight in plane.weights)
    assert plan.status == "optimal"
    assert taken[5.0] <= 1
    assert taken[3.0] <= 2
    put_back_of(text)
    identified = identify(read_text(text))
    ways: list[tuple[complex, Counter[float]]] = [(0.0, Counter())]
    for many in (1, 2):
        for places in combinations(range(12), many):
            for weights in product((1.0, 3.0, 5.0), repeat=many):
                z = sum(m * np.exp(-1j * TURN * k / 12) for k, m in zip(places, weights, strict=True))
                ways.append((complex(z) * 0.15e-3, Counter(weights)))
    u = np.array([z for z, _ in ways])
    counts = np.array([[count[5.0], count[3.0]] for _, count in ways])
    best = np.inf
    for z, count in ways:
        left = identified.y0 + identified.H[:, 0] * z + u[:, None] * identified.H[:, 1]
        fits = np.all(counts + np.array([count[5.0], count[3.0]]) <= np.array([1, 2]), axis=1)
        if not fits.any():
            continue
        best = min(best, float(np.sqrt((np.abs(left[fits]) ** 2).mean(axis=1)).min()))
    assert plan.goal is not None
    assert float(plan.goal[1].value) == pytest.approx(best, rel=1e-9)
    plenty = box('"5 g"', '"3 g"', '"1 g"')
    without = solve_text(fan(plenty, plenty)).goal
    assert without is not None
    assert float(without[1].value) < float(plan.goal[1].value)


@pytest.mark.parametrize(
    ("left", "right", "said"),
    [
        (
            ['{ mass = "5 g", stock = 0 }'],
            ['"1 g"'],
            'planes.left.shelf[1] = { mass = "5 g", stock = 0 } is no weight with its stock. Write { mass = "5 g", '
            "stock = 3 } with 1 or more, or leave the weight out.",
        ),
        (
            ['{ mass = "5 g", stock = 3 }'],
            ['"5 g"'],
            "planes.right.shelf has 5 g with no stock, planes.left.shelf with a stock of 3. A stock is for all planes "
            "together: write the same in each.",
        ),
        (
            ['{ mass = "5 g", stock = 3 }', '{ mass = "5 g", stock = 2 }'],
            ['"1 g"'],
            "names a weight twice with different stocks. Write it once, with all there are.",
        ),
    ],
)
def test_a_stock_that_cannot_be_is_refused(left: list[str], right: list[str], said: str) -> None:
    (found,) = messages(fan(box(*left), box(*right)))
    assert said in found


def test_a_stock_and_pairs_of_planes_are_refused_together() -> None:
    with pytest.raises(InputError, match="a stock of weights and pairs of planes do not go together"):
        Question(
            y0=np.ones(1), H=np.ones((1, 2)), importance=np.ones(1), limits=np.full(1, np.inf), caps=np.full(2, np.inf),
            stock=np.ones(1), pairs=((0, 1, 1.0),),
        )  # fmt: skip


def test_a_pair_and_a_list_of_one_plane_are_refused_together() -> None:
    listed = Options(np.array([0.0, 1.0], dtype=complex), np.array([0.0, 1.0]))
    with pytest.raises(InputError, match="a plane of a pair has a list of weights"):
        Question(
            y0=np.ones(1), H=np.ones((1, 2)), importance=np.ones(1), limits=np.full(1, np.inf), caps=np.full(2, np.inf),
            options=(None, listed), pairs=((0, 1, 1.0),),
        )  # fmt: skip


def test_a_shelf_without_a_stock_counts_nothing() -> None:
    job = read_text(FAN.replace("[planes.left]\n", "[planes.left]\n" + box('"5 g"')))
    assert job.planes[0].stock == ()
