"""Where no weights keep every limit: those that miss least, and the least of each limit, for each kind of job.

The second route is the claim itself: with bounds as wide as the nearest weights need there is an answer, with bounds a
little narrower there is none; and every choice of holes by itself.
"""

from __future__ import annotations

import re
from itertools import combinations_with_replacement, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from rotor_jobs import FAN
from texts import LEFT, MIDDLE, best, plane, reaction, table
from texts import shaft as on_shaft
from vibopt.answer.answer import Answer
from vibopt.jobs import answer as answer_of
from vibopt.jobs import from_text

PROBLEMS = Path(__file__).parents[2] / "problems" / "balancing"
LIMITS = {
    "rao_9_7_holes": {"all": ("residual", "0.005 mm")},
    "rao_9_14_b_capped": {"bearings": ("bearing_reaction", "2 N"), "static": ("static_unbalance", "100 g mm")},
    "engine_share_capped": {"first": ("primary_force", "400 N"), "every": ("force", "1 kN")},
}


def text_of(name: str, bounds: dict[str, str] | None = None) -> str:
    """A stock file with other limits."""
    text = (PROBLEMS / f"{name}.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
    head, *tables = text.split("\n[limits.")
    rest = "".join(f"\n[{one.partition(chr(10) + '[')[2]}" for one in tables if "\n[" in one)
    asked = bounds if bounds is not None else {key: bound for key, (_, bound) in LIMITS[name].items()}
    own = [f'\n[limits.{key}]\nresponse = "{LIMITS[name][key][0]}"\nat_most = "{one}"\n' for key, one in asked.items()]
    return head + rest + "\n" + "".join(own)


def solved(name: str, bounds: dict[str, str] | None = None) -> Answer[Any]:
    return vo.explain(from_text(text_of(name, bounds), f"{name}.toml"), thorough=True).answer


def bound(answer: Answer[Any], key: str, value: float, part: float) -> str:
    assert answer.nearest is not None
    limit = answer.nearest.limits[key].limit
    assert limit is not None
    return f"{value * part!r} {limit.si}"


@pytest.mark.parametrize("name", ["rao_9_7_holes", "rao_9_14_b_capped", "engine_share_capped"])
def test_bounds_as_wide_as_it_needs_have_an_answer_and_narrower_ones_none(name: str) -> None:
    answer = solved(name)
    assert answer.status == "infeasible"
    assert not answer.limits  # of no answer; those of the nearest weights are said to be theirs
    near = answer.nearest
    assert near is not None
    factor = max(row.value.value / row.limit.value for row in near.limits.values() if row.limit is not None)
    assert factor > 1.0
    given = {key: row.limit.value for key, row in near.limits.items() if row.limit is not None}
    for part, good in ((1.0 + 1e-4, True), (1.0 - 1e-4, False)):
        asked = {key: bound(answer, key, one * factor, part) for key, one in given.items()}
        assert (solved(name, asked).status in ("optimal", "feasible")) == good


@pytest.mark.parametrize("name", ["rao_9_7_holes", "rao_9_14_b_capped", "engine_share_capped"])
def test_of_each_limit_alone_there_is_no_less(name: str) -> None:
    answer = solved(name)
    assert answer.nearest is not None
    assert set(answer.nearest.least) == set(LIMITS[name])
    for key, one in answer.nearest.least.items():
        assert one.proven
        limit = answer.nearest.limits[key].limit
        assert limit is not None
        assert one.enough == (one.value.value <= limit.value)
        for part, good in ((1.0 + 1e-4, True), (1.0 - 1e-4, False)) if one.value.value else ():
            asked = {key: bound(answer, key, one.value.value, part)}
            assert (solved(name, asked).status in ("optimal", "feasible")) == good


@pytest.mark.parametrize("name", ["rao_9_7_holes", "rao_9_14_b_capped", "engine_share_capped"])
def test_the_loosening_that_is_named_helps(name: str) -> None:
    answer = solved(name)
    assert answer.conflict is not None
    bounds = {key: one for key, (_, one) in LIMITS[name].items()}
    for key, now, then in answer.conflict.loosenings:
        assert solved(name, {**bounds, key: then.shown}).status in ("optimal", "feasible")
        assert now.value < then.value
    assert answer.conflict.loosenings or len(LIMITS[name]) > 1


def test_of_all_weights_in_holes_none_leaves_less() -> None:
    """Every choice of at most two weights, by the coefficient that the readings give."""
    found = np.array(0.15e-3 * np.exp(-1j * np.radians(15.0)))
    trial = 0.22e-3 * np.exp(1j * np.radians(35.0))
    per = (trial.conj() - found.conj()) / (50e-3 * np.exp(1j * np.radians(45.0)))  # the mark moves the other way round
    weights = [m * np.exp(1j * np.radians(45.0 * hole)) for m, hole in product((10e-3, 20e-3, 30e-3), range(8))]
    sums = [
        0.0,
        *weights,
        *(a + b for a, b in combinations_with_replacement(weights, 2) if abs(np.angle(a / b)) > 1e-9),
    ]
    least = min(abs(found.conj() + per * one) for one in sums)
    near = solved("rao_9_7_holes").nearest
    assert near is not None
    assert near.limits["all"].value.value == pytest.approx(least, rel=1e-9)


def test_what_is_shown_is_said_in_words_and_on_the_page() -> None:
    for name, title in (
        ("rao_9_7_holes", "The nearest plan"),
        ("rao_9_14_b_capped", "The nearest weights"),
        ("engine_share_capped", "The nearest weights"),
    ):
        answer = solved(name)
        from vibopt.answer.answer_page import html

        for text in (answer.report(), html(answer)):
            assert title in text
            assert "what each limit could be alone" in text


SOFT = {"rao_9_7_holes": "all", "rao_9_14_b_capped": "static", "engine_share_capped": "every"}


@pytest.mark.parametrize("name", ["rao_9_14_b_capped", "engine_share_capped"])
def test_soft_bounds_as_wide_as_their_weights_say_have_an_answer_and_narrower_ones_none(name: str) -> None:
    text = text_of(name).replace(f"[limits.{SOFT[name]}]", f"[limits.{SOFT[name]}]\nsoft = 3")
    answer = vo.explain(from_text(text, f"{name}.toml"), thorough=True).answer
    assert answer.status == "infeasible"
    assert answer.nearest is not None
    rows = {key: row for key, row in answer.nearest.limits.items() if row.limit is not None}
    weights = {key: 3.0 if key == SOFT[name] else 1.0 for key in rows}
    part = max(-row.margin / weights[key] for key, row in rows.items())
    assert part > 0.0
    assert "With wider limits all could hold: " in answer.reason
    for more, good in ((1.0 + 1e-4, True), (1.0 - 1e-4, False)):
        asked = {
            key: bound(answer, key, row.limit.value * (1.0 + weights[key] * part), more)
            for key, row in rows.items()
            if row.limit is not None
        }
        assert (solved(name, asked).status in ("optimal", "feasible")) == good


def test_soft_readings_of_a_rotor_are_left_by_their_share() -> None:
    """Four sensors, two planes: with each bound widened by its share there are weights, with a little less none."""

    def rotor(bounds: dict[str, str], soft: dict[str, int]) -> Answer[Any]:
        text = (PROBLEMS / "feese_two_planes.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
        for name, one in bounds.items():
            weight = f"soft = {soft[name]}" if name in soft else ""
            text += f'\n[limits.{name}]\nresponse = "residual"\nat = "{name}"\nat_most = "{one}"\n{weight}\n'
        return vo.explain(from_text(text, "fan.toml"), thorough=True).answer

    soft = {"c": 3}
    answer = rotor({"a": "0.03 mil", "b": "0.03 mil", "c": "0.02 mil"}, soft)
    assert answer.status == "infeasible"
    assert answer.nearest is not None
    rows = answer.nearest.limits
    part = max(-row.margin / soft.get(name, 1) for name, row in rows.items())
    assert part > 0.0
    assert "With wider limits all could hold: " in answer.reason
    assert answer.reason.endswith("(soft: c 3).")
    for more, good in ((1.0 + 1e-4, True), (1.0 - 1e-4, False)):
        asked = {
            name: f"{row.limit.value * (1.0 + soft.get(name, 1) * part) * more / 25.4e-6 * 2.0!r} mil"
            for name, row in rows.items()
            if row.limit is not None
        }
        assert (rotor(asked, {}).status in ("optimal", "feasible")) == good


def test_weights_of_a_rotor_are_not_soft_and_measures_neither() -> None:
    text = text_of("engine_share_capped") + '\n[measures.m]\nresponse = "force"\nsoft = 2\n'
    error = refused(from_text, text, "engine.toml")
    assert "measures.m has soft, but no bound to loosen: soft weighs the loosening of a limit." in str(error)


def shaft_of(A: float, B: float, total: float, soft: str) -> str:
    """Three known masses, two planes, and bounds [N, N, g] that may be too tight."""
    hole = table("masses.hole", mass="0.3 kg", radius="60 mm", angle="330 deg", at="700 mm", removed=True)
    bounds = reaction("A", f"{A!r} N"), reaction("B", f"{B!r} N") + f"{soft}\n"
    correction = table("limits.total", response="correction", total=True, at_most=f"{total!r} g")
    planes = plane("drive", "100 mm"), plane("free", "800 mm")
    return on_shaft(LEFT, MIDDLE, hole, *planes, *bounds, correction, best(minimise="unbalance"))


def shaft(A: float = 20.0, B: float = 20.0, total: float = 900.0, soft: str = "") -> Answer[Any]:
    return vo.solve(from_text(shaft_of(A=A, B=B, total=total, soft=soft), "shaft.toml"))


def kept(A: float, B: float, total: float = 900.0) -> bool:
    """Whether weights keep all limits."""
    job = from_text(shaft_of(A=A, B=B, total=total, soft=""), "shaft.toml")
    return answer_of(job, explain=False, brief=True).status == "optimal"


def test_a_limit_on_weights_is_not_among_those_that_the_bound_is_told_of() -> None:
    """Each factor that is named is enough for the limits it names, and a little less is not."""
    answer = shaft()
    wider = "no correction keeps the limits: with the weights that are allowed, those on what is left would have to be "
    assert answer.claim.startswith(f"{wider}at least ")
    readings = float(answer.claim.split(" at least ")[1].split()[0])
    assert answer.reason.endswith(" times as wide all could hold.")
    every = float(answer.reason.split(" With every limit ")[1].split()[0])
    assert every < readings
    assert "vibopt whatif FILE" in answer.report()
    for part, good in ((1.0 + 5e-4, True), (1.0 - 5e-4, False)):
        assert kept(20.0 * readings * part, 20.0 * readings * part) == good
    for part, good in ((1.0, True), (0.99, False)):  # three digits, outward
        assert kept(20.0 * every * part, 20.0 * every * part, 900.0 * every * part) == good


def test_limits_that_are_missed_many_times_over_say_how_much_wider_they_have_to_be() -> None:
    answer = shaft(soft="soft = 4")
    said = answer.reason.split("With wider limits all could hold: ")[1]
    found = re.fullmatch(
        r"A ([\d.]+) times as wide, B ([\d.]+) times as wide, total by ([\d.]+) % \(soft: B 4\)\.", said
    )
    assert found is not None
    a, b, total = map(float, found.groups())
    assert kept(20.0 * a, 20.0 * b, 900.0 * (1.0 + total / 100.0))


HOLES = 'radius = "150 mm"\nholes = 8\nshelf = ["4 g", "8 g"]\nmost_weights = 2'
ROTOR_LIMITS = {
    "total": {"left": (0.7, "mil"), "total": (9.0, "g"), "cap": (12.0, "g")},
    "cap": {"left": (2.0, "mil"), "total": (30.0, "g"), "cap": (5.0, "g")},
}
"""By the limit on weights that stands in the way: greatest values."""


def rotor(narrow: str, holes: bool, bounds: dict[str, float] | None = None) -> Answer[Any]:
    """The fan with a limit on what is left, one on all weights and one on a plane, at which not all can hold."""
    limits = ROTOR_LIMITS[narrow]
    kinds = ('"residual"', '"correction"\ntotal = true', '"correction"\nof = "left"')
    tables = "".join(
        f'[limits.{key}]\nresponse = {kind}\nat_most = "{(bounds or {}).get(key, bound)!r} {unit}"\n'
        for kind, (key, (bound, unit)) in zip(kinds, limits.items(), strict=True)
    )
    text = FAN.replace('radius = "150 mm"', HOLES) if holes else FAN
    return vo.explain(from_text(text + tables, "fan.toml"), thorough=True).answer


def fan_choices() -> np.ndarray[Any, np.dtype[np.float64]]:
    """What each choice of weights in holes leaves [mil], weighs [g], and weighs in the plane left [g]."""

    def phasor(amplitude: float, angle: float) -> complex:
        return complex(amplitude * np.exp(1j * np.radians(angle)))

    found = np.array([phasor(8.6, 63), phasor(6.5, 206)])
    left = (np.array([phasor(5.9, 123), phasor(4.5, 228)]) - found) / phasor(10, 270)
    right = (np.array([phasor(6.2, 36), phasor(10.4, 162)]) - found) / phasor(12, 180)
    singles = [(hole, mass) for hole in range(8) for mass in (4.0, 8.0)]
    pairs = [(one, other) for one in singles for other in singles if one[0] < other[0]]
    sets: list[tuple[tuple[int, float], ...]] = [(), *((one,) for one in singles), *pairs]
    does = np.array([sum(phasor(mass, 45.0 * hole) for hole, mass in some) for some in sets])
    mass = np.array([sum(mass for _, mass in some) for some in sets])
    remains = abs(found[:, None, None] + left[:, None, None] * does[:, None] + right[:, None, None] * does).max(axis=0)
    one, other = np.meshgrid(mass, mass, indexing="ij")
    return np.array([remains.ravel(), (one + other).ravel(), one.ravel()])


@pytest.mark.parametrize("narrow", ROTOR_LIMITS)
def test_of_a_measured_rotor_limits_on_weights_are_loosened_too(narrow: str) -> None:
    """Every choice of weights by itself: the least factor of all limits, and the least bound of each."""
    limits = ROTOR_LIMITS[narrow]
    answer = rotor(narrow, holes=True)
    table, bounds = fan_choices(), np.array([[bound] for bound, _ in limits.values()])
    assert answer.nearest is not None
    assert answer.conflict is not None
    factor = max(row.value.value / row.limit.value for row in answer.nearest.limits.values() if row.limit is not None)
    assert factor == pytest.approx((table / bounds).max(axis=0).min(), rel=1e-6)
    keeps = table <= bounds * (1.0 + 1e-9)
    least = {
        key: float(table[k, np.delete(keeps, k, axis=0).all(axis=0)].min(initial=np.inf))
        for k, key in enumerate(limits)
    }
    steps = {name: then.value / now.value * limits[name][0] for name, now, then in answer.conflict.loosenings}
    shared = set(answer.conflict.limits).intersection(*answer.conflict.others)
    assert narrow in shared
    assert set(steps) == {name for name in shared if np.isfinite(least[name])}
    for name, value in steps.items():
        assert value == pytest.approx(least[name], rel=1e-3)
    parts = [value / limits[name][0] for name, value in steps.items()]
    said = [one.split()[0] for one in answer.conflict.steps]
    assert said == [name for _, name in sorted(zip(parts, steps, strict=True))]


@pytest.mark.parametrize("narrow", ROTOR_LIMITS)
def test_free_weights_need_the_bounds_that_are_told_and_no_less(narrow: str) -> None:
    limits = ROTOR_LIMITS[narrow]
    answer = rotor(narrow, holes=False)
    assert answer.nearest is not None
    assert answer.conflict is not None
    factor = max(row.value.value / row.limit.value for row in answer.nearest.limits.values() if row.limit is not None)
    every = {key: bound * factor for key, (bound, _) in limits.items()}
    told = {name: then.value / now.value for name, now, then in answer.conflict.loosenings}
    assert narrow in told
    asked = [every, *({name: limits[name][0] * part / 1.0005} for name, part in told.items())]
    for bounds in asked:
        for part, good in ((1.0 + 1e-4, True), (1.0 - 1e-4, False)):
            given = {key: bound * part for key, bound in bounds.items()}
            assert (rotor(narrow, holes=False, bounds=given).status == "optimal") == good
