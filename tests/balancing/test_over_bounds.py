"""A measured rotor at many values of a bound, answered together: as each alone, within its bounds, and best."""

from __future__ import annotations

import cmath
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_jobs import read_text
from test_rotor_laws import PLANES, SENSORS, Truth, best, job, truths
from vibopt.answer.answer import Answer
from vibopt.balancing.rotor_job import RotorJob
from vibopt.jobs import answer, fact_at, facts, open_job, with_changes
from vibopt.study.points import Columns, Point
from vibopt.study.rotor_points import columns
from vibopt.study.sweep import sweep

FILES = sorted((Path(__file__).parents[2] / "problems" / "balancing").glob("*.toml"))
RADIUS = 'radius = "100 mm"'
POINTS = 25
LIMITS = {
    "planes.p.weight.to": "",
    "limits.most.at_most": '[limits.most]\nresponse = "correction"\nof = "q"\nat_most = "1 kg"\n',
    "limits.left.at_most": '[limits.left]\nresponse = "residual"\nat_most = "1 mm pk"\n',
    "limits.one.at_most": '[limits.one]\nresponse = "residual"\nat = "a"\nat_most = "1 mm pk"\n'
    '[limits.all]\nresponse = "residual"\nat_most = "0.05 mm pk"\n',
}


def asked(truth: Truth, goal: str, path: str, part: float, lag: bool, against: bool, remove: bool) -> tuple[str, str]:
    """The file, and the range of its bound."""
    most = float(np.abs(best(truth)).max())
    text = job(
        truth, lag=lag, against=against, more=f'{LIMITS[path]}[goal]\nminimise = "residual"\ncombine = "{goal}"\n'
    )
    taken = "\nremove = true" if remove else ""
    cap = f'weight = {{ from = "0 kg", to = "{(1.0 + part) * most!r} kg" }}'
    greatest = float(np.abs(truth.y0).max())
    span = f"{part * most!r} kg..{2.0 * most!r} kg" if "kg" in LIMITS[path] or not LIMITS[path] else ""
    return text.replace(RADIUS, f"{RADIUS}\n{cap}{taken}"), span or f"{0.02 * greatest!r} m pk..{greatest!r} m pk"


def together(found: object) -> Columns:
    held = found.points.columns
    assert isinstance(held, Columns)
    return held


@settings(max_examples=40)
@given(
    truth=truths(), goal=st.sampled_from(["rms", "worst"]), path=st.sampled_from(list(LIMITS)),
    part=st.floats(0.05, 0.9), lag=st.booleans(), against=st.booleans(), remove=st.booleans(),
)  # fmt: skip
def test_every_point_is_as_if_asked_alone(
    truth: Truth, goal: str, path: str, part: float, lag: bool, against: bool, remove: bool
) -> None:
    text, span = asked(truth, goal, path, part, lag, against, remove)
    rotor = read_text(text)
    found = sweep(rotor, path, span, POINTS)
    assert sum(not status for status in together(found).status) <= 1
    fact, held = found.fact, together(found).held
    for index, point in enumerate(found.points):
        if index % 6:
            continue
        here = with_changes(rotor, fact.changes(point.value.value))
        alone = answer(here, explain=False)
        assert point.status == alone.status
        if point.status == "optimal":
            assert alone.goal is not None
            assert point.goal is not None
            scale = float(np.abs(truth.y0).max())
            assert point.goal.value == pytest.approx(alone.goal[1].value, rel=1e-6, abs=1e-9 * scale)
            assert point.goal.unit == alone.goal[1].unit
            assert point.variables.keys() == {one for one in alone.entries() if one in rotor.choices}
            assert point.margins.keys() == alone.limits.keys()
            _is_what_the_rotor_shows(truth, point, goal, lag, against, remove)
            if together(found).status[index]:
                assert held is not None
                _is_held_by(here, alone, held(index))


def _is_held_by(here: RotorJob, alone: Answer[RotorJob], held: set[str]) -> None:
    """What is said to hold the goal back is what multipliers of the answer alone say, but for what is worth nothing."""
    assert alone.rates is not None
    assert alone.goal is not None
    bounds = {one.name: one.at_most for one in (*here.residual_limits, *here.correction_limits)}
    bounds |= {f"planes.{plane.name}.weight": plane.cap for plane in here.planes}
    assert held <= bounds.keys()
    for name, rate in alone.rates.items():
        worth = rate * bounds[name] / max(alone.goal[1].value, 1e-300)
        assert (name in held) == (rate > 0.0) or worth <= 1e-4


def _is_what_the_rotor_shows(truth: Truth, point: Point, goal: str, lag: bool, against: bool, remove: bool) -> None:
    """Residuals and goal of the weights as written, and that none near them does better within the bounds."""
    u = np.array([_fitted(point, name, against) * (-1.0 if remove else 1.0) for name in PLANES])
    left = np.abs(truth.y0 + truth.H @ u)
    said = [point.results[f"sensors.{name}.residual"].value for name in SENSORS]
    np.testing.assert_allclose(said, left, rtol=1e-9, atol=1e-14)
    assert point.goal is not None
    value = float(left.max() if goal == "worst" else np.sqrt((left**2).mean()))
    assert point.goal.value == pytest.approx(value, rel=1e-9, abs=1e-14)
    assert min(point.margins.values(), default=0.0) >= -1e-9


def _fitted(point: Point, plane: str, against: bool) -> complex:
    mass, angle = (point.variables[f"planes.{plane}.{word}"].value for word in ("mass", "angle"))
    return cmath.rect(mass, -angle if against else angle)


@settings(max_examples=25)
@given(truth=truths(), goal=st.sampled_from(["rms", "worst"]), part=st.floats(0.05, 0.9))
def test_a_wider_bound_is_never_worse_and_no_weight_within_the_bounds_does_better(
    truth: Truth, goal: str, part: float
) -> None:
    text, span = asked(truth, goal, "planes.p.weight.to", part, False, False, False)
    found = sweep(read_text(text), "planes.p.weight.to", span, POINTS)
    goals = np.array([point.goal.value for point in found.points if point.goal is not None])
    assert len(goals) == POINTS
    assert (np.diff(goals) <= 1e-9 * goals.max()).all()
    dice, cap_q = np.random.default_rng(0), (1.0 + part) * float(np.abs(best(truth)).max())
    for point in found.points[::8]:
        at = np.array([_fitted(point, name, False) for name in PLANES])
        caps, size = np.array([point.value.value, cap_q]), np.abs(at).max()
        tried = at + size * 10.0 ** dice.uniform(-6, 0, (400, 1)) * (dice.normal(size=(400, 2, 2)) @ [1.0, 1.0j])
        tried *= np.minimum(1.0, caps / np.maximum(np.abs(tried), 1e-300))
        left = np.abs(truth.y0 + tried @ truth.H.T)
        values = left.max(axis=1) if goal == "worst" else np.sqrt((left**2).mean(axis=1))
        assert point.goal is not None
        assert values.min() >= point.goal.value * (1.0 - 1e-9) - 1e-15


@pytest.mark.parametrize("file", FILES, ids=[one.stem for one in FILES])
def test_of_all_problems_what_is_answered_together_is_as_alone(file: Path) -> None:
    rotor = open_job(file)
    if not isinstance(rotor, RotorJob) or not rotor.choices:
        return
    bounds = [one.path for one in facts(rotor) if one.path.endswith((".at_most", "weight.to", "unbalance.to"))]
    for path in bounds[:2]:
        fact = fact_at(rotor, path)
        values = fact.value * np.linspace(0.5, 1.5, 21)
        found = columns(rotor, lambda one, at=fact: with_changes(rotor, at.changes(float(one[0]))), values[:, None])
        if found is None:
            continue
        index = next((k for k, status in enumerate(found.status) if status), 0)
        alone = answer(with_changes(rotor, fact.changes(float(values[index]))), explain=False)
        assert found.status[index] in ("", alone.status)
        if found.status[index] == "optimal":
            assert found.goal is not None
            assert alone.goal is not None
            assert found.goal[index] == pytest.approx(alone.goal[1].value, rel=1e-7)


def test_bounds_from_impossible_to_idle() -> None:
    H = np.array([[4e-3, 1e-3j], [1e-3, 5e-3], [2e-3, 2e-3]])
    truth = Truth(np.array([1e-4, 5e-5j, 2e-5]), H, tuple(np.eye(2) / 100))
    text, _ = asked(truth, "rms", "limits.left.at_most", 0.5, False, False, False)
    found = sweep(read_text(text), "limits.left.at_most", "0.001 mm pk..0.1 mm pk", 101)
    statuses = [one.status for one in found.points]
    first = statuses.index("optimal")
    assert set(statuses[:first]) == {"infeasible"}
    assert set(statuses[first:]) == {"optimal"}
    for k in (first - 1, first):
        here = with_changes(found.job, found.fact.changes(found.points[k].value.value))
        assert answer(here, explain=False).status == statuses[k]


def test_two_bounds_vary_at_once() -> None:
    truth = Truth(
        np.array([1e-4, 5e-5j, 2e-5]), np.array([[4e-3, 1e-3j], [1e-3, 5e-3], [2e-3, 2e-3]]), tuple(np.eye(2) / 100)
    )
    text, span = asked(truth, "worst", "limits.left.at_most", 0.5, False, False, False)
    ranges = {"planes.p.weight.to": "1 g..30 g", "limits.left.at_most": span}
    found = sweep(read_text(text), ranges, points=6)
    assert sum(not status for status in together(found).status) <= 1
    assert {"optimal", "infeasible"} == {one.status for one in found.points}
    for point in found.points[::5]:
        changes = {path: f"{one.value!r} {'kg' if 'weight' in path else 'm pk'}" for path, one in point.varied.items()}
        alone = answer(with_changes(found.job, changes), explain=False)
        assert alone.status == point.status
        if point.goal is not None:
            assert alone.goal is not None
            assert point.goal.value == pytest.approx(alone.goal[1].value, rel=1e-6)


def test_what_changes_more_than_a_bound_is_answered_one_by_one() -> None:
    H = np.array([[4e-3, 1e-3j], [1e-3, 5e-3], [2e-3, 2e-3]])
    truth = Truth(np.array([1e-4, 5e-5j, 2e-5]), H, tuple(np.eye(2) / 100))
    text, _ = asked(truth, "rms", "planes.p.weight.to", 0.5, False, False, False)
    rotor = read_text(text + '[scatter]\namplitude = "2 %"\nangle = "1 deg"\n')
    for path, span in (("scatter.angle", "0.1 deg..5 deg"), ("runs.1.readings.a.angle", "10 deg..20 deg")):
        found = sweep(rotor, path, span, POINTS)
        assert not any(together(found).status), path
        assert found.complete
