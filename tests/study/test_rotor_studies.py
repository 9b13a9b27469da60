"""Studies of measured rotors: their ends and boundaries are where solve changes its answer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.cli.main import main
from vibopt.jobs import answer, fact_at, from_text, open_job, with_changes
from vibopt.study import tradeoff
from vibopt.study.edges import BY_SEARCH
from vibopt.study.price_words import range_rows
from vibopt.study.prices import prices

PROBLEMS = Path(__file__).parent.parent.parent / "problems"

FAN = """
[conventions]
phase = "lag"
readings = "phase"
angles = "against rotation"
detector = "pp"
zero = "reflective tape"
[planes.left]
radius = "150 mm"
weight = { from = "0 g", to = "9 g" }
[planes.right]
radius = "150 mm"
weight = { from = "0 g", to = "8 g" }
[[runs]]
name = "as found"
speed = "1200 rpm"
readings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }
[[runs]]
name = "trial left"
speed = "1200 rpm"
weights = { left = "10 g @ 270 deg" }
readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }
[[runs]]
name = "trial right"
speed = "1200 rpm"
weights = { right = "12 g @ 180 deg" }
readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }
[limits.a]
response = "residual"
at = "a"
at_most = "2.5 mil pp"
[limits.total]
response = "correction"
total = true
at_most = "16 g"
[goal]
minimise = "residual"
combine = "rms"
"""


@pytest.mark.parametrize("points", [3, 5, 9])
def test_the_ends_of_a_rotors_curve_are_where_solve_changes_its_verdict_and_nothing_is_left_out(points: int) -> None:
    found = vo.tradeoff(from_text(FAN), "limits.total", points)
    reached = [one.value for one in found.reached]

    def solved(total: float) -> tuple[str, float]:
        answer = vo.solve(vo.with_changes(from_text(FAN), {"limits.total.at_most": f"{total:.17g} kg"}), explain=False)
        return answer.status, answer.goal[1].value if answer.goal is not None else np.inf

    assert solved(reached[0] * (1.0 - 1e-5))[0] == "infeasible"
    assert solved(reached[0] * (1.0 + 1e-5))[0] == "optimal"
    assert solved(reached[-1] * (1.0 - 1e-2))[1] > solved(1.0)[1]
    assert solved(1.0)[1] == pytest.approx(found.points[-1].goal.value, rel=1e-6)
    assert found.jumps == ()
    assert found.gap <= 2.0 / (points - 1) * (1.0 + 1e-6)


@pytest.mark.parametrize(
    ("path", "low_high", "limit"),
    [("planes.left.weight.to", "7 g..16 g", "total"), ("limits.a.at_most", "0.7..6 mil pp", "a")],
)
def test_a_rotors_limit_becomes_active_where_the_plan_without_it_reaches_its_bound(
    path: str, low_high: str, limit: str
) -> None:
    job = from_text(FAN)
    found = vo.sweep(job, path, low_high, 5)
    (edge,) = (one for one in found.boundaries if limit in {*one.before[1]} ^ {*one.after[1]})
    free = vo.with_changes(job, {f"limits.{limit}.at_most": "1 kg" if limit == "total" else "1 m pk"})
    away = 2.0 * BY_SEARCH * edge.at

    def room(value: float) -> float:
        """What is left of the bound in the plan that is best without the limit."""
        moved = vo.with_changes(job if limit == "a" else free, {path: fact_at(job, path).text(value)})
        bound = value if limit == "a" else 0.016
        plan = vo.solve(free if limit == "a" else moved, explain=False)
        return bound - plan.limits[limit].value.value

    assert room(edge.at - away) * room(edge.at + away) < 0.0


@pytest.mark.parametrize(("status", "said"), [("feasible", True), ("optimal", False)])
def test_designs_of_a_curve_that_are_not_proven_best_are_marked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, status: str, said: bool
) -> None:
    (tmp_path / "fan.toml").write_text(FAN)
    weigh = tradeoff.tradeoff

    def with_status(*words: Any, **more: Any) -> tradeoff.Tradeoff:
        found = weigh(*words, **more)
        assert {one.status for one in found.points} == {"optimal"}
        return replace(found, points=(replace(found.points[0], status=status), *found.points[1:]))

    monkeypatch.setattr(tradeoff, "tradeoff", with_status)
    main(["tradeoff", str(tmp_path / "fan.toml"), "--against", "limits.total", "--points", "4"])
    text = " ".join(capsys.readouterr().out.split())
    words = "not proven best: others may be better in both there, and the knee may be elsewhere."
    assert (words in text, "tightest, not" in text, "none of them better" in text) == (said, said, said)


@pytest.mark.parametrize(
    ("file", "path"), [("rao_9_13_holes", "planes.right.shelf.2"), ("shaft_holes", "planes.P.shelf.1")]
)
def test_a_price_of_a_weight_holds_as_long_as_the_same_holes_are_filled(file: str, path: str) -> None:
    """Between both ends the same weights sit in the same holes, behind them others do."""
    job = open_job(PROBLEMS / "balancing" / f"{file}.toml")
    row = prices(job, only=[path]).rows[0]
    below, above = (one.until for one in row.ways)
    assert below is not None
    assert above is not None
    assert below.value < 0.95 * row.now.value < 1.05 * row.now.value < above.value
    here = _holes(job)
    step = 1e-3 * row.now.value
    for end, inward in ((below.value, step), (above.value, -step)):
        inside, outside = (
            _holes(with_changes(job, {path: f"{1e3 * (end + way):.12g} g"})) for way in (inward, -inward)
        )
        assert inside == here != outside


def _holes(job: Any) -> list[list[tuple[int | None, int]]]:
    """Which weight of the shelf, by its place on it, is in which hole of each plane."""
    plan = answer(job, explain=False).plan
    return [
        [(one.hole, int(np.argmin(np.abs(np.array(plane.shelf) - one.mass)))) for one in made.weights]
        for plane, made in zip(job.planes, plan.planes, strict=True)
    ]


def test_another_number_of_holes_is_another_design() -> None:
    found = prices(open_job(PROBLEMS / "balancing" / "rao_9_13_holes.toml"), only=["planes.right.holes"])
    assert list(range_rows(found)) == [("planes.right.holes", "12 alone: 11 and 13 have designs of other kinds")]
