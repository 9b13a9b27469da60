"""What holds for every measured rotor: the plan does what it says, whatever mark, sense and units it has."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from math import degrees, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_jobs import correction, polar, read_text, solve_text
from vibopt.balancing.influence import identify
from vibopt.balancing.trust import bands, noise_of

PLANES, SENSORS = ("p", "q"), ("a", "b", "c")


@dataclass(frozen=True)
class Truth:
    """A rotor: readings as found [m pk] and response [m/kg at 0.1 m], internal phasors; trial weights [kg]."""

    y0: np.ndarray
    H: np.ndarray
    trials: tuple[np.ndarray, ...]


@st.composite
def truths(draw: st.DrawFn, spare: int = 0) -> Truth:
    def phasor(low: float, high: float) -> complex:
        return cmath.rect(draw(st.floats(low, high)), draw(st.floats(0.0, 6.28)))

    y0 = np.array([phasor(1e-5, 2e-4) for _ in SENSORS])
    H = np.array([[phasor(1e-3, 1e-2) for _ in PLANES] for _ in SENSORS])
    H[0] *= np.array([3.0, 0.2])
    H[1] *= np.array([0.2, 3.0])
    trials = [np.array([phasor(5e-3, 2e-2), 0.0]), np.array([0.0, phasor(5e-3, 2e-2)])]
    trials += [np.array([cmath.rect(1e-2, 1.3 * k), cmath.rect(1.2e-2, 2.1 * k + 1.0)]) for k in range(spare)]
    return Truth(y0, H, tuple(trials))


def job(
    truth: Truth,
    turn: float = 0.0,
    lag: bool = True,
    against: bool = True,
    units: tuple[str, float, str, float] = ("mm", 1e3, "g", 1e3),
    more: str = "",
) -> str:
    """The rotor as measured with a mark `turn` degrees further on, in the conventions and units given."""
    length, per_m, mass, per_kg = units
    lines = [
        'title = "law"',
        'speed = "1500 rpm"',
        "[conventions]",
        f'phase = "{"lag" if lag else "lead"}"',
        'readings = "phase"',
    ]
    lines += [f'angles = "{"against" if against else "with"} rotation"', 'detector = "pk"', 'zero = "mark"']
    lines += [f'[planes.{name}]\nradius = "100 mm"' for name in PLANES]
    back = cmath.exp(-1j * radians(turn))
    for weights in (np.zeros(len(PLANES)), *truth.trials):
        shown = {name: _written(z * back, lag) for name, z in zip(SENSORS, truth.y0 + truth.H @ weights, strict=True)}
        fitted = {name: _written(w * back, against) for name, w in zip(PLANES, weights, strict=True) if w}
        readings = ", ".join(f'{name} = "{polar(z, length, per_m)}"' for name, z in shown.items())
        bolted = ", ".join(f'{name} = "{polar(w, mass, per_kg)}"' for name, w in fitted.items())
        lines.append(f"[[runs]]\nreadings = {{ {readings} }}\nweights = {{ {bolted} }}")
    return "\n".join([*lines, more])


def _written(z: complex, mirrored: bool) -> complex:
    return complex(z).conjugate() if mirrored else complex(z)


def best(truth: Truth) -> np.ndarray:
    return np.linalg.lstsq(truth.H, -truth.y0, rcond=None)[0]


@settings(max_examples=40, deadline=None)
@given(truth=truths(), turn=st.floats(0.0, 360.0), lag=st.booleans(), against=st.booleans())
def test_the_residual_is_what_the_rotor_shows(truth: Truth, turn: float, lag: bool, against: bool) -> None:
    plan = solve_text(job(truth, turn, lag, against))
    back = cmath.exp(1j * radians(turn))
    u = np.array([_written(correction(plan, name), against) * back for name in PLANES])
    left = np.abs(truth.y0 + truth.H @ u)
    said = np.array([float(row.residual.value) for row in plan.plan.rows])
    np.testing.assert_allclose(said, left, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(u, best(truth), rtol=1e-8, atol=1e-12)
    assert plan.status == "optimal"


@settings(max_examples=20, deadline=None)
@given(truth=truths())
def test_units_do_not_matter(truth: Truth) -> None:
    metric = solve_text(job(truth))
    inch = solve_text(job(truth, units=("mil pp", 2.0 / 2.54e-5, "oz", 1.0 / 0.028349523125)))
    for name in PLANES:
        assert abs(correction(metric, name) - correction(inch, name)) <= 1e-10 * abs(correction(metric, name))


@settings(max_examples=20, deadline=None)
@given(truth=truths(spare=3))
def test_more_runs_than_unknowns_give_back_the_coefficients(truth: Truth) -> None:
    found = identify(read_text(job(truth)))
    np.testing.assert_allclose(found.H, truth.H / 0.1, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.y0, truth.y0, rtol=1e-9)
    assert not any("agree" in one for one in solve_text(job(truth)).notes)


@settings(max_examples=10, deadline=None)
@given(truth=truths(), against=st.booleans(), lag=st.booleans())
def test_coefficients_of_one_job_serve_the_next(truth: Truth, against: bool, lag: bool) -> None:
    """One shot from history: the as-found run and the coefficients printed by the earlier plan."""
    text = job(truth, lag=lag, against=against)
    plan = solve_text(text)
    ready = []
    for path, entry in plan.values.items():
        if path.endswith(".value"):
            _, sensor, plane, _ = path.split(".")
            ready.append(f'[[influence]]\nsensor = "{sensor}"\nplane = "{plane}"\nvalue = "{entry.value}"')
    head, first, *_ = text.split("[[runs]]")
    again = solve_text("\n".join([head, "[[runs]]", first, *ready]))
    assert again.status == "optimal"
    for name in PLANES:
        assert abs(correction(plan, name) - correction(again, name)) <= 1e-5 * max(
            abs(correction(plan, one)) for one in PLANES
        )


@settings(max_examples=15, deadline=None)
@given(truth=truths(spare=4), wrong=st.integers(1, 5))
def test_the_run_that_does_not_agree_is_named(truth: Truth, wrong: int) -> None:
    text = job(truth)
    parts = text.split("[[runs]]")
    lines = parts[1 + wrong].split("\n")
    values = lines[1].split('"')
    for index in range(1, len(values), 2):
        amount, unit, at, angle, deg = values[index].split()
        values[index] = f"{float(amount) + 0.3} {unit} {at} {(float(angle) + 20) % 360} {deg}"
    lines[1] = '"'.join(values)
    parts[1 + wrong] = "\n".join(lines)
    notes = solve_text("[[runs]]".join(parts)).notes
    assert any(note.startswith(f'Run "run {1 + wrong}" at 1500 rpm does not agree with the others') for note in notes)


def test_the_band_holds_95_percent_of_the_true_residuals() -> None:
    """500 jobs of one rotor with scatter: the true residual of each plan lies in its band about 19 times out of 20."""
    dice = np.random.default_rng(3)
    y0 = np.array([1e-4, -4e-5 + 6e-5j, 2e-5j])
    H = np.array([[3e-2, 2e-3j], [1e-3, 2e-2 + 1e-2j], [5e-3, -4e-3]])
    trials = (np.array([4e-3, 0.0]), np.array([0.0, 5e-3j]))
    inside, total = 0, 0
    for _ in range(150):
        text = job(Truth(y0, H, trials), more='[scatter]\namplitude = "1 µm"\n')
        noisy = _with_noise(text, 1e-6, dice)
        plan = solve_text(noisy)
        u = np.array([correction(plan, name).conjugate() for name in PLANES])
        left = np.abs(y0 + H @ u)
        for row, true in zip(plan.plan.rows, left, strict=True):
            assert row.band is not None
            inside += float(row.band[0].value) <= true <= float(row.band[1].value)
            total += 1
    assert 0.92 < inside / total < 0.985


def _with_noise(text: str, sd: float, dice: np.random.Generator) -> str:
    lines = text.split("\n")
    for number, line in enumerate(lines):
        if line.startswith("readings = {"):
            values = line.split('"')
            for index in range(1, len(values), 2):
                amount, _, _, angle, _ = values[index].split()
                z = cmath.rect(float(amount) * 1e-3, radians(float(angle))) + sd * complex(*dice.standard_normal(2))
                values[index] = f"{abs(z) * 1e3!r} mm @ {degrees(cmath.phase(z)) % 360!r} deg"
            lines[number] = '"'.join(values)
    return "\n".join(lines)


@pytest.mark.parametrize("robust", ["worst", "mean"])
def test_a_robust_plan_is_better_over_the_scatter(robust: str) -> None:
    """With one plane known badly, the robust plan trusts it less."""
    truth = Truth(
        np.array([1e-4, 8e-5j, -5e-5]), np.array([[3e-2, 2.9e-2], [1e-2j, 1.1e-2j], [5e-3, 4e-3]]),
        (np.array([2e-3, 0.0]), np.array([0.0, 2e-3])),
    )  # fmt: skip
    scatter = '[scatter]\namplitude = "6 µm"\n'
    combine = "worst" if robust == "worst" else "rms"
    goal = f'[goal]\nminimise = "residual"\ncombine = "{combine}"\n'
    plain = solve_text(job(truth, more=goal))
    careful = solve_text(job(truth, more=f'{scatter}{goal}robust = "{robust}"'))
    scattered = read_text(job(truth, more=scatter))
    identified = identify(scattered)
    noise = noise_of(scattered, identified)
    assert noise is not None
    u = [np.array([one.u for one in plan.plan.planes]) for plan in (plain, careful)]
    bound = [float(bands(scattered, identified, noise, one)[:, 1].max()) for one in u]
    assert bound[1] < bound[0]
    assert careful.status == "optimal"
    assert solve_text(job(truth, more=f"{scatter}{goal}")).status == "unproven"
