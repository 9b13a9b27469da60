"""Ratios in modes and motions after a release, against matrices written by hand and against time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import vibopt as vo
from refusals import refused
from vibopt.program.pose import on_needed, pose
from vibopt.scene.read import from_dict, from_text
from vibopt.verify.certify import measure

Array = NDArray[np.float64]
NAMES = ("a", "b", "c")


class Chain:
    """One to three bodies one on the other, the first on the ground, let go somewhere with some velocity."""

    def __init__(self, seed: int, *, damped: bool, least: int = 1) -> None:
        rng = np.random.default_rng(seed)
        self.n = int(rng.integers(least, 4))
        self.masses = 10.0 ** rng.uniform(-1, 2, self.n)
        self.springs = 10.0 ** rng.uniform(2, 5, self.n)
        self.dampers = 10.0 ** rng.uniform(-1, 2.5, self.n) * damped
        self.start = rng.uniform(-0.01, 0.01, self.n)
        self.speed = rng.uniform(-1.0, 1.0, self.n)

    def matrix(self, values: Array) -> Array:
        rows = np.eye(self.n) - np.eye(self.n, k=-1)
        return np.asarray(rows.T @ np.diag(values) @ rows)

    def modes(self) -> tuple[Array, Array]:
        """Natural frequencies and shapes from the matrices."""
        root = np.sqrt(self.masses)
        squares, vectors = np.linalg.eigh(self.matrix(self.springs) / np.outer(root, root))
        return np.sqrt(squares), vectors / root[:, None]

    def scene(self, measures: dict[str, Any]) -> vo.Scene:
        links = {
            f"l{i}": {
                "between": ["ground" if i == 0 else NAMES[i - 1], NAMES[i]],
                "stiffness": f"{spring!r} N/m",
                **({"damping": f"{damper!r} N s/m"} if damper else {}),
            }
            for i, (spring, damper) in enumerate(zip(self.springs.tolist(), self.dampers.tolist(), strict=True))
        }
        bodies = {name: {"mass": f"{mass!r} kg"} for name, mass in zip(NAMES, self.masses.tolist(), strict=False)}
        return from_dict({"bodies": bodies, "links": links, "measures": measures}, name="chain")

    def released(self) -> dict[str, dict[str, str]]:
        both = zip(NAMES, self.start.tolist(), self.speed.tolist(), strict=False)
        return {name: {"displacement": f"{x!r} m", "velocity": f"{v!r} m/s"} for name, x, v in both}

    def after(self, time: float) -> dict[str, Any]:
        """A measure of each body."""
        rest = {"response": "free_displacement", "after": f"{time!r} s", "released": self.released()}
        return {name: {**rest, "of": name} for name in NAMES[: self.n]}


def both_routes(scene: vo.Scene, name: str) -> tuple[float, float]:
    """Value on the machine as built, and of the form."""
    response = scene.measures[name]
    model, form = on_needed(scene, pose(scene).model, response)
    return measure(scene, {}, response).value, form.value(model, np.zeros(0))


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), part=st.just(0.0) | st.floats(1e-6, 30.0))
def test_free_vibration_is_the_sum_of_the_modes(seed: int, part: float) -> None:
    chain = Chain(seed, damped=False)
    omega, shapes = chain.modes()
    time = float(part / omega[0])
    weights = shapes.T * chain.masses
    amounts = (weights @ chain.start) * np.cos(omega * time) + (weights @ chain.speed) / omega * np.sin(omega * time)
    scene = chain.scene(chain.after(time))
    size = np.abs(chain.start).max() + np.abs(chain.speed).max() / omega[0]
    for i, expected in enumerate(shapes @ amounts):
        assert both_routes(scene, NAMES[i]) == pytest.approx((expected, expected), rel=1e-8, abs=1e-9 * size)


@settings(max_examples=8)
@given(seed=st.integers(0, 10_000), part=st.floats(0.1, 3.0))
def test_damped_free_vibration_is_that_of_a_simulation_in_time(seed: int, part: float) -> None:
    chain = Chain(seed, damped=True)
    time = float(part / chain.modes()[0][0])
    stiffness, damping = chain.matrix(chain.springs), chain.matrix(chain.dampers)

    def flow(_: float, state: Array) -> Array:
        x, v = state[: chain.n], state[chain.n :]
        return np.concatenate([v, -(stiffness @ x + damping @ v) / chain.masses])

    start = np.concatenate([chain.start, chain.speed])
    found = solve_ivp(flow, (0.0, time), start, method="Radau", rtol=1e-9, atol=1e-12)
    scene = chain.scene(chain.after(time))
    for i, expected in enumerate(found.y[: chain.n, -1]):
        assert both_routes(scene, NAMES[i]) == pytest.approx((expected, expected), rel=1e-5, abs=1e-7)


def test_a_critically_damped_mass_has_a_double_pole_and_an_answer() -> None:
    scene = from_dict(
        {
            "bodies": {"a": {"mass": "2 kg"}},
            "links": {"l": {"between": ["ground", "a"], "stiffness": "800 N/m", "damping": "80 N s/m"}},
            "measures": {
                "x": {
                    "response": "free_displacement",
                    "of": "a",
                    "after": "50 ms",
                    "released": {"a": {"displacement": "3 mm", "velocity": "-1 m/s"}},
                }
            },
        },
        name="critical",
    )
    expected = (0.003 + (-1.0 + 20.0 * 0.003) * 0.05) * np.exp(-1.0)
    assert both_routes(scene, "x") == pytest.approx((expected, expected), rel=1e-12)


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000))
def test_ratios_of_a_mode_are_those_of_its_shape_and_modes_are_orthogonal(seed: int) -> None:
    chain = Chain(seed, damped=True, least=2)
    _, shapes = chain.modes()
    asked = {
        f"{name}{mode}": {"response": "mode_ratio", "of": name, "relative_to": "a", "mode": mode}
        for name in NAMES[: chain.n]
        for mode in range(1, chain.n + 1)
    }
    scene = chain.scene(asked)
    ratios = np.array([[both_routes(scene, f"{n}{m + 1}") for m in range(chain.n)] for n in NAMES[: chain.n]])
    expected = shapes / shapes[0]
    for route in range(2):
        found = ratios[:, :, route]
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-9 * np.abs(expected).max())
        size = np.sqrt(chain.masses @ found**2)
        assert (found.T * chain.masses) @ found / np.outer(size, size) == pytest.approx(np.eye(chain.n), abs=1e-6)


def twins(extra: str) -> vo.Scene:
    """Two like machines side by side; `extra` joins them."""
    text = """
[bodies.a]
mass = "1 kg"
[bodies.b]
mass = "1 kg"
[links.la]
between = ["a", "ground"]
stiffness = "100 N/m"
[links.lb]
between = ["b", "ground"]
stiffness = "100 N/m"
[measures.r]
response = "mode_ratio"
of = "b"
relative_to = "a"
"""
    return from_text(text + extra)


def test_modes_of_one_frequency_have_no_ratio() -> None:
    assert both_routes(twins(""), "r") == (np.inf, np.inf)


def test_joined_twins_move_together_first_and_against_each_other_then() -> None:
    joint = '[links.j]\nbetween = ["a", "b"]\nstiffness = "10 N/m"\n'
    second = '[measures.s]\nresponse = "mode_ratio"\nof = "b"\nrelative_to = "a"\nmode = 2\n'
    scene = twins(joint + second)
    assert both_routes(scene, "r") == pytest.approx((1.0, 1.0), rel=1e-9)
    assert both_routes(scene, "s") == pytest.approx((-1.0, -1.0), rel=1e-9)


def test_a_ratio_to_a_body_at_rest_is_infinite() -> None:
    middle = """
[bodies.m]
mass = "1 kg"
[links.am]
between = ["a", "m"]
stiffness = "50 N/m"
[links.bm]
between = ["b", "m"]
stiffness = "50 N/m"
[measures.s]
response = "mode_ratio"
of = "a"
relative_to = "m"
mode = 2
"""
    assert both_routes(twins(middle), "s") == (np.inf, np.inf)


RELEASED = '[measures.x]\nresponse = "free_displacement"\nof = "b"\nafter = "1 s"\n'


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        (
            '[limits.x]\nresponse = "mode_ratio"\nof = "b"\nrelative_to = "a"\nat_most = 2\n',
            "limits.x asks for the mode_ratio, which has a sign and is only measured. Move it to [measures.x].",
        ),
        (
            '[goal]\nminimise = "mode_ratio"\nof = "b"\nrelative_to = "a"\n',
            "goal asks for the mode_ratio, which has a sign and is only measured. Ask for it in [measures.NAME].",
        ),
        (
            '[measures.x]\nresponse = "mode_ratio"\nof = "b"\nrelative_to = "c"\n',
            'measures.x.relative_to = "c" names no body of this scene. Known: a, b.',
        ),
        (
            '[measures.x]\nresponse = "mode_ratio"\nof = "b"\nrelative_to = "a"\nmode = 0\n',
            "measures.x has a mode below 1. Modes are counted from 1, the lowest.",
        ),
        (
            '[bodies.t]\ninertia = "1 kg m2"\n[links.s]\nbetween = ["t", "ground"]\ntorsional_stiffness = "9 N m/rad"\n'
            '[measures.x]\nresponse = "mode_ratio"\nof = "b"\nrelative_to = "t"\n',
            "measures.x looks at t, which turns, and at b, which moves along a line. Name one kind.",
        ),
        (
            RELEASED + "released = {}\n",
            "measures.x.released = {  } says of no body how it is let go. Write released = { first = { displacement = "
            '"10 mm", velocity = "0.3 m/s" } }.',
        ),
        (
            RELEASED + 'released = { a = { velocity = "1 mm" } }\n',
            'measures.x.released = { a = { velocity = "1 mm" } } has a velocity of a that cannot be read: it is a '
            'length, but a velocity is needed here. Write a velocity, for example "2.8 mm/s".',
        ),
        (
            RELEASED + 'released = { a = { speed = "1 mm/s" } }\n',
            'measures.x.released = { a = { speed = "1 mm/s" } } has an unknown key "speed" for a. Write released = '
            '{ first = { displacement = "10 mm", velocity = "0.3 m/s" } }.',
        ),
        (
            RELEASED + 'released = { q = { velocity = "1 m/s" } }\n',
            'measures.x.released.q = "q" names no body of this scene. Known: a, b.',
        ),
        (
            '[links.j]\nbetween = ["a", "b"]\nstiffness = "10 N/m"\nloss_factor = 0.1\n'
            + RELEASED
            + 'released = { a = { velocity = "1 m/s" } }\n',
            "measures.x asks for the free vibration, but links.j has a loss_factor, which speaks of steady harmonic "
            "motion only. Give it damping or damping_ratio instead.",
        ),
        (
            '[links.j]\nbetween = ["a", "b"]\nstiffness = { value = "10 N/m", tolerance = "10 %" }\n',
            "measures.r: mode_ratio is worked out for one machine, but links.j.stiffness has a tolerance. Remove the "
            "one or the other.",
        ),
        (
            '[structures.f]\nmodes = [{ frequency = "10 Hz", modal_mass = "1 kg", shape = { p = 1.0 } }]\n',
            "measures.r: mode_ratio is not supported for machines in space or on structures yet. Remove it.",
        ),
    ],
)
def test_what_cannot_be_asked_is_refused_with_the_way_out(extra: str, message: str) -> None:
    assert message in [one.split(": ", 1)[1] for one in refused(twins, extra).messages]
