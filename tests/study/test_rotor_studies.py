"""Studies of measured rotors: their ends and boundaries are where solve changes its answer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from rotor_jobs import FAN as MEASURED
from texts import best, table
from vibopt.cli.main import main
from vibopt.jobs import answer, fact_at, from_text, open_job, with_changes
from vibopt.study import tradeoff
from vibopt.study.edges import BY_SEARCH
from vibopt.study.price_words import range_rows
from vibopt.study.prices import prices
from vibopt.study.sweep import sweep
from vibopt.study.sweep_series import change_words

PROBLEMS = Path(__file__).parent.parent.parent / "problems"

FAN = (
    MEASURED.replace("[planes.right]", 'weight = { from = "0 g", to = "9 g" }\n[planes.right]').replace(
        "[[runs]]", 'weight = { from = "0 g", to = "8 g" }\n[[runs]]', 1
    )
    + table("limits.a", response="residual", at="a", at_most="2.5 mil pp")
    + table("limits.total", response="correction", total=True, at_most="16 g")
    + best(minimise="residual", combine="rms")
)


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


READ = {
    "as found": ((8.0, 63.0), (6.5, 206.0), (5.0, 100.0)),
    "left": ((12.97704482, 65.69135523), (8.366730658, 211.579519), (8.492161941, 102.0585521)),
    "right": ((9.052340481, 47.68626407), (11.03934085, 179.2184046), (4.358898944, 136.5867756)),
}
"""Three sensors [mil pp @ deg] as found, with 10 g at 30 deg on the left and with 10 g at 200 deg on the right."""


def shelves() -> Any:
    """Two planes of twelve holes, each with at most two weights of a shelf of 2 g, 5 g and 10 g."""
    plane = 'radius = "150 mm"\nholes = 12\nshelf = ["2 g", "5 g", "10 g"]\nmost_weights = 2\n'
    text = FAN.partition("[planes.left]")[0] + f"[planes.left]\n{plane}[planes.right]\n{plane}"
    for name, one in READ.items():
        spots = ", ".join(f'{key} = "{size} mil pp @ {at} deg"' for key, (size, at) in zip("abc", one, strict=True))
        trial = {"left": 'weights = { left = "10 g @ 30 deg" }', "right": 'weights = { right = "10 g @ 200 deg" }'}
        text += f'[[runs]]\nname = "{name}"\nspeed = "1200 rpm"\n{trial.get(name, "")}\nreadings = {{ {spots} }}\n'
    for key in "abc":
        text += f'[limits.{key}]\nresponse = "residual"\nat = "{key}"\nat_most = "1.3 mil pp"\n'
    return from_text(text + '[goal]\nminimise = "residual"\n', "shelves.toml")


def every_filling(left: list[float], right: list[float]) -> tuple[float, Any]:
    """The least root mean square of all fillings that keep the limits, and which weights are where; inf without one."""
    runs = {
        name: np.array([size * np.exp(1j * np.radians(at)) for size, at in one]) for name, one in READ.items()
    }  # fmt: skip
    trials = {"left": 30.0, "right": 200.0}
    per = {name: (runs[name] - runs["as found"]) / (10.0 * np.exp(1j * np.radians(at))) for name, at in trials.items()}
    single = [(hole, kind) for hole in range(12) for kind in range(3)]
    fillings = [(), *((one,) for one in single), *((a, b) for a in single for b in single if a[0] < b[0])]
    turned = np.exp(2j * np.pi * np.arange(12) / 12.0)
    sums = [np.array([sum(shelf[k] * turned[h] for h, k in one) for one in fillings]) for shelf in (left, right)]
    left_over = [
        np.abs(v + a * sums[0][:, None] + b * sums[1][None, :])
        for v, a, b in zip(runs["as found"], per["left"], per["right"], strict=True)
    ]
    worst, total = np.maximum.reduce(left_over), sum(one**2 for one in left_over)
    goal = np.where(worst <= 1.3 * (1.0 + 1e-9), np.sqrt(total / 3.0), np.inf)
    i, j = np.unravel_index(int(goal.argmin()), goal.shape)
    return float(goal[i, j]), (fillings[i], fillings[j])


@pytest.mark.parametrize(("plane", "beyond"), [pytest.param("left", "5.4 g", marks=pytest.mark.slow), ("right", "8 g")])
def test_of_a_shelf_weight_nothing_is_said_of_what_lies_beyond_the_same_filling(plane: str, beyond: str) -> None:
    """Every filling by itself: the same is best within the range, another behind it, and better ones further out."""

    def at(value: float) -> tuple[float, Any]:
        moved = {"left": [2.0, 5.0, 10.0], "right": [2.0, 5.0, 10.0]}
        moved[plane][0] = value
        return every_filling(**moved)

    job, path = shelves(), f"planes.{plane}.shelf.1"
    found = prices(job, only=[path])
    (row,) = found.rows
    low, high = (1e3 * (one.until or one.far).value for one in row.ways if one.until or one.far)
    here = at(2.0)
    for value in np.geomspace(low * (1.0 + 1e-4), high * (1.0 - 1e-4), 7):
        assert at(float(value))[1] == here[1]
    for way, end in zip(row.ways, (low * (1.0 - 1e-3), high * (1.0 + 1e-3)), strict=True):
        if way.until is not None:
            assert at(end)[1] != here[1]
            assert way.then == "other fillings beyond"
        assert (way.ends, way.beyond) == (None, "")
    said = " ".join(text for _, text in range_rows(found))
    assert not any(word in said for word in ("no design", "changes nothing", "takes over"))
    assert found.notes[0] == (
        "The range of a shelf weight is that over which the same weights were found in the same holes. Beyond it, and "
        "between the values that were looked at, other fillings may be better: vibopt sweep FILE --vary PATH=RANGE."
    )
    other = answer(with_changes(job, {path: beyond}), explain=False)
    assert other.status == "optimal"
    assert at(float(beyond.split()[0]))[0] == pytest.approx(other.goal[1].value / 1.27e-5 if other.goal else 0.0)
    assert at(float(beyond.split()[0]))[0] < here[0]


def test_the_radius_of_a_plane_moves_its_trial_weights() -> None:
    found = prices(from_text(FAN.partition("[limits.a]")[0], "fan.toml"), only=["planes.left.radius"])
    assert (
        "With the radius of a plane its trial weights move, too: the readings ask for the same weights in grams."
        in (found.notes)
    )
    assert [way.change for way in found.rows[0].ways] == [0.0, 0.0]


@pytest.mark.slow
def test_a_sweep_finds_every_other_filling_of_holes() -> None:
    """Totals of weights of 3, 5 and 8 g are whole grams: of every whole total either the plan of one less is best."""
    plane = 'radius = "150 mm"\nholes = 12\nshelf = ["3 g", "5 g", "8 g"]\nmost_weights = 2'
    total = '[limits.total]\nresponse = "correction"\ntotal = true\nat_most = "20 g"\n'
    job = from_text(MEASURED.replace('radius = "150 mm"', plane) + total)
    best = {}
    for grams in range(12, 16):
        goal = answer(with_changes(job, {"limits.total.at_most": f"{grams}.5 g"}), explain=False).goal
        assert goal is not None
        best[grams] = goal[1].value
    leaps = [1e-3 * grams for grams in range(13, 16) if best[grams] < best[grams - 1]]
    found = sweep(job, "limits.total.at_most", "12.5 g..15.5 g", 2)
    other = [one for one in found.boundaries if one.before[2] != one.after[2]]
    assert [one.at for one in other] == pytest.approx(leaps, rel=1e-5)
    assert change_words(other[-1]) == "left 11 g @ 321.9 deg -> 10 g @ 315 deg, right 3 g @ 60 deg -> 5 g @ 90 deg"
    assert change_words(other[-1], briefly=True) == "other weights in left and right"


def test_a_trade_off_of_weights_in_holes_has_the_least_left_of_each_sum() -> None:
    """Of plans with the same sum the one that leaves least: every filling by itself."""
    plane = 'radius = "150 mm"\nholes = 8\nshelf = ["4 g", "8 g"]\nmost_weights = 2'
    rest = '[limits.left]\nresponse = "residual"\nat_most = "3 mil pp"\n[goal]\nminimise = "correction"\n'
    found = vo.tradeoff(from_text(MEASURED.replace('radius = "150 mm"', plane) + rest), "limits.left", 6)
    runs = np.array([[8.6, 63, 6.5, 206], [5.9, 123, 4.5, 228], [6.2, 36, 10.4, 162]])
    first, left, right = runs[:, ::2] * np.exp(1j * np.radians(runs[:, 1::2]))
    per = (left - first) / (10.0 * np.exp(1.5j * np.pi)), (right - first) / (12.0 * np.exp(1j * np.pi))
    single = [(size, size * np.exp(0.25j * np.pi * hole), hole) for size in (4.0, 8.0) for hole in range(8)]
    pairs = [(a[0] + b[0], a[1] + b[1]) for a in single for b in single if a[2] < b[2]]
    sums, vectors = np.array([(0.0, 0.0), *(one[:2] for one in single), *pairs]).T
    moved = [np.abs(f + a * vectors[:, None] + b * vectors[None, :]) for f, a, b in zip(first, *per, strict=True)]
    worst, total = np.maximum(*moved), sums.real[:, None] + sums.real[None, :]
    least = {grams: float(worst[total == grams].min()) for grams in np.unique(total)}
    for point, at in zip(found.points, found.reached, strict=True):
        assert point.goal is not None
        assert at.value / 25.4e-6 * 2.0 == pytest.approx(least[round(1e3 * point.goal.value, 9)], rel=1e-6)
