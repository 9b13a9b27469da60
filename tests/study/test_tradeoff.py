"""Trade-offs: no point is dominated, neighbours are near, both ends are where solve says they are."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from rotor_jobs import FAN
from texts import best, floor, shaken_fan, table
from vibopt.answer.console import Console
from vibopt.balancing import is_rotor
from vibopt.balancing.solve_rotor import asked_of
from vibopt.cli.tradeoff_command import _list
from vibopt.document.mistakes import Mistakes
from vibopt.jobs import fact_at, from_text, of_document
from vibopt.report.figures import tradeoff_figure
from vibopt.report.series import Front
from vibopt.solve.closed_program import question
from vibopt.study import together, tradeoff
from vibopt.study.against import bounded
from vibopt.study.pareto import rising
from vibopt.study.sweep_series import front_of
from vibopt.study.tradeoff import Tradeoff

ROOT = Path(__file__).parents[2] / "problems"
PRESS = ROOT / "isolation" / "rao_9_34.toml"
CATALOGUE = shaken_fan(
    {"stiffness": '{ one_of = ["200 kN/m", "300 kN/m", "450 kN/m", "700 kN/m"] }', "damping": "500 N s/m"},
    floor("60 N"), best(minimise="displacement", of="fan", over="0..100 rpm"),
    amplitude="1 kN", speed="3000 rpm", varies="constant",
)  # fmt: skip


def front(text: str, against: str, points: int) -> Tradeoff:
    return vo.tradeoff(from_text(text), against, points)


def costs(found: Tradeoff) -> tuple[np.ndarray, np.ndarray]:
    goal = np.array([point.goal.value for point in found.points if point.goal is not None])
    reached = np.array([one.value for one in found.reached])
    sense = -1.0 if getattr(found.job.goal, "sense", "") == "maximise" else 1.0
    return reached * (-1.0 if found.fact.path.endswith("at_least") else 1.0), sense * goal


def test_an_isolation_is_told_as_the_design_reaches_it() -> None:
    """Its margin is a part of what may come through, not of the isolation."""
    text = PRESS.read_text(encoding="utf-8").partition("[[expected]]")[0]
    isolation = '[limits.isolation]\nresponse = "isolation"\ninto = "ground"\nat_least = "75 %"\n'
    found = front(text + isolation, "limits.isolation", 5)
    for reached, point in zip(found.reached, found.points, strict=True):
        values = {path: f"{one.value:.17g} {one.si}" for path, one in point.variables.items()}
        kept = vo.solve(vo.with_changes(found.job, values), explain=False)
        assert reached.value == pytest.approx(kept.limits["isolation"].value.value, rel=1e-9)
        assert reached.value >= point.varied["limits.isolation.at_least"].value * (1.0 - 1e-9)


def test_an_isolation_is_weighed_as_what_is_to_be_great() -> None:
    assert str(refused(lambda: vo.tradeoff(vo.read(PRESS), "isolation into ground"))) == (
        'rao_9_34.toml: --against "isolation into ground" is to be as small as can be, and an isolation is better the '
        'greater it is. Write --against "most isolation into ground".'
    )
    assert len(vo.tradeoff(vo.read(PRESS), "most isolation into ground", 4).points) >= 4


@pytest.fixture(scope="module")
def press() -> Tradeoff:
    return vo.tradeoff(vo.read(PRESS), "limits.start_up", 20)


def test_every_point_is_better_than_its_neighbours_in_one_quantity(press: Tradeoff) -> None:
    reached, goal = costs(press)
    assert np.all(np.diff(reached) > 0.0)
    assert np.all(np.diff(goal) < 0.0)
    assert len(press.points) >= 20
    assert press.gap <= 2.0 / 19 * (1.0 + 1e-6)


def test_what_one_batch_has_read_of_the_question_the_others_follow(
    press: Tradeoff, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The scene is read at few bounds; read anew by every batch it has the same curve, to the last digits."""
    read: list[int] = []
    monkeypatch.setattr(together, "question", lambda *args: read.append(1) or question(*args))
    again = vo.tradeoff(vo.read(PRESS), "limits.start_up", 20)
    few, forget = len(read), together.Seen.at
    monkeypatch.setattr(together.Seen, "at", lambda self, *args: forget(together.Seen(), *args))
    anew = vo.tradeoff(vo.read(PRESS), "limits.start_up", 20)
    assert few == 3
    assert len(read) - few > 4 * few
    for one in (again, anew):
        assert np.allclose(costs(one), costs(press), rtol=1e-13)


def test_a_number_that_is_linear_in_a_fact_is_read_anew_between_values_that_are_nearer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Between ends a million times apart it has lost digits; a power of the fact has all of them everywhere."""
    document, read = vo.read(PRESS).document, []
    pipes = {name: {"between": ["press", "ground"], "stiffness": "20 kN/m"} for name in ("supply", "drain")}
    job = vo.from_dict({**document, "links": {**document["links"], **pipes}})
    monkeypatch.setattr(together, "question", lambda *args: read.append(1) or question(*args))
    for path, again in (("limits.start_up.at_most", 0), ("links.supply.stiffness", 3)):
        fact, seen = fact_at(job, path), together.Seen()
        for low, high in ((1e-3, 1e3), (0.5, 2.0)):
            read.clear()
            assert together.columns(job, [fact], fact.value * np.geomspace(low, high, 15)[:, None], seen=seen)
            assert len(read) == (3 if low < 0.5 else again)


def test_no_design_of_many_is_better_in_both(press: Tradeoff) -> None:
    """Stiffness and damping drawn at random, measured on the machine as built: none lies below the curve."""
    job = vo.read(PRESS)
    reached, goal = costs(press)
    rng, tried = np.random.default_rng(5), 0
    for k, c in zip(rng.uniform(4e6, 7.4e6, 60), np.exp(rng.uniform(np.log(500.0), np.log(24e3), 60)), strict=True):
        found = vo.solve(vo.from_dict({
            **{key: one for key, one in job.document.items() if key not in ("goal", "expected")},
            "links": {"mount": {"between": ["press", "ground"], "stiffness": f"{k} N/m", "damping": f"{c} N s/m"}},
        }), explain=False)  # fmt: skip
        if not all(one.met for name, one in found.limits.items() if name != "start_up"):
            continue
        tried += 1
        at = found.limits["start_up"].value.value
        assert not np.any((at < reached * (1.0 - 1e-9)) & (-k < goal * (1.0 + np.sign(goal) * 1e-9)))
    assert tried > 5


def test_both_ends_are_where_solve_says(press: Tradeoff) -> None:
    job, (reached, goal) = vo.read(PRESS), costs(press)

    def best(bound: float) -> float | None:
        found = vo.solve(vo.with_changes(job, {"limits.start_up.at_most": f"{bound:.17g} m"}), explain=False)
        return found.goal[1].value if found.goal is not None and found.status == "optimal" else None

    assert best(reached[0] * (1.0 - 2e-6)) is None
    assert best(reached[0] * (1.0 + 2e-6)) is not None
    own, less = best(1e4), best(reached[-1] * (1.0 - 1e-3))
    assert own is not None
    assert less is not None
    assert -goal[-1] == pytest.approx(own, rel=1e-9)
    assert less < own
    assert press.free


@pytest.mark.parametrize(
    ("file", "limit", "tightest"),
    [("absorbers/rao_9_61", "stroke", 2e-3), ("isolation/pump_with_inerter", "smooth", None)],
)
def test_where_each_point_costs_an_answer_few_are_asked(file: str, limit: str, tightest: float | None) -> None:
    job = vo.read(ROOT / f"{file}.toml")
    found = vo.tradeoff(job, f"limits.{limit}", 12)
    assert found.gap <= 2.0 / 11 * (1.0 + 1e-6)
    assert len(found.points) <= 18
    assert found.asked <= 32  # the tightest bound alone took twenty
    least = found.reached[0].value
    assert tightest is None or least == pytest.approx(tightest, rel=1e-6)
    for part, verdict in ((1.0 - 2e-6, "infeasible"), (1.0 + 2e-6, "optimal")):
        changed = vo.with_changes(job, dict(found.fact.changes(least * part)))
        assert vo.solve(changed, explain=False).status == verdict


def test_an_end_beyond_what_is_answered_together_is_found_one_by_one() -> None:
    """Soft mounts that hardly damp: near the tightest bound the closed form has no answer, and it ended 1.4 % short."""
    job = vo.with_changes(vo.read(PRESS), {"limits.floor_force.at_most": "0.07798 kN"})
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("vibopt.study.moved_bound.CLOSE", 1e-3)
        found = vo.tradeoff(job, "limits.start_up", 3)
    tightest = found.reached[0].value
    for part, status in ((1.0 - 2e-3, "infeasible"), (1.0 + 2e-3, "optimal")):
        changes = {"limits.start_up.at_most": f"{tightest * part!r} m"}
        assert vo.solve(vo.with_changes(job, changes), explain=False).status == status


def test_each_point_is_the_answer_at_its_bound_and_the_knee_is_farthest_from_the_chord(press: Tradeoff) -> None:
    job = vo.read(PRESS)
    for index in (0, len(press.points) // 2, -1):
        point = press.points[index]
        bound = f"{point.value.value:.17g} m"
        alone = vo.solve(vo.with_changes(job, {"limits.start_up.at_most": bound}), explain=False)
        assert alone.goal is not None
        assert point.goal is not None
        assert point.goal.value == pytest.approx(alone.goal[1].value, rel=1e-8)
        assert alone.limits["start_up"].value.value == pytest.approx(press.reached[index].value, rel=1e-8)
    reached, goal = costs(press)  # the amplitude spans more than a factor 100, the stiffness does not
    x, y = np.log(reached), goal
    x, y = (x - x[0]) / (x[-1] - x[0]), (y - y[-1]) / (y[0] - y[-1])
    assert press.knee == int((x + y).argmin())
    tradeoff_figure(front_of(press))


def test_a_second_goal_may_be_a_measure_or_said_in_words() -> None:
    job = vo.read(PRESS)
    words = vo.tradeoff(job, "displacement of press over 0..3000 rpm", 5)
    document = {**job.document, "measures": {"up": {"response": "displacement", "of": "press", "over": "0..3000 rpm"}}}
    measure = vo.tradeoff(vo.from_dict(document), "measures.up", 5)
    for one, other in pairwise((words, measure)):
        assert costs(one)[1] == pytest.approx(costs(other)[1], rel=1e-6)


def test_a_list_of_springs_has_a_point_for_each_that_is_worth_having_and_nothing_between() -> None:
    found = front(CATALOGUE, "limits.floor", 8)
    springs = [round(point.variables["links.mount.stiffness"].value / 1e3) for point in found.points]
    assert springs == [200, 300, 450, 700]
    assert found.jumps == (0, 1, 2)
    assert found.gap == 0.0


TOTAL = {"response": "correction", "total": True, "at_most": "80 g"}
JOBS = {
    "rotor": ("fan_verification_run.toml", {"limits": {"total": TOTAL}, "goal": {"minimise": "residual"}}),
    "known": ("rao_9_14_b_capped.toml", {"limits": {"total": TOTAL}}),
}


@pytest.mark.parametrize("kind", JOBS)
def test_rotors_and_shafts_weigh_what_is_left_against_the_weights(kind: str) -> None:
    name, more = JOBS[kind]
    document = {**vo.read(ROOT / "balancing" / name).document, **more}
    job = vo.with_changes(of_document(document, Mistakes(name, None)), {})
    found = vo.tradeoff(job, "limits.total", 6)
    reached, goal = np.array([one.value for one in found.reached]), np.array([one.goal.value for one in found.points])
    assert np.all(np.diff(reached) > 0.0)
    assert np.all(np.diff(goal) < 0.0)
    assert found.gap <= 2.0 / 5.0 * (1.0 + 1e-6)
    for point, at in zip(found.points[1:-1:2], found.reached[1:-1:2], strict=True):
        tighter = vo.with_changes(job, {"limits.total.at_most": f"{at.value * (1.0 - 1e-4):.17g} kg"})
        answer = vo.solve(tighter, explain=False)
        assert answer.goal is not None
        assert answer.goal[1].value > point.goal.value


TOTAL_OF_HOLES = table("limits.total", response="correction", total=True, at_most="6 oz")


@pytest.mark.parametrize("worst", ["", table("limits.b", response="residual", at="B", at_most="3.5 mil pp")])
def test_of_holes_and_shelves_every_choice_that_is_worth_having_is_found_in_few_answers(worst: str) -> None:
    """Against every filling of both planes, one after the other."""
    text = (ROOT / "balancing" / "rao_9_13_holes.toml").read_text().partition("[[expected]]")[0]
    job = from_text(text + TOTAL_OF_HOLES + worst)
    assert is_rotor(job)
    asked = asked_of(job)[3].question
    first, second = asked.options
    assert first is not None
    assert second is not None
    (left, light), (right, heavy) = (first.u, first.masses), (second.u, second.masses)
    both = np.array(
        [(a, b, m + n) for a, m in zip(left, light, strict=True) for b, n in zip(right, heavy, strict=True)]
    )
    amplitudes = np.abs(both[:, :2] @ asked.H.T + asked.y0)
    keeps = np.all(amplitudes <= asked.limits, axis=1)
    every = sorted(zip(both[keeps, 2].real, amplitudes[keeps].max(axis=1), strict=True))
    worth: list[tuple[float, float]] = []
    for mass, left_over in every:
        if not worth or left_over < worth[-1][1] * (1.0 - 1e-9):
            worth.append((mass, left_over))
    found = vo.tradeoff(job, "limits.total", 20)
    reached, goal = costs(found)
    begun = 1 if worth[0][0] == 0.0 else 0  # no weights at all: a bound is more than zero
    assert np.stack([reached, goal], axis=1)[begun:] == pytest.approx(np.array(worth)[begun:], rel=1e-9)
    assert found.asked <= 4 * len(worth)


def test_a_bound_that_may_fade_to_nothing_is_counted_as_it_is_and_not_by_ratios() -> None:
    """Without weights the readings stay as they are, so that no total is the tightest; the knee is where one bends."""
    text = FAN + table("limits.total", response="correction", total=True, at_most="16 g")
    found = front(text + best(minimise="residual", combine="rms"), "limits.total", 9)
    reached, goal = costs(found)
    assert reached[0] <= 2e-6 * reached[-1]
    assert np.max(np.diff(reached)) <= 2.0 / 8 * reached[-1]
    x, y = reached / reached[-1], (goal - goal[-1]) / (goal[0] - goal[-1])
    assert found.knee == int((x + y).argmin())
    assert 0.2 < x[found.knee] < 0.8


@pytest.mark.parametrize(
    ("against", "points", "words"),
    [
        ("limits.startup", 5,
         "rao_9_34.toml: --against limits.startup is no limit with at_most or at_least. Did you mean "
         '"limits.start_up"?'),
        ("measures.sagg", 5,
         'rao_9_34.toml: --against measures.sagg is none of its limits or measures. Did you mean "measures.sag"?'),
        ("limits.start_up", 2, "--points 2 is not between 3 and 1000."),
        ("measures.sag", 5,
         "rao_9_34.toml: limits.sag.at_most and the goal are best in one and the same design: there is nothing to "
         "weigh."),
    ],
)  # fmt: skip
def test_what_cannot_be_weighed_is_said(against: str, points: int, words: str) -> None:
    assert str(refused(lambda: vo.tradeoff(vo.read(PRESS), against, points))) == words


THREE = """
[engine]
stroke = "86 mm"
rod = "145 mm"
speed = "6000 rpm"
reciprocating = "0.5 kg"
rotating = "0.4 kg"
spacing = "90 mm"
[[cylinders]]
crank = "0 deg"
[[cylinders]]
crank = "120 deg"
[[cylinders]]
crank = "240 deg"
[counterweights.front]
at = "-40 mm"
unbalance = { from = "0 g mm", to = "20 kg mm" }
[counterweights.rear]
at = "220 mm"
unbalance = { from = "0 g mm", to = "20 kg mm" }
[limits.force]
response = "primary_force"
at_most = "100 N"
[goal]
minimise = "primary_couple"
"""


def test_a_limit_that_costs_nothing_down_to_zero_leaves_nothing_to_weigh() -> None:
    job = from_text(THREE, "three.toml")
    assert str(refused(vo.tradeoff, job, "limits.force", 3)) == (
        "three.toml: limits.force.at_most and the goal are best in one and the same design: there is nothing to weigh."
    )


def test_a_second_goal_in_words_is_called_by_its_response() -> None:
    """A name that a limit or a measure has already is left to it."""
    job = from_text(THREE.replace("[limits.force]", "[limits.secondary_couple]"), "three.toml")
    assert str(refused(vo.tradeoff, job, "secondary_couple", 3)).startswith(
        "three.toml: limits.secondary_couple_2.at_most and the goal are best in one and the same design"
    )


def test_a_second_goal_of_which_the_best_design_leaves_nothing_is_not_weighed() -> None:
    assert str(refused(vo.tradeoff, from_text(THREE, "three.toml"), "primary_force", 3)) == (
        "three.toml: --against primary_force and the goal are best in one and the same design, which leaves nothing of "
        "it: there is nothing to weigh."
    )


def test_a_response_in_words_is_named_as_it_was_given() -> None:
    assert str(refused(lambda: vo.tradeoff(vo.read(PRESS), against="displacement of nobody"))) == (
        'rao_9_34.toml: --against "displacement of nobody": measure.of = "nobody" names no body of this scene. '
        "Known: press."
    )


def test_bounds_that_a_limit_has_from_its_parts_are_named() -> None:
    """The load of mounts between one and six kN is their rating's: the limit names no bound itself."""
    job = vo.read(PRESS.parents[1] / "mounts" / "generator_set.toml")
    sides = "limits.load.at_most or limits.load.at_least"
    words = f"generator_set.toml: --against limits.load has two sides. Name one: {sides}."
    assert str(refused(vo.tradeoff, job, "limits.load")) == words
    assert bounded(job, "limits.load.at_least") == (job, "limits.load.at_least")


def test_where_the_work_is_short_there_are_fewer_points_and_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    job = from_text(CATALOGUE)
    whole = vo.tradeoff(job, "limits.floor", 12)
    monkeypatch.setattr(tradeoff, "MOST_WORK", 60.0)
    found = vo.tradeoff(job, "limits.floor", 12)
    assert (found.short, whole.short) == (True, False)
    assert found.asked < whole.asked
    assert (found.jumps, bool(whole.jumps)) == ((), True)  # between them may lie what was not looked for
    assert vo.tradeoff(job, "limits.floor", 12, thorough=True).to_json() == whole.to_json()
    console = Console(400)
    _list(found, console)
    assert (
        "answers are about the work that is done unasked: there are fewer points than asked for, and the"
        in console.text
    )
    assert "`vibopt tradeoff FILE --thorough` finds all." in console.text


@pytest.mark.parametrize("against", ["residual", "measures.left"])
def test_a_measured_rotor_is_weighed_against_its_limits(against: str) -> None:
    """It has no measures: "unknown key measures" was told of a file without that key."""
    job = vo.read(Path(__file__).parents[2] / "problems" / "balancing" / "fan_for_99_of_100.toml")
    first = next(iter(job.document["limits"]))
    assert str(refused(bounded, job, against)) == (
        f"fan_for_99_of_100.toml: --against {against} is no limit, and a measured rotor is weighed against its limits. "
        f"Write --against limits.{first}."
    )


def test_no_end_of_a_curve_stands_on_the_frame_of_its_figure() -> None:
    """Over decades, too: the room beside the ends is a part of the span."""
    x, y = np.geomspace(18.0, 5449.0, 7), np.geomspace(100.0, 1e6, 7)
    front = Front(title="press", x_label="x", y_label="y", x=x, y=y, marks=((0, "tightest"), (6, "best")), jumps=(5,))
    figure = tradeoff_figure(front)
    axes = figure.axes[0]
    inside = axes.transAxes.inverted().transform(axes.transData.transform(np.column_stack([x, y])))
    assert inside.min() > 0.04
    assert inside.max() < 0.96


def test_the_curve_on_which_bounds_are_placed_rises_through_all_points() -> None:
    """As scipy has it between the inner points, without what it takes to load that."""
    from scipy.interpolate import PchipInterpolator

    dice = np.random.default_rng(5)
    for count in (3, 4, 9, 30):
        x, y = dice.exponential(size=count).cumsum(), (dice.exponential(size=count) ** 3).cumsum()
        at = np.linspace(x[0], x[-1], 200)
        curve = rising(at, x, y)
        assert rising(x, x, y) == pytest.approx(y, rel=1e-12)
        assert (np.diff(curve) >= 0.0).all()
        inner = (x[1] <= at) & (at <= x[-2])
        assert curve[inner] == pytest.approx(PchipInterpolator(x, y)(at[inner]), rel=1e-9)
