"""No machine of a box decays faster, or has its least damped mode better damped, than what is known of the box."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from vibopt.arrays import FloatArray
from vibopt.forms.bounds import FormBounds
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_text
from vibopt.solve.boundable import unbounded
from vibopt.solve.choose import choose
from vibopt.solve.ranges import closed

few = settings(derandomize=True, database=None, deadline=None, max_examples=18)
ASKED = ("decay_rate", "damping_ratio", "logarithmic_decrement")
Machine = tuple[list[float], list[float], list[float]]


def text(machine: Machine, goal: str, *, drifts: bool = False) -> str:
    """A chain from the ground up, or without it; the last body is an absorber whose numbers are chosen."""
    masses, springs, dampers = machine
    words = []
    for i, (m, k, c) in enumerate(zip(masses, springs, dampers, strict=True)):
        below, last = f"b{i - 1}" if i else "ground", i == len(masses) - 1
        each = [f'{{ from = "{one / 30.0!r} {unit}", to = "{one * 30.0!r} {unit}" }}' if last and unit != "kg" else
                f'"{one!r} {unit}"' for one, unit in ((m, "kg"), (k, "N/m"), (c, "N s/m"))]  # fmt: skip
        words.append(f"[bodies.b{i}]\nmass = {each[0]}")
        if i or not drifts:
            words.append(f"[links.l{i}]\nbetween = ['b{i}', '{below}']\nstiffness = {each[1]}\ndamping = {each[2]}")
    return "\n".join([*words, f'[goal]\nmaximise = "{goal}"'])


def drawn(rng: np.random.Generator, bodies: int) -> Machine:
    masses = (10.0 ** rng.uniform(0.0, 1.0, bodies)).tolist()
    springs = (10.0 ** rng.uniform(3.0, 4.0, bodies)).tolist()
    light = 10.0 ** rng.uniform(-3.0, -1.0)
    dampers = [2.0 * light * float(np.sqrt(k * m)) for m, k in zip(masses, springs, strict=True)]
    masses[-1] *= 0.1
    return masses, springs, dampers


def numbers(machine: Machine, x: FloatArray, goal: str, *, drifts: bool = False) -> float:
    """By a companion matrix of the chain's own matrices; of what drifts both poles next to zero are left out."""
    masses, springs, dampers = machine
    n = len(masses)
    stiff, damped = np.zeros((2, n, n))
    for i, (k, c) in enumerate(zip([*springs[:-1], x[0]], [*dampers[:-1], x[1]], strict=True)):
        across = (np.eye(n)[i] - (np.eye(n)[i - 1] if i else 0.0)) * (i > 0 or not drifts)
        stiff += k * np.outer(across, across)
        damped += c * np.outer(across, across)
    light = np.diag(1.0 / np.array(masses))
    poles = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-light @ stiff, -light @ damped]]))
    poles = poles[np.argsort(np.abs(poles))[2 * drifts :]]
    if goal == "decay_rate":
        return float(-poles.real.max())
    swinging = poles[np.abs(poles.imag) > 1e-7 * np.abs(poles)]
    ratio = float((-swinging.real / np.abs(swinging)).min(initial=np.inf))
    return ratio if goal == "damping_ratio" else 2.0 * np.pi * ratio / float(np.sqrt(1.0 - ratio**2))


def posed(machine: Machine, goal: str, *, drifts: bool = False) -> Program:
    return closed(pose(from_text(text(machine, goal, drifts=drifts))))


@few
@given(seed=st.integers(0, 100_000), bodies=st.integers(2, 6), goal=st.sampled_from(ASKED), drifts=st.booleans())
def test_no_design_of_a_box_is_better_damped_than_its_bound(seed: int, bodies: int, goal: str, drifts: bool) -> None:
    """On boxes of any width; on narrow ones the bound is next to the number."""
    rng = np.random.default_rng(seed)
    machine = drawn(rng, bodies)
    program = posed(machine, goal, drifts=drifts)
    (one,) = program.parts
    known = FormBounds(one.model, one.form, np.sqrt(program.low * program.high))
    x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (40, 2)))
    reach = np.exp(10.0 ** rng.uniform(-6.0, 0.5, (40, 2)))
    low, high = np.maximum(x / reach, program.low), np.minimum(x * reach, program.high)
    least, most = known.on(low, high)
    assert (least == 0.0).all()
    for there in (
        x,
        low,
        high,
        np.exp(rng.uniform(np.log(low), np.log(high))),
        np.where(rng.random(x.shape) < 0.5, low, high),
    ):
        own = np.array([numbers(machine, design, goal, drifts=drifts) for design in there])
        assert (np.where(np.isinf(own), 0.0, own) <= most * (1.0 + 1e-7)).all()
    narrow = known.on(x * (1.0 - 1e-7), x * (1.0 + 1e-7))[1]
    near = np.array([numbers(machine, design, goal, drifts=drifts) for design in x])
    assert np.median((narrow / near)[np.isfinite(near)]) < 1.001


@pytest.mark.parametrize("seed", range(3))
def test_of_one_mass_both_ends_are_known(seed: int) -> None:
    """By the roots of m s^2 + c s + k, below and above critical damping; at one design both ends are the number."""
    rng = np.random.default_rng([23, seed])
    masses, springs, dampers = machine = drawn(rng, 1)
    dampers = [2.0 * float(np.sqrt(springs[0] * masses[0]))]
    program = posed((masses, springs, dampers), "decay_rate")
    (one,) = program.parts
    known = FormBounds(one.model, one.form, np.sqrt(program.low * program.high))
    x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (200, 2)))
    reach = np.exp(10.0 ** rng.uniform(-6.0, 0.5, (200, 2)))
    low, high = np.maximum(x / reach, program.low), np.minimum(x * reach, program.high)
    least, most = known.on(low, high)
    for there in (x, low, high, np.exp(rng.uniform(np.log(low), np.log(high)))):
        own = np.array([-np.roots([masses[0], c, k]).real.max() for k, c in there])
        assert (own <= most * (1.0 + 1e-7)).all()
        assert (own >= least * (1.0 - 1e-7)).all()
    own = np.array([numbers(machine, at, "decay_rate") for at in x])
    for end in known.on(x, x):
        assert end == pytest.approx(own, rel=1e-6)


@pytest.mark.parametrize(("asked", "status"), [(0.9, "optimal"), (1.1, "infeasible")])
def test_a_decay_rate_of_one_mass_is_proven(asked: float, status: str) -> None:
    """At best it is damped critically on the stiffest spring."""
    document = text(([2.0], [500.0], [60.0]), "x").split("[goal]")[0]
    best = float(np.sqrt(30.0 * 500.0 / 2.0))
    document += f'[limits.d]\nresponse = "decay_rate"\nat_least = "{asked * best!r} 1/s"\n'
    answer = vo.solve(from_text(document + '[goal]\nminimise = "damping"\nof = "l0"'))
    assert answer.status == status
    if status == "optimal":
        assert answer.goal[1].value == pytest.approx(4.0 * asked * best, rel=1e-6)


@pytest.mark.parametrize("stiff", [1e6, 1e8])
def test_what_rounding_takes_of_determinants_beside_a_stiff_link_is_counted(stiff: float) -> None:
    """The bound on the least damping ratio is never below what hardly damped modes have."""
    told = 0
    for seed in range(12):
        rng = np.random.default_rng([3, seed])
        masses, springs, _ = machine = drawn(rng, 3)
        springs[1] *= stiff
        machine = masses, springs, [1e-9 * float(np.sqrt(k * m)) for k, m in zip(springs, masses, strict=True)]
        program = posed(machine, "damping_ratio")
        (one,) = program.parts
        x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (100, 2)))
        reach = 1.0 + 10.0 ** rng.uniform(-9.0, -2.0, (100, 1))
        most = FormBounds(one.model, one.form, np.sqrt(program.low * program.high)).on(x / reach, x * reach)[1]
        own = np.array([numbers(machine, design, "damping_ratio") for design in x])
        assert (own <= most + 1e-13 * np.sqrt(stiff)).all()
        told += int((most < 1.0).sum())
    assert told > 0 or stiff > 1e6


@pytest.mark.parametrize("ratio", [0.01, 0.05, 0.3])
def test_two_pairs_of_poles_that_meet_are_proven_best(ratio: float) -> None:
    """An absorber on an undamped machine: the decay rate is half its frequency times the root of mu / (1 + mu)."""
    answer = vo.solve(from_text(text(([1.0, ratio], [1.0, ratio], [0.0, ratio]), "decay_rate").replace(
        'damping = "0.0 N s/m"', ""
    )))  # fmt: skip
    assert answer.status == "optimal"
    assert answer.goal[1].value == pytest.approx(0.5 * np.sqrt(ratio / (1.0 + ratio)), rel=1e-6)
    assert answer.claim == "proven by branch and bound: nothing is better by more than 1e-05 of the goal"


@pytest.mark.parametrize(
    ("seed", "goal"), [(1, "decay_rate"), (2, "damping_ratio"), *(
        pytest.param(seed, ASKED[seed % 3], marks=pytest.mark.slow) for seed in range(3, 15)
    )]
)  # fmt: skip
def test_the_best_damped_design_is_proven_and_no_sample_beats_it(seed: int, goal: str) -> None:
    rng = np.random.default_rng([17, seed])
    machine = drawn(rng, 2 + seed % 3)
    program = posed(machine, goal)
    answer = vo.solve(from_text(text(machine, goal)))
    assert answer.status == "optimal"
    best = answer.goal[1].value
    x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (4000, 2)))
    for _ in range(6):  # closer around the best of them
        own = np.array([numbers(machine, one, goal) for one in x])
        assert own.max() <= best * (1.0 + 2e-5)
        x = np.clip(x[own.argmax()] * np.exp(0.1 * rng.normal(size=(300, 2))), program.low, program.high)


@few
@given(seed=st.integers(0, 100_000), bodies=st.integers(2, 6), goal=st.sampled_from(ASKED), listed=st.booleans())
def test_boxes_are_asked_for_the_most_of_a_poles_number_alone(
    seed: int, bodies: int, goal: str, *, listed: bool
) -> None:
    """Of the least they know nothing: starts have it, on each listed value of its own."""
    words, methods = text(drawn(np.random.default_rng(seed), bodies), goal), []
    if listed:
        words = words.replace("[goal]", "[bodies.more]\nmass = { one_of = ['1 kg', '2 kg'] }\n[links.up]\n"
                              "between = ['more', 'b0']\nstiffness = '1 N/m'\ndamping = '1 N s/m'\n[goal]")  # fmt: skip
    for sense in ("maximise", "minimise"):
        program = closed(pose(from_text(words.replace("maximise", sense))))
        methods.append(choose(program, None).name)
        assert (unbounded(program.parts) is None) == (sense == "maximise" and bodies + listed <= 6)
    assert methods[1] == ("each_listed" if listed else "nlp")
    assert methods[0] == methods[1] or bodies + listed <= 6


def test_what_has_no_bounds_is_said() -> None:
    many = posed(drawn(np.random.default_rng(0), 7), "decay_rate").parts[0]
    assert not FormBounds(many.model, many.form, np.ones(2)).bounded
    assert many.form.no_bounds == (
        "is a decay rate: of up to three variables and six coordinates, held or free, poles have bounds"
    )
    loose = from_text(text(drawn(np.random.default_rng(0), 2), "damping_ratio").replace(
        "[bodies.b0]", "[bodies.free]\nmass = '1 kg'\n[links.drag]\nbetween = ['free', 'ground']\n"
        "damping = '1 N s/m'\n[bodies.b0]"
    ).replace("'b0', 'ground'", "'b0', 'free'"))  # fmt: skip
    free = closed(pose(loose)).parts[0]
    assert not FormBounds(free.model, free.form, np.ones(2)).bounded
