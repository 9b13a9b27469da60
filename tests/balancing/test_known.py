"""Known masses on a shaft: what is recorded, what physics says, and what the messages say."""

from __future__ import annotations

import copy
import tomllib
from dataclasses import replace
from math import isclose, pi, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from vibopt.answer.answer import Answer
from vibopt.balancing.known import read_known, solve_known
from vibopt.balancing.known.correct import correct
from vibopt.balancing.known.known_job import KnownJob
from vibopt.balancing.known.shaft_statics import equilibrium, turned_by_hand, unbalances
from vibopt.balancing.plan_views import goal_words
from vibopt.document.locate import Locator
from vibopt.document.mistakes import Mistakes
from vibopt.errors import NotProven, UnknownName
from vibopt.study.prices import priced

PROBLEMS = Path(__file__).parents[2] / "problems" / "balancing"
FILES = sorted(path for path in PROBLEMS.glob("*.toml") if "[masses." in path.read_text(encoding="utf-8"))

SHAFT: dict[str, Any] = {
    "shaft": {"bearings": {"A": "0 mm", "B": "900 mm"}, "speed": "3000 rpm"},
    "masses": {
        "one": {"mass": "120 g", "radius": "100 mm", "angle": "20 deg", "at": "150 mm"},
        "two": {"unbalance": "9 kg mm", "angle": "200 deg", "at": "450 mm"},
    },
    "planes": {
        "P": {"at": "50 mm", "radius": "100 mm"},
        "Q": {"at": "850 mm", "radius": "100 mm"},
    },
}


def solved(document: dict[str, Any]) -> Answer[KnownJob]:
    """The answer to a document."""
    return solve_known(read_known(document, Mistakes("shaft.toml")))


def changed(**tables: dict[str, Any]) -> dict[str, Any]:
    """The shaft with some keys of some tables replaced; a path is written planes__P."""
    document = copy.deepcopy(SHAFT)
    for path, keys in tables.items():
        here = document
        for step in path.split("__"):
            here = here.setdefault(step, {})
        here.update(keys)
    return document


def number_at(answer: Answer[KnownJob], path: str) -> float:
    """A number of the answer."""
    value = answer.find(path).value
    assert isinstance(value, float)
    return value


@settings(max_examples=60, deadline=None)
@given(
    sizes=st.lists(
        st.tuples(st.floats(1.0, 500.0), st.floats(0.0, 360.0), st.floats(0.0, 900.0)), min_size=1, max_size=5
    ),
    places=st.tuples(st.floats(-200.0, 300.0), st.floats(500.0, 1100.0)),
)
def test_two_planes_stop_every_force_and_couple(
    sizes: list[tuple[float, float, float]], places: tuple[float, float]
) -> None:
    document = changed(planes__P={"at": f"{places[0]:.6f} mm"}, planes__Q={"at": f"{places[1]:.6f} mm"})
    document["masses"] = {
        f"m{k}": {"unbalance": f"{size:.6f} g mm", "angle": f"{angle:.6f} deg", "at": f"{at:.6f} mm"}
        for k, (size, angle, at) in enumerate(sizes)
    }
    job = read_known(document, Mistakes("shaft.toml"))
    found = correct(job)
    scale = abs(unbalances(job)).sum() * float(job.speed or 0.0) ** 2
    force, couple = turned_by_hand(job, found.u)
    assert found.status == "optimal"
    assert force < 1e-11 * scale
    assert couple < 1e-11 * scale
    assert equilibrium(job, 0.0 * found.u) < 1e-12


@settings(max_examples=30, deadline=None)
@given(turn=st.floats(1.0, 359.0))
def test_turning_the_zero_turns_the_weights(turn: float) -> None:
    document = changed()
    for mass in document["masses"].values():
        mass["angle"] = f"{float(mass['angle'].split()[0]) + turn} deg"
    here, there = solved(changed()), solved(document)
    for plane in ("P", "Q"):
        gap = number_at(there, f"planes.{plane}.angle") - number_at(here, f"planes.{plane}.angle") - radians(turn)
        assert abs((gap + pi) % (2.0 * pi) - pi) < 1e-9
        assert isclose(number_at(there, f"planes.{plane}.mass"), number_at(here, f"planes.{plane}.mass"), rel_tol=1e-9)


def test_removed_material_goes_where_a_weight_would_not() -> None:
    added, taken = solved(changed()), solved(changed(planes__P={"remove": True}))
    turn = number_at(taken, "planes.P.angle") - number_at(added, "planes.P.angle")
    assert abs(abs(turn) - pi) < 1e-12
    assert number_at(taken, "planes.P.mass") == pytest.approx(number_at(added, "planes.P.mass"))
    assert taken.find("planes.P.action").value == "remove material here"


def test_depth_of_a_drilled_hole_holds_its_mass() -> None:
    drill = {"diameter": "12 mm", "density": "7850 kg/m³"}
    answer = solved(changed(planes__P={"remove": True, "drill": drill}))
    volume = number_at(answer, "planes.P.depth") * pi * 0.006**2
    assert volume * 7850.0 == pytest.approx(number_at(answer, "planes.P.mass"))


def test_capped_plane_is_filled_and_nothing_else_within_the_caps_is_better() -> None:
    goal = {"minimise": "reaction", "combine": "worst"}
    document = changed(planes__P={"weight": {"from": "0 g", "to": "20 g"}}, goal=goal)
    job = read_known(document, Mistakes("shaft.toml"))
    found = correct(job)
    answer = solve_known(job)
    best = max(number_at(answer, f"residual.bearings.{name}.reaction") for name in "AB")
    assert answer.status == "optimal"
    assert number_at(answer, "planes.P.mass") == pytest.approx(0.02, rel=1e-6)
    assert any("out of reach" in note for note in answer.notes)
    from vibopt.balancing.known.shaft_statics import reactions

    generator = np.random.default_rng(7)
    for _ in range(2000):
        other = found.u + 3e-4 * (generator.normal(size=2) + 1j * generator.normal(size=2))
        other[0] *= min(1.0, 0.002 / abs(other[0]))
        assert max(abs(one) for one in reactions(job, other).values()) > best * (1.0 - 1e-6)


def test_of_three_planes_the_lightest_balance_is_chosen() -> None:
    document = changed(planes__R={"at": "400 mm", "radius": "100 mm"}, goal={"minimise": "correction"})
    job = read_known(document, Mistakes("shaft.toml"))
    found = correct(job)
    assert found.way == "least mass"
    null = np.array([(0.85 - 0.4), (0.4 - 0.05), -(0.85 - 0.05)])
    generator = np.random.default_rng(3)
    for _ in range(500):
        other = found.u + null * complex(*generator.normal(scale=1e-3, size=2))
        assert turned_by_hand(job, other)[0] < 1e-6
        assert np.abs(other).sum() >= np.abs(found.u).sum() * (1.0 - 1e-9)


def test_limit_on_a_reaction_is_held_with_the_least_mass_and_has_a_price() -> None:
    limits = {"front": {"response": "bearing_reaction", "of": "A", "at_most": "200 N"}}
    answer = solved({**changed(goal={"minimise": "correction"}), "limits": limits})
    assert answer.status == "optimal"
    held = answer.limits["front"]
    assert held.met
    assert held.margin == pytest.approx(0.0, abs=1e-6)
    looser = {"front": {**limits["front"], "at_most": "201 N"}}
    less = solved({**changed(goal={"minimise": "correction"}), "limits": looser})
    assert answer.rates["front"] == pytest.approx(number_at(answer, "goal") - number_at(less, "goal"), rel=0.02)


def test_forbidden_sector_keeps_the_weight_out() -> None:
    free = number_at(solved(changed()), "planes.P.angle") * 180.0 / pi
    sector = f"{free - 20:.6f}..{free + 30:.6f} deg"
    answer = solved(changed(planes__P={"forbidden": [sector]}))
    turned = (number_at(answer, "planes.P.angle") * 180.0 / pi - free + 180.0) % 360.0 - 180.0
    assert answer.status == "optimal"
    assert not -19.999 < turned < 29.999


def test_plane_that_is_kept_stays_empty_and_limits_that_cannot_hold_are_infeasible() -> None:
    kept = solved(changed(planes__Q={"keep": True}))
    assert number_at(kept, "planes.Q.mass") == 0.0
    limits = {"all": {"response": "bearing_reaction", "at_most": "1 N"}}
    none = solved({**changed(planes__Q={"keep": True}), "limits": limits})
    assert none.status == "infeasible"
    assert none.exit_code == 3


def test_of_limits_that_cannot_hold_with_the_least_mass_those_are_named_that_clash() -> None:
    """A cap on all weights stands beside them: alone it asks for no complete balance."""
    force = {"response": "bearing_reaction", "of": "A", "at_most": "1 N"}
    total = {"response": "correction", "total": True, "at_most": "500 g"}
    some = changed(planes__Q={"keep": True}, planes__P={"weight": {"to": "1 g"}}, goal={"minimise": "correction"})
    found = solved({**some, "limits": {"total": total, "force": force}})
    assert found.status == "infeasible"
    assert found.conflict is not None
    assert (found.conflict.limits, found.conflict.others) == (("force",), ())
    ((_, _, enough),) = found.conflict.loosenings
    for factor, status in ((0.999, "infeasible"), (1.0, "optimal")):
        again = {"force": {**force, "at_most": f"{enough.value * factor:.17g} N"}, "total": total}
        assert solved({**some, "limits": again}).status == status


def test_least_mass_without_a_complete_balance_asks_for_a_limit() -> None:
    way = 'Write [limits.NAME] with response = "static_unbalance" and at_most, or minimise = "unbalance".'
    goal = {"minimise": "correction"}
    one = solved(changed(planes__Q={"keep": True}, goal=goal))
    assert (one.status, one.claim) == (
        "infeasible", f"no weights in these planes balance the shaft completely. {way}"
    )  # fmt: skip
    capped = solved(changed(planes__Q={"weight": {"to": "1 g"}}, goal=goal))
    assert (capped.status, capped.claim) == (
        "infeasible", f"the only weights that balance the shaft completely break a cap or a forbidden sector. {way}"
    )  # fmt: skip


@pytest.mark.parametrize("part", [0.2, 0.999, 1.001, 5.0])
def test_a_total_below_the_lightest_balance_is_proven_to_leave_none(part: float) -> None:
    """Of three planes the balance has one number to choose, of which the masses of all are looked at here."""
    document = changed(planes__R={"at": "400 mm", "radius": "100 mm"}, goal={"minimise": "correction"})
    turn = np.exp(1j * np.radians([20.0, 200.0])) * [0.012, 0.009]
    total, moment = turn.sum(), turn @ [0.15, 0.45]

    def mass(third: Any) -> Any:
        right = -(moment + 0.4 * third - 0.05 * (total + third)) / 0.8
        return (np.abs(third) + np.abs(right) + np.abs(total + third + right)) / 0.1

    at = np.linspace(-0.03, 0.03, 1201)
    least = float(mass(at[:, None] + 1j * at).min())
    limit = {"response": "correction", "total": True, "at_most": f"{part * least!r} kg"}
    answer = solved({**document, "limits": {"all": limit}})
    assert answer.status == ("optimal" if part > 1.0 else "infeasible")
    assert part > 1.0 or answer.claim.startswith("no weights within caps, total, holes and sectors balance")


def test_two_planes_at_one_place_do_what_they_can() -> None:
    answer = solved(changed(planes__Q={"at": "50 mm"}))
    assert answer.status == "optimal"
    assert number_at(answer, "residual.couple") > 0.0


def test_shaft_alone_is_met_or_violated() -> None:
    document = changed(limits={"all": {"response": "bearing_reaction", "at_most": "100 N"}})
    del document["planes"]
    broken = solved(document)
    assert (broken.status, broken.exit_code) == ("violated", 7)
    document["limits"]["all"]["at_most"] = "2 kN"
    assert solved(document).status == "met"


def test_holes_name_their_weights() -> None:
    rim = {"holes": 12, "shelf": ["10 g", "50 g"], "most_weights": 2}
    answer = solved(changed(planes__P=rim, planes__Q=rim))
    words = answer.find("planes.P.weights").value
    assert isinstance(words, str)
    assert "in hole" in words
    assert sum(float(one.split(" g")[0]) for one in words.split(", ")) * 1e-3 == pytest.approx(
        number_at(answer, "planes.P.mass")
    )


def test_answer_as_json_is_nested_by_path_and_unknown_paths_are_refused() -> None:
    answer = solved(changed())
    data = answer.to_json()
    assert data["planes"]["P"]["mass"]["unit"] == "kg"
    assert data["residual"]["static"]["value"] == 0.0
    with pytest.raises(UnknownName, match=r'unknown path "planes.P.mas". Did you mean "planes.P.mass"\?'):
        answer.find("planes.P.mas")
    with pytest.raises(NotProven):
        replace(answer, status="unproven").require_proof()


TEXT = """
[shaft]
bearings = { A = "0 mm", B = "900 mm" }
speed = "3000 rpm"

[masses.one]
mass = "120 g"
radius = "100 mm"
angle = "20 deg"
at = "150 mm"

[planes.P]
at = "50 mm"
radius = "100 mm"
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'radius = "100 mm"\nangle',
            "angle",
            'shaft.toml line 6: masses.one has no radius. Add it, or write unbalance = "50 kg mm" instead of both.',
        ),
        ('at = "150 mm"', "", 'shaft.toml line 6: masses.one has no axial place. Add it, for example at = "300 mm".'),
        ('mass = "120 g"', 'mass = "120"', 'shaft.toml line 7: masses.one.mass = "120" has no unit. Write "120 kg".'),
        (
            "B = ",
            'C = "1 m", B = ',
            "shaft.toml line 3: shaft.bearings names 3 bearings, but two carry a shaft. Write bearings = { A "
            '= "0 mm", B = "900 mm" }.',
        ),
        (
            '"900 mm"',
            '"0 mm"',
            "shaft.toml line 3: shaft.bearings has both bearings at the same place. Write "
            'bearings = { A = "0 mm", B = "900 mm" }.',
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\nholes = 24\nshelf = ["5 g", "ground"]',
            'shaft.toml line 15: planes.P.shelf[2] = "ground" does not start with one number. Write a mass, for '
            'example "300 kg".',
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\nholes = 24\nshelf = ["0 g"]',
            'shaft.toml line 15: planes.P.shelf[1] = "0 g" is not greater than zero. Write a positive value, for '
            'example "300 kg".',
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\nholes = 24',
            'shaft.toml line 14: planes.P has holes without weights. Add shelf = ["5 g", "10 g"] with the weights '
            "there are, or split = true for a weight cut to measure in the two neighbouring holes.",
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\nshelf = ["5 g"]',
            "shaft.toml line 14: planes.P has weights on the shelf, but no holes to put them. Add holes = 24, or a "
            "list of angles.",
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\nholes = 0',
            "shaft.toml line 14: planes.P.holes = 0 is no number of holes from 2 to 720. Write holes = 24, or a list "
            "of angles.",
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\nweight = "5 g"',
            'shaft.toml line 14: planes.P.weight = "5 g" is no range. The correction is to be chosen: write '
            '{ from = "0 g", to = "60 g" }; or write the weight that is fitted with its angle, "10 g @ 270 deg".',
        ),
        (
            'at = "50 mm"\nradius = "100 mm"',
            'at = "50 mm"\nweight = { from = "0 g", to = "60 g" }',
            "shaft.toml line 12: planes.P has weights or a drill but no radius: what a mass does there is not known. "
            'Write radius = "150 mm", or cap its unbalance.',
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\nforbidden = ["80 deg"]',
            'shaft.toml line 14: planes.P.forbidden[1] = "80 deg" is no sector. Write "80..110 deg".',
        ),
        (
            'at = "50 mm"',
            'at = "50 mm"\ndrill = { diameter = "5 mm", density = "7850 kg/m³" }',
            "shaft.toml line 14: planes.P has a drill, but adds weights. Write remove = true, or leave the drill out.",
        ),
        (
            "[planes.P]",
            '[bearings.left]\nat = "0 mm"\n[planes.P]',
            'shaft.toml line 12: unknown key "bearings" at the top level. Bearings stand in [shaft], of a measured '
            'rotor in [quality]: bearings = { A = "0 mm", B = "900 mm" }.',
        ),
        ("[planes.P]", "[plane.P]", 'shaft.toml line 12: unknown key "plane" at the top level. Did you mean "planes"?'),
        (
            "[planes.P]",
            '[limits.a]\nresponse = "bearing_reaction"\nof = "C"\nat_most = "5 N"\n[planes.P]',
            'shaft.toml line 14: limits.a.of = "C" names no bearing of this scene. Known: A, B.',
        ),
        (
            "[planes.P]",
            '[limits.a]\nresponse = "correction"\nat_most = "5 g"\n[planes.P]',
            'shaft.toml line 12: limits.a needs of = "PLANE" or total = true, one of the two.',
        ),
        (
            "[planes.P]",
            '[limits.a]\nresponse = "static_unbalance"\n[planes.P]',
            "shaft.toml line 12: limits.a has no bound. Write at_most, or move it to [measures.a].",
        ),
        (
            'speed = "3000 rpm"',
            '[limits.a]\nresponse = "bearing_reaction"\nat_most = "5 N"',
            'shaft.toml line 4: limits.a needs [shaft] with bearings = { A = "0 mm", B = "900 mm" } and '
            'speed = "1500 rpm".',
        ),
    ],
)
def test_mistake_is_said_with_its_place_and_the_way_out(old: str, new: str, message: str) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    assert message in refused(read_known, tomllib.loads(text), Mistakes("shaft.toml", Locator(text))).messages


HOLES = {"holes": 6, "shelf": ["50 g", "80 g"], "radius": "100 mm"}


def every_choice() -> dict[tuple[float, float], float]:
    """(unbalances at A and B as a pair of sizes, the static one) of each filling, by forces added up one by one."""
    fills = [0j] + [m * 0.1 * np.exp(1j * pi / 3.0 * h) for m in (0.05, 0.08) for h in range(6)]
    known = [(0.012 * np.exp(1j * radians(20.0)), 0.15), (0.009 * np.exp(1j * radians(200.0)), 0.45)]
    found = {}
    for p in fills:
        for q in fills:
            points = [*known, (p, 0.05), (q, 0.85)]
            at_b = sum(u * z for u, z in points) / 0.9
            whole = sum(u for u, _ in points)
            found[(abs(whole - at_b), abs(at_b))] = abs(whole)
    return found


@pytest.mark.parametrize(
    ("goal", "name"),
    [
        ({"minimise": "unbalance"}, "root mean square of the unbalances at the bearings"),
        ({"minimise": "unbalance", "combine": "worst"}, "worst unbalance at the bearings"),
        ({"minimise": "unbalance", "combine": "sum"}, "sum of the unbalances at the bearings"),
        ({"minimise": "reaction"}, "root mean square of the bearing reactions"),
        ({"minimise": "reaction", "combine": "worst"}, "worst bearing reaction"),
        ({"minimise": "static_unbalance"}, "static unbalance"),
    ],
)
def test_the_goal_is_named_and_is_the_least_of_all_choices(goal: dict[str, str], name: str) -> None:
    answer = solved(changed(planes__P=HOLES, planes__Q=HOLES, goal=goal))
    combine = {
        "worst": lambda ends: max(ends),
        "sum": lambda ends: sum(ends),
        "rms": lambda ends: (sum(one**2 for one in ends) / 2.0) ** 0.5,
    }[goal.get("combine", "rms")]
    choices = every_choice()
    least = min(choices.values()) if "static" in name else min(combine(ends) for ends in choices)
    scale = (100.0 * pi) ** 2 if "reaction" in name else 1.0
    assert answer.status == "optimal"
    assert answer.goal is not None
    assert answer.goal[0] == name
    assert number_at(answer, "goal") == pytest.approx(scale * least, rel=1e-9)
    assert goal_words(answer).startswith(f"least {name} is ")
    shown = [number_at(answer, f"residual.bearings.{one}.reaction") for one in "AB"]
    if name != "static unbalance":
        assert number_at(answer, "goal") * (100.0 * pi) ** 2 / scale == pytest.approx(combine(shown), rel=1e-9)


def test_a_stock_is_one_box_for_all_planes() -> None:
    """Against every filling, tried one by one: no mass is taken twice where there is one of each."""
    box = {**HOLES, "shelf": [{"mass": one, "stock": 1} for one in ("50 g", "80 g")]}
    answer = solved(changed(planes__P=box, planes__Q=box, goal={"minimise": "static_unbalance"}))
    fills = [(m, m * 0.1 * np.exp(1j * pi / 3.0 * h)) for m in (0.05, 0.08) for h in range(6)]
    known = 0.012 * np.exp(1j * radians(20.0)) + 0.009 * np.exp(1j * radians(200.0))
    pairs = [known + p + q for one, p in [(0.0, 0j), *fills] for other, q in [(0.0, 0j), *fills] if one != other]
    assert answer.status == "optimal"
    assert number_at(answer, "goal") == pytest.approx(min(abs(known), *map(abs, pairs)), rel=1e-9)


@pytest.mark.parametrize("radius", ["100 mm", ["60 mm", "100 mm"]])
def test_weights_cut_in_two_for_the_holes_balance_as_free_ones_do(radius: Any) -> None:
    cut = {"holes": 7, "split": True, "radius": radius}
    answer = solved(changed(planes__P=cut, planes__Q=cut))
    assert answer.status == "optimal"
    assert number_at(answer, "goal") == pytest.approx(0.0, abs=1e-15)
    for plane in answer.plan.planes:
        parts = [one.mass * 0.1 * np.exp(1j * one.angle) for one in plane.weights]
        assert len(parts) == 2
        assert sum(parts) == pytest.approx(plane.u, rel=1e-9)


def test_without_bearings_the_goal_is_the_unbalance_at_both_ends() -> None:
    document = changed(planes__P=HOLES, planes__Q=HOLES)
    del document["shaft"]
    answer = solved(document)
    assert answer.goal is not None
    assert answer.goal[0] == "root mean square of the unbalances at both ends"
    static, couple = (number_at(answer, f"residual.{one}") for one in ("static", "couple"))
    assert number_at(answer, "goal") == pytest.approx(0.5 * (static**2 + (couple / 0.4) ** 2) ** 0.5, rel=1e-9)
    assert any(note.endswith("the unbalances at both ends are those in the outermost of their planes.")
               for note in answer.notes)  # fmt: skip


@pytest.mark.parametrize("minimise", ["unbalance", "reaction", "couple_unbalance"])
def test_the_price_is_that_of_the_goal_named(minimise: str) -> None:
    def with_cap(cap: float) -> Answer[KnownJob]:
        limits = {"most": {"response": "correction", "total": True, "at_most": f"{cap} g"}}
        return solved({**changed(goal={"minimise": minimise}), "limits": limits})

    here, wider = with_cap(40.0), with_cap(40.01)
    price = priced(here).limits["most"].price.rate
    assert price is not None
    assert price > 0.0
    assert price == pytest.approx((number_at(here, "goal") - number_at(wider, "goal")) / 1e-5, rel=1e-2)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (
            {"goal": {"minimise": "static_unbalance", "combine": "worst"}},
            'shaft.toml: goal has combine, but minimise = "static_unbalance" is one quantity. Leave combine out.',
        ),
        (
            {"planes__P": {"forbidden": ["0..360 deg"]}},
            "shaft.toml: planes.P has forbidden sectors all the way round: no weight could sit anywhere. Narrow them, "
            "or write keep = true.",
        ),
        (
            {"planes__P": {"keep": True, "remove": True}},
            "shaft.toml: planes.P has keep = true and remove = true. Leave one out: nothing is removed from a plane "
            "that is kept.",
        ),
        (
            {"planes__P": {**HOLES, "holes": ["0 deg", "30 deg", "30 deg"]}},
            "shaft.toml: planes.P.holes lists 30 deg twice. List each hole once.",
        ),
        (
            {"planes__P": {"most_weights": 2}},
            "shaft.toml: planes.P.most_weights is for weights of a shelf, and there is none. Add shelf = [...], or "
            "leave it out.",
        ),
        (
            {"limits": {"a": {"response": "static_unbalance", "of": "A", "at_most": "5 g mm"}}},
            "shaft.toml: limits.a has of, but static_unbalance is of the whole shaft. Leave of out.",
        ),
        (
            {"limits": {"a": {"response": "bearing_reaction", "total": True, "at_most": "5 N"}}},
            "shaft.toml: limits.a has total, but bearing_reaction is not of weights. Leave total out.",
        ),
        (
            {"measures": {"a": {"response": "bearing_reaction", "of": "A", "at_most": "5 N"}}},
            "shaft.toml: measures.a has a bound (at_most), but a measure has none. Move it to [limits.a].",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(tables: dict[str, Any], message: str) -> None:
    assert refused(solved, changed(**tables)).messages == (message,)


FLAT = """
[masses.a]
unbalance = "50 kg mm"
angle = "20 deg"
[planes.P]
radius = "100 mm"
weight = { from = "0 g", to = "100 g" }
[limits.static]
response = "static_unbalance"
at_most = "45 kg mm"
"""


@pytest.mark.parametrize("goal", ["unbalance", "correction"])
def test_in_one_plane_a_limit_on_the_couple_holds_and_changes_nothing(goal: str) -> None:
    document = tomllib.loads(f'{FLAT}[goal]\nminimise = "{goal}"\n')
    couple = {"response": "couple_unbalance", "at_most": "1 kg mm2"}
    bare, limited = solved(document), solved(document | {"limits": {**document["limits"], "couple": couple}})
    assert limited.limits["couple"].met
    assert limited.status == bare.status == "optimal"
    assert limited.goal == bare.goal
    assert limited.limits["static"] == bare.limits["static"]


def test_a_couple_needs_places() -> None:
    document = changed(goal={"minimise": "couple_unbalance"})
    del document["shaft"]
    for family in ("masses", "planes"):
        for one in document[family].values():
            del one["at"]
    assert refused(solved, document).messages == (
        "shaft.toml: goal minimises a couple, but all masses and planes lie in one plane. Write where each is with at, "
        'or minimise = "static_unbalance".',
    )
