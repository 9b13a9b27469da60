"""Run-ups of rotors: closed forms without gyroscopic moments, slow limits, turned bearings, and the second route."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from refusals import refused
from vibopt.arrays import FloatArray
from vibopt.forms.peak_in_time import matrices, reading
from vibopt.mechanics.model import Model
from vibopt.mechanics.rotating import RotatingMachine
from vibopt.mechanics.spinning_up import SpinUp
from vibopt.mechanics.sweep_response import RunUp
from vibopt.program.pose import form_of, pose
from vibopt.report.run_up_notes import run_up_notes
from vibopt.responses import TransientResponse
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.signals import Output, Sweep
from vibopt.solve import solve
from vibopt.verify.certify import machine_of
from vibopt.verify.spun_up import SpunUp

FREE: FloatArray = np.zeros(0)
SPRING = {"stiffness": "8 MN/m", "damping": "9 kN s/m"}
FILM = [
    {"speed": "200 rpm", "k_yy": "6 MN/m", "k_yz": "2 MN/m", "k_zy": "-1 MN/m", "k_zz": "11 MN/m", "c_yy": "20 kN s/m",
     "c_zz": "30 kN s/m"},
    {"speed": "2000 rpm", "k_yy": "5 MN/m", "k_yz": "1 MN/m", "k_zy": "-1 MN/m", "k_zz": "9 MN/m", "c_yy": "12 kN s/m",
     "c_zz": "20 kN s/m"},
    {"speed": "6000 rpm", "k_yy": "5 MN/m", "k_yz": "0 MN/m", "k_zy": "0 MN/m", "k_zz": "8 MN/m", "c_yy": "8 kN s/m",
     "c_zz": "15 kN s/m"},
]  # fmt: skip


def rotor(run: dict[str, Any] | None = None, table: list[dict[str, str]] | None = None, **changed: Any) -> Scene:
    """A disc that hangs over, in two bearings, of which the one beside it may be a table."""
    held = {"between": ["near", "ground"]}
    document: dict[str, Any] = {
        "title": "rotor that runs up",
        "rotors": {"shaft": {
            "modulus": "207 GPa", "density": "7850 kg/m3",
            "sections": [{"length": "500 mm", "diameter": "60 mm"}, {"length": "300 mm", "diameter": "50 mm"}],
            "stations": {"far": "0 mm", "near": "500 mm"},
            "discs": [
                {"name": "disc", "at": "800 mm", "mass": "60 kg", "diametral": "1.5 kg m2", "polar": "2.4 kg m2"},
            ],
        }},
        "links": {"far_bearing": {"between": ["far", "ground"], **SPRING}},
        "excitations": {"lost": {
            "kind": "unbalance", "on": "disc", "unbalance": "5 g m", "speed": "4000 rpm",
            "run_up": run or {"from": "300 rpm", "acceleration": "200 rpm/s"},
        }},
        "measures": {
            "whirl": {"response": "peak_displacement", "of": "disc"},
            "force": {"response": "peak_force", "into": "ground"},
        },
    }  # fmt: skip
    if table is None:
        document["links"]["near_bearing"] = {**held, **SPRING}
    else:
        document["bearings"] = {"near_bearing": {**held, "table": table}}
    for path, value in changed.items():
        family, name, key = path.split("__")
        document[family][name][key] = value
    return from_dict(document)


def spun_up(scene: Scene, model: Model, sweep: Sweep, power: int = 0) -> tuple[SpinUp, Output]:
    output = Output(model.points["disc"], np.zeros(len(model.terms)), power)
    return SpinUp(model, FREE, output, model.points["disc"], sweep), output


def evenly(low: float, high: float, rate: float) -> Sweep:
    """An unbalance of 1 kg m from one speed to another [rad/s]."""
    rate = rate if high > low else -rate
    return Sweep((low, high), (rate,), (np.array([-1j * rate, 0.0, 1.0]),), (low**2, high**2))


@pytest.mark.parametrize(("low", "high", "power"), [(30.0, 400.0, 0), (400.0, 30.0, 0), (30.0, 400.0, 2)])
def test_without_gyroscopic_moments_it_is_the_closed_form(low: float, high: float, power: int) -> None:
    scene = rotor()
    whole = pose(scene).model
    model = replace(whole, terms=tuple(term for term in whole.terms if not term.polar))
    sweep = evenly(low, high, 40.0)
    spinning, output = spun_up(scene, model, sweep, power)
    p = model.values(FREE)
    closed = RunUp(*matrices(model, p), model.n_free, model.points["disc"], sweep)
    expected = closed.peak(reading(model, output, p))
    found = spinning.peak()
    assert found.value == pytest.approx(expected.value, rel=1e-7)
    assert found.time == pytest.approx(expected.time, rel=1e-4)
    times = np.linspace(0.2, 0.9, 7) * sweep.times[-1]
    assert spinning.history(None, times) == pytest.approx(
        closed.history(reading(model, output, p), times), rel=1e-4, abs=1e-6 * expected.value
    )


def test_gyroscopic_moments_move_the_passage_up() -> None:
    scene = rotor()
    whole = pose(scene).model
    without = replace(whole, terms=tuple(term for term in whole.terms if not term.polar))
    sweep = evenly(30.0, 400.0, 5.0)
    speeds = [sweep.at(np.array(spun_up(scene, one, sweep)[0].peak().time)) for one in (without, whole)]
    assert speeds[1] > 1.05 * speeds[0]


@pytest.mark.parametrize("table", [None, FILM])
def test_slow_run_ups_are_steady(table: list[dict[str, str]] | None) -> None:
    scene = rotor(table=table)
    model = pose(scene).model
    off = []
    for rate in (2.0, 0.5):
        spinning, _ = spun_up(scene, model, evenly(30.0, 300.0, rate))
        steady = spinning.steady(None, np.linspace(30.0, 300.0, 2001)).max()
        off.append(abs(spinning.peak().value / steady - 1.0))
    assert off[0] < 5e-3
    assert off[1] < 0.3 * off[0] + 1e-6


def test_a_bearing_alike_in_both_planes_drives_no_backward_whirl() -> None:
    alike = [{"speed": f"{at} rpm", "k_yy": "8 MN/m", "k_zz": "8 MN/m", "c_yy": "9 kN s/m", "c_zz": "9 kN s/m"}
             for at in (0, 9000)]  # fmt: skip
    sweep = evenly(30.0, 400.0, 40.0)
    circle, both = (spun_up(scene, pose(scene).model, sweep)[0] for scene in (rotor(), rotor(table=alike)))
    assert both.peak().value == pytest.approx(circle.peak().value, rel=1e-8)
    assert max(np.abs(seen[1]).max() for seen in both._course.seen) <= 1e-12 * both.peak().value


def test_a_machine_may_be_turned_by_a_quarter() -> None:
    """What was level is upward: the same whirl."""
    pairs = {"k_yy": "k_zz", "k_zz": "k_yy", "c_yy": "c_zz", "c_zz": "c_yy"}
    turned = [{pairs.get(key, key): value for key, value in row.items() if key not in ("k_yz", "k_zy")} for row in FILM]
    for row, old in zip(turned, FILM, strict=True):  # z turns to -y
        row["k_yz"], row["k_zy"] = (f"{-float(old[key].split()[0])} MN/m" for key in ("k_zy", "k_yz"))
    sweep = evenly(30.0, 400.0, 40.0)
    scenes = rotor(table=FILM), rotor(table=turned)
    one, other = (spun_up(scene, pose(scene).model, sweep)[0].peak() for scene in scenes)
    assert other.value == pytest.approx(one.value, rel=1e-9)


@pytest.mark.parametrize(
    ("run", "table", "changed"),
    [
        (None, None, {"links__far_bearing__rotating_damping": "6 kN s/m"}),
        pytest.param({"from": "4000 rpm", "to": "300 rpm", "duration": "6 s"}, FILM, {}, marks=pytest.mark.slow),
        ({"acceleration": "900 rpm/s"}, None, {"rotors__shaft__material_damping": "0.00002 s"}),
    ],
)
def test_both_routes_agree(
    run: dict[str, Any] | None, table: list[dict[str, str]] | None, changed: dict[str, str]
) -> None:
    scene = rotor(run, table, **changed)
    program, machine = pose(scene), machine_of(scene, {})
    assert isinstance(machine, RotatingMachine)
    follows = SpunUp(machine, scene.excitations["lost"])
    for response in scene.measures.values():
        assert isinstance(response, TransientResponse)
        form = form_of(scene, program.model, response)
        value = form.value(program.model, FREE)
        room = form.room(program.model, FREE, value, value, 0.0)
        found, _ = follows.peak(response)
        assert abs(found - value) <= room
        assert room <= 1e-4 * value


def test_a_rotor_that_stays_beyond_its_threshold_grows_without_end() -> None:
    scene = rotor(links__near_bearing__rotating_damping="60 kN s/m")
    model = pose(scene).model
    assert spun_up(scene, model, evenly(30.0, 420.0, 40.0))[0].peak().value == np.inf
    assert np.isfinite(spun_up(scene, model, evenly(30.0, 60.0, 40.0))[0].peak().value)


@pytest.mark.parametrize("table", [None, FILM])
def test_what_resists_is_straight_between_the_rows_of_tables(table: list[dict[str, str]] | None) -> None:
    scene = rotor(None, table, links__far_bearing__rotating_damping="1 kN s/m")
    machine = machine_of(scene, {})
    assert isinstance(machine, RotatingMachine)
    follows = SpunUp(machine, scene.excitations["lost"])
    for spin in (25.0, 100.0, 300.0, 419.0):
        part_by_part = np.array(follows._resisting_at(spin))
        assert follows._resisting(spin) == pytest.approx(
            part_by_part, rel=1e-12, abs=1e-12 * np.abs(part_by_part).max()
        )
    assert len(follows._lines) == (1 if table is None else 2)


def test_a_run_up_that_ends_beyond_the_threshold_says_which_whirl_that_is() -> None:
    notes = run_up_notes(rotor(links__near_bearing__rotating_damping="60 kN s/m"), {})
    assert re.fullmatch(
        r"measures.whirl: a whirl grows without end at 4000 rpm, where the run-up ends; the stability threshold is "
        r"\d+ rpm.",
        notes[0],
    )


def test_what_is_not_answered_is_refused() -> None:
    torque = {"torque": "20 N m", "inertia": "2 kg m2"}
    assert list(refused(rotor, torque).messages) == [
        "scene: excitations.lost runs up by torque, beside rotors.shaft, of which it is not known what its whirl takes "
        'of that. Write the acceleration that the motor reaches: run_up = { acceleration = "50 rpm/s" }.'
    ]
    bare: Any = {"links__far_bearing__damping": "0 N s/m", "links__near_bearing__damping": "0 N s/m"}
    assert refused(rotor, None, None, **bare).messages[0] == (
        "scene: measures.whirl asks for the run-up of rotors.shaft, whose whirl nothing damps: what a critical speed "
        "leaves rings on for ever. Write damping of a link or of a bearing."
    )
    assert refused(rotor, {"acceleration": "50 rpm/s"}, FILM).messages[0] == (
        "scene: measures.whirl looks at 0 rpm to 4000 rpm, but the tables of bearings, bearings.near_bearing among "
        "them, say something of 200 rpm to 6000 rpm alone. Write more rows, or look at these speeds."
    )


def test_what_a_run_up_of_a_rotor_is_known_to_is_said_where_edges_are_judged() -> None:
    scene = rotor()
    form = form_of(scene, pose(scene).model, scene.measures["whirl"])
    assert form.known_to == 1e-6


@pytest.mark.slow
def test_what_is_greatest_behind_the_end_of_a_quick_run_up_is_followed() -> None:
    """Both routes: while the spin rises less is reached than a load at rest would move it by."""
    scene = rotor(
        {"from": "0 rpm", "acceleration": "40000 rpm/s"}, excitations__lost__speed="8000 rpm",
        measures__whirl__response="peak_velocity",
    )  # fmt: skip
    answer = solve(scene)
    assert answer.status == "met", answer.claim
