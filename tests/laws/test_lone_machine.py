"""One body as built: what is found by a division is what the matrices of any machine give."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import GROUND, Joint
from vibopt.mechanics.lone import LoneMachine
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.peaks import greatest, least
from vibopt.signals import Band
from vibopt.verify.over_bands import Search

sizes = st.floats(-3.0, 3.0).map(lambda power: 10.0**power)
OMEGA = np.array([1e-3, 0.3, 1.0, 4.0, 300.0])


@st.composite
def machines(draw: st.DrawFn, held: bool = False) -> tuple[LoneMachine, Machine]:
    """The same body on up to four joints to the ground and two bases, as both kinds of machine.

    One that is `held` has springs in all of them, and damping of one kind.
    """
    joints, viscous = [], draw(st.booleans())
    for index in range(draw(st.integers(1, 4))):
        ends = ["body", draw(st.sampled_from([GROUND, "floor", "wall"]))]
        spring, damper, loss = (draw(st.one_of(st.just(0.0), sizes)) for _ in range(3))
        if held:
            spring = spring or 1.0
            damper, loss = (damper, 0.0) if viscous else (0.0, loss)
        joints.append(Joint(f"j{index}", tuple(draw(st.permutations(ends))), spring, damper, loss, spring, 1.0))
    masses, bases = {"body": draw(sizes)}, ("floor", "wall")
    return LoneMachine(masses, tuple(joints), bases), Machine(masses, tuple(joints), bases)


@given(machines(), st.booleans(), st.sampled_from([1.0, 1.0 + 0.2j]))
def test_one_body_moves_as_any_machine(both: tuple[LoneMachine, Machine], shaken: bool, turn: complex) -> None:
    omega = OMEGA * turn if turn != 1.0 else OMEGA
    push = np.linspace(1.0, 2.0, len(OMEGA)) * (1.0 + 0.5j)
    bases = {"floor": push, "wall": 0.3j * push} if shaken else {}
    forces = {} if shaken else {"body": push}
    with np.errstate(all="ignore"):
        here, there = (one.shake(omega, forces, bases) for one in both)
        for joint in both[0].joints:
            apart, other = both[0].stretch_of(joint, here), both[1]._shake_stretched(omega, forces, bases)
            _alike(apart, both[1].stretch_of(joint, other), 1e-9, 1e-9 * abs(push).max())
        _alike(both[0].force_into(GROUND, here), both[1].force_into(GROUND, there), 1e-8, 1e-8)
    _alike(here.points["body"], there.points["body"], 1e-9, 1e-13 if shaken else 0.0)


def _alike(lone: ComplexArray, other: ComplexArray, part: float, size: float) -> None:
    """At the resonance of what nothing damps neither is finite."""
    finite = np.isfinite(other)
    assert (np.isfinite(lone) == finite).all()
    assert lone[finite] == pytest.approx(other[finite], rel=part, abs=size)


@given(machines())
def test_poles_of_one_body_are_those_of_any_machine(both: tuple[LoneMachine, Machine]) -> None:
    lone, machine = (np.sort_complex(one.poles()) for one in both)
    size = np.abs(machine).max()
    assert np.abs(lone[:, None] - machine).min(axis=1).max() <= 1e-7 * size
    assert both[0].loose == both[1].loose


@given(machines(held=True), st.sampled_from([-1, 0, 1, 2]), st.booleans(), st.booleans())
def test_extremes_of_one_body_are_those_that_a_search_finds(
    both: tuple[LoneMachine, Machine], power: int, shaken: bool, into: bool
) -> None:
    machine = both[0]

    def read(omega: FloatArray) -> FloatArray:
        unit = np.ones(omega.shape, dtype=complex)
        moved = machine.shake(omega, {} if shaken else {"body": unit}, {"floor": unit} if shaken else {})
        return np.abs(machine.force_into(GROUND, moved) if into else moved.points["body"] * omega**2)

    def response(omega: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            value = read(omega) * omega ** float(power)
        return np.where(np.isnan(value), np.inf, value)

    turning = machine.turning(read, power)
    assume(turning is not None)  # of a reading that is zero none is known
    assert turning is not None
    natural = float(turning[0])
    bands, poles = (Band(0.02 * natural, 7.0 * natural),), machine.poles()
    for search in (greatest, least):
        found = Search(response, poles, np.zeros(0), search is least).over(bands, turning).value
        assert found == pytest.approx(search(response, bands, poles, np.zeros(0)).value, rel=1e-8)


@st.composite
def pairs(draw: st.DrawFn) -> Machine:
    """A body on the ground and another on it, sprung, with damping of one kind or none."""
    viscous, light = draw(st.booleans()), st.floats(-5.0, 0.5).map(lambda power: 10.0**power)
    joints = []
    masses = {"body": 1.0, "rider": draw(st.floats(0.01, 3.0))}
    for name, ends in (("below", ("body", GROUND)), ("between", ("rider", "body")), ("beside", (GROUND, "rider"))):
        mass = masses[ends[0]] if ends[0] != GROUND else 0.1 * masses["rider"]
        spring = mass * draw(st.floats(0.2, 4.0))
        loss = draw(st.one_of(st.just(0.0), light))
        damper, loss = (mass * loss, 0.0) if viscous else (0.0, loss)
        joints.append(Joint(name, ends, spring, damper, loss, spring, 1.0))
    return Machine(masses, tuple(joints[: draw(st.integers(2, 3))]), ("floor",))


@given(pairs(), st.sampled_from([0, 1, 2, 4]), st.sampled_from(["body", "rider", "stroke", GROUND]))
def test_the_greatest_of_two_bodies_is_what_a_search_finds(machine: Machine, power: int, asked: str) -> None:
    def response(omega: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            value = read(omega) * omega ** float(power)
        return np.where(np.isnan(value), np.inf, value)

    def read(omega: FloatArray) -> FloatArray:
        moved = machine.shake(omega, {"body": np.ones(omega.shape, dtype=complex)}, {})
        if asked == "stroke":
            return np.abs(moved.points["rider"] - moved.points["body"])
        return np.abs(machine.force_into(GROUND, moved) if asked == GROUND else moved.points[asked])

    turning = machine.turning(read, power)  # where digits are lost it is not known, and searched for
    bands, poles = (Band(0.02, 7.0),), machine.poles()
    found = Search(response, poles, np.zeros(0), least=False).over(bands, turning).value
    assert found == pytest.approx(greatest(response, bands, poles, np.zeros(0)).value, rel=1e-9)


@given(pairs())
def test_speeds_at_which_two_bodies_turn_are_known_where_no_digits_are_lost(machine: Machine) -> None:
    poles = machine.poles()
    sure = np.abs(poles).min() > 0.11 * np.abs(poles).max() and (np.abs(poles.imag) > 4e-3 * np.abs(poles)).all()
    found = machine.turning(lambda omega: machine.shake(omega, {"body": 1.0 + 0j * omega}, {}).points["body"].real, 0)
    assert found is not None or not sure or machine.matrices()[3].any()
