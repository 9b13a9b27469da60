"""Responses against time under what comes once, run-ups against their speed: figures before anything is drawn."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from typing import cast

import numpy as np

from vibopt.answer.blocks import spoken, value_at
from vibopt.answer.entry import Checked
from vibopt.arrays import FloatArray
from vibopt.excitations.run_up import motor_of
from vibopt.forms import PeakInRunUp, PeakInTime, PeakOverDurations
from vibopt.mechanics.harmonic import mount_count
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import natural_frequencies
from vibopt.mechanics.peaks_in_time import Peak
from vibopt.program.pose import form_of, pose
from vibopt.records import dataclass
from vibopt.report.series import Mark, Panel, Zone, known_curve
from vibopt.responses import TransientResponse
from vibopt.scene.drives import durations_of, names_for
from vibopt.scene.places import place_of
from vibopt.scene.scene import Design, Scene
from vibopt.scene.space import members
from vibopt.units import best_unit, show, to_unit
from vibopt.verify.as_built import factors_of, machine_of
from vibopt.verify.by_torque import ByTorque

_POINTS, _FINE, _PERIODS, _EVEN = 600, 2500, 4.0, 1e-6
"""Points of a curve, and of one that beats; periods of the slowest mode that are shown behind the load; part by which
two peaks that are as great may differ."""
_SEEN, _WORST = 4.0, "worst machine within the tolerances"
"""How much of what a vibration would take is shown, in the motor's greatest torque."""


@dataclass(frozen=True, slots=True)
class _Asked:
    """A limit or measure in time, or the goal, which has no row in the answer; of a sum one part of it, by itself."""

    name: str
    response: TransientResponse
    row: Checked | None
    bound: float | None
    part: str = ""


def histories(design: Design, model: Model) -> list[Panel]:
    """Every limit, measure and goal of what comes once as a history, its greatest value marked."""
    scene = design.scene
    asked = [
        _Asked(name, one, rows[name], one.at_most.value if one.at_most is not None else None)
        for given, rows in ((scene.limits, design.limits), (scene.measures, design.measures))
        for name, one in given.items()
        if isinstance(one, TransientResponse) and name in rows
    ]
    if scene.goal is not None and isinstance(scene.goal.response, TransientResponse):
        asked.append(_Asked("goal", scene.goal.response, None, None))
    asked = [_worst_of(design, model, part) for one in asked for part in _parts(scene, one)]
    first: dict[tuple[str, str, tuple[str, ...]], _Asked] = {}
    for one in asked:
        first.setdefault((one.response.response, place_of(one.response), names_for(scene, one.response)), one)
    drawn = [_panel(design, model, one) for one in first.values()]
    return [*{(panel.title, panel.excitation): panel for panel in drawn if panel is not None}.values()]


def _parts(scene: Scene, asked: _Asked) -> list[_Asked]:
    """What has a history: of a sum over several times each that it adds up and that comes once."""
    if asked.response.combine is None:
        return [asked]
    alone = {
        name: asked.response.alone(name, scene.excitations[name].sorts) for name in names_for(scene, asked.response)
    }
    return [
        _Asked(asked.name, one, None, None, f", {name} by itself")
        for name, one in alone.items()
        if isinstance(one, TransientResponse)
    ]


def _worst_of(design: Design, model: Model, asked: _Asked) -> _Asked:
    """Of a group of mounts the one that is worst, along its own axis that is."""
    every, x = members(design.scene, asked.response), np.array(design.x)
    if len(every) == 1:
        return asked
    worst = max(every, key=lambda one: form_of(design.scene, model, one).value(model, x))
    assert isinstance(worst, TransientResponse)
    return replace(asked, response=worst)


@dataclass(frozen=True, slots=True)
class _Shown:
    """One machine whose motion is drawn: x is time [s] or speed [rad/s], y in SI; the greatest |y| stands at `at`.

    label, worst
        As of a curve.
    steady
        Beside a run-up the steady vibration: speeds [rad/s], values.
    """

    label: str
    worst: bool
    x: FloatArray
    y: FloatArray
    at: float
    there: float
    steady: tuple[FloatArray, FloatArray] | None = None
    runs: str = ""


def _machines(design: Design, model: Model, asked: _Asked) -> list[tuple[str, Scene, Model]]:
    """The machine as designed and the worst within the tolerances, where that is another: label, scene and model."""
    off = asked.row.off if asked.row is not None else {}
    if asked.row is None and not asked.part and design.tolerances is not None:
        off = design.tolerances.goal_off
    if not off:
        return [("", design.scene, model)]
    worst = replace(design.scene, off=factors_of(design.scene, off))
    return [("as designed", design.scene, model), (_WORST, worst, pose(worst).model)]


def _panel(design: Design, model: Model, asked: _Asked) -> Panel | None:
    [name, *_] = names = names_for(design.scene, asked.response)
    ramps = design.scene.excitations[name].ramp is not None
    shown, lasts = [], asked.part
    for label, scene, own in _machines(design, model, asked):
        form, x = form_of(scene, own, asked.response), np.array(design.x)
        if ramps:
            one = _swept(label, own, cast("PeakInRunUp", form), x)
            if one is None:
                return _torques(
                    replace(design, job=scene), name, "the worst machine" if label == _WORST else "the motor"
                )
        else:
            if durations_of(scene, asked.response) is not None:
                of_any = cast("PeakOverDurations", form)
                duration = of_any.worst_of(own, x)[1]
                form = of_any.lasting(duration)
                lasts = f"{asked.part}, pulse of {show(duration, best_unit(duration, 'time'), 'time')}"
            assert isinstance(form, PeakInTime)
            one = _history(label, own, form, x, asked)
            if one is None:
                return None
        shown.append(one)
    return (_against_speed if ramps else _against_time)(design, asked, shown, names, lasts)


def _history(label: str, model: Model, form: PeakInTime, x: FloatArray, asked: _Asked) -> _Shown | None:
    """Motion against time; None where it has no end."""
    peak = form.peak(model, x)
    if not isfinite(peak.value):
        return None
    machine, reading = form.motion(model, x)
    count = mount_count(model, form.output, x)
    most, at, there = abs(peak.value) / count, peak.time, peak.value / count
    if asked.row is not None and isfinite(peak.time):
        for entry in asked.row.worst_at.values():  # of several that are as great, the one that the answer names
            other = float(machine.history(reading, np.array([entry.value]))[0]) / count
            at, there = (entry.value, other) if abs(other) >= (1.0 - _EVEN) * most else (at, there)
    times = np.linspace(0.0, max(_end(model, form, peak, x), at if isfinite(at) else 0.0), _POINTS)
    if isfinite(peak.time):
        times = np.sort(np.append(times, at))
    return _Shown(label, label == _WORST, times, machine.history(reading, times) / count, at, there)


def _against_time(design: Design, asked: _Asked, shown: list[_Shown], names: tuple[str, ...], lasts: str) -> Panel:
    """Histories; the last of the machines is the one that the answer measures."""
    last = shown[-1]
    most = max(abs(one.there) for one in shown)
    end = max(min(float(one.x[-1]) for one in shown), last.at if isfinite(last.at) else 0.0)  # as far as all are known
    unit, words = _said(asked, abs(last.there), show(last.at, best_unit(last.at, "time"), "time"))
    slow = "ms" if end < 1.0 else "s"
    factor, per = to_unit(1.0, unit, asked.response.dimension), to_unit(1.0, slow, "time")
    top, span = factor * max(most, asked.bound or 0.0), (0.0, per * end)
    mark = Mark(asked.name, words, per * last.at, factor * last.there)
    return Panel(
        title=f"{spoken(asked.response.response).capitalize()} {place_of(asked.response)}{lasts}",
        x_label=f"time [{slow}]",
        y_label=f"{spoken(asked.response.response).removeprefix('peak ')} [{unit}]",
        curves=tuple(known_curve(one.label, per * one.x, factor * one.y, worst=one.worst) for one in shown),
        zones=tuple(_zones(asked, factor, span, unit)),
        marks=(mark,) if isfinite(last.at) else (),
        excitation=", ".join(names),
        x_span=span,
        y_span=(-1.3 * top, 1.3 * top) if min(one.y.min() for one in shown) < -0.02 * most else (0.0, 1.3 * top),
    )


def _swept(label: str, model: Model, form: PeakInRunUp, x: FloatArray) -> _Shown | None:
    """The envelope of a run-up against the speed, beside the steady vibration; None where it has no end."""
    peak, count = form.peak(model, x), mount_count(model, form.output, x)
    if not isfinite(peak.value):
        return None
    machine, row = form.course(model, x)
    sweep, length = machine.sweep, float(machine.sweep.times[-1])
    top_time = min(peak.time, length)
    times = np.sort(np.append(np.linspace(0.0, length, _FINE), top_time))
    swept = sweep.at(times)
    modes = natural_frequencies(model, model.values(x)) if not model.bearings else np.zeros(0)
    speeds = np.sort(np.append(swept, modes[(modes > swept.min()) & (modes < swept.max())]))
    steady = speeds, machine.steady(row, speeds) / count
    at, runs = float(sweep.at(np.array(top_time))), "run-up" if sweep.rates[0] > 0.0 else "run-down"
    motion = machine.history(row, times) / count
    return _Shown(label, label == _WORST, swept, motion, at, peak.value / count, steady, runs)


def _against_speed(design: Design, asked: _Asked, shown: list[_Shown], names: tuple[str, ...], lasts: str) -> Panel:
    """Run-ups, and the steady vibration of the first; the last of the machines is the one that the answer measures."""
    [name], first, last = names, shown[0], shown[-1]
    assert first.steady is not None
    unit_x, most = design.scene.excitations[name].speed.unit, max(one.there for one in shown)
    unit, words = _said(asked, last.there, show(last.at, unit_x, "angular_rate"))
    factor, per = to_unit(1.0, unit, asked.response.dimension), to_unit(1.0, unit_x, "angular_rate")
    speeds, steady = first.steady
    seen = 3.0 * max(most, asked.bound or 0.0)
    top = factor * max(most, asked.bound or 0.0, float(np.minimum(np.nan_to_num(steady), seen).max()))
    span = (per * float(first.x.min()), per * float(first.x.max()))
    runs = [
        known_curve(", ".join(filter(None, (one.runs, one.label))), per * one.x, factor * one.y, worst=one.worst)
        for one in shown
    ]
    return Panel(
        title=f"{spoken(asked.response.response).capitalize()} {place_of(asked.response)}{lasts}",
        x_label=f"speed of {name} [{unit_x}]",
        y_label=f"{spoken(asked.response.response).removeprefix('peak ')} [{unit}]",
        curves=(*runs, known_curve("steady", per * speeds, factor * np.minimum(steady, 2.0 * seen), before=True)),
        zones=tuple(_zones(asked, factor, span, unit)[:1]),
        marks=(Mark(asked.name, words, per * last.at, factor * last.there),),
        excitation=name,
        x_span=span,
        y_span=(0.0, 1.25 * top),
    )


def _said(asked: _Asked, most: float, at: str) -> tuple[str, str]:
    """Unit of the values, and what stands at the greatest of them."""
    unit = (asked.row.value.unit if asked.row is not None else "") or best_unit(most, asked.response.dimension)
    found = f"{show(most, unit, asked.response.dimension)} at {at}"
    return unit, f"{asked.name} {value_at(asked.row) if asked.row is not None else found}"


def _torques(design: Design, name: str, which: str) -> Panel | None:
    """Of a motor that sticks: its torque against the speed, beside that of load and vibration, and where they meet."""
    scene = design.scene
    motor, chosen = (
        motor_of(scene.excitations[name]),
        dict(zip([variable.path for variable in scene.variables], design.x, strict=True)),
    )
    if motor is None:
        return None
    course = ByTorque(machine_of(scene, chosen), motor, scene.excitations[name].on)
    if not course.sticks:
        return None
    unit, held = scene.excitations[name].speed.unit, course.held_at
    speeds = np.union1d(course.speeds, [held])
    gives, load = motor.driving.at(speeds), motor.load.at(speeds)
    full = max(float(gives.max()), float(load.max()))
    needs = np.minimum(load + course.taken(speeds), 100.0 * full)
    per, size = to_unit(1.0, unit, "angular_rate"), best_unit(full, "moment")
    factor = to_unit(1.0, size, "moment")
    top = factor * min(max(full, float(needs.max())), _SEEN * full)
    at = factor * float(motor.driving.at(np.array([held]))[0])
    return Panel(
        title=f"Torque of the run-up of {name}: {which} sticks",
        x_label=f"speed of {name} [{unit}]", y_label=f"torque [{size}]",
        curves=(
            known_curve("load and steady vibration", per * speeds, factor * needs),
            known_curve("motor", per * speeds, factor * gives, worst=True),
            known_curve("load", per * speeds, factor * load, before=True),
        ),
        marks=(Mark(name, f"sticks at {show(held, unit, 'angular_rate')}", per * held, at),),
        excitation=name, x_span=(per * speeds[0], per * speeds[-1]),
        y_span=(min(0.0, 1.2 * factor * float(min(gives.min(), load.min()))), 1.25 * top),
    )  # fmt: skip


def _end(model: Model, form: PeakInTime, peak: Peak, x: FloatArray) -> float:
    """To where a history is shown [s]: the load, some periods behind it, and the peak."""
    load = sum(segment.length for segment in form.segments)
    modes = natural_frequencies(model, model.values(x))
    slow = modes[modes > 0.0].min(initial=np.inf)
    behind = _PERIODS * 2.0 * np.pi / float(slow) if np.isfinite(slow) else load
    return max(min(load, 1e3 * behind) + behind, 1.3 * peak.time if isfinite(peak.time) else 0.0)


def _zones(asked: _Asked, factor: float, span: tuple[float, float], unit: str) -> list[Zone]:
    if asked.bound is None:
        return []
    words = f"{asked.name}: at most {show(asked.bound, unit, asked.response.dimension)}"
    return [Zone(asked.name, words, *span, sign * factor * asked.bound, sign > 0.0) for sign in (1.0, -1.0)]
