"""Dry friction: Den Hartog's formula, an integration from event to event, energy, limits, units, words of refusal."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import cos, cosh, pi, sin, sinh, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from vibopt.mechanics.dry_friction import Piece, Rub
from vibopt.mechanics.slipping import Slipping, edges
from vibopt.report.curves import panels
from vibopt.solve import loosen, solve
from vibopt.verify.as_built import machine_of
from vibopt.verify.stick_slip import Rubbed

few = settings(derandomize=True, database=None, deadline=None, max_examples=40)
PLACE = (1.0, 0.0, 0.0)
ratios = st.one_of(st.just(0.0), st.floats(1e-3, 3.0))


def den_hartog(r: float, ratio: float, f: float) -> float:
    """Amplitude over the static deflection of a motion without stops (1931), the damper beside."""
    ring = sqrt(1.0 - ratio**2)
    below = cosh(ratio * pi / r) + cos(ring * pi / r)
    g = (sinh(ratio * pi / r) - ratio / ring * sin(ring * pi / r)) / below
    h = sin(ring * pi / r) / (r * ring) / below
    return sqrt(1.0 / ((1.0 - r**2) ** 2 + (2.0 * ratio * r) ** 2) - (h * f) ** 2) - g * f


@few
@given(r=st.floats(0.7, 4.0), ratio=st.one_of(st.just(0.0), st.floats(1e-3, 0.95)), f=st.floats(0.01, 0.6))
def test_without_stops_it_is_den_hartogs_formula(r: float, ratio: float, f: float) -> None:
    assume(abs(r - 1.0) > 1e-3)
    rub = Rub(r, ratio, f)
    half = rub.half_cycle
    assert half is not None
    if len(half) == 1:
        assert rub.greatest(PLACE, 0j) == pytest.approx(den_hartog(r, ratio, f), rel=1e-9)


@pytest.mark.parametrize(("r", "f", "printed"), [(0.5, 0.0, 4 / 3), (2.0, 0.5, 0.2205), (1.0, 0.8, 0.2994)])
def test_undamped_examples(r: float, f: float, printed: float) -> None:
    """Den Hartog's V and U: sqrt(V^2 - (f U)^2) with V = 1 / (1 - r^2), U = tan(pi / 2 r) / r; at 1 it stops."""
    found = Rub(r, 0.0, max(f, 1e-12)).greatest(PLACE, 0j)
    assert found == pytest.approx(printed, rel=1e-3)
    if r > 1.0:
        assert found == pytest.approx(sqrt((1 - r * r) ** -2 - (f / r * np.tan(pi / 2 / r)) ** 2), rel=1e-12)


@few
@given(r=st.floats(0.06, 5.0), ratio=ratios, f=st.floats(0.02, 0.98))
def test_in_a_cycle_the_force_does_what_friction_and_the_damper_take(r: float, ratio: float, f: float) -> None:
    """And it closes: every piece begins where the one before ends, and the last at the negative of the first."""
    assume(ratio > 0.0 or abs(1.0 / r - round(1.0 / r)) > 1e-3)
    rub = Rub(r, ratio, f)
    half = rub.half_cycle
    assert half is not None
    nodes, weights = np.polynomial.legendre.leggauss(30)
    work = lost = size = 0.0
    for piece in half:
        for low, high in pairwise(edges(rub.poles, piece.length)):
            tau = low + 0.5 * (high - low) * (nodes + 1.0)
            _, v, _ = rub.at(piece, tau)
            part = 0.5 * (high - low) * weights
            work += float(part @ (v * np.cos(piece.begin + tau)))
            lost += float(part @ (f * np.abs(v) + 2.0 * ratio * r * v**2))
            size = max(size, float(np.abs(v).max()))
            assert (piece.side * v >= -1e-10 * max(size, 1e-3)).all()
    assert work == pytest.approx(lost, rel=1e-9, abs=1e-12)
    ends = [rub.at(one, np.array([one.length])) for one in half]
    for (z, v, _), following in zip(ends, half[1:], strict=False):
        assert (z[0], v[0]) == (pytest.approx(following.z, abs=1e-11), pytest.approx(following.v, abs=1e-9))
    assert ends[-1][0][0] == pytest.approx(-half[0].z, rel=1e-9, abs=1e-11)
    for one in half:
        if one.side == 0:
            held = np.cos(one.begin + np.linspace(0.0, one.length, 50)) - one.z
            assert (np.abs(held) <= f * (1.0 + 1e-9)).all()


@few
@given(r=st.floats(0.1, 4.0), ratio=ratios, below=st.integers(1, 60))
@example(r=0.7527324252800529, ratio=0.04330127018922193, below=3)
def test_friction_that_only_rounding_tells_from_the_force_holds(r: float, ratio: float, below: int) -> None:
    """What is left of the force is e = 1 - f, over 2 sqrt(2 e) of the cycle: it slips by less than 8 e^2 / r^2."""
    assert Rub(r, ratio, 1.0 - below * 2.0**-53).greatest(PLACE, 0j) <= 1e-15


@few
@given(r=st.floats(0.1, 4.0), ratio=st.floats(0.01, 2.0))
def test_without_friction_it_is_linear_and_from_the_force_on_it_holds(r: float, ratio: float) -> None:
    linear = 1.0 / abs(1.0 - r**2 + 2j * ratio * r)
    assert Rub(r, ratio, 1e-9).greatest(PLACE, 0j) == pytest.approx(linear, rel=1e-6)
    assert Rub(r, ratio, 1e-9).equivalent(PLACE, 0j) == pytest.approx(linear, rel=1e-6)
    assert Rub(r, ratio, 1.0).greatest(PLACE, 0j) == 0.0
    assert Rub(r, ratio, 1.0).greatest((0.0, 0.0, -(r**2)), 1.0) == pytest.approx(1.0)
    assert Rub(r, ratio, 1.0 - 1e-6).greatest(PLACE, 0j) < 1e-5


def test_an_undamped_resonance_has_an_end_above_a_quarter_of_pi_alone() -> None:
    assert Rub(1.0, 0.0, 0.25 * pi).greatest(PLACE, 0j) == np.inf
    assert Rub(1.0, 0.0, 0.25 * pi + 1e-3).greatest(PLACE, 0j) < 1.0
    assert Rub(1.0, 1e-3, 0.25 * pi).greatest(PLACE, 0j) < 40.0
    near = [Rub(1.0 + gap, 0.0, 0.7).greatest(PLACE, 0j) for gap in (1e-3, 1e-5, 1e-7)]
    assert near[0] < near[1] / 50.0 < near[2] / 2500.0


@few
@given(r=st.floats(0.05, 5.0), ratio=ratios, f=st.floats(0.01, 0.9), order=st.integers(0, 2), turn=st.floats(0.0, 6.0))
def test_many_motions_together_are_greatest_where_dense_instants_are(
    r: float, ratio: float, f: float, order: int, turn: float
) -> None:
    """Where the closed form says that a motion never stops; instants of a half cycle from its first one."""
    many, phasor = Slipping(*(np.array([one, 2.0]) for one in (r, ratio, f))), np.exp(1j * np.array([turn, 0.0]))
    found = float(many.greatest(np.eye(3)[:, [order]] * [-1.3, 1.0], phasor)[0])
    assume(not np.isnan(found))
    begin, top = (float(one[0]) for one in many.tops)
    tau = np.linspace(0.0, pi, 20_001)
    z, v, a = (one[0] for one in many.at(tau[None, :]))
    assert (z[-1], v[0], v[-1]) == (pytest.approx(-top, abs=1e-9), 0.0, pytest.approx(0.0, abs=1e-8))
    assert r**2 * a + 2.0 * ratio * r * v + z - f == pytest.approx(np.cos(begin + tau), abs=1e-9)
    assert v[1:-1].max() < 0.0
    read = -1.3 * (z, v, a)[order] + np.cos(begin + tau + turn)
    assert found == pytest.approx(float(np.abs(read).max()), rel=1e-6)
    assert found >= float(np.abs(read).max()) * (1.0 - 1e-11)


PRESS: dict[str, Any] = {
    "title": "press that rubs",
    "bodies": {"press": {"mass": "300 kg"}},
    "links": {
        "mount": {"between": ["press", "ground"], "stiffness": "300 kN/m", "damping": "500 N s/m",
                  "friction_force": "800 N"},
    },
    "excitations": {
        "load": {"kind": "force", "on": "press", "amplitude": "2 kN", "speed": "5 Hz", "varies": "constant"},
    },
    "measures": {
        "displacement": {"response": "displacement", "of": "press"},
        "velocity": {"response": "velocity", "of": "press"},
        "acceleration": {"response": "acceleration", "of": "press"},
        "travel": {"response": "relative_displacement", "across": "mount"},
        "force": {"response": "transmitted_force", "into": "ground"},
        "through": {"response": "transmitted_force", "through": "mount"},
        "ratio": {"response": "transmissibility", "into": "ground"},
        "friction": {"response": "friction_force", "of": "mount"},
    },
}  # fmt: skip


def changed(*, base: bool = False, load: dict[str, Any] | None = None, **mount: Any) -> dict[str, Any]:
    """The press with another mount or load, on a base that moves by 5 mm."""
    document = {**PRESS, "links": {"mount": {**PRESS["links"]["mount"], **mount}}}
    shaken = PRESS["excitations"]["load"]
    if base:
        document["links"]["mount"]["between"] = ["press", "floor"]
        document["bases"] = {"floor": {}}
        shaken = {"kind": "base_motion", "on": "floor", "displacement": "5 mm", "speed": "5 Hz", "varies": "constant"}
        asked = {**PRESS["measures"], "ratio": {"response": "transmissibility", "of": "press"}}
        document["measures"] = {**asked, "force": {"response": "transmitted_force", "into": "floor"}}
    document["excitations"] = {"load": {**shaken, **(load or {})}}
    return document


def told(document: dict[str, Any]) -> dict[str, float]:
    """Values of the measures; both routes agree on them."""
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    return {name: one.value.value for name, one in answer.measures.items()}


@pytest.mark.sampled(5)
@pytest.mark.parametrize("base", [False, True])
@pytest.mark.parametrize("speed", ["0.6 Hz", "3.5 Hz", "5.03 Hz", "9 Hz"])
@pytest.mark.parametrize("mount", [{}, {"damping": "30 N s/m"}, {"damping": "30 kN s/m", "friction_force": "1.7 kN"}])
def test_every_response_has_one_value_by_both_routes(base: bool, speed: str, mount: dict[str, str]) -> None:
    """The second integrates place and speed from event to event (1e-7), and reads forces off spring and friction."""
    found = told(changed(base=base, load={"speed": speed}, **mount))
    assert found["force"] == pytest.approx(found["through"], rel=1e-9)
    if base:
        assert found["ratio"] == pytest.approx(found["displacement"] / 5e-3, rel=1e-9)
        assert found["force"] == pytest.approx(300.0 * found["acceleration"], rel=1e-7)
    else:
        assert found["ratio"] == pytest.approx(found["force"] / 2000.0, rel=1e-9)
        assert found["travel"] == pytest.approx(found["displacement"], rel=1e-12)


@pytest.mark.slow
@settings(few, max_examples=100)
@given(r=st.floats(0.15, 4.0), ratio=ratios, f=st.floats(0.02, 0.98))
def test_no_integration_finds_another_motion(r: float, ratio: float, f: float) -> None:
    assume(ratio > 1e-3 or abs(1.0 / r - round(1.0 / r)) > 1e-2)
    mount = {"stiffness": "1 N/m", "damping": f"{2.0 * ratio!r} N s/m", "friction_force": f"{f!r} N"}
    document = changed(load={"amplitude": "1 N", "speed": f"{r!r} rad/s"}, **mount)
    told({**document, "bodies": {"press": {"mass": "1 kg"}}})


SIDES = st.sampled_from(("ground", "floor", "wall"))
LINKS = st.tuples(SIDES, st.floats(10.0, 500.0), st.one_of(st.just(0.0), st.floats(0.01, 3.0)), st.booleans())


def beside(
    links: list[tuple[str, float, float, bool]], rubs: int, friction: float, shaken: str, hertz: float
) -> dict[str, Any]:
    """The press on several links, each to one side; number `rubs` rubs, and a force or a side that moves shakes it."""
    document = {**PRESS, "bases": {"floor": {}, "wall": {}}, "links": {}, "measures": {}}
    for i, (side, stiffness, damping, turned) in enumerate(links):
        ends = [side, "press"] if turned else ["press", side]
        link = {"between": ends, "stiffness": f"{stiffness!r} kN/m", "damping": f"{damping!r} kN s/m"}
        document["links"][f"l{i}"] = link | ({"friction_force": f"{friction!r} N"} if i == rubs else {})
        document["measures"][f"through{i}"] = {"response": "transmitted_force", "through": f"l{i}"}
        document["measures"][f"across{i}"] = {"response": "relative_displacement", "across": f"l{i}"}
    asked = {f"into {one}": {"response": "transmitted_force", "into": one} for one in ("press", links[rubs][0])}
    document["measures"] |= asked | {
        one: PRESS["measures"][one] for one in ("displacement", "velocity", "acceleration")
    }
    if shaken != "press":
        moved = {"kind": "base_motion", "on": shaken, "displacement": "2 mm", "varies": "constant"}
        document["excitations"] = {"load": {**moved, "speed": f"{hertz!r} Hz"}}
    else:
        document["excitations"] = {"load": {**PRESS["excitations"]["load"], "speed": f"{hertz!r} Hz"}}
    return document


@settings(few, max_examples=16)
@given(
    links=st.lists(LINKS, min_size=2, max_size=3), rubs=st.integers(0, 1), friction=st.floats(50.0, 1500.0),
    shaken=st.sampled_from(("press", "floor")), hertz=st.floats(2.0, 12.0),
)  # fmt: skip
@example(links=[("ground", 60.0, 0.2, False), ("floor", 200.0, 0.0, True)], rubs=0, friction=150.0, shaken="floor",
         hertz=5.0)  # fmt: skip
def test_links_beside_the_one_that_rubs_are_right_by_both_routes_and_energy_is_kept(
    links: list[tuple[str, float, float, bool]], rubs: int, friction: float, shaken: str, hertz: float
) -> None:
    """To the ground, to what moves, to what does not; per turn what shakes it does what friction and dampers take."""
    assume(shaken == "press" or any(side == shaken for side, *_ in links))
    scene = vo.from_dict(beside(links, rubs, friction, shaken, hertz))
    assert vo.solve(scene).status == "met"
    force, base = (2000.0, 0.0) if shaken == "press" else (0.0, 2e-3)
    rubbed = Rubbed(machine_of(scene, {}), force, base, 2.0 * pi * hertz, shaken)
    half, work, lost = rubbed.steady(), 0.0, 0.0
    assert half is not None
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for one in half:
        for low, high in pairwise(np.linspace(one.begin, one.end, 12)):
            at = low + 0.5 * (high - low) * (nodes + 1.0)
            course, part = rubbed.course(one, at), 0.5 * (high - low) * weights
            rate = {name: points[1] for name, points in course.points.items()} | {"ground": 0.0 * at}
            work += float(part @ (course.forces["press"] * rate["press"]))
            work -= float(part @ (rubbed.machine.force_course(shaken, course) * rate[shaken])) if base else 0.0
            for joint in rubbed.machine.joints:
                slip = rate[joint.ends[1]] - rate[joint.ends[0]]
                lost += float(part @ (joint.damping * slip**2 + joint.friction * np.abs(slip)))
    assert work == pytest.approx(lost, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("base", [False, True])
def test_three_links_side_by_side_are_one(base: bool) -> None:
    """A pad that only rubs, a spring and a damper: as a mount of all three, but for what each of them carries."""
    one = told(changed(base=base))
    document = changed(base=base)
    ends = document["links"]["mount"]["between"]
    document["links"] = {
        "mount": {"between": ends, "friction_force": "800 N"},
        "spring": {"between": ends, "stiffness": "300 kN/m"}, "damper": {"between": ends, "damping": "500 N s/m"},
    }  # fmt: skip
    three = told(document)
    assert three.pop("through") <= 800.0 < one.pop("through")
    assert three == pytest.approx(one, rel=1e-12)


@pytest.mark.parametrize("base", [False, True])
def test_at_rest_the_spring_carries_what_friction_leaves(base: bool) -> None:
    found = told(changed(base=base, load={"speed": "0 Hz"}))
    assert found["displacement"] == pytest.approx(5e-3 if base else 1200.0 / 3e5)
    assert (found["velocity"], found["force"]) == (0.0, pytest.approx(0.0 if base else 2000.0))


def test_units_counts_and_scales_change_nothing() -> None:
    """Twice the force with twice the friction is twice the motion; four mounts of a quarter are one."""
    first = told(PRESS)
    four = changed(count=4, stiffness="75 kN/m", damping="125 N s/m", friction_force="200 N")
    found = told(four)
    assert found["displacement"] == pytest.approx(first["displacement"], rel=1e-9)
    assert (4.0 * found["through"], 4.0 * found["friction"]) == pytest.approx((first["through"], first["friction"]))
    twice = told(changed(load={"amplitude": "4 kN"}, friction_force="1.6 kN"))
    assert twice["displacement"] == pytest.approx(2.0 * first["displacement"], rel=1e-9)
    assert twice["ratio"] == pytest.approx(first["ratio"], rel=1e-9)
    same = told(changed(load={"speed": "300 rpm", "amplitude": "2000 N"}, stiffness="300 N/mm"))
    assert same == pytest.approx(first, rel=1e-12)


def test_a_peak_behind_the_speed_at_which_a_mount_lets_go_is_found_beside_what_holds() -> None:
    """Up to 5.15 Hz it moves with its base by 1 mm, from there on slips: 1.0016 mm at 6.481 Hz, 0.977 mm at 6.55 Hz."""
    mount = {"damping": "100 N s/m", "friction_force": "314.3 N"}
    document = changed(base=True, load={"displacement": "1 mm", "speed": "1..20 Hz"}, **mount)
    document["measures"] = {"moved": {"response": "displacement", "of": "press"}}
    at = changed(base=True, load={"displacement": "1 mm", "speed": "6.4809 Hz"}, **mount)
    found, there = told(document)["moved"], told({**at, "measures": document["measures"]})["moved"]
    assert found == pytest.approx(there, rel=1e-6)
    assert found >= there > 1.0015e-3


def test_limits_that_clash_end_by_counted_work() -> None:
    """Below its natural frequency a force of 2 kN holds or passes on more than 1 kN, whatever rubs."""
    from vibopt.program.pose import pose
    from vibopt.solve.choose import choose, modest

    document = changed(load={"speed": "4 Hz"}, friction_force={"from": "500 N", "to": "1.9 kN"})
    document["limits"] = {"floor": {"response": "transmitted_force", "into": "ground", "at_most": "1 kN"}}
    document["goal"] = {"minimise": "displacement", "of": "press"}
    program = pose(vo.from_dict({name: one for name, one in document.items() if name != "measures"}))
    alone = replace(program, aim=None)
    assert choose(alone, None).name == modest(alone).name == "one_range"
    assert choose(alone, None).solve(alone).status == "infeasible"
    easy = replace(alone, limits=tuple(replace(one, bound=1e5) for one in alone.limits))
    assert choose(easy, None).solve(easy).claim == "a design that meets every limit"


def test_all_that_is_asked_beside_an_answer_on_what_rubs_ends_by_counted_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Over ranges of speeds each is as much as the answer itself: what is left out is named, `thorough` or not."""
    document = changed(load={"speed": "4 Hz"}, friction_force={"from": "500 N", "to": "1.9 kN"})
    document["limits"] = {
        "floor": {"response": "transmitted_force", "into": "ground", "at_most": "1 kN"},
        "moved": {"response": "displacement", "of": "press", "at_most": "1 um"},
    }
    document["goal"] = {"minimise": "velocity", "of": "press"}
    scene = vo.from_dict({name: one for name, one in document.items() if name != "measures"})
    monkeypatch.setattr(loosen, "RUBBED", -1.0)
    answer = vo.explain(scene, thorough=True).answer
    assert (answer.status, answer.nearest is not None) == ("infeasible", True)
    few = "each is an answer of its own, and where something rubs `vibopt explain FILE --thorough` works out only the "
    assert f"The least of floor, moved was not looked for: {few}first few." in answer.notes


def test_a_range_is_no_less_than_any_speed_in_it_and_notes_say_what_equivalent_damping_would() -> None:
    document = changed(load={"speed": "12 Hz"})
    document["measures"] = {"worst": {"response": "displacement", "of": "press", "over": "1..12 Hz"}}
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    worst = answer.measures["worst"].value.value
    for speed in np.linspace(1.0, 12.0, 60):
        push = 2000.0 / 3e5
        rub = Rub(speed * 2.0 * pi / sqrt(1000.0), 500.0 / (2.0 * sqrt(300.0 * 3e5)), 0.4)
        assert rub.greatest((push, 0.0, 0.0), 0j) <= worst * (1.0 + 1e-9)
    assert any(one.startswith("measures.worst: equivalent viscous damping would say ") for one in answer.notes)


def test_an_undamped_resonance_says_what_would_bound_it() -> None:
    document = changed(load={"speed": "300 rpm"})
    del document["links"]["mount"]["damping"]
    document["measures"] = {"d": {"response": "displacement", "of": "press", "over": "100..400 rpm"}}
    answer = vo.solve(vo.from_dict(document))
    assert answer.measures["d"].value.value == np.inf
    assert (
        "At the resonance, 302 rpm, the motion has no end: without viscous damping friction bounds it only above π/4 "
        "of the force, 1.571 kN, and there are 800 N." in answer.notes
    )


def test_the_best_friction_of_one_mount_is_found_and_confirmed() -> None:
    """Base motion at 8 Hz: least transmissibility; every other friction passes on more."""
    document = changed(base=True, load={"speed": "8 Hz"}, friction_force={"from": "50 N", "to": "5 kN"})
    document["limits"] = {"travel": {"response": "relative_displacement", "across": "mount", "at_most": "7 mm"}}
    document["goal"] = {"minimise": "transmissibility", "of": "press"}
    del document["measures"]
    answer = vo.solve(vo.from_dict(document))
    assert answer.status in ("optimal", "feasible"), answer.claim
    assert answer.limits["travel"].margin == pytest.approx(0.0, abs=1e-6)
    assert answer.goal is not None
    for friction in (900.0, 1500.0, 2500.0, 4000.0):
        other = told(changed(base=True, load={"speed": "8 Hz"}, friction_force=f"{friction} N"))
        assert other["travel"] > 7e-3 or other["ratio"] >= answer.goal[1].value * (1.0 - 1e-6)


def test_begun_beside_a_design_another_valley_is_found_as_well() -> None:
    """On three springs instead of four the best are at their softest: 1.776 kN was told of the valley at 81 kN/m."""
    job = vo.read(Path(__file__).parents[2] / "problems" / "friction" / "springs_and_pads.toml")
    three = vo.with_changes(job, {"links.springs.count": 3})
    goals = [solve(three, explain=False, near=near).goal for near in ((73.1e3, 850.0), (81.0e3, 875.0), None)]
    forces = [goal[1].value for goal in goals if goal is not None]
    assert forces == [pytest.approx(1709.949, rel=1e-5)] * 3


def test_the_figure_has_both_curves_and_the_holds() -> None:
    document = changed(load={"speed": "2 Hz"})
    document["measures"] = {"d": PRESS["measures"]["displacement"]}
    against, over = panels(vo.solve(vo.from_dict(document)))
    assert [one.label for one in against.curves] == ["dry friction", "equivalent viscous"]
    assert [one.label for one in over.curves] == ["slips", "held by friction"]
    assert np.isfinite(over.curves[1].y).any()
    assert np.isnan(over.curves[1].y).any()
    assert np.nanmax(over.curves[0].y) == pytest.approx(against.marks[0].y, rel=1e-9)


@pytest.mark.parametrize(
    ("share", "begins"),
    [
        *((share, None) for share in (0.0, 0.375, 0.9)),
        *(pytest.param(share, "suddenly", marks=pytest.mark.slow) for share in (0.0, 0.375, 0.9)),
    ],
)
def test_frictions_between_the_same_two_ends_add(share: float, begins: str | None) -> None:
    """As one link with the sum, on whichever of them it stands and in whichever order the ends are named."""
    sort = "peak_" if begins else ""
    asked = {
        "d": {"response": f"{sort}displacement", "of": "press"},
        "f": {"response": "peak_force" if begins else "transmitted_force", "into": "ground"},
    }
    load = PRESS["excitations"]["load"] | ({"begins": begins} if begins else {})
    pads = {
        "pad": {"between": ["ground", "press"], "friction_force": f"{800.0 * share!r} N"},
        "shoe": {"between": ["press", "ground"], "friction_force": f"{200.0 * (1.0 - share)!r} N", "count": 4},
    }
    spring = {"between": ["press", "ground"], "stiffness": "300 kN/m"}
    alone = {"links": {"mount": {**spring, "friction_force": "800 N"}}}
    several = {"links": {"pad": pads["pad"], "mount": spring, "shoe": pads["shoe"]}}
    found = [
        vo.solve(vo.from_dict(PRESS | {"excitations": {"load": load}, "measures": asked} | links))
        for links in (alone, several)
    ]
    assert [one.status for one in found] == ["met", "met"]  # by both routes
    one, other = ({name: row.value.value for name, row in answer.measures.items()} for answer in found)
    assert other == pytest.approx(one, rel=1e-9)


LINK = {"between": ["press", "ground"], "stiffness": "300 kN/m", "friction_force": "800 N"}
LOAD = PRESS["excitations"]["load"]
PULSE = {"kind": "pulse", "on": "press", "shape": "half sine", "amplitude": "1 kN", "duration": "20 ms"}
_OTHERS = "Ask for a steady displacement, force or transmissibility, or write damping instead of the friction."
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no stiffness": (
        {"links": {"mount": {"between": ["press", "ground"], "friction_force": "800 N"}}},
        "links.mount has a friction_force but no stiffness that brings it back: it slips away, and where it stays "
        'nobody knows. Add stiffness = "200 kN/m".',
    ),
    "loss factor": (
        {"links": {"mount": {**LINK, "loss_factor": 0.1}}},
        "links.mount gives friction_force and loss_factor, which knows harmonic motion only, and a motion that rubs is "
        "not harmonic. Write damping or damping_ratio beside the friction.",
    ),
    "two links": (
        {"bodies": PRESS["bodies"] | {"cart": {"mass": "10 kg"}},
         "links": {"mount": LINK, "other": {**LINK, "between": ["press", "cart"]}}},
        "links.mount.friction_force rubs beside links.other: where friction holds, what it joins moves as one, and "
        "which of several hold changes in every cycle. Dry friction is answered between one pair of ends that move "
        "along a line, beside links and absorbers that do not rub.",
    ),
    "which of both carries what": (
        {"links": {"mount": LINK, "pad": {"between": ["ground", "press"], "friction_force": "1 N"}},
         "measures": {"f": {"response": "transmitted_force", "through": "pad"}}},
        "measures.f.through: links.mount and links.pad rub between the same two ends: they slip together, and only the "
        "sum of their friction is known to act. Ask for the force into a place, or give the friction of all to "
        "links.mount.",
    ),
    "loss factor beside it": (
        {"links": {"mount": LINK, "other": {"between": ["press", "ground"], "stiffness": "1 N/m", "loss_factor": 1}}},
        "links.mount.friction_force rubs beside links.other.loss_factor, which knows harmonic motion only, and a "
        "motion that rubs is not harmonic. Write damping or damping_ratio there.",
    ),
    "two loads": (
        {"excitations": {"load": LOAD, "second": LOAD}},
        "links.mount.friction_force rubs under excitations.load and excitations.second. The sum of both decides when "
        "it slips, so that their motions do not add. Keep one of them.",
    ),
    "harmonics": (
        {"excitations": {"load": {"kind": "harmonics", "on": "press", "speed": "5 Hz", "harmonics": [
            {"order": 1, "amplitude": "1 kN"}, {"order": 2, "amplitude": "1 kN"}]}}},
        "links.mount.friction_force rubs under the harmonics of excitations.load. All of them together decide when it "
        'slips, so that their motions do not add. Write the greatest alone: kind = "force".',
    ),
    "noise": (
        {"excitations": {"load": {"kind": "white_noise", "on": "press", "density": "1 N²/Hz"}}},
        "links.mount.friction_force rubs under the white noise of excitations.load. Dry friction is answered in steady "
        "vibration under one harmonic, and under what comes once. Write damping or damping_ratio, or another "
        "excitation.",
    ),
    "unknown duration": (
        {"excitations": {"load": {"kind": "pulse", "on": "press", "shape": "sine", "amplitude": "1 kN",
                                  "duration_up_to": "1 s"}}},
        "links.mount.friction_force rubs under a pulse of unknown duration, excitations.load: which is the worst is "
        'known of linear motion alone. Write duration = "20 ms", and look at others with vibopt sweep.',
    ),
    "a step": (
        {"excitations": {"load": {"kind": "pulse", "on": "press", "shape": "step", "amplitude": "1 kN"}}},
        "links.mount.friction_force rubs under excitations.load, which stays for ever. Dry friction is answered under "
        'what ends: write shape = "rectangle" and a duration that is long enough for it to come to rest.',
    ),
    "sum of peaks": (
        {"excitations": dict.fromkeys(("load", "second"), PULSE),
         "measures": {"d": {"response": "peak_force", "into": "ground", "combine": "sum"}}},
        "measures.d: with links.mount.friction_force, peak_force of one excitation is no part of that of several, for "
        "all together decide when it slips. Leave combine out: then all act together, from one beginning.",
    ),
    "run-up": (
        {"excitations": {"load": {**LOAD, "run_up": {"from": "1 Hz", "to": "9 Hz", "acceleration": "1 Hz/s"}}}},
        "links.mount.friction_force rubs under the run-up of excitations.load. Dry friction is answered in steady "
        "vibration under one harmonic, and under what comes once. Write damping or damping_ratio, or another "
        "excitation.",
    ),
    "pulse beside a vibration": (
        {"excitations": {"load": LOAD, "second": PULSE}},
        "links.mount.friction_force rubs under excitations.load and excitations.second. The sum of both decides when "
        "it slips, so that their motions do not add. Keep one of them.",
    ),
    "decay": (
        {"measures": {"d": {"response": "decay_rate"}}},
        "measures.d: with links.mount.friction_force, decay_rate speaks of linear motion, and what rubs does not move "
        f"linearly. {_OTHERS}",
    ),
    "jerk": (
        {"measures": {"d": {"response": "jerk", "of": "press"}}},
        "measures.d: with links.mount.friction_force, jerk is infinite, for friction turns at once where the slip "
        f"does. {_OTHERS}",
    ),
    "sag": (
        {"measures": {"d": {"response": "static_deflection", "of": "press"}}},
        "measures.d: with links.mount.friction_force, static_deflection is not known, for friction holds the weight "
        f"anywhere near where the spring would. {_OTHERS}",
    ),
    "unknown amplitude": (
        {
            "excitations": {"load": {"kind": "force", "on": "press", "amplitude": "2 kN", "speed": "5 Hz"}},
            "measures": {"d": {"response": "transmissibility", "into": "ground", "over": "1..9 Hz"}},
        },
        "measures.d looks at speeds other than those of excitations.load: how does its amplitude vary? Add varies = "
        '"constant" or varies = "speed^2" to excitations.load.',
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_has_no_answer_with_friction_is_refused(name: str) -> None:
    change, message = WRONG[name]
    assert f"scene: {message}" in refused(vo.from_dict, {**PRESS, **change}).messages


def test_no_friction_is_a_linear_machine() -> None:
    linear = changed()
    del linear["links"]["mount"]["friction_force"], linear["measures"]["friction"]
    rest = {**linear, "links": {"mount": {**linear["links"]["mount"], "friction_force": "0 N"}}}
    assert told(rest) == pytest.approx(told(linear), rel=1e-14)


@pytest.mark.parametrize(
    ("friction", "speed"),
    [("399.99 N", "700 rpm"), ("399.9999999 N", "700 rpm"), pytest.param("150 N", "5 rpm", marks=pytest.mark.slow)],
)
def test_both_routes_agree_at_the_edge_of_holding_and_where_it_slips_slowly(friction: str, speed: str) -> None:
    """A motion of a picometre is beside what the spring gives nothing; one slow slip has dozens of tops alike."""
    assert vo.solve(vo.from_dict(undamped(friction, speed))).status == "met"


@pytest.mark.parametrize(
    ("friction", "speed"),
    [
        pytest.param(friction, speed, marks=[pytest.mark.slow] * ((friction, speed) == ("314 N", "584.4 rpm")))
        for friction in ("308 N", "314 N", "314.3 N", "330 N")
        for speed in ("584.4 rpm", "585.1 rpm")
    ],
)
def test_both_routes_agree_where_friction_hardly_ends_a_resonance(friction: str, speed: str) -> None:
    """About pi / 4 of the force each half cycle differs from that before by nearly the same, for thousands of them."""
    assert vo.solve(vo.from_dict(undamped(friction, speed))).status == "met"


def undamped(friction: str, speed: str) -> dict[str, Any]:
    """A pump of 80 kg whose mount rubs, tuned to 584.77 rpm."""
    return {
        "title": "edge",
        "bodies": {"pump": {"mass": "80 kg"}},
        "links": {"mount": {"between": ["pump", "ground"], "stiffness": "300 kN/m", "friction_force": friction}},
        "excitations": {
            "f": {"kind": "force", "on": "pump", "amplitude": "400 N", "speed": speed, "varies": "constant"}
        },
        "measures": {
            "travel": {"response": "displacement", "of": "pump"},
            "acceleration": {"response": "acceleration", "of": "pump"},
        },
    }


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 1.0000001, 5.0])
@pytest.mark.parametrize("r", [0.05, 1.0, 30.0])
def test_one_time_alone_has_the_place_and_speed_of_many(r: float, ratio: float) -> None:
    """Next to critical damping by a series, far from it by a quotient: the same in both roads."""
    rub, taus = Rub(r, ratio, 0.3), np.array([1e-9, 1e-3, 0.4, 2.0, np.pi])
    for piece in (Piece(0.7, np.pi, 1.3, -0.4, -1), Piece(2.0, np.pi, 0.2, 0.0, 0)):
        for found, tau in zip(np.transpose(rub.at(piece, taus)), taus, strict=True):
            assert rub.now(piece, float(tau)) == pytest.approx(found, rel=1e-11, abs=1e-12 / r**2)


@pytest.mark.parametrize(("friction", "most"), [(0.8, 10), (0.8236, 10), (0.85, 35), (0.9, 35)])
def test_a_motion_that_hardly_stops_near_the_resonance_closes_within_few_half_cycles(
    friction: float, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It begins at Den Hartog's motion; from rest it took up to 37, and where two motions nearly meet up to 210."""
    asked: list[float] = []
    follow = Rub._half
    monkeypatch.setattr(Rub, "_half", lambda rub, state: (asked.append(rub.r), follow(rub, state))[1])
    for r in np.linspace(0.55, 0.86, 17).tolist():
        assert Rub(r, 0.0, friction).half_cycle is not None
        assert asked.count(r) <= most, r


def test_limits_over_a_range_that_no_friction_keeps_are_told_within_little_work() -> None:
    """Undamped, the least of each limit has a kink wherever its speed changes: looking for it is bounded."""
    document = {
        "title": "no friction does",
        "bodies": {"press": {"mass": "300 kg"}},
        "links": {
            "mount": {
                "between": ["press", "ground"],
                "stiffness": "300 kN/m",
                "friction_force": {"from": "100 N", "to": "5 kN"},
            }
        },
        "excitations": {
            "it": {"kind": "force", "on": "press", "amplitude": "3 kN", "speed": "1500 rpm", "varies": "constant"}
        },
        "limits": {
            "start_up": {"response": "displacement", "of": "press", "over": "0..1500 rpm", "at_most": "5 mm"},
            "floor": {"response": "transmitted_force", "into": "ground", "at_most": "1 kN"},
        },
        "goal": {"minimise": "friction_force", "of": "mount"},
    }
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "infeasible"
    assert answer.conflict is not None
    assert answer.conflict.limits == ("start_up", "floor")
    assert answer.conflict.left == ("floor",)
    words = (
        "each is an answer of its own, and where something rubs `vibopt explain FILE --thorough` works out only the "
    )
    assert f"No loosening of floor was looked for: {words}first few." in answer.notes
    assert answer.work < 100_000.0


def test_what_friction_holds_on_the_ground_does_not_move_at_all() -> None:
    document = {
        "title": "held",
        "bodies": {"box": {"mass": "234.454 kg"}},
        "links": {"feet": {"between": ["box", "ground"], "stiffness": "20793.8 N/m", "friction_force": "1700 N"}},
        "excitations": {"it": {"kind": "force", "on": "box", "amplitude": "1672.43 N", "speed": "4.79316 Hz"}},
        "measures": {
            kind: {"response": kind, "of": "box"} for kind in ("displacement", "velocity", "acceleration")
        },
    }  # fmt: skip
    answer = vo.solve(vo.from_dict(document))
    assert [one.value.value for one in answer.measures.values()] == [0.0, 0.0, 0.0]


def test_what_friction_holds_on_a_moving_base_has_moved_by_nothing_at_all() -> None:
    document = {
        "title": "held",
        "bases": {"floor": {}},
        "bodies": {"box": {"mass": "10 kg"}},
        "links": {"feet": {"between": ["box", "floor"], "stiffness": "10 kN/m", "friction_force": "60 N"}},
        "excitations": {"it": {"kind": "base_motion", "on": "floor", "acceleration": "5 m/s²", "speed": "7.3 Hz"}},
        "measures": {
            "rattle": {"response": "relative_displacement", "across": "feet"},
            "force": {"response": "transmitted_force", "into": "floor"},
        },
    }
    answer = vo.solve(vo.from_dict(document))
    assert answer.measures["rattle"].value.value == 0.0
    assert answer.measures["force"].value.value == pytest.approx(50.0, rel=1e-9)


def slow(speed: str, **feet: str) -> dict[str, Any]:
    """A pump that is pushed slowly beside its own vibration of 4.4 Hz."""
    return {
        "bodies": {"pump": {"mass": "400 kg"}},
        "links": {"feet": {"between": ["pump", "ground"], "stiffness": "300 kN/m", "friction_force": "500 N", **feet}},
        "excitations": {"push": {"kind": "force", "on": "pump", "amplitude": "2 kN", "speed": speed}},
        "limits": {"way": {"response": "displacement", "of": "pump", "at_most": "15 mm"}},
        "measures": {"fast": {"response": "velocity", "of": "pump"}},
    }


@pytest.mark.parametrize("speed", ["0.3 rpm", "1e-4 rpm"])
def test_a_slow_slip_rings_until_dampers_end_it_and_both_routes_follow_that(speed: str) -> None:
    """Springs carry all but friction; the speed has its greatest while what the release set ringing is there."""
    answer = vo.solve(vo.from_dict(slow(speed, damping="2 kN s/m")))
    assert answer.status == "met", answer.claim
    omega = answer.limits["way"].worst_at["push"].value
    quasi = (2000.0 - 500.0) / 300e3
    assert answer.limits["way"].value.value == pytest.approx(quasi, rel=1e-4)
    assert 1.01 < answer.measures["fast"].value.value / (2000.0 / 300e3 * omega) < 2.0


@pytest.mark.parametrize(("speed", "times", "way"), [
    ("1e-9 rpm", "2.6e+11", "0.1383 rpm or more, or more damping."),
    ("0.01 rpm", "2.6e+04", "0.1383 rpm or more, or more damping."),
])  # fmt: skip
def test_a_turn_that_is_endless_beside_the_vibration_ends_in_words(speed: str, times: str, way: str) -> None:
    """Undamped, every slip rings on for ever: at 1e-9 rpm there would be 1e12 steps."""
    with pytest.raises(vo.InputError) as said:
        vo.solve(vo.from_dict(slow(speed)))
    assert str(said.value) == (
        f"excitations.push at {speed}: what rubs vibrates by itself {times} times in a turn of it, more than is "
        f'followed. Write speed = "0 rpm", where springs and friction carry all, {way}'
    )


def test_what_only_one_route_finds_is_not_known_and_no_limit_of_it_is_met(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Rubbed, "steady", lambda _: None)
    answer = vo.solve(vo.from_dict(slow("300 rpm")))
    assert answer.status == "check_failed"
    assert (answer.limits["way"].value.shown, answer.limits["way"].state) == ("not known", "OPEN")


def test_find_all_of_a_friction_force_is_refused_with_the_way_to_its_window() -> None:
    document = changed(load={"speed": "300 rpm"}, friction_force={"from": "10 N", "to": "500 N"})
    document["limits"] = {"moved": {"response": "displacement", "of": "press", "at_most": "2 mm"}}
    document["goal"] = {"find_all": "links.mount.friction_force"}
    with pytest.raises(vo.InputError) as error:
        vo.from_dict(document)
    assert (
        "goal.find_all finds all values at which a linear machine keeps its limits, but links.mount.friction_force "
        "rubs. Write a goal with minimise or maximise instead: vibopt window FILE then tells what is permitted."
    ) in str(error.value)


def test_equivalent_damping_is_of_the_machine_as_said_where_there_are_tolerances() -> None:
    document = changed(load={"speed": "300 rpm"})
    document["measures"] = {"d": {"response": "displacement", "of": "press"}}
    as_said = vo.solve(vo.from_dict(document)).measures["d"].value.shown
    document["links"]["mount"] = {**document["links"]["mount"], "tolerance": "5 %"}
    [note] = [one for one in vo.solve(vo.from_dict(document)).notes if "equivalent viscous" in one]
    own = as_said.removesuffix(" pk")
    assert note.startswith(f"measures.d: of the machine as said, without tolerances, which has {own}, equivalent")
