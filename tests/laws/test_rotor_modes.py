"""Rotors through their undamped modes, and bends of what has no speeds, against direct solutions and differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from refusals import refused
from test_rotors import NONE, RPM, friswell, held
from vibopt.forms.form import bend_of_slopes
from vibopt.mechanics.harmonic import modal_of, motion
from vibopt.mechanics.modal import Undamped
from vibopt.mechanics.modes import modes_at, natural_frequencies, poles
from vibopt.program.pose import on_needed, pose
from vibopt.program.program import Program
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict
from vibopt.verify.as_built import machine_of


def damped(left: float, right: float, hysteretic: bool = False) -> Program:
    document = friswell()
    document["links"] = held(2e6)
    for name, size in zip(document["links"], (left, right), strict=True):
        document["links"][name] |= {"loss_factor": size} if hysteretic else {"damping": f"{size!r} N s/m"}
    return pose(from_dict(document))


@pytest.mark.parametrize(
    ("left", "right", "hysteretic"),
    [(1.0, 0.1, False), (3e3, 5e4, False), (1e6, 2e3, False), (1e9, 1e-9, False), (1e-4, 1e-4, True), (0.3, 9.0, True)],
)
def test_the_whirl_through_undamped_modes_is_the_direct_one(left: float, right: float, hysteretic: bool) -> None:
    model = damped(left, right, hysteretic).model
    p, top = model.values(NONE), 8000.0 * RPM
    modes = modal_of(model, p, top)
    assert isinstance(modes, Undamped)
    inside = modes.poles[(np.abs(modes.poles) <= top) & (modes.poles.real > 1e-9 * np.abs(modes.poles))]
    omega = np.concatenate([np.linspace(0.0, top, 40), inside.real, np.sqrt(1.0 / modes.squares[:2]) * (1.0 + 1e-13)])
    load = np.linspace(1.0, 2.0, model.n_free).astype(complex)
    found = modes.seen(np.eye(model.n_free), load, omega)
    true = motion(model, p, load, omega)
    assert (np.abs(found - true).max(axis=1) <= 1e-7 * np.abs(true).max(axis=1)).all()
    every = poles(model, p)
    every = every[(np.abs(every) <= top) & (every.real > 1e-9 * np.abs(every))]
    assert len(inside) == len(every)
    assert all(np.abs(every - one).min() <= 1e-8 * abs(one) for one in inside)


def test_matrices_of_many_designs_are_those_of_each() -> None:
    document = friswell(sections=[{"length": "1.5 m", "diameter": {"from": "40 mm", "to": "60 mm"}}])
    model = model_of(from_dict({**document, "goal": {"minimise": "displacement", "of": "second"}, "measures": {}}))
    x = np.array([[0.04], [0.047], [0.06]])
    for kind in range(4):
        for one, p in zip(model.sums(kind, model.values(x)), model.values(x), strict=True):
            assert np.allclose(one, model.matrix(kind, p), rtol=1e-13, atol=1e-13 * np.abs(one).max(initial=0.0))
    each = [natural_frequencies(replace(model), model.values(one)) for one in x]
    assert modes_at(model, x)[:, :6] == pytest.approx(np.array(each)[:, :6], rel=1e-11)


def test_bends_of_critical_speed_and_sag_are_differences_of_slopes() -> None:
    document = friswell(sections=[{"length": "1.5 m", "diameter": {"from": "40 mm", "to": "60 mm"}}])
    document["links"]["left_bearing"]["stiffness"] = {"from": "1 MN/m", "to": "9 MN/m"}
    document["rotors"]["rotor"]["discs"][0]["width"] = {"from": "50 mm", "to": "90 mm"}
    document["goal"] = {"minimise": "static_deflection", "of": "second"}
    document["limits"] = {"c": {"response": "critical_speed", "mode": 2, "at_least": "900 rpm"}}
    program = pose(from_dict({**document, "measures": {}}))
    assert program.aim is not None
    x = np.sqrt(program.low * program.high)
    for part in (program.aim, *program.limits):
        bend = part.form.bend(part.model, x)
        assert bend is not None
        assert bend == pytest.approx(bend_of_slopes(part.form, part.model, x), rel=1e-6, abs=1e-7)


def test_a_diameter_from_a_thread_to_a_tower_is_refused() -> None:
    document = friswell(sections=[{"length": "1.5 m", "diameter": {"from": "1 um", "to": "160 m"}}])
    caught = refused(from_dict, {**document, "goal": {"minimise": "displacement", "of": "second"}, "measures": {}})
    assert caught.messages == (
        "scene: rotors.rotor has sections of 1e-06 m and of 160 m: where diameters differ by more than a factor of "
        "1000, rounding decides how the shaft bends. Write diameters nearer to each other.",
    )


def test_without_any_damper_the_poles_are_the_critical_speeds_and_the_greatest_whirl_has_no_end() -> None:
    scene = from_dict(friswell())
    model = model_of(scene)
    modes = modal_of(model, model.values(NONE), 4000.0 * RPM)
    assert isinstance(modes, Undamped)
    inside = modes.poles[(modes.poles.real > 0.0) & (np.abs(modes.poles) <= 4000.0 * RPM)]
    critical = natural_frequencies(model, model.values(NONE))
    assert np.sort(inside.real) == pytest.approx(critical[critical <= 4000.0 * RPM], rel=1e-12)
    assert not inside.imag.any()
    assert on_needed(scene, model, scene.measures["first"])[1].value(model, NONE) == np.inf


def test_a_critical_speed_is_met_from_the_side_or_has_no_number() -> None:
    machine = machine_of(from_dict(friswell()), {})
    for sense in (1.0, -1.0):
        speeds = machine.critical_speeds(sense)[:4]
        for number, speed in enumerate(speeds):
            cut = machine.cut_for(1.3 * speed)
            for near in (0.85 * speed, speed, 1.2 * speed):
                assert cut._between(near, sense, number) == pytest.approx(speed, rel=1e-10)
            assert cut._between(1.01 * speed, sense, None) == pytest.approx(speed, rel=1e-10)
        assert np.isnan(machine.cut_for(2.0 * speeds[0])._between(2.0 * speeds[0], sense, 0))
