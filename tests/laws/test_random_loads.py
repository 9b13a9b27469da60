"""Random loads in time, several at once: every peak is that of an integrator of its own; releases and their words."""

from __future__ import annotations

from copy import copy, deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from random_loads import Chain
from refusals import refused
from vibopt.forms import PeakOverDurations
from vibopt.program.pose import on_needed, pose
from vibopt.report.limiting_views import limiting
from vibopt.verify.certify import measure

few = settings(derandomize=True, database=None, deadline=None, max_examples=8)


def measured(document: dict[str, Any]) -> dict[str, float]:
    """Values of the measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


def loaded(seed: int, most: int = 3) -> Chain:
    """A chain under one to four loads that begin together: pulses, releases, a sine or a step that stays."""
    rng = np.random.default_rng(seed)
    chain = Chain.drawn(rng, most)
    for _ in range(int(rng.integers(1, 4))):
        kind = rng.random()
        if kind < 0.6:
            chain.pulse(rng, float(2.0 * np.pi / chain.rates[0] * 10.0 ** rng.uniform(-1.0, 0.5)))
        else:
            chain.release(rng)
    stays = rng.random()
    if stays < 0.4:
        (chain.lasting if stays < 0.2 else chain.step)(rng)
    return chain


@few
@given(seed=st.integers(0, 1_000_000))
def test_every_peak_under_several_loads_is_that_of_an_integrator(seed: int) -> None:
    chain = loaded(seed)
    assert measured(chain.document) == pytest.approx(chain.peaks(), rel=2e-6)


@settings(few, max_examples=4)
@given(seed=st.integers(0, 1_000_000))
def test_window_sweep_and_whatif_end_where_an_integrator_meets_the_limit(seed: int) -> None:
    """Of the stiffness of one link: no interval too wide, none left out between two, no softer design that keeps it."""
    rng = np.random.default_rng(seed)
    chain = loaded(seed, most=2)
    own = float(chain.springs[0])
    ends = own / 3.0, 3.0 * own

    def travel(stiffness: float) -> float:
        return replace(chain, springs=np.append(stiffness, chain.springs[1:])).peaks()["travel"]

    most = travel(float(rng.uniform(0.5, 2.0)) * own)
    document = chain.document
    document["links"]["l0"]["stiffness"] = {"from": f"{ends[0]!r} N/m", "to": f"{ends[1]!r} N/m"}
    document["limits"] = {"travel": {**document.pop("measures")["travel"], "at_most": f"{most!r} m"}}
    scene = vo.from_dict({**document, "goal": {"minimise": "stiffness", "of": "l0"}})
    intervals = [(one.value, other.value) for one, other in vo.window(scene).spans[0].intervals]
    for end in {end for both in intervals for end in both}:
        at_range = min(abs(end / one - 1.0) for one in ends) < 1e-9
        assert travel(end) <= most * (1.0 + 1e-6) if at_range else travel(end) == pytest.approx(most, rel=1e-5)
    for one, other in intervals:
        assert travel(0.5 * (one + other)) <= most * (1.0 + 1e-6)
    outside = np.reshape([ends[0], *np.ravel(intervals), ends[1]], (-1, 2))
    for one, other in outside[outside[:, 1] > outside[:, 0] * (1.0 + 1e-6)].tolist():
        assert travel(0.5 * (one + other)) > most
    softest = {}
    for point in vo.sweep(scene, "limits.travel.at_most", f"{most!r} m..{1.2 * most!r} m", 2).points:
        assert point.good
        softest[point.value.value] = chosen = point.variables["links.l0.stiffness"].value
        assert travel(chosen) <= point.value.value * (1.0 + 1e-6)
        below = 0.999 * chosen
        assert below < ends[0] or travel(below) > point.value.value
    assert min(softest.values()) == softest[max(softest)]
    assert softest[min(softest)] == pytest.approx(intervals[0][0], rel=1e-6)
    changed = vo.whatif(scene, {"limits.travel.at_most": f"{1.2 * most!r} m"}).after
    assert changed.variables["links.l0.stiffness"].value.value == pytest.approx(softest[max(softest)], rel=1e-6)


@settings(few, max_examples=4)
@given(seed=st.integers(0, 1_000_000), known=st.booleans())
def test_a_pulse_of_any_duration_beside_others_has_one_greatest_by_both_routes(seed: int, known: bool) -> None:
    """To 1e-6, at edges and ends of the range, too; an integrator finds it at that duration, and elsewhere no more."""
    rng = np.random.default_rng(seed)
    chain = Chain.drawn(rng, most=2)
    longest = float(2.0 * np.pi / chain.rates[0] * 10.0 ** rng.uniform(-0.7, 0.3))
    shortest = longest * float(rng.uniform(0.1, 0.9)) if known else 0.0
    if rng.random() < 0.5:
        chain.release(rng)
    if rng.random() < 0.5:
        chain.pulse(rng, 0.3 * longest)
    other = Chain(chain.masses, chain.springs, chain.dampers, *map(copy, (chain.loads, chain.rows, chain.signals,
                  chain.joints)), chain.start)  # fmt: skip
    again, given = deepcopy(rng), {"duration_from": f"{shortest!r} s"} if known else {}
    chain.pulse(rng, longest, {"duration_up_to": f"{longest!r} s", **given})
    scene = vo.from_dict(chain.document)
    model, response = pose(scene).model, scene.measures["felt"]
    model, form = on_needed(scene, model, response)
    assert isinstance(form, PeakOverDurations)
    most, lasts = form.worst_of(model, np.zeros(0))
    assert measure(scene, {}, response).value == pytest.approx(most, rel=1e-6)
    other.pulse(again, lasts, {"duration": f"{lasts!r} s"})
    assert other.peaks()["felt"] == pytest.approx(most, rel=2e-6)
    tried = rng.uniform(shortest, longest, 20)
    assert max(form.lasting(one).value(model, np.zeros(0)) for one in tried.tolist()) <= most * (1.0 + 1e-9)


def let_go(**release: Any) -> dict[str, Any]:
    """A trolley of 2 kg on a spring and a damper, let go."""
    buffer = {"between": ["trolley", "ground"], "stiffness": "800 N/m", "damping": "16 N s/m"}
    return {
        "title": "trolley on its buffer",
        "bodies": {"trolley": {"mass": "2 kg"}},
        "links": {"buffer": buffer},
        "excitations": {"arrival": {"kind": "release", "on": "trolley", **release}},
        "measures": {
            "place": {"response": "peak_displacement", "of": "trolley"},
            "travel": {"response": "peak_relative_displacement", "across": "buffer"},
            "speed": {"response": "peak_velocity", "of": "trolley"},
            "felt": {"response": "peak_acceleration", "of": "trolley"},
            "force": {"response": "peak_force", "into": "ground"},
        },
    }


def test_a_mass_that_is_let_go_moves_as_in_the_books() -> None:
    """x = x0 e^(-n t) (cos wt + n / w sin wt) is greatest as it begins, and its velocity where tan wt = w / n."""
    n, w = 4.0, np.sqrt(400.0 - 16.0)
    found, turned = measured(let_go(displacement="-10 mm")), np.arctan(w / n)
    assert found["place"] == pytest.approx(0.01, rel=1e-12)
    assert found["felt"] == pytest.approx(4.0, rel=1e-12)
    fastest = 0.01 * 400.0 / w * np.exp(-n * turned / w) * np.sin(turned)
    assert found["speed"] == pytest.approx(fastest, rel=1e-9)
    fast = measured(let_go(velocity="2 m/s"))
    assert fast["place"] == pytest.approx(2.0 / w * np.exp(-n * turned / w) * np.sin(turned), rel=1e-9)
    assert fast["travel"] == pytest.approx(fast["place"], rel=1e-12)
    assert fast["speed"] == pytest.approx(2.0, rel=1e-12)
    assert fast["force"] == pytest.approx(2.0 * fast["felt"], rel=1e-9)
    answer = vo.solve(vo.from_dict(let_go(velocity="2 m/s")))
    assert answer.measures["place"].worst_at["arrival"].value == pytest.approx(turned / w, rel=1e-7)
    assert answer.measures["speed"].worst_at["arrival"].value == 0.0


def test_a_velocity_at_which_a_mass_arrives_is_a_drop_of_its_base() -> None:
    """The same design to the last digit, proven, and as near to the best of all isolators."""
    chosen = {"stiffness": {"from": "100 N/m", "to": "100 kN/m"}, "damping": {"from": "1 N s/m", "to": "1 kN s/m"}}
    asked: dict[str, Any] = {
        **let_go(velocity="1.5 m/s"),
        "links": {"buffer": {"between": ["trolley", "ground"], **chosen}},
        "limits": {"travel": {"response": "peak_relative_displacement", "across": "buffer", "at_most": "40 mm"}},
        "goal": {"minimise": "peak_acceleration", "of": "trolley"},
        "measures": {},
    }
    falls = {
        **asked,
        "bases": {"box": {}},
        "links": {"buffer": {"between": ["trolley", "box"], **chosen}},
        "excitations": {"fall": {"kind": "drop", "on": "box", "velocity_change": "1.5 m/s"}},
    }
    one, other = (vo.solve(vo.from_dict(document)) for document in (asked, falls))
    assert one.status == other.status == "optimal"
    assert one.goal is not None
    assert other.goal is not None
    assert one.goal[1].value == pytest.approx(other.goal[1].value, rel=1e-9)
    assert one.x == pytest.approx(other.x, rel=1e-5)
    [best], [alike] = limiting(one), limiting(other)
    assert best.least.high == pytest.approx(alike.least.high, rel=1e-3)
    asked["excitations"]["arrival"]["displacement"] = "1 mm"
    assert not limiting(vo.solve(vo.from_dict(asked)))


def test_a_release_beside_a_pulse_of_unknown_duration_is_the_greatest_of_known_ones() -> None:
    document = let_go(velocity="0.4 m/s")
    document["measures"] = {name: document["measures"][name] for name in ("place", "felt")}
    pulse = {"kind": "pulse", "on": "trolley", "shape": "half sine", "amplitude": "30 N"}

    def found(**lasts: str) -> dict[str, float]:
        both = {**document["excitations"], "blow": {**pulse, **lasts}}
        return measured({**document, "excitations": both})

    every = [found(duration=f"{one} ms") for one in (20.0, 80.0, 200.0)]
    for name, value in found(duration_from="20 ms", duration_up_to="200 ms").items():
        assert max(one[name] for one in every) * (1.0 - 1e-9) <= value


JOINT = {"spring": {"between": ["trolley", "joint"], "stiffness": "300 N/m"}}
DAMPED = {**JOINT, "damper": {"between": ["joint", "ground"], "damping": "9 N s/m"}}


def with_joint(links: dict[str, Any], **release: str) -> dict[str, Any]:
    document = let_go(velocity="1 m/s")
    document["bodies"]["joint"] = {"mass": "0 kg"}
    document["links"] |= links
    document["excitations"]["pulled"] = {"kind": "release", "on": "joint", **release}
    document["measures"] = {"place": document["measures"]["place"]}
    return document


def test_a_joint_that_a_damper_holds_is_let_go_from_its_own_place() -> None:
    """Pulled along slowly its spring is slack, pulled at once it is not: the force on the body is another."""
    documents = [with_joint(DAMPED, displacement=f"{one} mm") for one in (10, 0.001)]
    for document in documents:
        document["excitations"]["arrival"] = {"kind": "release", "on": "trolley", "displacement": "10 mm"}
        document["measures"] = {"felt": {"response": "peak_acceleration", "of": "trolley"}}
    slowly, at_once = (measured(document)["felt"] for document in documents)
    assert slowly == pytest.approx(800.0 * 0.01 / 2.0, rel=1e-9)
    assert at_once == pytest.approx(1100.0 * 0.01 / 2.0, rel=1e-3)


@pytest.mark.parametrize(
    ("document", "said"),
    [
        (
            let_go(),
            "scene: excitations.arrival needs a displacement or a velocity that is not zero. Write velocity = "
            '"0.3 m/s".',
        ),
        (
            let_go(velocity="3 mm"),
            'scene: excitations.arrival.velocity = "3 mm" is a length, but a velocity is needed here. Write a '
            'velocity, for example "2.8 mm/s".',
        ),
        (
            {**let_go(velocity="1 m/s"), "bodies": {"trolley": {"inertia": "2 kg m²"}}},
            'scene: excitations.arrival is of kind "release", but trolley turns. What comes once is answered for '
            "bodies on a line only, so far.",
        ),
        (
            with_joint(DAMPED, velocity="1 m/s"),
            "scene: measures.place: excitations.pulled releases joint, which has no mass. Release a body with mass, or "
            "a joint that a damper holds, by a displacement alone.",
        ),
        (
            with_joint({**JOINT, "feet": {"between": ["joint", "ground"], "stiffness": "1 N/m"}}, displacement="1 mm"),
            "scene: measures.place: excitations.pulled releases joint, which has no mass. Release a body with mass, or "
            "a joint that a damper holds, by a displacement alone.",
        ),
    ],
)
def test_what_cannot_be_let_go_is_said(document: dict[str, Any], said: str) -> None:
    assert said in refused(vo.from_dict, document).messages


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.6, 1.0, 3.0])
def test_a_step_overshoots_as_in_the_books(ratio: float) -> None:
    """By e^(-pi z / sqrt(1 - z^2)) what it holds in the end, and overdamped mounts by nothing."""
    over = np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)) if ratio < 1.0 else 0.0
    mount = {"between": ["unit", "base"], "stiffness": "800 N/m", "damping": f"{80.0 * ratio!r} N s/m"}
    document: dict[str, Any] = {
        "title": "unit that is pushed for ever",
        "bases": {"base": {}},
        "bodies": {"unit": {"mass": "2 kg"}},
        "links": {"mount": mount},
        "excitations": {"push": {"kind": "pulse", "shape": "step", "on": "unit", "amplitude": "40 N"}},
        "measures": {
            "place": {"response": "peak_displacement", "of": "unit"},
            "felt": {"response": "peak_acceleration", "of": "unit"},
            "force": {"response": "peak_force", "into": "base"},
        },
    }
    found = measured(document)
    assert found["place"] == pytest.approx(0.05 * (1.0 + over), rel=1e-9)
    assert found["felt"] == pytest.approx(20.0, rel=1e-9)
    [row] = vo.shock_spectrum(vo.from_dict(document), frequencies=[10.0 / np.pi], damping=[ratio]).table()
    assert row["force_maximax"] == pytest.approx(found["force"], rel=1e-9)
    assert row["force_residual"] == 0.0
    shaken = {"push": {"kind": "pulse", "shape": "step", "on": "base", "acceleration": "20 m/s²"}}
    rattle = {"response": "peak_relative_displacement", "across": "mount"}
    moved = {**document, "excitations": shaken, "measures": {"rattle": rattle, "felt": document["measures"]["felt"]}}
    found = measured(moved)
    assert found["rattle"] == pytest.approx(0.05 * (1.0 + over), rel=1e-9)
    [row] = vo.shock_spectrum(vo.from_dict(moved), frequencies=[10.0 / np.pi], damping=[ratio]).table()
    assert row["acceleration_maximax"] == pytest.approx(found["felt"], rel=1e-9)
    assert row["relative_displacement"] == pytest.approx(found["rattle"], rel=1e-9)


def test_a_step_on_what_is_loose_strains_it_and_moves_it_without_end() -> None:
    """Two bodies on one spring: it holds m2 / (m1 + m2) of the force, and nearly twice that at once."""
    document: dict[str, Any] = {
        "title": "two wagons",
        "bodies": {"first": {"mass": "10 kg"}, "second": {"mass": "3 kg"}},
        "links": {"coupling": {"between": ["first", "second"], "stiffness": "900 N/m", "damping": "3 N s/m"}},
        "excitations": {"pull": {"kind": "pulse", "shape": "step", "on": "first", "amplitude": "100 N"}},
        "measures": {
            "stretch": {"response": "peak_relative_displacement", "across": "coupling"},
            "speed": {"response": "peak_velocity", "of": "second"},
        },
    }
    found, mass = measured(document), 30.0 / 13.0
    ratio = 3.0 / (2.0 * np.sqrt(900.0 * mass))
    over = np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2))
    assert found["stretch"] == pytest.approx(100.0 * 3.0 / 13.0 / 900.0 * (1.0 + over), rel=1e-9)
    assert found["speed"] == np.inf


STEP = {"kind": "pulse", "shape": "step", "on": "trolley", "amplitude": "9 N"}
PLACE = {"place": {"response": "peak_displacement", "of": "trolley"}}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"excitations": {"arrival": {**STEP, "duration": "2 s"}}},
            'excitations.arrival is a step, which stays for ever. Remove duration, or write shape = "rectangle".',
        ),
        (
            {"excitations": {"arrival": STEP, "fan": {"kind": "force", "on": "trolley", "amplitude": "1 N",
                                                      "speed": "3 Hz", "begins": "suddenly"}}},
            "measures.place counts a step, excitations.arrival, beside excitations.fan, which vibrates for ever. Name "
            'one: due_to = ["arrival"], or add up the greatest of each: combine = "sum".',
        ),
        (
            {"excitations": {"arrival": STEP, "blow": {**STEP, "shape": "sine", "duration_up_to": "1 s"}}},
            "measures.place counts a pulse of unknown duration, excitations.blow, beside excitations.arrival, which "
            'goes on for ever. Write its duration, name one: due_to = ["blow"], or add up the greatest of each: '
            'combine = "sum".',
        ),
        (
            {"bases": {"base": {}}, "links": {"buffer": {"between": ["trolley", "base"], "stiffness": "9 N/m"}},
             "excitations": {"arrival": {"kind": "pulse", "shape": "step", "on": "base", "acceleration": "1 m/s²"}},
             "measures": {"place": {"response": "peak_velocity", "of": "trolley"}}},
            "measures.place is infinite whatever the design: the base of excitations.arrival, whose acceleration is "
            "given, moves on behind it, and trolley with it. Ask for peak_relative_displacement across a link.",
        ),
    ],
)  # fmt: skip
def test_a_step_that_has_no_answer_is_refused(change: dict[str, Any], said: str) -> None:
    document = {**let_go(velocity="1 m/s"), "measures": PLACE, **change}
    assert f"scene: {said}" in refused(vo.from_dict, document).messages
