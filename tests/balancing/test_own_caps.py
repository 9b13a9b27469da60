"""Caps that bind have a price in every kind of balancing job, the same as solving a file with the wider cap."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ranged import ranged

from refusals import refused
from rotor_jobs import FAN, solve_text
from test_engine import engine, job_of, number_at, solved
from test_rotor_plan import SECOND, fan
from vibopt.answer.answer import Answer
from vibopt.balancing.engine.shaking import arms
from vibopt.balancing.known import read_known, solve_known
from vibopt.document.mistakes import Mistakes
from vibopt.jobs import answer, from_text, open_job
from vibopt.study.prices import priced, prices
from vibopt.study.seen import chosen, results

MIL = 2.54e-5 / 2.0
PROBLEMS = Path(__file__).parents[2] / "problems"


def numbers(text: str, unit: str) -> list[float]:
    return [float(one) for one in re.findall(rf"([\d.]+) {unit}(?![a-z])", text)]


@pytest.mark.parametrize("combine", ["rms", "worst"])
@pytest.mark.parametrize("more", ["", "holes = 24\nsplit = true\n"], ids=["free", "split"])
def test_a_cap_of_a_measured_rotor_has_the_price_of_the_file_with_the_wider_cap(combine: str, more: str) -> None:
    goal = f'[goal]\nminimise = "residual"\ncombine = "{combine}"\n'

    def text(cap: float) -> str:
        return fan(f'weight = {{ from = "0 g", to = "{cap} g" }}\n{more}') + goal

    plan, wider = priced(solve_text(text(6.0))), solve_text(text(6.6))
    words = plan.prices["planes.left.weight"].words
    assert words.startswith("6 g -> 6.6 g: ")
    assert plan.goal is not None
    assert wider.goal is not None
    expected = [float(one.goal[1].value) / MIL for one in (plan, wider) if one.goal is not None]
    assert numbers(words, "mil pp") == pytest.approx(expected, rel=2e-3)
    assert plan.to_json()["prices"]["planes.left.weight"]["words"] == words
    assert priced(solve_text(text(600.0))).prices == {}


def test_the_price_of_a_cap_writes_no_influence_coefficient(monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []
    monkeypatch.setattr("vibopt.balancing.begin.coefficients", lambda job, identified: written.append(job.name) or {})
    plan = priced(solve_text(fan('weight = { from = "0 g", to = "6 g" }\n')))
    assert plan.prices.keys() == {"planes.left.weight"}
    assert not written
    assert "influence.a.left.value" not in plan.values
    assert written


def test_a_plan_as_text_counts_coefficients_that_it_does_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = answer(open_job(PROBLEMS / "balancing/foiles_min_max.toml"))
    with monkeypatch.context() as without:
        without.delattr("vibopt.balancing.begin.coefficients")
        text = plan.report()
    many = sum(path.startswith("influence.") and path.endswith(".value") for path in plan.values)
    assert f"{many} values; vibopt solve --json prints them under influence." in " ".join(text.split())
    assert len(plan.values) == len(dict(plan.values))


def test_a_point_of_a_sweep_writes_no_influence_coefficient(monkeypatch: pytest.MonkeyPatch) -> None:
    job = open_job(PROBLEMS / "balancing/bk_17_227.toml")
    plan = answer(job)
    every = plan.entries()
    again = answer(job)
    monkeypatch.delattr("vibopt.balancing.begin.coefficients")
    assert chosen(job, again) == chosen(job, plan, every)
    assert results(job, again) == results(job, plan, every) != {}


def test_a_deepest_hole_has_a_price_as_well() -> None:
    drill = 'remove = true\ndrill = {{ diameter = "10 mm", density = "7850 kg/m³", deepest = "{} mm" }}\n'
    words = priced(solve_text(fan(drill.format(8)))).prices["planes.left.drill"].words
    wider = solve_text(fan(drill.format(8.8)))
    assert words.startswith("8 mm -> 8.8 mm: ")
    assert wider.goal is not None
    assert numbers(words, "mil pp")[1] == pytest.approx(float(wider.goal[1].value) / MIL, rel=2e-3)


def test_a_cap_on_shelf_weights_has_the_price_of_the_longer_list() -> None:
    def text(cap: float) -> str:
        more = f'holes = 12\nshelf = ["5 g", "6 g", "9 g"]\nweight = {{ from = "0 g", to = "{cap} g" }}\n'
        return fan(more, more)

    assert priced(solve_text(text(5.4))).prices == {}
    plan, wider = priced(solve_text(text(5.5))), solve_text(text(5.5).replace('"5.5 g"', '"6.05 g"', 1))
    assert wider.goal is not None
    words = plan.prices["planes.left.weight"].words
    assert numbers(words, "mil pp")[1] == pytest.approx(float(wider.goal[1].value) / MIL, rel=2e-3)


def shaft(cap: float, **plane: Any) -> Answer[Any]:
    document = {
        "shaft": {"bearings": {"A": "0 mm", "B": "900 mm"}, "speed": "1500 rpm"},
        "masses": {"one": {"unbalance": "50 kg mm", "angle": "30 deg", "at": "300 mm"}},
        "planes": {
            "L": {"radius": "100 mm", "at": "100 mm", "weight": {"from": "0 g", "to": f"{cap} g"}, **plane},
            "R": {"radius": "100 mm", "at": "800 mm"},
        },
        "goal": {"minimise": "reaction", "combine": "worst"},
    }
    return solve_known(read_known(document, Mistakes("shaft.toml")))


def test_a_cap_with_known_masses_has_the_price_of_the_file_with_the_wider_cap() -> None:
    answer, wider = ranged(shaft(200.0)), shaft(220.0)
    words = answer.prices["planes.L.weight"].words
    assert answer.goal is not None
    assert wider.goal is not None
    assert words.startswith("200 g -> 220 g: ")
    expected = [float(answer.goal[1].value), float(wider.goal[1].value)]
    assert numbers(words, "N")[:2] == pytest.approx(expected, rel=2e-3)
    assert "; nothing more to gain beyond " in words
    assert priced(shaft(5000.0)).prices == {}


@pytest.mark.parametrize("cap", [1.0, 2.0])
def test_a_cap_of_an_engine_has_the_price_of_the_file_with_the_wider_cap(cap: float) -> None:
    def document(most: float) -> dict[str, Any]:
        found = engine(["0 deg", "180 deg", "180 deg", "0 deg"])
        shaft = {"order": 2, "at": "135 mm", "unbalance": {"from": "0 g mm", "to": f"{most} kg mm"}}
        found["balance_shafts"] = {
            "left": {**shaft, "turns": "with rotation"},
            "right": {**shaft, "turns": "against rotation", "unbalance": {"from": "0 g mm", "to": "9 kg mm"}},
        }
        found["goal"] = {"minimise": "secondary_force"}
        return found

    answer, wider = ranged(solved(document(cap))), solved(document(1.1 * cap))
    words = answer.prices["balance_shafts.left.unbalance"].words
    now, then = (1e3 * one for one in numbers(words, "kN")[:2])
    assert now == pytest.approx(number_at(answer, "goal"), rel=2e-3)
    assert then == pytest.approx(number_at(wider, "goal"), rel=2e-3)
    assert "; nothing more to gain beyond " in words


def test_a_share_at_its_end_has_a_price() -> None:
    document = engine(["0 deg"], counterweight_share={"from": "0 %", "to": "40 %"})
    document["goal"] = {"minimise": "primary_force"}
    words = ranged(solved(document)).prices["engine.counterweight_share"].words
    assert words.startswith("40 % -> 44 %: primary force ")
    assert words.endswith("; nothing more to gain beyond 50 %")


@pytest.mark.parametrize(("reciprocating", "rotating"), [(None, 0.4), (0.3, None), (0.3, 0.7), (0.0, 0.0)])
def test_shares_of_rotating_and_of_reciprocating_mass_are_independent(
    reciprocating: float | None, rotating: float | None
) -> None:
    """By hand: m r omega² of what each crank carries; all of the rotating mass and none of the other by default."""
    shares = {"counterweight_share": reciprocating, "rotating_share": rotating}
    given = {key: f"{value}" for key, value in shares.items() if value is not None}
    job = job_of(engine(["0 deg"], rotating="0.3 kg", **given))
    bare = job_of(engine(["0 deg"], rotating="0.3 kg"))
    carried = 0.5 * (reciprocating or 0.0) + 0.3 * (1.0 if rotating is None else rotating)
    change = arms(bare, (0.0,)).constant[0, 0, 1] - arms(job, (0.0,)).constant[0, 0, 1]
    radius = bare.cylinders[0].rotating / 0.3
    assert change == pytest.approx(carried * radius * bare.speed**2)
    answer = solved(engine(["0 deg"], rotating="0.3 kg", **given))
    assert answer.status == "met"
    assert number_at(answer, "rotating_share") == (1.0 if rotating is None else rotating)
    assert number_at(answer, "counterweight_share") == (reciprocating or 0.0)


def test_of_two_free_shares_the_rotating_mass_is_carried_first() -> None:
    free = {"from": "0 %", "to": "100 %"}
    document = engine(["0 deg"], rotating="0.3 kg", counterweight_share=free, rotating_share=free)
    document["goal"] = {"minimise": "primary_force"}
    answer = solved(document)
    assert answer.status == "optimal"
    assert number_at(answer, "rotating_share") == pytest.approx(1.0)
    assert number_at(answer, "counterweight_share") == pytest.approx(0.5, abs=1e-6)


def test_a_rotating_share_of_nothing_is_refused() -> None:

    error = refused(job_of, engine(["0 deg"], rotating_share={"from": 0, "to": 1}))
    assert (
        "rotating_share is chosen, but no mass rotates. Add rotating to [engine], or leave rotating_share out."
        in str(error)
    )


def test_equal_choices_are_taken_in_the_order_of_planes_and_holes() -> None:
    """Two planes of one effect: what is fitted in which is a matter of the rule, whatever the last digits say."""
    from vibopt.balancing.discrete import solve_discrete
    from vibopt.balancing.question import Options, Question

    dice = np.random.default_rng(2)
    H = np.repeat(dice.normal(size=(3, 1)) + 1j * dice.normal(size=(3, 1)), 2, axis=1)
    listed = np.concatenate([[0.0], np.outer([0.2, 0.5], np.exp(2j * np.pi * np.arange(8) / 8)).ravel()])
    options = Options(listed, np.abs(listed))
    chosen = set()
    for _ in range(6):
        noise = 1.0 + 1e-13 * dice.normal(size=H.shape)
        question = Question(
            y0=-H[:, 0] * (0.2 + 0.5j), H=H * noise, importance=np.ones(3), limits=np.full(3, np.inf),
            caps=np.full(2, np.inf), options=(options, options),
        )  # fmt: skip
        chosen.add(solve_discrete(question).chosen)
    assert len(chosen) == 1
    first, second = chosen.pop()
    assert first <= second


NEARLY = FAN.replace(
    'weights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }',
    'weights = { right = "10 g @ 270 deg" }\nreadings = { a = "5.5 mil @ 112 deg", b = "4.8 mil @ 234 deg" }',
)


def test_nearly_alike_planes_are_compared_with_fewer_and_what_the_last_buys_is_said() -> None:
    plan = solve_text(NEARLY)
    assert 10.0 < plan.plan.condition < 30.0
    assert plan.status == "optimal"
    assert [one.name for one in plan.plan.remedies] == ["as asked", "left left out", "right left out"]
    said = next(one for one in plan.notes if "act nearly alike" in one)
    assert said.startswith("Planes left and right act nearly alike: condition number ")
    buys = next(one for one in plan.notes if one.startswith("What plane "))
    fewer = min(
        (
            solve_text(NEARLY.replace(f"[planes.{one}]\n", f"[planes.{one}]\nkeep = true\n"))
            for one in ("left", "right")
        ),
        key=lambda other: max(float(row.residual.value) for row in other.plan.rows),
    )
    worst = max(float(row.residual.value) for row in fewer.plan.rows) / MIL
    assert numbers(buys, "mil pp")[1] == pytest.approx(worst, rel=1e-3)


def test_a_grade_is_judged_without_phase_as_with_it() -> None:
    """The same rotor read with and without angles leaves the same unbalance."""
    quality = '[quality]\ngrade = "6.3 mm/s"\nmass = "80 kg"\nspeed = "1200 rpm"\ncentre_of_mass = "100 mm"\n'
    quality += 'bearings = { A = "0 mm", B = "200 mm" }\nplanes = { p = "100 mm" }\n'
    y0, H = 30.0 * np.exp(0.7j), 2.0 * np.exp(1.9j)
    head = '[conventions]\nangles = "with rotation"\ndetector = "pk"\nzero = "mark"\n{}'
    head += '[planes.p]\nradius = "100 mm"\nholes = 8\nshelf = ["5 g"]\n'
    plans = []
    for phase in (True, False):
        text = 'title = "t"\nspeed = "1200 rpm"\n' + head.format(
            'phase = "lead"\nreadings = "phase"\n' if phase else ""
        )
        for w in (0.0, 5.0, 5.0 * np.exp(2j), 5.0 * np.exp(4j)):
            z = y0 + H * w
            angle = f" @ {np.degrees(np.angle(z)) % 360.0} deg" if phase else ""
            fitted = f'p = "{abs(w)} g @ {np.degrees(np.angle(w)) % 360.0} deg"' if w else ""
            text += f'[[runs]]\nweights = {{ {fitted} }}\nreadings = {{ a = "{abs(z)} µm{angle}" }}\n'
        plans.append(solve_text(text + quality))
    values = [plan.values["quality.earned"].value for plan in plans]
    assert values[1] == pytest.approx(values[0], rel=1e-4)
    assert plans[0].values["quality.permissible"] == plans[1].values["quality.permissible"]


def test_the_range_of_a_cap_ends_where_the_goal_bends() -> None:
    """By hand, in g m: 10 at 0, 10 at 60, 15 at 120 and 15 at 180 degrees; the fifth hole takes 18 of them."""
    job = open_job(PROBLEMS / "balancing" / "rao_9_4_capped.toml")
    found = prices(job, only=["planes.fifth.weight.to", "masses.hole_3.radius"])
    left = 10.0 + 10.0 * np.exp(1j * np.pi / 3) + 15.0 * np.exp(2j * np.pi / 3) - 15.0
    end = found.find("planes.fifth.weight.to").ways[1].until
    assert end is not None
    assert end.value == pytest.approx(1e-3 * abs(left) / 0.12, rel=5e-5)
    end = found.find("masses.hole_3.radius").ways[0].until
    assert end is not None
    assert end.value == pytest.approx(1e-2 / 1.5 * 0.5 * (np.sqrt(15.0**2 + 4.0 * 249.0) - 15.0), rel=1e-4)


def test_the_end_of_a_range_of_a_drilled_hole_is_where_it_is_as_deep() -> None:
    """Without the greatest depth the hole of the best plan says how deep it wants to be."""
    drill = 'remove = true\ndrill = {{ diameter = "10 mm", density = "7850 kg/m³"{} }}\n'
    free = solve_text(fan(drill.format("")))
    found = prices(from_text(fan(drill.format(', deepest = "8 mm"'))), only=["planes.left.drill.deepest"])
    end = found.rows[0].ways[1]
    assert end.until is not None
    assert end.until.value == pytest.approx(free.plan.planes[0].weights[0].depth, rel=1e-4)
    assert end.then == "planes.left.drill at its highest lets go"


@pytest.mark.parametrize("combine", ["rms", "worst", "sum", 'huber"\nhuber_at = "1 mil'])
def test_the_rate_of_a_limit_is_what_solving_again_shows(combine: str) -> None:
    def plan(both: float, total: float) -> Answer[Any]:
        limits = f'[limits.both]\nresponse = "residual"\nat = "a"\nat_most = "{both} mil"\n'
        limits += f'[limits.t]\nresponse = "correction"\ntotal = true\nat_most = "{total} g"\n'
        return solve_text(FAN + SECOND + limits + f'[goal]\nminimise = "residual"\ncombine = "{combine}"\n')

    here, step = plan(2.6, 8.0), 1e-4
    assert here.rates is not None
    for name, one, size in (("both", plan(2.6 * (1 + step), 8.0), 2.6 * MIL), ("t", plan(2.6, 8.0 * (1 + step)), 8e-3)):
        assert here.goal is not None
        assert one.goal is not None
        gained = float(here.goal[1].value) - float(one.goal[1].value)
        assert here.rates[name] * size * step == pytest.approx(gained, rel=2e-2, abs=1e-7 * MIL)
    assert here.rates["t"] > 0.0


def test_a_lower_end_that_the_file_refuses_is_told_as_less() -> None:
    """A rod no longer than the crank."""
    text = (
        (PROBLEMS / "balancing" / "engine_share_capped.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
    )
    text = text.replace('at_most = "600 N"', 'at_most = "1 MN"').replace("orders = 12", 'kinematics = "truncated"')
    job = from_text(text, "engine.toml")
    down, _ = prices(job, only=["engine.rod"]).rows[0].ways
    assert (down.then, down.beyond) == ("the file cannot have less", "the file cannot have less")
    assert down.ends is not None
    assert down.ends.value == pytest.approx(40e-3, rel=5e-4)
