"""One plan of weights, or one engine, for all scenarios: by all readings at once, and by each choice as measured."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from rotor_jobs import FAN
from texts import best, table
from vibopt.answer.entry import Entry
from vibopt.jobs import from_text
from vibopt.study.scenarios import one_for_all, variants_of

HEAD, _, RUNS = FAN.partition("[[runs]]")
OPEN = HEAD.replace('radius = "150 mm"', 'radius = "150 mm"\nweight = { from = "0 g", to = "30 g" }')
HOLES = HEAD.replace('radius = "150 mm"', 'radius = "150 mm"\nholes = 8\nshelf = ["3 g", "6 g", "9 g"]')
READINGS = {"a": (8.6, 63.0), "b": (6.5, 206.0)}


def as_found(off: tuple[float, ...], speed: str = "1200 rpm") -> str:
    """The run as found, its amplitudes [mil] and angles [deg] off by some."""
    moved = zip(READINGS.items(), zip(off[::2], off[1::2], strict=True), strict=True)
    said = {name: f"{mil + more:.6g} mil @ {deg + turn:.6g} deg" for (name, (mil, deg)), (more, turn) in moved}
    inner = ", ".join(f'{name} = "{text}"' for name, text in said.items())
    return f'[[runs]]\nname = "as found"\nspeed = "{speed}"\nreadings = {{ {inner} }}\n'


def trials(speed: str = "1200 rpm") -> str:
    return "[[runs]]" + RUNS.split("[[runs]]", 1)[1].replace("1200 rpm", speed)


def scenario(name: str, off: tuple[float, ...]) -> str:
    moved = zip(READINGS.items(), zip(off[::2], off[1::2], strict=True), strict=True)
    lines = [f'"runs.1.readings.{one}" = "{mil + more:.6g} mil @ {deg + turn:.6g} deg"'
             for (one, (mil, deg)), (more, turn) in moved]  # fmt: skip
    return f"[scenarios.{name}]\n" + "\n".join(lines) + "\n"


def weights(found: Any) -> np.ndarray:
    """Mass [kg] and angle of both planes as complex numbers."""
    one: dict[str, Entry] = dict(found)
    return np.array([
        one[f"planes.{plane}.mass"].value * np.exp(1j * turned.value)
        for plane in ("left", "right")
        if (turned := one.get(f"planes.{plane}.angle", Entry(0.0, "angle"))) is not None
    ])  # fmt: skip


NOTHING = (0.0, 0.0, 0.0, 0.0)
OFF = st.tuples(*(st.sampled_from([-12.0, -5.0, -1.0, 0.5, 4.0, 9.0]) for _ in range(4))).map(
    lambda off: (off[0] / 12.0, off[1], off[2] / 12.0, off[3])
)


@given(
    first=OFF, second=OFF, head=st.sampled_from([OPEN, HOLES]), combine=st.sampled_from(["worst", "rms", "sum"]),
    most=st.sampled_from(["14 g", "40 g"]),
)  # fmt: skip
def test_it_is_the_plan_of_one_rotor_with_all_readings_at_speeds_of_their_own(
    first: tuple[float, ...], second: tuple[float, ...], head: str, combine: str, most: str
) -> None:
    """And each scenario measured with these weights alone shows what is told of it."""
    limits = table("limits.b", response="residual", at="b", at_most="4.5 mil pp") + table(
        "limits.total", response="correction", total=True, at_most=most
    )
    goal = best(minimise="residual", combine=combine)
    many = from_text(
        head + as_found(NOTHING) + trials() + limits + goal + scenario("one", first) + scenario("two", second)
    )
    found = one_for_all(many)
    speeds = ("1200 rpm", "1500 rpm", "1900 rpm")
    runs = [as_found(off, speed) + trials(speed) for off, speed in zip((NOTHING, first, second), speeds, strict=True)]
    alone = vo.solve(from_text(head + "".join(runs) + limits + goal), explain=False)
    if alone.goal is None or found.goal is None:
        assert (found.status, alone.goal) == ("infeasible", None)
        return
    assert found.status == "optimal"
    told = weights(found.variables)
    left, right = (f'radius = "150 mm"\nweight = "{abs(u):.17g} kg @ {np.angle(u):.17g} rad"' for u in told)
    fitted = HEAD.replace('radius = "150 mm"', left, 1)
    fitted = right.join(fitted.rsplit('radius = "150 mm"', 1))
    for name, off in zip(found.limits, (NOTHING, first, second), strict=True):
        measured = vo.solve(from_text(fitted + as_found(off) + trials() + limits + goal))
        for key, limit in measured.limits.items():
            assert limit.margin >= -1e-7
            assert found.limits[name][key].value.value == pytest.approx(limit.value.value, rel=1e-6, abs=1e-12)
    if combine == "worst":
        assert found.goal[1].value == pytest.approx(alone.goal[1].value, rel=1e-6)
    elif head is OPEN and combine == "rms":
        assert told == pytest.approx(weights(alone.plan.entries()), rel=2e-3, abs=1e-7)


SHAFT = """
[shaft]
bearings = { A = "0 mm", B = "1000 mm" }
speed = "1000 rpm"
[masses.one]
mass = "50 g"
radius = "80 mm"
angle = "10 deg"
at = "200 mm"
[planes.L]
at = "300 mm"
radius = "250 mm"
holes = 12
shelf = ["4 g", "8 g", "12 g", "16 g"]
[limits.A]
response = "bearing_reaction"
of = "A"
at_most = "{most}"
[goal]
minimise = "{goal}"
{how}
[scenarios.worn]
"masses.one.mass" = "38 g"
[scenarios.fast]
"shaft.speed" = "1300 rpm"
[scenarios.turned]
"masses.one.angle" = "35 deg"
"""


@pytest.mark.parametrize(
    ("goal", "how", "most"), [("reaction", 'combine = "worst"', "40 N"), ("correction", "", "14 N"),
                              ("correction", "", "2 N")],
)  # fmt: skip
def test_known_masses_are_balanced_by_the_choice_that_is_best_of_all_when_each_is_tried(
    goal: str, how: str, most: str
) -> None:
    """By levers on forces in newtons, every filling in every scenario."""
    found = one_for_all(from_text(SHAFT.replace("{most}", most).replace("{goal}", goal).replace("{how}", how)))
    tried = []
    for mass in (0.0, 4e-3, 8e-3, 12e-3, 16e-3):
        for hole in range(12):
            forces = []
            for known, turned, rpm in ((0.05, 10, 1000), (0.038, 10, 1000), (0.05, 10, 1300), (0.05, 35, 1000)):
                speed = (rpm * np.pi / 30.0) ** 2
                own = known * 0.08 * np.exp(1j * np.radians(turned)) * speed
                put = mass * 0.25 * np.exp(1j * hole * np.pi / 6.0) * speed
                forces.append((abs(0.8 * own + 0.7 * put), abs(0.2 * own + 0.3 * put)))
            keeps = max(a for a, _ in forces) <= float(most.split()[0]) * (1.0 + 1e-9)
            tried += [mass if goal == "correction" else max(max(one) for one in forces)] if keeps else []
    if not tried:
        assert (found.status, found.goal) == ("infeasible", None)
        assert found.reason.startswith(("This cannot hold: A", "These cannot hold together: A"))
        return
    assert found.status == "optimal"
    assert found.goal is not None
    assert found.goal[1].value == pytest.approx(min(tried), rel=1e-9)


def test_limits_that_clash_are_named_once_where_they_bound_the_weights_alone() -> None:
    limits = table("limits.a", response="residual", at="a", at_most="3 mil pp") + table(
        "limits.total", response="correction", total=True, at_most="4 g"
    )
    text = (
        OPEN + as_found(NOTHING) + trials() + limits + best(minimise="residual") + scenario("hot", (1.0, 5.0, 1.0, 5.0))
    )
    found = one_for_all(from_text(text))
    assert found.status == "infeasible"
    assert found.reason == "These cannot hold together: total, a in hot. Nor these: a, total."


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HOLES + as_found(NOTHING) + trials() + best(minimise="residual")
         + '[scenarios.more]\n"planes.left.holes" = 12\n',
         "job: scenario more changes what may be chosen, or what is made best, so there is no one plan for all. "
         "vibopt compare FILE --scenarios answers each by itself."),
        (OPEN + as_found(NOTHING) + trials() + best(minimise="residual")
         + '[scenarios.fitted]\n"planes.left.weight" = "3 g @ 0 deg"\n"planes.right.weight" = "3 g @ 0 deg"\n',
         "job: one plan for all scenarios needs weights that are chosen and readings with their angles, and scenario "
         "fitted has not both. vibopt compare FILE --scenarios answers each by itself."),
    ],
)  # fmt: skip
def test_scenarios_that_have_no_one_plan_are_refused(text: str, words: str) -> None:
    assert str(refused(one_for_all, from_text(text))) == words


ENGINE = """
[engine]
stroke = "90 mm"
rod = "150 mm"
speed = "4500 rpm"
reciprocating = "0.6 kg"
rotating = "0.5 kg"
spacing = "100 mm"
orders = 6
"""


def engine(cranks: list[str], more: str, goal: str, **scenarios: str) -> Any:
    cylinders = "".join(f'[[cylinders]]\ncrank = "{crank}"\n' for crank in cranks)
    named = "".join(f"[scenarios.{name}]\n{changes}\n" for name, changes in scenarios.items())
    head = ENGINE if not more.startswith("counter") else f"{ENGINE}{more}"
    return from_text(f"{head}{cylinders}{'' if head != ENGINE else more}[goal]\n{goal}\n{named}", "engine.toml")


@pytest.mark.parametrize("most", ["30 kN", "4.2 kN", "2.5 kN"])
def test_one_share_of_an_engine_is_best_for_the_worst_scenario_by_the_axes_of_its_ellipse(most: str) -> None:
    """A counterweight leaves 1 - s of the force along the cylinder, and s across it."""
    limit = table("limits.first", response="primary_force", at_most=most)
    job = engine(
        ["0 deg"], 'counterweight_share = { from = 0, to = 1 }\n', f'minimise = "primary_force"\n{limit}',
        fast='"engine.speed" = "4900 rpm"', heavy='"engine.reciprocating" = "0.7 kg"\n"engine.speed" = "4300 rpm"',
    )  # fmt: skip
    found = one_for_all(job)
    size = [mass * 0.045 * (rpm * np.pi / 30.0) ** 2 for mass, rpm in ((0.6, 4500), (0.6, 4900), (0.7, 4300))]
    least = 0.5 * max(size)
    if least > float(most.split()[0]) * 1e3:
        assert found.status == "infeasible"
        assert found.reason.startswith(("This cannot hold: first in fast", "This cannot hold: first"))
        return
    assert found.status == "optimal"
    assert found.goal is not None
    assert found.goal[1].value == pytest.approx(least, rel=1e-6)
    assert found.variables["counterweight_share"].value == pytest.approx(0.5, abs=1e-6)
    values = [rows["first"].value.value for rows in found.limits.values()]
    assert values == pytest.approx([0.5 * one for one in size], rel=1e-6)


@settings(max_examples=8)
@given(
    rod=st.integers(130, 200), rpm=st.integers(3000, 6000), mass=st.floats(0.45, 0.75), cap=st.sampled_from([2, 4, 12]),
    response=st.sampled_from(["secondary_force", "force", "secondary_couple"]),
)  # fmt: skip
def test_no_other_weights_near_those_for_all_scenarios_are_better_in_the_worst(
    rod: int, rpm: int, mass: float, cap: int, response: str
) -> None:
    """The goal is convex in the weights, so that what no step betters is the best; each is measured as it stands."""
    shafts = "".join(
        table(f"balance_shafts.{name}", order=2, turns=f"{name} rotation", at="120 mm")
        + f'unbalance = {{ from = "0 g mm", to = "{cap} kg mm" }}\n'
        for name in ("with", "against")
    )
    job = engine(
        ["0 deg", "180 deg", "180 deg", "0 deg"], shafts, f'minimise = "{response}"', rod=f'"engine.rod" = "{rod} mm"',
        fast=f'"engine.speed" = "{rpm} rpm"', uneven=f'"cylinders.2.reciprocating" = "{mass:.6g} kg"',
    )  # fmt: skip
    found = one_for_all(job)
    assert found.status in ("optimal", "feasible")
    assert found.goal is not None
    paths = [f"balance_shafts.{name}" for name in ("with", "against")]
    chosen = found.variables
    best = np.array([
        chosen[f"{path}.unbalance"].value * np.exp(1j * chosen[f"{path}.angle"].value) for path in paths
    ])  # fmt: skip

    def worst(weights: np.ndarray) -> float:
        said = {
            f"{path}.{key}": text
            for path, u in zip(paths, weights, strict=True)
            for key, text in (("unbalance", f"{abs(u):.17g} kg m"), ("angle", f"{np.angle(u):.17g} rad"))
        }
        order, kind = ("all_orders", "force") if response == "force" else ("orders.2", response.split("_")[1])
        return max(
            vo.solve(vo.with_changes(one, said)).find(f"{order}.{kind}").value for one in variants_of(job).values()
        )

    assert worst(best) == pytest.approx(found.goal[1].value, rel=1e-6)
    for step in (1e-2, 1e-3):
        for k in range(2):
            for way in (1.0, -1.0, 1j, -1j):
                moved = best + step * 4e-3 * way * np.eye(2)[k]
                if (np.abs(moved) <= cap * 1e-3).all():
                    assert worst(moved) >= found.goal[1].value * (1.0 - 1e-6)


@pytest.mark.parametrize("mass", ["0.3 kg", "0.62 kg", "1.5 kg"])
def test_cranks_for_all_scenarios_are_the_best_of_all_when_each_is_tried(mass: str) -> None:
    offered = [0, 90, 180, 270]
    job = engine(
        ["choose"] * 4, f"counterweight_share = 0.5\ncranks = {[f'{one} deg' for one in offered]}\n".replace("'", '"'),
        'minimise = "primary_couple"\nthen = ["secondary_couple"]', other=f'"cylinders.2.reciprocating" = "{mass}"',
        slow='"engine.speed" = "4000 rpm"\n"cylinders.4.rotating" = "0.9 kg"',
    )  # fmt: skip
    found = one_for_all(job)
    tried = []
    for cranks in ((0, *rest) for rest in permutations(offered[1:])):  # turned as a whole it is the same
        said = {f"cylinders.{k + 1}.crank": f"{crank} deg" for k, crank in enumerate(cranks)}
        answers = [vo.solve(vo.with_changes(one, said)) for one in variants_of(job).values()]
        both = [max(one.find(f"orders.{order}.couple").value for one in answers) for order in (1, 2)]
        tried.append((round(both[0], 6), both[1]))
    assert found.goal is not None
    assert found.goal[1].value == pytest.approx(min(tried)[0], rel=1e-8)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ('"engine.counterweight_share.to" = 0.5', "engine.toml: scenario other changes what may be chosen, how the "
         "cranks stand, or what is made best, so there is no one design for all. vibopt compare FILE --scenarios "
         "answers each by itself."),
        ('"engine.counterweight_share" = 0.5', "engine.toml: one design for all scenarios needs something to choose "
         "and a goal, and scenario other has not both. vibopt compare FILE --scenarios answers each by itself."),
    ],
)  # fmt: skip
def test_scenarios_of_an_engine_that_have_no_one_design_are_refused(changes: str, words: str) -> None:
    job = engine(["0 deg"], "counterweight_share = { from = 0, to = 1 }\n", 'minimise = "primary_force"', other=changes)
    assert str(refused(one_for_all, job)) == words
