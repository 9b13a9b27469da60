"""The general method: exact local optima of every kind of limit, and no false claims."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest

from vibopt.charts.isolation_cases import many, undamped_passage
from vibopt.charts.machines import block, chain, fan, press
from vibopt.forms import Modulus
from vibopt.program.casadi_nlp import SampledProgram, Samples
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict, from_text
from vibopt.solve.branch import Judge
from vibopt.solve.local import improved
from vibopt.solve.measured_pieces import Exact
from vibopt.solve.nlp import Nlp, told
from vibopt.solve.ranges import closed, halton, log_box, starts
from vibopt.solve.rivals.sampled import SampledRows
from vibopt.solve.solve import solve
from vibopt.solve.sqp import Sqp
from vibopt.work import Budget

FREE = 'stiffness = { from = "10 kN/m", to = "100 MN/m" }\ndamping = { from = "10 N s/m", to = "100 kN s/m" }'
STIFFNESS = 'stiffness = { from = "10 kN/m", to = "100 MN/m" }\ndamping = "300 N s/m"'
FIXED = 'stiffness = "5 MN/m"\ndamping = "1 kN s/m"'
FORCE = """
[excitations.f]
kind = "force"
on = "a"
amplitude = "1 kN"
speed = "1500 rpm"
varies = "constant"
"""
SECOND = """
[excitations.g]
kind = "unbalance"
on = "b"
unbalance = "0.05 kg m"
speed = "800..1200 rpm"
"""
HARMONICS = """
[excitations.f]
kind = "harmonics"
on = "a"
speed = "600..900 rpm"
varies = "speed^2"
amplitude_at = "900 rpm"
harmonics = [ { order = 1, amplitude = "1 kN" }, { order = 2, amplitude = "400 N", phase = "30 deg" } ]
"""
STIFFEST = 'maximise = "stiffness"\nof = "base"'


def two(
    limits: str, goal: str, *, base: str = FREE, top: str = FIXED, shaken: str = FORCE, mass: str = '"400 kg"'
) -> Program:
    """Two bodies on top of each other."""
    text = f"""title = "two bodies"
[bodies.a]
mass = "100 kg"
[bodies.b]
mass = {mass}
[links.top]
between = ["a", "b"]
{top}
[links.base]
between = ["b", "ground"]
{base}
{shaken}
{limits}
[goal]
{goal}
"""
    return closed(pose(from_text(text)))


def limit(name: str, words: str) -> str:
    return f"[limits.{name}]\n{words}\n"


UP = limit("up", 'response = "displacement"\nof = "a"\nover = "0..1500 rpm"\nat_most = "4 mm"')
FLOOR = 'response = "transmitted_force"\ninto = "ground"\n'
SAG = limit("sag", 'response = "static_deflection"\nof = "a"\nat_most = "5 mm"')
BOTH = 'due_to = ["f", "g"]\n'

# Name: program, best goal to be minimised as branch and bound proves it (gap 1e-6), polished.
SCENES = {
    "least worst motion": (
        lambda: two(SAG, 'minimise = "displacement"\nof = "a"\nover = "0..1500 rpm"'),
        3.47132648124396e-4,
    ),
    "least force": (
        lambda: two(UP.replace("4 mm", "3 mm"), 'minimise = "transmitted_force"\ninto = "ground"\nat = "1500 rpm"'),
        232.921838990876,
    ),
    "two excitations, sum": (
        lambda: two(
            limit("floor", f'{FLOOR}{BOTH}combine = "sum"\nat_most = "900 N"')
            + limit("up", f'response = "displacement"\nof = "a"\n{BOTH}combine = "sum"\nat_most = "1 mm"'),
            STIFFEST,
            shaken=FORCE + SECOND,
        ),
        -2214280.0762995966,
    ),
    "two excitations, rss": (
        lambda: two(
            limit("floor", f'{FLOOR}{BOTH}combine = "rss"\nat_most = "700 N"'), STIFFEST, shaken=FORCE + SECOND
        ),
        -2298886.0398626314,
    ),
    "insertion loss": (
        lambda: two(
            limit("il", 'response = "insertion_loss"\nacross = "top"\nover = "1200..1500 rpm"\nat_least = "6 dB"'),
            'maximise = "stiffness"\nof = "top"',
            base=FIXED,
            top=FREE,
        ),
        -240888.24685316606,
    ),
    "modes": (
        lambda: two(
            limit("m1", 'response = "natural_frequency"\nat_least = "10 Hz"')
            + limit("m2", 'response = "natural_frequency"\nmode = 2\nat_most = "40 Hz"'),
            'maximise = "stiffness"\nof = "top"',
            base=STIFFNESS,
            top=STIFFNESS,
            shaken="",
        ),
        -4967463.84737756,
    ),
    "outside a band": (
        lambda: two(
            limit("o", 'response = "natural_frequency"\noutside = "15..40 Hz"') + SAG,
            'minimise = "stiffness"\nof = "top"',
            base=STIFFNESS,
            top=STIFFNESS,
            shaken="",
        ),
        198075.45667722376,
    ),
    "a mass to choose": (
        lambda: two(
            limit("floor", f'{FLOOR}at_most = "100 N"')
            + limit("up", 'response = "displacement"\nof = "a"\nover = "1200..1500 rpm"\nat_most = "0.2 mm"'),
            'minimise = "total_mass"',
            base=STIFFNESS,
            top=STIFFNESS,
            mass='{ from = "50 kg", to = "5 t" }',
        ),
        156.83510037463927,
    ),
    "an open range": (
        lambda: two(
            limit("floor", f'{FLOOR}at_most = "400 N"') + UP.replace("4 mm", "6 mm"),
            STIFFEST,
            base='stiffness = { from = "1 kN/m" }\ndamping = { from = "1 N s/m" }',
        ),
        -2451536.65216106,
    ),
    "most isolation": (
        lambda: two(UP, 'maximise = "isolation"\ninto = "ground"\nat = "1500 rpm"'),
        0.18757078034488234,
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_finds_the_proven_optimum_of_every_kind_of_limit(name: str) -> None:
    make, best = SCENES[name]
    program = make()
    found = Nlp().solve(program)
    judge = Judge(program)
    assert found.status == "feasible"
    assert found.x is not None
    assert judge.goal(found.x).value == pytest.approx(best, rel=1e-9)
    assert max(judge.limit(one, found.x)[0] for one in program.limits) <= 1e-9


@pytest.mark.parametrize(
    ("text", "best"),
    [
        (fan(), 370110.16504085094821),
        (press(), 6956917.160715138961),
        (press("speed^2"), 7376914.526398903795),
        (chain(5, floor="300 N", start_up="4 mm"), 1727991.4374941021286),
    ],
)
def test_optima_at_corners_are_sharp_to_ten_digits(text: str, best: float) -> None:
    program = pose(from_text(text))
    found = Nlp().solve(program)
    assert found.x is not None
    assert -Judge(program).goal(found.x).value == pytest.approx(best, rel=1e-10)


@pytest.mark.slow
def test_ten_unknowns_are_chosen_together() -> None:
    case = many()[-1]
    program = pose(case.scene())
    found = Nlp().solve(program)
    assert found.x is not None
    assert len(found.x) == 10
    assert -Judge(program).goal(found.x).value == pytest.approx(case.goal, rel=1e-10)


def test_several_harmonics_by_their_true_peak() -> None:
    words = f'{FLOOR}combine = "peak"\nat_most = "600 N"'
    program = two(limit("floor", words), STIFFEST, shaken=HARMONICS)
    found = Nlp(count=2).solve(program)
    assert found.x is not None
    assert Judge(program).limit(program.limits[0], found.x)[0] == pytest.approx(0.0, abs=1e-9)


def test_nothing_found_is_called_unproven_and_never_infeasible() -> None:
    found = Nlp().solve(pose(undamped_passage()[-1].scene()))
    assert found.status == "unproven"
    assert found.x is None
    assert found.claim == "no design found from 18 starts, which proves nothing"


def test_claim_counts_starts_and_those_that_agree_as_far_as_every_processor_counts_the_same() -> None:
    found = Nlp(count=4).solve(pose(from_text(press())))
    assert found.claim == "best of 8 starts, 4 or more agreed, some ended outside the limits"
    agreed, outside = found.details["agreed"], found.details["ended outside the limits"]
    assert agreed >= 4
    assert outside >= 1
    assert agreed + outside + found.details["left far behind"] <= found.details["starts"] == 8


@pytest.mark.parametrize(
    ("agreed", "outside", "left", "words"),
    [
        (9, 0, 0, "best of 12 starts, 4 or more agreed"),
        (3, 0, 0, "best of 12 starts, 3 agreed"),
        (1, 9, 2, "best of 12 starts, 1 agreed, most ended outside the limits, some were left far behind"),
        (2, 0, 10, "best of 12 starts, 2 agreed, most were left far behind"),
        (0, 6, 0, "better than what 12 starts led to, some ended outside the limits"),
    ],
)
def test_claim_says_of_starts_that_failed_that_they_are_no_agreement(
    agreed: int, outside: int, left: int, words: str
) -> None:
    assert told(12, agreed, outside, left) == words


def unlike_absorbers(masses: tuple[float, ...]) -> Program:
    """Absorbers of given masses [kg] on one undamped machine, all springs and dampers to be chosen."""
    host, spring = 20.916338457677803, 47734.22808716226
    own = np.sqrt(spring / host)
    document: dict[str, Any] = {
        "bodies": {"main": {"mass": f"{host} kg"}},
        "links": {"base": {"between": ["main", "ground"], "stiffness": f"{spring} N/m"}},
        "excitations": {
            "e": {
                "kind": "force",
                "on": "main",
                "amplitude": "1 kN",
                "speed": f"{0.3 * own}..{2 * own} rad/s",
                "varies": "constant",
            }
        },
        "goal": {"minimise": "displacement", "of": "main"},
    }
    for i, mass in enumerate(masses):
        k, c = mass * own**2, 2.0 * mass * own
        document["bodies"][f"a{i}"] = {"mass": f"{mass} kg"}
        document["links"][f"t{i}"] = {
            "between": ["main", f"a{i}"],
            "stiffness": {"from": f"{0.05 * k} N/m", "to": f"{20 * k} N/m"},
            "damping": {"from": f"{0.001 * c} N s/m", "to": f"{5 * c} N s/m"},
        }
    return closed(pose(from_dict(document)))


def test_a_start_that_falls_behind_the_best_known_is_left() -> None:
    """With a bar far below all there is, no way comes near it; without one the same way is followed to its end."""
    program = unlike_absorbers((0.4, 0.3, 0.3))
    low, high = log_box(program)
    ways = []
    for bar in (-50.0, np.inf):
        sqp = Sqp(Exact(program, low, high, Budget(2000, "exact measurements")), bar=bar)
        ways.append((sqp.run(0.5 * (low + high)), sqp.behind, sqp.exact.budget.spent))
    (early, left, few), (late, followed, many_more) = ways
    assert left
    assert not followed
    assert few < many_more
    assert late.missed <= 1e-9
    assert late.goal < early.goal + 4.0 * max(early.missed, 0.0)


def test_same_question_gives_the_same_answer() -> None:
    one, other = (Nlp().solve(pose(from_text(block()))) for _ in range(2))
    assert one.x is not None
    assert other.x is not None
    assert list(one.x) == list(other.x)


def test_discrete_variables_are_refused_in_a_sentence() -> None:
    text = press().replace(
        'damping = { from = "10 N s/m", to = "1 MN s/m" }', 'damping = { one_of = ["1 kN s/m", "2 kN s/m"] }'
    )
    refusal = Nlp().refuses(pose(from_text(text)))
    assert refusal == "nlp takes continuous variables only, but links.mount.damping is chosen from 2 values."


def test_nothing_reaches_standard_output(capfd: pytest.CaptureFixture[str]) -> None:
    Nlp(count=2).solve(pose(from_text(press())))
    out, err = capfd.readouterr()
    assert out == ""
    assert err == ""


@pytest.mark.parametrize("name", [name for name in SCENES if name != "an open range"])
def test_slopes_of_local_extremes_are_those_of_differences(name: str) -> None:
    program = SCENES[name][0]()
    low, high = log_box(program)
    for y in low + (high - low) * (0.1 + 0.8 * halton(4, len(low))):
        for part in [*program.limits, program.aim]:
            assert part is not None
            least_wanted = getattr(part, "side", "") == "at_least"

            def value(at: np.ndarray, part=part, least_wanted=least_wanted) -> float:
                return part.form.extremes(part.model, np.exp(at), least_wanted=least_wanted)[0].value

            slope = part.form.extremes(part.model, np.exp(y), least_wanted=least_wanted)[0].slope
            step = 1e-5 * np.eye(len(y))
            differences = [(value(y + d) - value(y - d)) / 2e-5 for d in step]
            assert slope == pytest.approx(differences, rel=2e-4, abs=2e-4)


def test_sampled_program_in_casadi_has_the_values_of_the_model() -> None:
    import casadi

    program = SCENES["a mass to choose"][0]()
    low, high = log_box(program)
    nlp = SampledProgram(Samples(program).spread(9), np.exp(0.5 * (low + high)), low, high)
    values = casadi.Function("rows", [nlp.y], [casadi.vertcat(*nlp.rows)])
    rows = SampledRows(program, 9)
    for y in low + (high - low) * halton(5, len(low)):
        assert np.array(values(y)).ravel() == pytest.approx(rows.limits(y), abs=1e-7)


def test_starts_spread_over_the_box_and_begin_in_its_middle() -> None:
    program = pose(from_text(press()))
    low, high = log_box(program)
    points = starts(program, 16)
    assert (points >= low).all()
    assert (points <= high).all()
    assert points[1] == pytest.approx(low + (high - low) * np.array([0.25, 2 / 3]))
    assert any(isinstance(one.form, Modulus) for one in program.limits)


@pytest.mark.parametrize(
    "masses",
    [
        (0.3233939457538378, 0.27272036012866463),
        (0.4, 0.3, 0.3),
        pytest.param((0.1, 0.6, 0.2), marks=pytest.mark.slow),
    ],
)
def test_no_order_of_unlike_absorbers_is_better_than_the_one_found(masses: tuple[float, ...]) -> None:
    """The heavier tuned higher or lower: each is a local optimum, and four starts may agree on the worse one."""
    program = unlike_absorbers(masses)
    found = Nlp().solve(program)
    assert found.x is not None
    assert "4 or more agreed" in found.claim, "starts that end at another order agree, too"
    judge, each = Judge(program), found.x.reshape(-1, 2) / np.array(masses)[:, None]
    apart = 0.0
    for order in permutations(range(len(masses))):
        other = improved(program, (each[list(order)] * np.array(masses)[:, None]).ravel(), judge)
        assert judge.goal(found.x).value <= judge.goal(other).value * (1.0 + 1e-9)
        apart = max(apart, float(np.abs(np.log(other / found.x)).max()))
    assert apart > 0.05, "different designs are compared"


@pytest.mark.parametrize(
    ("sense", "goal"), [("minimise", 1.0), pytest.param("maximise", 5000.0, marks=pytest.mark.slow)]
)
def test_a_goal_at_the_end_of_its_range_is_proven(sense: str, goal: float) -> None:
    """The second mode's damping has no bounds, and none are needed."""
    made = solve(
        from_dict(
            {
                "title": "t",
                "bodies": {"a": {"mass": "50 kg"}, "b": {"mass": "5 kg"}},
                "links": {
                    "low": {
                        "between": ["a", "ground"],
                        "stiffness": "200 kN/m",
                        "damping": {"from": "1 N s/m", "to": "5 kN s/m"},
                    },
                    "up": {
                        "between": ["b", "a"],
                        "stiffness": {"from": "0.1 kN/m", "to": "10 MN/m"},
                        "damping": {"from": "0.1 N s/m", "to": "200 kN s/m"},
                    },
                },
                "limits": {"d": {"response": "damping_ratio", "mode": 2, "at_least": "12 %"}},
                "goal": {sense: "damping", "of": "low"},
            }
        ),
        explain=False,
    )
    assert made.goal is not None
    assert (made.status, made.goal[1].value) == ("optimal", goal)
    assert made.claim == (
        "proven: the ranges alone permit no better goal, and this design meets every limit; of the designs found with "
        "this goal it has the most room in its limits"
    )
    assert made.limits["d"].met
