"""What holds of answers over tolerances: nothing within them is worse, and they never make a goal better."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from texts import ANY_DAMPING, STIFFEST, choice, floor, moves, press
from vibopt.arrays import FloatArray
from vibopt.program.over import Cover
from vibopt.program.pose import pose
from vibopt.program.worst_case import around, hit
from vibopt.scene.read import from_dict, from_text
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve import solve
from vibopt.solve.branch import Judge
from vibopt.solve.proof import parts_of, raised, worst_machines
from vibopt.solve.robust import judged
from vibopt.verify.certify import measure
from vibopt.work import Budget

_parts = st.sampled_from([0.0, 0.02, 0.05, 0.1, 0.2, 0.4])


def _text(value: float | str, unit: str, off: float) -> dict[str, object] | str:
    said = f"{value!r} {unit}"
    return {"value": said, "tolerance": off} if off else said


def _one_mass(mass: float, spring: float, damper: float, offs: tuple[float, ...], band: str, bound: float) -> Scene:
    return from_dict({
        "bodies": {"m": {"mass": _text(mass, "kg", offs[0])}},
        "links": {"k": {
            "between": ["m", "ground"],
            "stiffness": _text(spring, "N/m", offs[1]),
            "damping": _text(damper, "N s/m", offs[2]),
        }},
        "excitations": {"f": {"kind": "force", "on": "m", "amplitude": "1 kN", "speed": band, "varies": "constant"}},
        "limits": {
            "floor": {"response": "transmitted_force", "into": "ground", "at_most": f"{bound!r} N"},
            "way": {"response": "displacement", "of": "m", "at_most": "1 m"},
        },
    })  # fmt: skip


def _floor_force(mass: FloatArray, spring: FloatArray, damper: FloatArray, omega: FloatArray) -> FloatArray:
    """Force on the floor under 1 kN, by the formula of every textbook."""
    held = spring + 1j * omega * damper
    force: FloatArray = 1e3 * np.abs(held / (held - omega**2 * mass))
    return force


@given(
    zeta=st.floats(0.005, 0.6),
    offs=st.tuples(_parts, _parts, _parts),
    band=st.sampled_from(["2..40 Hz", "0..100 Hz", "12 Hz", "30..80 Hz"]),
    seed=st.integers(0, 10**6),
)
@settings(derandomize=True, database=None, deadline=None, max_examples=40)
def test_no_machine_within_the_tolerances_is_worse_than_the_worst_that_was_stated(
    zeta: float, offs: tuple[float, ...], band: str, seed: int
) -> None:
    mass, spring = 100.0, 1e6
    damper = 2.0 * zeta * (spring * mass) ** 0.5
    scene = _one_mass(mass, spring, damper, offs, band, 1e9)
    stated = solve(scene).limits["floor"].value.value
    rng = np.random.default_rng(seed)
    some = rng.uniform(-1.0, 1.0, (3, 3000, 1))
    some[:, :600] = np.sign(some[:, :600])
    low, _, high = band.removesuffix(" Hz").partition("..")
    omega = 2.0 * np.pi * np.linspace(float(low), float(high or low), 700)
    m, k, c = (value * (1.0 + off * part) for value, off, part in zip((mass, spring, damper), offs, some, strict=True))
    assert _floor_force(m, k, c, omega).max() <= stated * (1.0 + 1e-9)


@given(
    zeta=st.floats(0.01, 0.5),
    offs=st.tuples(_parts, _parts, _parts),
    over=st.floats(-0.2, -1e-6) | st.floats(1e-3, 0.2),
)
@settings(derandomize=True, database=None, deadline=None, max_examples=25)
def test_a_limit_that_some_machine_breaks_is_never_called_proven(
    zeta: float, offs: tuple[float, ...], over: float
) -> None:
    scene = _one_mass(100.0, 1e6, 2e4 * zeta, offs, "2..40 Hz", 1e9)
    program = around(scene, np.zeros(0))
    worst = hit(program.limits[0], program.axes).value
    level = worst * (1.0 + over)
    proven = Cover(program.limits[0], program.axes, level).proven(Budget(1000 if over > 0.0 else 40, "batches"))
    assert proven == (over > 0.0)


def test_limits_that_hold_are_proven_and_the_claim_says_so() -> None:
    answer = solve(_one_mass(100.0, 1e6, 2e3, (0.05, 0.2, 0.1), "2..40 Hz", 1e4))
    assert answer.status == "met"
    assert answer.proven
    assert answer.claim.endswith("for every machine within the tolerances, proven")


def test_a_limit_that_only_the_nominal_machine_meets_is_violated() -> None:
    nominal = solve(_one_mass(100.0, 1e6, 2e3, (0.0, 0.0, 0.0), "30 Hz", 1e9)).limits["floor"].value.value
    alone = solve(_one_mass(100.0, 1e6, 2e3, (0.0, 0.0, 0.0), "30 Hz", nominal * 1.01))
    answer = solve(_one_mass(100.0, 1e6, 2e3, (0.0, 0.2, 0.0), "30 Hz", nominal * 1.01))
    assert (alone.status, answer.status) == ("met", "violated")
    assert answer.limits["floor"].off == {"links.k.stiffness": pytest.approx(0.2)}


FRAME = """
[bodies.a]
mass = { value = "300 kg", tolerance = "5 %" }
[bodies.b]
weight = { value = "800 N", tolerance = "3 %" }
[links.m]
between = ["a", "ground"]
stiffness = { from = "1 MN/m", to = "9 MN/m", tolerance = "20 %" }
damping_ratio = 0.08
relative_to = "a"
tolerance = "10 %"
[links.n]
between = ["b", "a"]
stiffness = "200 kN/m"
damping = "300 N s/m"
dynamic_to_static = 1.4
tolerance = "7 %"
[absorbers.t]
on = "b"
mass_ratio = 0.1
tuning = { value = 0.97, tolerance = "2 %" }
tuning_to = "12 Hz"
damping_ratio = 0.1
tolerance = "4 %"
[absorbers.p]
on = "a"
mass = { value = "5 kg", tolerance = "6 %" }
length = { value = "60 mm", tolerance = "1 %" }
damping_ratio = 0.05
[excitations.f]
kind = "force"
on = "a"
amplitude = "1 kN"
speed = "5..40 Hz"
varies = "constant"
[limits.x]
response = "displacement"
of = "a"
at_most = "1 mm"
[limits.tr]
response = "transmitted_force"
into = "ground"
at_most = "1 kN"
[limits.st]
response = "stroke"
of = "t"
at_most = "9 mm"
[limits.nf]
response = "natural_frequency"
mode = 2
at_least = "3 Hz"
[limits.dr]
response = "damping_ratio"
of = "m"
at_least = 0.01
[limits.mr]
response = "mass_ratio"
of = "t"
at_most = 1
[limits.tu]
response = "tuning"
of = "t"
at_most = 2
[limits.ma]
response = "total_mass"
at_most = "1 t"
[goal]
minimise = "displacement"
of = "b"
"""


@given(parts=st.lists(st.floats(-1.0, 1.0), min_size=11, max_size=11), spring=st.floats(1e6, 9e6))
@settings(derandomize=True, database=None, deadline=None, max_examples=25)
def test_both_roads_build_the_same_machine_off_its_numbers(parts: list[float], spring: float) -> None:
    scene = from_text(FRAME)
    doubts = uncertain(scene)
    assert len(doubts) == len(parts)
    off = {one.path: 1.0 + one.tolerance * part for one, part in zip(doubts, parts, strict=True)}
    built = replace(scene, off=off)
    program, x = pose(built), np.array([spring])
    seen = around(scene, x)
    factors = np.array([off[one.path] for one in doubts])
    for limit, other in zip(program.limits, seen.limits, strict=True):
        value = Judge(program).limit(limit, x)[1].value
        assert Judge(seen).limit(other, factors)[1].value == pytest.approx(value, rel=1e-9)
        second = measure(built, {"links.m.stiffness": spring}, scene.limits[limit.name], limit.side)
        assert second.value == pytest.approx(value, rel=1e-8)


@pytest.mark.slow
def test_no_machine_of_a_frame_with_two_absorbers_is_worse_than_the_worst_found() -> None:
    """As `judged` finds it; whether a bound is proven to be kept as well, the longest part of that, is not asked."""
    program = around(from_text(FRAME), np.array([4e6]))
    parts, hits = parts_of(program), worst_machines(program, {})
    worst = {index: raised(part, program.axes, hits[index])[0].value for index, part in parts.items()}
    judge = Judge(program)
    rng = np.random.default_rng(3)
    low, high = program.low, program.high
    for _ in range(30):
        factors = np.clip(1.0 + 1.6 * (high - 1.0) * rng.uniform(-1.0, 1.0, len(low)), low, high)
        for index, limit in enumerate(program.limits):
            value = judge.limit(limit, factors)[1].value
            sign = -1.0 if limit.side == "at_least" else 1.0
            assert sign * value <= sign * worst[index] + 1e-9 * abs(value)
        goal = judge.goal(factors).value
        assert goal <= worst[-1] * (1.0 + 1e-9)


def _mount(off: str) -> Scene:
    stiffness = choice("10 kN/m", "1 GN/m", off)
    start_up = moves("press", "20 mm", "start_up", "0..3000 rpm")
    return from_text(press(stiffness, ANY_DAMPING, floor("10 kN", "floor_force"), start_up, STIFFEST, name="press"))


def test_a_tolerance_of_nothing_changes_nothing() -> None:
    with_it, without = solve(_mount(", tolerance = 0")), solve(_mount(""))
    assert with_it.x == without.x
    assert with_it.tolerances is None


def test_a_wider_tolerance_never_makes_the_goal_better() -> None:
    goals = []
    for off in ("", ', tolerance = "5 %"', ', tolerance = "10 %"', ', tolerance = "20 %"'):
        answer = solve(_mount(off))
        assert answer.status == "optimal"
        assert answer.goal is not None
        goals.append(answer.goal[1].value)
    assert all(after <= before * (1.0 + 1e-6) for before, after in pairwise(goals))


def test_the_best_mount_over_a_tolerance_is_that_of_a_dense_search() -> None:
    """Every (k, c) of a grid, with each limit by its formula at both ends of the tolerance."""
    answer = solve(_mount(', tolerance = "20 %"'))
    assert answer.goal is not None
    k, c = np.meshgrid(np.linspace(3e6, 7e6, 401), np.linspace(5e3, 3e4, 401), indexing="ij")
    good = np.ones_like(k, dtype=bool)
    mass, fast = 300.0, 100.0 * np.pi
    for factor in (0.8, 1.0, 1.2):
        spring = k * factor
        held = spring + 1j * fast * c
        good &= np.abs(3e4 * held / (held - mass * fast**2)) <= 1e4
        for omega in np.linspace(1.0, fast, 300):
            good &= np.abs(3e4 / (spring + 1j * omega * c - mass * omega**2)) <= 20e-3
    best = 0.8 * float(k[good].max())
    assert best <= answer.goal[1].value * (1.0 + 1e-9)
    assert answer.goal[1].value <= best + 0.8 * 1.5e4


TUNED = """
[bodies.deck]
mass = { value = "40 t", tolerance = "3 %" }
[links.girder]
between = ["deck", "ground"]
stiffness = "6.3 MN/m"
damping = "8 kN s/m"
[absorbers.tmd]
on = "deck"
mass = "800 kg"
tuning = { from = 0.8, to = 1.1, tolerance = "2 %" }
damping_ratio = { from = 0.01, to = 0.3 }
[excitations.walkers]
kind = "force"
on = "deck"
amplitude = "600 N"
speed = "1.6..2.4 Hz"
[goal]
minimise = "acceleration"
of = "deck"
"""


def _deck(tuning: FloatArray, zeta: FloatArray, heavier: FloatArray, omega: FloatArray) -> FloatArray:
    """Acceleration of a deck with an absorber by Cramer's rule; the frequency that tuning refers to is nominal."""
    own = tuning * np.sqrt(6.3e6 / 4e4)
    said = np.sqrt(6.3e6 / 4e4) * 2.0 * zeta * 800.0
    k, s = 800.0 * own**2, 1j * omega
    c = said * np.broadcast_to(TUNED_RATIO, tuning.shape) if TUNED_RATIO else said * tuning
    link = k + s * c
    first, second = 6.3e6 + s * 8e3 + 4e4 * heavier * s**2 + link, link + 800.0 * s**2
    answer: FloatArray = np.abs(600.0 * s**2 * second / (first * second - link**2))
    return answer


TUNED_RATIO = 0.0
"""Set by the test: the nominal tuning, to which the absorber's damper belongs."""


def test_a_detuned_absorber_is_never_worse_than_stated_and_no_other_is_better(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answer = solve(from_text(TUNED))
    assert answer.status == "optimal"
    assert answer.goal is not None
    assert answer.tolerances is not None
    assert answer.tolerances.open == ()
    stated = answer.goal[1].value
    omega = 2.0 * np.pi * np.linspace(1.6, 2.4, 801)
    rng = np.random.default_rng(5)

    def worst(tuning: float, zeta: float, count: int) -> float:
        monkeypatch.setitem(globals(), "TUNED_RATIO", tuning)
        parts = np.sign(rng.uniform(-1.0, 1.0, (2, count, 1))) * np.minimum(rng.uniform(0.0, 2.0, (2, count, 1)), 1.0)
        off = 1.0 + np.array([0.02, 0.03])[:, None, None] * parts
        return float(_deck(tuning * off[0], np.full((count, 1), zeta), off[1], omega).max())

    assert worst(answer.x[0], answer.x[1], 4000) == pytest.approx(stated, rel=1e-3)
    assert worst(answer.x[0], answer.x[1], 4000) <= stated * (1.0 + 1e-9)
    near = rng.uniform([0.97, 0.08], [1.01, 0.13], (60, 2))
    assert min(worst(one[0], one[1], 60) for one in near) >= stated * (1.0 - 2e-3)


def test_a_band_without_modes_is_kept_clear_between_the_corners_too() -> None:
    """Softest below the band and stiffest above it: both are fine, and what lies between is not."""
    scene = from_text("""
[bodies.m]
mass = "100 kg"
[links.k]
between = ["m", "ground"]
stiffness = { value = "1 MN/m", tolerance = "20 %" }
[limits.clear]
response = "natural_frequency"
outside = "15.8..16 Hz"
""")
    answer = solve(scene)
    assert answer.status == "violated"
    robust = judged(scene, np.zeros(0))
    assert robust.hits[0].proven
