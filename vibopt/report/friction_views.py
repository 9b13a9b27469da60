"""A machine with dry friction beside its equivalent viscous damping: in words, against speed, and over a cycle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite, pi
from typing import cast

import numpy as np

from vibopt.answer.blocks import spoken, value_at
from vibopt.answer.entry import Checked
from vibopt.arrays import FloatArray
from vibopt.forms import Rubbing
from vibopt.forms.rubbing import friction_of
from vibopt.mechanics.model import Model
from vibopt.program.pose import form_of
from vibopt.records import dataclass
from vibopt.report.series import Mark, Panel, Zone, known_curve
from vibopt.responses import HarmonicResponse
from vibopt.scene.assemble import model_of
from vibopt.scene.drives import bands_for
from vibopt.scene.places import place_of
from vibopt.scene.scene import Design, Scene
from vibopt.scene.uncertain import uncertain
from vibopt.units import best_unit, show, to_unit
from vibopt.values.speeds import ROTATION

_SPEEDS, _SAME = 160, 5e-3
"""Points of a curve; part by which two values must differ to be told apart in words."""
_CLOSER, _BENT, _WIDE = 4, 0.03, 2.0
"""How often points are added where a curve bends, by how much between two of its pieces [rad], in a figure that is so
many times as wide as high."""
_ENDLESS = 1e5
"""Natural frequency over that of the force from which on nothing of a cycle can be drawn."""


@dataclass(frozen=True, slots=True)
class _Asked:
    """A steady response of a limit, a measure or the goal, and its row in the answer where it has one."""

    where: str
    response: HarmonicResponse
    form: Rubbing
    row: Checked | None = None


def _asked(scene: Scene, model: Model, rows: Mapping[str, Checked]) -> Iterator[_Asked]:
    for where, response in scene.responses.items():
        if isinstance(response, HarmonicResponse):
            form = cast("Rubbing", form_of(scene, model, response))
            yield _Asked(where, response, form, rows.get(where.partition(".")[2]))


def friction_notes(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """What equivalent viscous damping would say, where friction bounds a resonance, and where the start decides."""
    model, x, notes = model_of(scene), np.array([chosen[variable.path] for variable in scene.variables]), list[str]()
    endless: set[float] = set()
    nominal = bool(uncertain(scene))
    for asked in _asked(scene, model, {}):
        worst = asked.form.worst(model, x)
        [(name, speed)] = worst.speeds.items()
        unit = scene.excitations[name].speed.unit
        if not isfinite(worst.value):
            endless.add(speed)
            continue
        notes.append(
            f"{asked.where}: {_beside(asked, worst.value, asked.form.at(model, x, speed, rough=True), nominal=nominal)}"
        )
        if asked.form.left_to_the_start(model, x, speed):
            notes.append(
                f"{asked.where}: at {show(speed, unit, ROTATION)} the natural frequency is a whole multiple of that of "
                "the force and nothing is damped: what it began with swings on, and the greatest may be more."
            )
    for speed in sorted(endless):
        push = asked.form.motion(model, x, speed)[1]
        notes.append(
            f"At the resonance, {show(speed, unit, ROTATION)}, the motion has no end: without viscous damping friction "
            f"bounds it only above π/4 of the force, {show(0.25 * pi * push, '', 'force')}, and there are "
            f"{show(friction_of(model, x), '', 'force')}."
        )
    return notes


def _beside(asked: _Asked, value: float, other: float, *, nominal: bool) -> str:
    """The equivalent viscous value, and how far it is off; `nominal` of a machine that has tolerances beside."""
    if asked.response.complement:
        value, other = 1.0 - value, 1.0 - other
    kind = asked.response.dimension
    said, own = (show(one, best_unit(one, kind) if kind != "ratio" else "", kind) for one in (other, value))
    part = (other - value) / abs(value) if value else 0.0
    size = 100.0 * abs(part)
    much = f"{size:.0f}" if size > 10.0 else f"{size:.2g}"
    much += f" % too {'much' if part > 0.0 else 'little'}"
    of = f"of the machine as said, without tolerances, which has {own}, " if nominal else ""
    return f"{of}equivalent viscous damping would say {said}, {'which is right' if abs(part) < _SAME else much}."


def friction_panels(design: Design, model: Model) -> list[Panel]:
    """Each response against speed, the equivalent viscous one beside, and over one cycle at its worst speed."""
    x = np.array(design.x)
    first: dict[tuple[str, str], _Asked] = {}
    for asked in _asked(design.scene, model, {**design.measures, **design.limits}):
        first.setdefault(
            (asked.response.response.replace("isolation", "transmissibility"), place_of(asked.response)), asked
        )
    panels = []
    for asked in first.values():
        panels.append(_against_speed(design, model, x, asked))
        value, speed = asked.form.tops(model, x)[0]
        if isfinite(value) and speed * _order(asked.form) * _ENDLESS > asked.form.naturals(model, x)[0]:
            panels.append(_over_cycle(design, model, x, asked))
    return panels


def _against_speed(design: Design, model: Model, x: FloatArray, asked: _Asked) -> Panel:
    scene, name = design.scene, asked.form.shaken[0].name
    bands, naturals = bands_for(scene, asked.response, name), asked.form.naturals(model, x) / _order(asked.form)
    known = scene.excitations[name].known_bands[0]
    many = len(naturals) > 1  # then each speed takes long, and the slowest ones longest
    low = max(known.low, (0.5 if many else 0.1) * naturals[0], 1e-3 * bands[-1].high)
    high = min(known.high, max(1.2 * max(band.high for band in bands), 2.0 * naturals[0]))
    value, speed = asked.form.tops(model, x)[0]
    count = _SPEEDS // (1 + 2 * many)
    speeds = np.union1d(np.geomspace(min(low, 0.5 * high), high, count), [speed, *naturals[naturals < high]])
    exact = asked.form.sizes(model, x, speeds)
    unit, factor = _unit(asked, value)
    per = to_unit(1.0, scene.excitations[name].speed.unit, ROTATION)
    bound = asked.response.at_most
    limit = (1.0 - bound.value if asked.response.complement else bound.value) if bound is not None else 0.0
    top = factor * max(4.0 * float(np.median(exact)), limit, value if isfinite(value) else 0.0)
    for _ in range(_CLOSER // (1 + many)):
        steep = np.arctan2(np.diff(np.minimum(factor * exact / top, 1.5)), _WIDE * np.diff(speeds) / (high - speeds[0]))
        bent = np.flatnonzero(np.abs(np.diff(steep)) > _BENT)
        speeds = np.union1d(speeds, [0.5 * (speeds[bent + k] + speeds[bent + k + 1]) for k in (0, 1)])
        exact = asked.form.sizes(model, x, speeds)
    other = np.array([asked.form.at(model, x, w, rough=True) for w in speeds])
    said = "" if bound is None else show(bound.value, bound.unit, asked.response.dimension)
    zones = [
        Zone(asked.where, f"{asked.where.partition('.')[2]}: at most {said}",
             per * band.low, per * band.high, factor * limit, True)
        for band in (bands if bound is not None else ())
    ]  # fmt: skip
    words = f"{asked.where.rpartition('.')[2]} {value_at(asked.row)}" if asked.row is not None else asked.where
    return Panel(
        title=_title(asked), x_label=f"speed of {name} [{scene.excitations[name].speed.unit}]",
        y_label=_label(asked, unit),
        curves=(
            known_curve("dry friction", per * speeds, np.minimum(factor * exact, 1e3 * top)),
            known_curve("equivalent viscous", per * speeds, np.minimum(factor * other, 1e3 * top), before=True),
        ),
        zones=tuple(zones), marks=(Mark(asked.where, words, per * speed, factor * value),), excitation=name,
        x_span=(per * speeds[0], per * speeds[-1]), y_span=(0.0, 1.25 * top),
    )  # fmt: skip


def _over_cycle(design: Design, model: Model, x: FloatArray, asked: _Asked) -> Panel:
    """Two cycles, with the times at which friction holds."""
    value, speed = asked.form.tops(model, x)[0]
    half, read, still = asked.form.half_cycle(model, x, speed)
    long = pi / (speed * _order(asked.form))
    times, held = np.concatenate([half - half[0] + k * long for k in range(4)]), np.tile(still, 4)
    unit, factor = _unit(asked, value)
    slow = "ms" if times[-1] < 1.0 else "s"
    per, y = to_unit(1.0, slow, "time"), factor * np.concatenate([read, -read, read, -read])
    top, at, name = factor * value, int(np.abs(y).argmax()), asked.form.shaken[0].name
    shaker = design.scene.excitations[name]
    shown = show(shaker.from_rotation(speed), shaker.speed.unit, ROTATION)
    curves = [known_curve("slips", per * times, y)]
    if held.any():
        curves.append(known_curve("held by friction", per * times, np.where(held, y, np.nan), worst=True))
    return Panel(
        title=f"{_title(asked)}, two cycles at {shown}", x_label=f"time [{slow}]", y_label=_label(asked, unit),
        curves=tuple(curves), excitation=name, marks=(Mark(asked.where, "greatest", per * times[at], float(y[at])),),
        x_span=(0.0, per * float(times[-1])), y_span=(-1.35 * top, 1.35 * top),
    )  # fmt: skip


def _order(form: Rubbing) -> float:
    return form.shaken[0].lines[0].order


def _title(asked: _Asked) -> str:
    quantity = "transmissibility" if asked.response.complement else asked.response.response
    return f"{spoken(quantity).capitalize()} {place_of(asked.response)}"


def _label(asked: _Asked, unit: str) -> str:
    quantity = "transmissibility" if asked.response.complement else asked.response.response
    return spoken(quantity) + (f" [{unit}]" if unit else "")


def _unit(asked: _Asked, value: float) -> tuple[str, float]:
    kind = asked.response.dimension
    if kind == "ratio":
        return "", 1.0
    unit = best_unit(value if isfinite(value) else 1.0, kind)
    return unit, to_unit(1.0, unit, kind)
