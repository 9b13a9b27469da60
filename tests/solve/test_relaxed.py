"""What boxes of all variables prove of several absorbers: rows below every response, and bounds that nothing beats."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.optimize import linprog

from vibopt.charts.machines import absorbed
from vibopt.forms import Monomials
from vibopt.forms.rational import sampled
from vibopt.forms.rows_on_boxes import Rows, power_rows, response_rows
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict, from_text
from vibopt.solve.nlp import Nlp
from vibopt.solve.passive import with_bound
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve

relaxed = import_module("vibopt.solve.relaxed")
rows_on_boxes = import_module("vibopt.forms.rows_on_boxes")
few = settings(derandomize=True, database=None, deadline=None, max_examples=6)
HOST, MASSES = (100.0, 60.0), (4.0, 2.5)
SPRINGS = (100.0 * (20.0 * np.pi) ** 2, 60.0 * (32.0 * np.pi) ** 2)
W = 2.0 * np.pi * np.geomspace(4.0, 30.0, 40)


def scene(on: tuple[int, ...], *, about: tuple[str, str] = ("4 Hz", "30 Hz"), **more: Any) -> dict[str, Any]:
    """One or two absorbers on a chain of two masses, of which the lower is shaken and looked at."""
    links = {
        f"l{i}": {
            "between": [f"b{i}", f"b{i - 1}" if i else "ground"],
            "stiffness": f"{k!r} N/m",
            "damping": "40 N s/m",
        }
        for i, k in enumerate(SPRINGS)
    }
    own = {"frequency": {"from": about[0], "to": about[1]}, "damping_ratio": {"from": 0.01, "to": 0.6}}
    return {
        "title": "t",
        "bodies": {f"b{i}": {"mass": f"{m!r} kg"} for i, m in enumerate(HOST)},
        "links": links,
        "absorbers": {f"a{i}": {"on": f"b{on[i]}", "mass": f"{MASSES[i]!r} kg", **own} for i in range(len(on))},
        "excitations": {"e": {"kind": "force", "on": "b0", "amplitude": "100 N", "speed": "4 Hz..30 Hz"}},
        "goal": {"minimise": "displacement", "of": "b0"},
        **more,
    }


def by_matrices(x: np.ndarray, on: tuple[int, ...], w: np.ndarray, masses: Any = MASSES) -> np.ndarray:
    """Motion of the lower mass per speed with f1, zeta1, f2, zeta2 of the absorbers, by matrices of its own."""
    count = 2 + len(on)
    matrix = np.zeros((len(w), count, count), dtype=complex)

    def add(i: int, j: int, z: np.ndarray) -> None:
        for a, b, sign in ((i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)):
            if min(a, b) >= 0:
                matrix[:, a, b] += sign * z

    for i, (m, k) in enumerate(zip(HOST, SPRINGS, strict=True)):
        matrix[:, i, i] -= w**2 * m
        add(i, i - 1, k + 40j * w)
    for i, m in enumerate(masses[: len(on)]):
        f, zeta = x[2 * i : 2 * i + 2]
        matrix[:, 2 + i, 2 + i] -= w**2 * m
        add(2 + i, on[i], m * f**2 + 2j * zeta * m * f * w)
    load = np.array([100.0, *[0.0] * (count - 1)])
    return np.asarray(np.abs(np.linalg.solve(matrix, np.broadcast_to(load, (len(w), count))[..., None])[:, 0, 0]))


places = st.sampled_from([(0, 0), (0, 1), (1, 1)])


@pytest.mark.parametrize("on", [(0,), (1,), (0, 0), (0, 1), (1, 1)])
@few
@given(st.booleans(), st.integers(0, 999), st.floats(-3.0, 0.0))
def test_no_response_on_a_box_is_below_its_row(on: tuple[int, ...], heavy: bool, seed: int, size: float) -> None:
    """At corners and inside, of given and of any masses; on small boxes the row is the response to second order.

    Springs and dampers of some boxes may go down to nothing.
    """
    rng, document = np.random.default_rng(seed), scene(on)
    if heavy:
        for one in document["absorbers"].values():
            one["mass"] = {"from": "0.5 kg", "to": "10 kg"}
    program = pose(from_dict(document))
    assert program.aim is not None
    model, form = program.aim.model, program.aim.form.harmonic
    assert form is not None
    assert form.line is not None
    low, high = np.log(program.low), np.log(program.high)
    line = sampled(model, form.output, form.line, W, np.exp(0.5 * (low + high)))
    weighs = np.array([one.path.endswith("mass") for one in program.axes])

    def true(y: np.ndarray) -> np.ndarray:
        masses = np.exp(y[weighs]) if heavy else MASSES
        return np.log(by_matrices(np.exp(y[~weighs]), on, W, masses))

    middle = low + (high - low) * rng.random((30, len(low)))
    half = 10.0**size * rng.random(middle.shape)
    down = (rng.random(middle.shape) < 0.2) & ~weighs & (np.arange(30) % 2 == 0)[:, None]
    rows = response_rows(line, np.exp(middle), half, down)
    assert np.isfinite(rows.value[down.any(axis=1)]).any()
    for turn in range(6):
        way = rng.uniform(-1.0, 1.0, middle.shape)
        way = half * (np.sign(way) if turn % 2 else way)
        way = np.where(down & (rng.random(down.shape) < 0.5), -60.0 * rng.random(down.shape), way)
        for box in range(30):
            row = rows.value[box] + rows.slope[box] @ way[box]
            assert (row <= true(middle[box] + way[box]) + 1e-12).all()
    near = response_rows(line, np.exp(middle), np.full(middle.shape, 1e-4))
    assert np.quantile(np.array([true(one) for one in middle]) - near.value, 0.9) < 1e-3


@pytest.mark.parametrize("half", [0.0, 1e-9, 0.5])
def test_boxes_about_an_undamped_absorber_at_resonance_claim_nothing(half: float) -> None:
    """What is zero there has a row of minus infinity, and no warning of numpy reaches the user."""
    document: dict[str, Any] = {
        "title": "t",
        "bodies": {"bridge": {"mass": "15 t"}},
        "links": {"girder": {"between": ["bridge", "ground"], "stiffness": "2 MN/m"}},
        "absorbers": {"a": {"on": "bridge", "mass": "10 kg", "stiffness": {"from": "500 N/m", "to": "5 kN/m"}}},
        "excitations": {
            "e": {"kind": "force", "on": "bridge", "amplitude": "600 N", "speed": "11 rad/s", "varies": "constant"}
        },
        "goal": {"minimise": "displacement", "of": "bridge"},
    }
    aim = pose(from_dict(document)).aim
    assert aim is not None
    form = aim.form.harmonic
    assert form is not None
    assert form.line is not None
    tuned = np.array([[10.0 * 11.0**2]])
    line = sampled(aim.model, form.output, form.line, np.array([11.0]), tuned[0])
    assert (response_rows(line, tuned, np.array([[half]])).value == -np.inf).all()


def two_stages(goal: dict[str, str], low: str = "0 N s/m") -> dict[str, Any]:
    """A machine on a raft, every number of both mounts to be chosen; four of the lower ones share what they bear."""
    own = {"stiffness": {"from": "10 kN/m", "to": "1 MN/m"}, "damping": {"from": low, "to": "5 kN s/m"}}
    return {
        "title": "t",
        "bodies": {"machine": {"mass": "200 kg"}, "raft": {"mass": "100 kg"}},
        "links": {
            "upper": {"between": ["machine", "raft"], **own},
            "lower": {"between": ["raft", "ground"], "count": 4, **own},
        },
        "excitations": {"e": {"kind": "unbalance", "on": "machine", "unbalance": "0.1 kg m", "speed": "0..1500 rpm"}},
        "goal": goal,
    }


def of_two_stages(x: np.ndarray, w: np.ndarray) -> dict[str, np.ndarray]:
    """Motion of the machine, across the upper mount and the force of one lower one, by hand; x (4,) as in the file."""
    upper, lower = x[0] + 1j * w * x[1], 4.0 * (x[2] + 1j * w * x[3])
    raft = upper / (upper + lower - 100.0 * w**2)
    machine = 0.1 * w**2 / (upper - 200.0 * w**2 - upper * raft)
    sag = 9.80665 * (200.0 / x[0] + 300.0 / (4.0 * x[2])) * np.ones(len(w))
    found = {"displacement": machine, "relative_displacement": machine * (1.0 - raft), "static_deflection": sag}
    return {key: np.abs(one) for key, one in (found | {"transmitted_force": machine * raft * lower / 4.0}).items()}


STAGES = {
    "displacement": {"of": "machine"}, "relative_displacement": {"across": "upper"},
    "transmitted_force": {"through": "lower"}, "static_deflection": {"of": "machine"},
}  # fmt: skip


@few
@given(st.sampled_from(sorted(STAGES)), st.integers(0, 999), st.floats(-3.0, 0.0))
def test_no_response_of_two_stages_on_a_box_is_below_its_row(response: str, seed: int, size: float) -> None:
    rng, w = np.random.default_rng(seed), np.geomspace(5.0, 150.0, 20)
    program = pose(from_dict(two_stages({"minimise": response, **STAGES[response]}, "10 N s/m")))
    boxes = relaxed._Relaxed(program, program.aim.pieces, 10)
    [line] = boxes.lines.values()
    line._add(w.tolist() if line.known else [])
    middle = np.log(program.low) + np.log(program.high / program.low) * rng.random((30, 4))
    half = 10.0**size * rng.random(middle.shape)
    rows = boxes._rows(program.aim, np.exp(middle), half, np.zeros(half.shape, dtype=bool))
    for turn in range(4):
        way = half * (np.sign(rng.normal(size=half.shape)) if turn % 2 else rng.uniform(-1.0, 1.0, half.shape))
        for box in range(30):
            true = np.log(of_two_stages(np.exp(middle + way)[box], np.array(line.known or [1.0]))[response])
            assert (rows.value[box] + rows.slope[box] @ way[box] <= true + 1e-12).all()


@pytest.mark.parametrize(
    ("response", "sag"), [("transmitted_force", ""), ("transmitted_force", "3 mm"), ("relative_displacement", "")]
)
def test_two_stages_are_proven_best_of_all_that_are_tried(response: str, sag: str) -> None:
    """What a mount hands on hangs on both outright: N is of their product, and was bounded by nothing.

    What the weights press together is |N| / |D| without speeds.
    """
    document = two_stages({"minimise": response, **STAGES[response]})
    if sag:
        document["limits"] = {"sag": {"response": "static_deflection", "of": "machine", "at_most": sag}}
    found = solve(from_dict(document))
    assert found.status == "optimal"
    assert found.goal is not None
    w, rng = np.linspace(1e-3, 50.0 * np.pi, 3000), np.random.default_rng(1)
    best, y, spread = found.goal[1].value, np.log(np.maximum(found.x, 1e-3)), 1.0
    assert of_two_stages(np.array(found.x), w)[response].max() == pytest.approx(best, rel=1e-4)
    for _ in range(200):
        there = np.clip(y + spread * rng.normal(size=4), np.log([1e4, 1e-6] * 2), np.log([1e6, 5e3] * 2))
        tried = of_two_stages(np.exp(there), w)
        assert tried[response].max() > best * (1.0 - 1e-4) or (sag and tried["static_deflection"][0] > 3e-3)
        spread *= 0.98


def test_what_is_best_left_out_is_nothing_and_not_next_to_it() -> None:
    """Far above resonance dampers hand on force: a search in logs ended at a part of 1e-9 of their range."""
    document = two_stages({"minimise": "transmitted_force", "through": "lower"})
    document["excitations"]["e"]["speed"] = "600..1500 rpm"
    found = solve(from_dict(document))
    assert found.status == "optimal"
    assert found.x[1::2] == (0.0, 0.0)
    assert found.goal is not None
    w = np.linspace(20.0 * np.pi, 50.0 * np.pi, 3000)
    assert of_two_stages(np.array(found.x), w)["transmitted_force"].max() == pytest.approx(
        found.goal[1].value, rel=1e-9
    )


def test_boxes_that_break_a_limit_on_a_natural_frequency_are_out() -> None:
    """It is bounded on boxes and has no rows: it was left out, and what it holds back was not proven."""
    document = two_stages({"minimise": "transmitted_force", "through": "lower"})
    document["limits"] = {"first": {"response": "natural_frequency", "mode": 1, "at_least": "4 Hz"}}
    del document["links"]["lower"]["count"]
    found = solve(from_dict(document))
    assert found.status == "optimal"
    assert found.goal is not None
    w, rng = np.linspace(1e-3, 50.0 * np.pi, 3000), np.random.default_rng(2)
    y, spread, tried = np.log(np.maximum(found.x, 1e-3)), 1.0, 0
    while tried < 60:
        x = np.exp(np.clip(y + spread * rng.normal(size=4), np.log([1e4, 1e-6] * 2), np.log([1e6, 5e3] * 2)))
        stiff = np.array([[x[0], -x[0]], [-x[0], x[0] + x[2]]])
        first = eigh(stiff, np.diag([200.0, 100.0]), eigvals_only=True)[0]
        spread *= 0.998
        if first >= (8.0 * np.pi) ** 2:
            tried += 1
            force = 4.0 * of_two_stages(x / [1.0, 1.0, 4.0, 4.0], w)["transmitted_force"].max()
            assert force > found.goal[1].value * (1.0 - 1e-4)


@few
@given(st.integers(0, 999), st.booleans())
def test_no_sum_of_powers_on_a_box_is_below_its_row(seed: int, least: bool) -> None:
    """And no one over a power where that is asked for; some variables may go down to nothing."""
    rng = np.random.default_rng(seed)
    powers = Monomials(
        10.0 ** rng.uniform(-2.0, 2.0, 1 if least else 3), rng.integers(0, 3, (1 if least else 3, 4)) / 2.0
    )
    middle, half, down = 10.0 ** rng.normal(size=(30, 4)), rng.random((30, 4)), rng.random((30, 4)) < 0.3
    rows = power_rows(powers, middle, half, down, least=least)
    for _ in range(6):
        way = half * np.sign(rng.uniform(-1.0, 1.0, half.shape))
        way = np.where(down & (rng.random(down.shape) < 0.5), -60.0 * rng.random(down.shape), way)
        true = np.log((powers.scale * np.prod((middle * np.exp(way))[:, None] ** powers.exponents, axis=2)).sum(axis=1))
        row = rows.value[:, 0] + (rows.slope[:, 0] * way).sum(axis=1)
        assert (row <= (-true if least else true)).all()


@pytest.mark.parametrize("zero", ["damping_ratio", "stiffness and damping"])
def test_two_absorbers_of_which_a_number_begins_at_zero_are_proven_best(zero: str) -> None:
    """As they are with a range that begins above: it is the same design."""
    document = scene((0, 0), about=("5 Hz", "12 Hz"))
    for m, one in zip(MASSES, document["absorbers"].values(), strict=True):
        one["damping_ratio"] = {"from": 0, "to": 0.6}
        if zero != "damping_ratio":
            del one["frequency"], one["damping_ratio"]
            one["stiffness"] = {"from": "0 N/m", "to": f"{m * (24.0 * np.pi) ** 2!r} N/m"}
            one["damping"] = {"from": "0 N s/m", "to": "1 kN s/m"}
    above, found = solve(from_dict(scene((0, 0), about=("5 Hz", "12 Hz")))), solve(from_dict(document))
    assert (above.status, found.status) == ("optimal", "optimal")
    assert above.goal is not None
    assert found.goal is not None
    assert found.goal[1].value == pytest.approx(above.goal[1].value, rel=2e-6)


@few
@given(places, st.integers(0, 999))
def test_nothing_beats_the_bound(on: tuple[int, int], seed: int) -> None:
    """Trials, ever nearer to the best of them, measured by matrices of their own at many speeds."""
    rng, w = np.random.default_rng(seed), 2.0 * np.pi * np.geomspace(4.0, 30.0, 1500)
    program = pose(from_dict(scene(on)))
    x = np.array([60.0, 0.15, 65.0, 0.15])
    best = np.log(by_matrices(x, on, w).max())
    boxes = relaxed._Relaxed(program, program.aim.pieces, 1500)
    boxes.learn(x)
    bound = boxes.search(best)
    y, spread = np.log(x), 0.5
    for _ in range(250):
        there = np.clip(y + spread * rng.normal(size=4), np.log(program.low), np.log(program.high))
        top = np.log(by_matrices(np.exp(there), on, w).max())
        assert top >= bound
        y, best, spread = (there, top, 1.3 * spread) if top < best else (y, best, 0.97 * spread)


@few
@given(st.integers(0, 999), st.integers(1, 5), st.booleans(), st.floats(-7.0, 1.0))
def test_rows_are_weighed_as_by_a_linear_program(seed: int, n: int, limited: bool, size: float) -> None:
    """By HiGHS, box by box: never above it, and near it; where limits cannot hold, above any bar."""
    rng, many = np.random.default_rng(seed), 6 + 4 * limited
    value, slope = 10.0**size * rng.normal(size=(20, many)) - 9.0, 10.0**size * rng.normal(size=(20, many, n))
    value[rng.random(value.shape) < 0.2] = -np.inf
    value[:, 0] = -9.0
    value[:, 6:] += 9.0
    half, goal = rng.uniform(0.1, 2.0, (20, n)), np.arange(many) < 6
    bound = relaxed._best_weighed(Rows(value, slope), goal, half)
    for box in range(20):
        use = np.isfinite(value[box])
        rows = np.column_stack([slope[box] * half[box], np.where(goal, -1.0, 0.0)])[use]
        ends = [(-1.0, 1.0)] * n + [(None, None)]
        found = linprog(np.eye(n + 1)[n], rows, (-9.0 * goal - value[box])[use], bounds=ends)
        if found.status == 2:
            assert bound[box] > 10.0**size * 10.0 - 9.0
        else:
            assert -2e-2 * 10.0**size <= bound[box] + 9.0 - found.fun <= 1e-6 * 10.0**size + 1e-12


@pytest.mark.parametrize("on", [(0, 1), *(pytest.param(one, marks=pytest.mark.slow) for one in ((0, 0), (1, 1)))])
def test_two_absorbers_are_proven_best_of_all_that_tune(on: tuple[int, int]) -> None:
    found = solve(from_dict(scene(on)))
    assert found.status == "optimal"
    assert found.claim.startswith("proven by ")
    assert found.goal is not None
    top = by_matrices(np.array(found.x), on, 2.0 * np.pi * np.geomspace(4.0, 30.0, 6000)).max()
    assert top == pytest.approx(found.goal[1].value, rel=1e-4)


def test_two_absorbers_are_proven_best() -> None:
    """With a limit a little lower there is proven to be no design; measured by matrices of their own."""
    near = ("8 Hz", "12 Hz")
    found = solve(from_dict(scene((0, 0), about=near)))
    assert found.status == "optimal"
    assert found.goal is not None
    assert found.claim.endswith("boxes of all variables: nothing is better by more than 1e-06 of the goal")
    best = found.goal[1].value
    w = 2.0 * np.pi * np.geomspace(4.0, 30.0, 6000)
    assert by_matrices(np.array(found.x), (0, 0), w).max() == pytest.approx(best, rel=1e-4)
    still = {"response": "displacement", "of": "b0", "at_most": f"{0.97 * best!r} m"}
    none = scene((0, 0), about=near, limits={"still": still}, goal={"minimise": "stroke", "of": "a0"})
    nothing = solve(from_dict(none), explain=False)
    assert nothing.status == "infeasible"
    assert nothing.claim.startswith("proven by boxes of all variables: every one of ")


def test_two_absorbers_of_which_any_physical_bound_says_little_are_proven_best() -> None:
    """Boxes rise late where either absorber may take either peak: they are not given up before."""
    sizes = ((0.245, (1236.0, 22940.0), (0.03481, 149.9)), (0.189, (953.6, 17700.0), (0.02685, 115.7)))
    found = solve(from_dict({
        "title": "t",
        "bodies": {"b": {"mass": "14.4 kg"}},
        "links": {"l": {"between": ["b", "ground"], "stiffness": "398334 N/m", "damping": "23.95 N s/m"}},
        "absorbers": {
            f"a{i}": {
                "on": "b",
                "mass": f"{m} kg",
                "stiffness": {"from": f"{k[0]} N/m", "to": f"{k[1]} N/m"},
                "damping": {"from": f"{c[0]} N s/m", "to": f"{c[1]} N s/m"},
            }
            for i, (m, k, c) in enumerate(sizes)
        },
        "excitations": {"e": {"kind": "force", "on": "b", "amplitude": "1 kN", "speed": "142.065..203.996 rad/s"}},
        "goal": {"minimise": "displacement", "of": "b"},
    }))  # fmt: skip
    assert found.status == "optimal"
    assert found.claim.startswith("proven by ")


def test_what_is_not_proven_best_says_how_far_it_may_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(relaxed, "_WORK", 40_000)
    found = solve(from_dict(scene((0, 1))))
    assert found.status == "feasible"
    assert found.claim.endswith(" % above the least possible")
    assert found.goal is not None
    assert 0.97 * found.goal[1].value < found.details["bound"] <= found.goal[1].value


@pytest.mark.parametrize(
    ("percent", "said"),
    [(42.5, "43"), (7.26, "7.3"), (0.0261, "0.027"), (4.4, "4.4"), (10.0, "10"), (357.2, "358"), (1e-4, "0.00010")],
)
def test_what_is_said_of_a_bound_is_never_less_than_it(percent: float, said: str) -> None:
    assert relaxed._no_less(percent) == said


def test_below_the_greatest_is_counted_of_the_greatest() -> None:
    """Nothing above zero is more than a hundred percent below anything."""
    asked = scene((0, 1), limits={"moved": {"response": "displacement", "of": "b0", "at_most": "2 mm"}})
    for absorber in asked["absorbers"].values():
        absorber["damping_ratio"] = 0.2
    asked["links"]["l1"] |= {
        "stiffness": {"from": "0.2 MN/m", "to": "0.6 MN/m"},
        "damping": {"from": "40 N s/m", "to": "400 N s/m"},
    }
    found = solve(from_dict({**asked, "goal": {"maximise": "stiffness", "of": "l1"}}), explain=False)
    assert found.status == "feasible"
    assert found.goal is not None
    below = 100.0 * (1.0 - found.goal[1].value / abs(found.details["bound"]))
    assert found.claim.endswith(f"; at most {relaxed._no_less(below)} % below the greatest possible")


def ordered(document: dict[str, Any]) -> list[tuple[str, str]]:
    """Variables of which boxes keep one order only."""
    program = closed(pose(from_dict(document)))
    assert program.aim is not None
    boxes = relaxed._Relaxed(program, program.aim.pieces)
    return [(program.axes[i].path, program.axes[j].path) for i, j in boxes.space.orders]


@pytest.mark.parametrize(
    ("on", "masses", "strokes", "alike"),
    [
        ((1, 1), ("3 kg", "3 kg"), (), True),
        ((1, 1), ("3 kg", "3 kg"), ("9 mm", "9 mm"), True),
        ((1, 1), ("3 kg", "3 kg"), ("9 mm", "8 mm"), False),
        ((1, 1), ("3 kg", "3 kg"), ("9 mm",), False),
        ((1, 1), ("3 kg", "3.000001 kg"), (), False),
        ((0, 1), ("3 kg", "3 kg"), (), False),
    ],
)
def test_one_order_is_kept_of_devices_that_are_alike(
    on: tuple[int, int], masses: tuple[str, str], strokes: tuple[str, ...], alike: bool
) -> None:
    document = scene(on)
    for one, mass in zip(document["absorbers"].values(), masses, strict=True):
        one["mass"] = mass
    for name, stroke in zip(document["absorbers"], strokes, strict=False):
        document.setdefault("limits", {})[name] = {"response": "stroke", "of": name, "at_most": stroke}
    pair = ("absorbers.a0.frequency", "absorbers.a1.frequency")
    assert ordered(document) == ([pair] if alike else [])


def test_one_order_of_devices_that_are_alike_bounds_both() -> None:
    """With as many boxes no worse a bound, and nothing in either order is below it."""
    document = scene((0, 0))
    for one in document["absorbers"].values():
        one["mass"] = "3 kg"
    program = closed(pose(from_dict(document)))
    assert program.aim is not None
    w, rng = 2.0 * np.pi * np.geomspace(4.0, 30.0, 1500), np.random.default_rng(5)
    x = np.array([58.0, 0.12, 66.0, 0.12])
    top = np.log(by_matrices(x, (0, 0), w, (3.0, 3.0)).max())
    bounds = []
    for every in (True, False):
        boxes = relaxed._Relaxed(program, program.aim.pieces, 1500)
        boxes.hung, boxes.space = None, replace(boxes.space, orders=() if every else boxes.space.orders)
        bounds.append(boxes.search(top))
    assert bounds[0] < bounds[1] <= top
    for _ in range(300):
        there = x * np.exp(0.1 * rng.normal(size=4))
        for one in (there, there[[2, 3, 0, 1]]):
            assert np.log(by_matrices(one, (0, 0), w, (3.0, 3.0)).max()) >= bounds[1]


@pytest.mark.parametrize("listed", [("8 Hz", "9.3 Hz", "11.9 Hz"), ("9 Hz", "9.1 Hz")])
def test_what_is_listed_is_bounded_beside_ranges(listed: tuple[str, ...]) -> None:
    """No combination is below the bound, which is near."""
    document, rng = scene((0, 0), about=("8 Hz", "12 Hz")), np.random.default_rng(2)
    document["absorbers"]["a0"]["frequency"] = {"one_of": list(listed)}
    program, w = closed(pose(from_dict(document))), 2.0 * np.pi * np.geomspace(4.0, 30.0, 1500)
    assert program.aim is not None
    tops: list[float] = []
    for choice in 2.0 * np.pi * np.array([float(one.split()[0]) for one in listed]):
        y, best, spread = np.log([0.15, 62.0, 0.15]), np.inf, 0.3
        for _ in range(150):
            there = np.clip(y + spread * rng.normal(size=3), np.log(program.low[1:]), np.log(program.high[1:]))
            top = float(np.log(by_matrices(np.array([choice, *np.exp(there)]), (0, 0), w).max()))
            y, best, spread = (there, top, 1.3 * spread) if top < best else (y, best, 0.97 * spread)
        tops.append(best)
    boxes = relaxed._Relaxed(program, program.aim.pieces, 2000)
    boxes.learn(np.array([program.low[0], 0.15, program.low[2], 0.15]))
    assert min(tops) - 0.1 < boxes.search(min(tops) + 0.01) <= min(tops)


def test_boxes_that_gain_next_to_nothing_are_left_early(monkeypatch: pytest.MonkeyPatch) -> None:
    """Six numbers of three absorbers: any passive device is a better bound than rows, and discs know more."""
    program = closed(pose(from_text(absorbed([0] * 3, [0.01] * 3))))
    found = Nlp(count=2).solve(program)
    known = with_bound(program, found).bound
    assert relaxed.with_least(program, found, lambda: known).details["bound"] > known
    monkeypatch.setattr(relaxed, "MOST", 0)
    early = relaxed.with_least(program, found, lambda: known)
    monkeypatch.setattr(relaxed, "_EARLY", 1.0)
    late = relaxed.with_least(program, found, lambda: known)
    assert early.status == late.status == "feasible"
    assert early.details["bound"] <= late.details["bound"] < known
    assert early.details["boxes"] < 0.5 * late.details["boxes"]


def test_boxes_of_which_nothing_is_known_are_left_without_a_warning() -> None:
    """What is handed on beside a resonance of the mount and the inerter that may be chosen."""
    document = {
        "title": "t",
        "bodies": {"disc": {"inertia": "1.16 kg m2"}},
        "links": {
            "shaft": {
                "between": ["disc", "ground"],
                "torsional_stiffness": {"from": "15 kN m/rad", "to": "1.5 MN m/rad"},
                "loss_factor": 0.123,
            }
        },
        "inerters": {
            "flywheel": {
                "between": ["ground", "disc"],
                "torsional_inertance": {"from": "0.0153 kg m2", "to": "0.0612 kg m2"},
            }
        },
        "excitations": {"e": {"kind": "moment", "on": "disc", "amplitude": "9 N m", "speed": "103..148 Hz"}},
        "goal": {"minimise": "transmissibility", "into": "disc"},
    }
    program = closed(pose(from_dict(document)))
    assert program.aim is not None
    assert relaxed._Relaxed(program, program.aim.pieces, 500).search(np.float64(5.0)) < 5.0


@few
@given(places, st.integers(0, 999))
def test_what_is_cut_off_a_box_is_above_the_bar(on: tuple[int, int], seed: int) -> None:
    """Designs outside of what is left of a box, by matrices of their own at the same speeds."""
    rng, program, bar = np.random.default_rng(seed), closed(pose(from_dict(scene(on)))), np.log(9e-4)
    assert program.aim is not None
    boxes = relaxed._Relaxed(program, program.aim.pieces)
    low, high = np.log(program.low), np.log(program.high)
    middle, half = low + (high - low) * rng.random((60, 4)), 10.0 ** rng.uniform(-3.0, 0.0, (60, 4))
    _, left, right = boxes._on(middle - half, middle + half, bar)
    assert (left >= middle - half).all()
    assert (right <= middle + half).all()
    cut, w = 0, np.array(next(iter(boxes.lines.values())).known)
    for box in range(60):
        for there in middle[box] + half[box] * rng.uniform(-1.0, 1.0, (20, 4)):
            if (there < left[box]).any() or (there > right[box]).any():
                cut += 1
                assert np.log(by_matrices(np.exp(there), on, w).max()) >= bar - 1e-9
    assert cut > 50


@few
@given(st.integers(0, 999))
def test_one_over_a_rectangle_is_in_its_disc(seed: int) -> None:
    """It has an end wherever the rectangle is on one side of an axis, also where a disc around it is not."""
    rng = np.random.default_rng(seed)
    middle = rng.normal(size=200) + 1j * rng.normal(size=200)
    sides = rng.uniform(0.0, 2.0, 200) * np.abs(middle.real) + 1j * rng.uniform(0.0, 2.0, 200) * np.abs(middle.imag)
    found, wide = rows_on_boxes._inverse_disc(middle, np.abs(sides), sides)
    beside = (sides.real < np.abs(middle.real)) | (sides.imag < np.abs(middle.imag))
    assert (np.isfinite(wide) == beside).all()
    for real, imag in rng.uniform(-1.0, 1.0, (50, 2)):
        there = middle + real * sides.real + 1j * imag * sides.imag
        assert (np.abs(1.0 / there - found)[beside] <= wide[beside] * (1.0 + 1e-9) + 1e-12).all()


STROKE = '[limits.stroke]\nresponse = "stroke"\nof = "a0"\nat_most = "0.3 mm"\n'


@pytest.mark.parametrize(
    ("document", "most"),
    [
        (absorbed([0, 0], [0.025] * 2), 5_000),
        (absorbed([0, 0], [0.094, 0.016]), 9_000),
        (absorbed([0, 1], [0.063, 0.031], count=2, damping=0.02, extra=STROKE), 16_000),
        *(pytest.param(scene(on), 14_000, marks=pytest.mark.slow) for on in ((0, 0), (0, 1), (1, 1))),
    ],
)
def test_two_absorbers_are_proven_by_few_boxes(document: Any, most: int) -> None:
    """The first design that is found is proven, so that no other is looked for; no short side is cut for ever."""
    found = solve(from_text(document) if isinstance(document, str) else from_dict(document))
    assert found.status == "optimal"
    assert found.details["starts"] < 4
    assert found.details["boxes"] < most


def test_what_is_not_proven_at_once_is_searched_as_before() -> None:
    """Asked once, of the first design and its orders; the same boxes are not looked at a second time."""
    program, asked, told = closed(pose(from_dict(scene((0, 0))))), [], dict[float, Any]()

    def proof(found: Any) -> Any:
        asked.append(found.x)
        return found

    begun, plain = Nlp(proof=proof).solve(program), Nlp().solve(program)
    assert len(asked) == 1
    assert (begun.claim, begun.details["starts"]) == (plain.claim, plain.details["starts"])
    assert begun.x == pytest.approx(plain.x, rel=1e-9)
    first, again = (relaxed.with_least(program, plain, told=told) for _ in range(2))
    assert len(told) == 1
    assert first.claim == again.claim
    assert first.details == again.details


def test_a_response_that_no_variable_moves_is_a_row_of_its_own() -> None:
    """A pump beside a press: under its own force the pump moves alike whatever is chosen for the press."""
    pump = {"between": ["pump", "ground"], "stiffness": "300 kN/m", "damping": "20 N s/m"}
    mount = {
        "between": ["press", "ground"],
        "stiffness": {"from": "1 MN/m", "to": "100 MN/m"}, "damping": {"from": "100 N s/m", "to": "100 kN s/m"},
    }  # fmt: skip
    asked = {"response": "relative_displacement", "across": "feet", "due_to": ["pump"]}
    document = {
        "bodies": {"press": {"mass": {"from": "140 kg", "to": "1200 kg"}}, "pump": {"mass": "2 kg"}},
        "links": {"mount": mount, "feet": pump},
        "excitations": {
            "punch": {"kind": "force", "on": "press", "amplitude": "150 N", "speed": "60..190 rad/s"},
            "pump": {"kind": "force", "on": "pump", "amplitude": "300 N", "speed": "100..400 rad/s"},
        },
        "goal": {"minimise": "relative_displacement", "across": "mount", "combine": "rss"},
    }
    w = np.linspace(100.0, 400.0, 300_001)
    most = float((300.0 / np.abs(300e3 - 2.0 * w**2 + 20.0j * w)).max())
    for factor, status in ((1.001, "optimal"), (0.999, "infeasible")):
        found = solve(from_dict({**document, "limits": {"pump": {**asked, "at_most": f"{factor * most!r} m"}}}))
        assert found.status == status, found.claim
    found = solve(from_dict({**document, "limits": {"pump": {**asked, "at_most": "50 mm"}}}))
    w = np.linspace(60.0, 190.0, 100_001)
    least = (150.0 / np.abs(100e6 - 140.0 * w**2 + 100e3j * w)).max()  # stiff, light and damped
    assert found.goal[1].value == pytest.approx(least, rel=1e-9)
