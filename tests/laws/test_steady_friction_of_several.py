"""Steady motion of several bodies of which one link rubs: both roads, limits, energy, one body, and a third road."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import vibopt as vo
from rubbing_route import ENDS, LOW, MASSES, UP, drawer_in_rack, follow
from vibopt.forms import RubbingOfSeveral
from vibopt.mechanics.panels import NODES, basis
from vibopt.program.pose import form_of, pose
from vibopt.report.curves import panels

few = settings(derandomize=True, database=None, deadline=None, max_examples=8)


def rack(
    load: dict[str, Any] | None = None, ends: tuple[str, str] = ENDS[0], friction: float = 300.0, damping: float = 400.0
) -> dict[str, Any]:
    force = {"kind": "force", "on": "rack", "amplitude": "1 kN", "speed": "8 Hz", "varies": "constant"}
    shaken = load if load and "kind" in load else force | (load or {})
    measures = {
        "place": {"response": "displacement", "of": "drawer"},
        "fast": {"response": "acceleration", "of": "rack"},
        "slip": {"response": "relative_displacement", "across": "pad"},
        "pad": {"response": "transmitted_force", "through": "pad"},
        "into": {"response": "transmitted_force", "into": "floor" if shaken["on"] == "floor" else "ground"},
    }
    return drawer_in_rack(shaken, ends, damping, {"friction_force": f"{friction!r} N"}, measures)


def moving(floor: str = "floor", **words: str) -> dict[str, Any]:
    return {"kind": "base_motion", "on": floor, "displacement": "3 mm", "speed": "8 Hz"} | words


def told(document: dict[str, Any]) -> dict[str, float]:
    """Values of the measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


def motion_of(document: dict[str, Any], name: str, hertz: float) -> Any:
    scene = vo.from_dict(document)
    model = pose(scene).model
    form = form_of(scene, model, scene.measures[name])
    assert isinstance(form, RubbingOfSeveral)
    return form.returning(model, np.zeros(0), 2.0 * np.pi * hertz)


@few
@given(
    on=st.sampled_from(["rack", "drawer", "floor"]), ends=st.sampled_from(ENDS), hertz=st.floats(1.0, 25.0),
    friction=st.floats(1.0, 1500.0), damping=st.floats(100.0, 3000.0), three=st.booleans(),
)  # fmt: skip
@example(on="floor", ends=ENDS[1], hertz=7.0, friction=400.0, damping=200.0, three=False)
@example(on="drawer", ends=ENDS[1], hertz=1.0, friction=700.0, damping=50.0, three=True)
def test_every_response_has_one_value_by_both_routes(
    on: str, ends: tuple[str, str], hertz: float, friction: float, damping: float, three: bool
) -> None:
    """Machines of two bodies, and of three with an absorber, under a force and on a floor that moves."""
    speed = {"speed": f"{hertz!r} Hz"}
    document = rack(moving() | speed if on == "floor" else {"on": on} | speed, ends, friction, damping)
    if three:
        document["bodies"]["lamp"] = {"mass": "5 kg"}
        document["links"]["arm"] = {"between": ["drawer", "lamp"], "stiffness": "20 kN/m", "damping": "30 N s/m"}
        document["absorbers"] = {"tmd": {"on": "rack", "mass": "9 kg", "frequency": "7 Hz", "damping_ratio": 0.1}}
        document["measures"]["lamp"] = {"response": "velocity", "of": "lamp"}
    told(document)


@pytest.mark.parametrize(
    ("ends", "friction", "hertz"), [pytest.param(ENDS[0], 100.0, 5.0, marks=pytest.mark.slow), (ENDS[1], 600.0, 8.0)]
)
def test_a_runge_kutta_method_between_events_ends_in_the_same_motion(
    ends: tuple[str, str], friction: float, hertz: float
) -> None:
    """From rest over many turns; the last of them is read."""
    row = {"rack": np.array([1.0, 0.0]), "drawer": np.array([0.0, 1.0]), "ground": np.zeros(2)}
    across, shape = row[ends[1]] - row[ends[0]], np.array([[1.0, -1.0], [-1.0, 1.0]])
    damp, stiff = (np.diag([low, 0.0]) + up * shape for low, up in ((4e3, 4e3), (LOW, UP)))
    turn = 1.0 / hertz
    last = 11 * turn
    peaks = follow(
        (np.diag(MASSES), damp, stiff), across, friction,
        lambda t: np.array([1e3 * np.cos(2.0 * np.pi * hertz * t), 0.0]), (last, last + turn),
        lambda t, x, _, faster, rubs: tuple((t > last) * one for one in (x[1], faster[0], across @ x, rubs)),
    )  # fmt: skip
    found = told(rack({"speed": f"{hertz!r} Hz"}, ends, friction, 4e3))
    for name, value in zip(("place", "fast", "slip", "pad"), peaks, strict=True):
        assert found[name] == pytest.approx(value, rel=3e-6)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("load", [{}, moving()], ids=["force", "floor"])
def test_hardly_any_friction_leaves_the_linear_machine(ends: tuple[str, str], load: dict[str, Any]) -> None:
    found, linear = told(rack(load, ends, 1e-6)), told(rack(load, ends, 0.0))
    for name in set(found) - {"pad"}:
        assert found[name] == pytest.approx(linear[name], rel=1e-7), name


def test_what_friction_never_lets_slip_moves_as_one_body() -> None:
    found = told(rack(friction=1e6))
    alone = rack()
    alone["bodies"] = {"rack": {"mass": f"{sum(MASSES)} kg"}}
    alone["links"] = {"low": alone["links"]["low"]}
    alone["measures"] = {"place": {"response": "displacement", "of": "rack"}}
    assert found["place"] == pytest.approx(told(alone)["place"], rel=1e-12)
    assert found["slip"] == pytest.approx(0.0, abs=1e-15)


@few
@given(hertz=st.floats(0.5, 20.0), friction=st.floats(50.0, 950.0), base=st.booleans())
def test_one_body_has_the_motion_of_its_closed_form(hertz: float, friction: float, base: bool) -> None:
    load = moving(speed=f"{hertz!r} Hz", displacement="50 mm") if base else {"speed": f"{hertz!r} Hz"}
    document = rack(load, ENDS[2], friction, 700.0)
    del document["bodies"]["drawer"], document["links"]["up"], document["measures"]["place"]
    scene = vo.from_dict(document)
    model = pose(scene).model
    for response in scene.measures.values():
        one: Any = form_of(scene, model, response)
        several = RubbingOfSeveral(one.output, one.shaken, one.normalised)
        value = one.value(model, np.zeros(0))
        assert several.value(model, np.zeros(0)) == pytest.approx(value, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("beyond", [1e-4, 1e-6, 1e-8, 1e-10, 1e-13, 1e-15, -1e-15])
@pytest.mark.parametrize("hertz", [0.7, 5.6])
def test_one_body_that_friction_all_but_holds_has_the_motion_of_its_closed_form(hertz: float, beyond: float) -> None:
    """Slip is of second order in what is beyond friction, and rounding where that is next to nothing."""
    document = rack({"speed": f"{hertz!r} Hz"}, ENDS[2], 1e3 * (1.0 - beyond), 4.0)
    del document["bodies"]["drawer"], document["links"]["up"], document["measures"]["place"]
    scene = vo.from_dict(document)
    model = pose(scene).model
    one: Any = form_of(scene, model, scene.measures["slip"])
    several = RubbingOfSeveral(one.output, one.shaken, one.normalised)
    value = several.value(model, np.zeros(0))
    assert value == pytest.approx(one.value(model, np.zeros(0)), rel=1e-6, abs=1e-17)
    assert value <= 10.0 * max(beyond, 0.0) * 1e3 / LOW + 1e-17
    told(document)


@pytest.mark.parametrize("beyond", [1e-4, 1e-6, 1e-7, 1e-9, 1e-12, 1e-14, 1e-15, -1e-15])
@pytest.mark.parametrize(("ends", "hertz"), [(ENDS[0], 3.0), (ENDS[2], 33.0)])
def test_what_friction_all_but_holds_is_told_alike_by_both_routes(
    ends: tuple[str, str], hertz: float, beyond: float
) -> None:
    for load in ({"speed": f"{hertz!r} Hz"}, moving(speed=f"{hertz!r} Hz")):
        scene = vo.from_dict(rack(load, ends, 1.0, 50.0))
        model = pose(scene).model
        form = form_of(scene, model, scene.measures["slip"])
        assert isinstance(form, RubbingOfSeveral)
        [holds] = 1.0 / form.grasp(model, np.zeros(0), np.array([2.0 * np.pi * hertz]))
        told(rack(load, ends, float(holds) * (1.0 - beyond), 50.0))


def test_the_last_digit_of_friction_that_all_but_holds_moves_nothing() -> None:
    speed, found = 2.0 * np.pi * 33.0, list[float]()
    for digit in range(-12, 13):
        scene = vo.from_dict(rack(moving(speed="33 Hz"), ENDS[2], 22897.3844291253925 * (1.0 + 2.2e-16 * digit), 50.0))
        model = pose(scene).model
        form = form_of(scene, model, scene.measures["fast"])
        assert isinstance(form, RubbingOfSeveral)
        found.append(form.at(model, np.zeros(0), speed))
    assert found == pytest.approx([found[0]] * len(found), rel=1e-11)


@few
@given(
    ends=st.sampled_from(ENDS),
    hertz=st.floats(1.0, 20.0),
    friction=st.floats(20.0, 600.0),
    damping=st.one_of(st.just(0.0), st.floats(1e-20, 3e3)),
)
@example(ends=ENDS[0], hertz=8.0, friction=300.0, damping=0.0)
def test_in_a_cycle_the_force_does_what_friction_and_dampers_take(
    ends: tuple[str, str], hertz: float, friction: float, damping: float
) -> None:
    """And it closes, and what slips does so against its friction."""
    motion = motion_of(rack({"speed": f"{hertz!r} Hz"}, ends, friction, damping), "slip", hertz)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    at, work, lost = basis(0.5 * (nodes + 1.0)), 0.0, 0.0
    for piece in motion.half_cycle:
        rates, part = piece.law.speeds[1] @ piece.states @ at, 0.5 * piece.length * weights
        push = motion.loads @ piece.states[-2:-1] @ at
        work += float((push * rates).sum(axis=0) @ part)
        damped = np.einsum("it,ij,jt->t", rates, motion.damping, rates)
        lost += float((damped + friction * np.abs(rates[0])) @ part)
        slips = rates[0] @ np.eye(len(part))
        assert (piece.side * slips >= -1e-9 * np.abs(slips).max(initial=1e-12)).all()
        if not piece.side:
            assert (np.abs(piece.law.carries @ piece.states @ basis(NODES)) <= friction * (1.0 + 1e-9)).all()
    assert work == pytest.approx(lost, rel=1e-9, abs=1e-12)
    first, last = motion.half_cycle[0].start, motion.half_cycle[-1].states.sum(axis=1)
    own = [0, 1, 3, 4]
    assert last[own] == pytest.approx(-first[own], rel=1e-9, abs=1e-12 * float(np.abs(first).max()))


def test_over_a_range_nothing_is_greater_than_what_is_found_and_the_figures_show_it() -> None:
    """A grid of the same motion, and a picture of the response against speed and over a cycle."""
    document = rack({"speed": "5.6..6.6 Hz"}, friction=300.0)
    document["measures"] = {name: document["measures"][name] for name in ("slip",)}
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met"
    scene = answer.scene
    model = pose(scene).model
    for name, row in answer.measures.items():
        form: Any = form_of(scene, model, scene.measures[name])
        values = form.sizes(model, np.zeros(0), 2.0 * np.pi * np.linspace(5.6, 6.6, 12))
        assert row.value.value >= values.max() * (1.0 - 1e-9)
    drawn = panels(answer)
    assert [panel.title.endswith("Hz") for panel in drawn] == [False, True]
    for against in drawn[::2]:
        assert max(against.curves[0].y) == pytest.approx(against.marks[0].y, rel=1e-6)


def test_what_nothing_damps_is_said_where_no_motion_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the resonance of two bodies that friction between ground and one of them cannot bound, with less patience."""
    monkeypatch.setattr("vibopt.verify.repeating._MOST", 60)
    hertz = float(np.sqrt(np.linalg.eigvalsh([[(LOW + UP) / 180.0, -UP / np.sqrt(7200.0)],
                                              [-UP / np.sqrt(7200.0), UP / 40.0]])[0]) / 2.0 / np.pi)  # fmt: skip
    document = rack({"speed": f"{hertz!r} Hz"}, ENDS[2], 20.0, 0.0)
    with pytest.raises(vo.InputError) as said:
        vo.solve(vo.from_dict(document))
    assert "What rubs comes to no steady motion within 600 half cycles" in str(said.value)


def test_a_slip_as_long_as_rounding_is_no_jump_of_the_acceleration() -> None:
    """Half a cycle may begin within a hold: what holds there has the acceleration of the base."""
    document: dict[str, Any] = {
        "bases": {"floor": {}},
        "bodies": {"a": {"mass": "43.49 kg"}, "b": {"mass": "102.42 kg"}, "c": {"mass": "164.24 kg"}},
        "links": {
            "l0": {"between": ["a", "floor"], "stiffness": "5531745 N/m", "damping": "8668.8 N s/m",
                   "friction_force": "215.69 N"},
            "l1": {"between": ["b", "a"], "stiffness": "1841408 N/m", "damping": "355 N s/m"},
            "l2": {"between": ["c", "b"], "stiffness": "767978 N/m", "damping": "1422.8 N s/m"},
            "l3": {"between": ["c", "floor"], "stiffness": "229343 N/m", "damping": "1244.3 N s/m"},
        },
        "excitations": {
            "e": {"kind": "base_motion", "on": "floor", "displacement": "0.515 mm", "speed": "913.33 rpm"}
        },
        "measures": {"fast": {"response": "acceleration", "of": "a"}},
    }  # fmt: skip
    assert told(document)["fast"] == pytest.approx(0.515e-3 * (913.33 * np.pi / 30.0) ** 2, rel=1e-6)
