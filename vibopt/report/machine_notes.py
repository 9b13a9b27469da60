"""What an answer takes for granted, said aloud."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

import numpy as np

from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.machine import Machine
from vibopt.responses import RandomResponse, TransientResponse
from vibopt.scene.check_bearings import bearings
from vibopt.scene.drives import durations_of, names_for
from vibopt.scene.places import rubbing, turning
from vibopt.scene.scene import Scene
from vibopt.scene.space import members
from vibopt.scene.uncertain import uncertain
from vibopt.units import best_unit, plain, show
from vibopt.verify.as_built import machine_of
from vibopt.verify.beyond import heavier, heavy

if TYPE_CHECKING:
    from vibopt.forms import PeakOverDurations

_NOTHING = 1e-9
"""Part of the weight that rounding may lift."""
_LATER = 1e-3
"""Part by which a peak must be able to grow for that to be said."""
_SEVERAL, _FEW = 2, 6
"""Modes from which on damping may mix them, and ratios that are told."""
_SMALL = 0.4
"""Part of its clearance up to which the orbit in a film is small."""
_HORIZON, _FADED = 4e5, 1e-12
"""Periods over which what lasts is followed, and the part to which all else must fade."""


def notes_of(scene: Scene, chosen: Mapping[str, float]) -> tuple[str, ...]:
    """What to know beside the answer: the scene's own notes, amplitudes taken as constant, soft floors."""
    notes = list(scene.notes)
    for name, excitation in scene.excitations.items():
        if excitation.variation is None and not excitation.inherent and not excitation.speed.is_one_speed:
            notes.append(f"excitations.{name}: the amplitude is taken as the same at each of its own speeds.")
        if excitation.speed.highest == 0.0 and (excitation.inherent or excitation.begins_at_rest):
            notes.append(f"excitations.{name}: it turns at 0 rpm, where its force is zero: it shakes nothing.")
        if excitation.remark:
            notes.append(f"excitations.{name}: {excitation.remark}")
    smooth = (name for name, link in scene.links.items() if link.friction_force is not None and not link.rubs)
    notes += [f"links.{name}: its friction is zero: it does not rub." for name in smooth]
    notes += alike(scene)
    notes += unasked(scene)
    notes += lifted(scene, chosen)
    notes += needless(scene, chosen)
    notes += soft_floor(scene, chosen)
    notes += wide_orbits(scene, chosen)
    if any(one.sorts != ("steady",) for one in scene.excitations.values()):
        notes += random_notes(scene, chosen)
        notes += ringing_notes(scene, chosen)
        notes += duration_notes(scene, chosen)
        notes += left_out(scene)
    notes += static_shapes(scene, chosen)
    notes += damping_of_poles(scene, chosen)
    if rubbing(scene):
        from vibopt.report.friction_views import friction_notes

        notes += friction_notes(scene, chosen)
    if any(one.ramp is not None for one in scene.excitations.values()):
        from vibopt.report.run_up_notes import run_up_notes

        notes += run_up_notes(scene, chosen)
    return tuple(notes)


def damping_of_poles(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """Which damping ratios are those of poles, as asked for, and which of undamped modes, where they differ."""
    every = [one for one in scene.responses.values() if one.response in ("damping_ratio", "logarithmic_decrement")]
    asked = [one.response for one in every if one.free_vibration and not one.spins]
    machine = machine_of(scene, chosen) if asked else None
    if machine is None or machine.on_structures:
        return []
    from vibopt.report.mode_shapes import shapes_of
    from vibopt.responses.damping import ratios_of

    shapes = shapes_of(machine, sorted(turning(scene)))
    modes = [plain(value, 3) for value in sorted(shape.damping for shape in shapes if shape.damping is not None)]
    told = [plain(float(one), 3) for one in np.sort(ratios_of(machine.held_poles()))]
    if told == modes or len(modes) < _SEVERAL:
        return []
    return [
        f"Tables show the damping ratio of each undamped mode. {asked[0]} is asked of the poles, which damping makes "
        f"others here: {', '.join(told[:_FEW])}{' and so on' if len(told) > _FEW else ''}."
    ]


def wide_orbits(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """Squeeze films whose rings whirl further than the formula of a film is good for, or touch."""
    films = {
        name: bearing_table.squeeze_film
        for name, bearing_table in bearings(scene).items()
        if bearing_table.squeeze_film is not None
    }
    if not films or not scene.excitations:
        return []
    from vibopt.report.isolators import asked

    notes, machine = [], machine_of(scene, chosen)
    for name, film in films.items():
        row = asked(scene, machine, "relative_displacement", across=name)
        path = f"bearings.{name}.squeeze_film.clearance"
        gap = chosen.get(path, getattr(film.clearance, "value", np.inf))
        if row is None or row.value.value <= _SMALL * gap:
            continue
        orbit, least = (show(one, "mm", "length") for one in (row.value.value, gap))
        why = "the rings touch, and nothing that is said of its whirl holds"
        if row.value.value < gap:
            why = "its damping is that of small orbits, and wide ones stiffen a film and are damped more"
        notes.append(f"bearings.{name} whirls by {orbit} in a squeeze film of {least} clearance: {why}.")
    return notes


def alike(scene: Scene) -> list[str]:
    """How the mounts of a group are off: all alike, unless the file says that each is by itself."""
    found, off = [], [tuple(one.path.split(".")[:2]) for one in uncertain(scene)]
    for name, mount in scene.mounts.items():
        if mount.count > 1 and mount.tolerance_of is None and ("mounts", name) in off:
            found.append(
                f"mounts.{name}: its {mount.count} mounts are off alike, as one batch is. Write tolerance_of = "
                '"mount" to let each be off by itself.'
            )
    return found


def lifted(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """Mounts that the weights pull at, where no limit forbids it."""
    if not scene.mounts:
        return []
    machine, found = machine_of(scene, chosen), []
    for name, mount in scene.mounts.items():
        asked = any(
            limit.response == "static_load"
            and limit.at_least is not None
            and str(getattr(limit, "of", "")).startswith(name)
            for limit in scene.limits.values()
        )
        rated = mount.part is not None and mount.part.rated_min is not None
        from vibopt.responses.space_responses import StaticLoadOfMount

        for single in mount.singles(name) if not asked and not rated else ():
            load = StaticLoadOfMount(response="static_load", of=single).measure_static(machine)
            if load < -_NOTHING * GRAVITY * sum(machine.weights.values()):
                found.append(
                    f"mounts.{single} is lifted with {show(-load, '', 'force')} by the weights: it must be able to "
                    f'pull. To forbid it, add a limit with response = "static_load", of = "{name}", at_least = "0 N".'
                )
    return found


def unasked(scene: Scene) -> list[str]:
    """Ratings and gaps of mounts that no limit asks for: said, so that nobody takes them for kept."""
    found, once = [], bool(scene.excitations) and all(one.sort == "transient" for one in scene.excitations.values())
    for name, mount in scene.mounts.items():
        for key, response in (("rating", "static_load"), ("gap", "peak_travel" if once else "travel")):
            asked = any(
                limit.response.removeprefix("peak_") == response.removeprefix("peak_")
                and str(getattr(limit, "of", "")).split(".")[0] == name
                for limit in scene.limits.values()
            )
            if getattr(mount, key) is not None and not asked:
                found.append(
                    f'mounts.{name}: its {key} binds nothing. Add a limit with response = "{response}" and '
                    f'of = "{name}".'
                )
    return found


def needless(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """A hint for every absorber whose mass is the least that is allowed."""
    fewer = {1: "none may do", 2: "one absorber may do"}.get(len(scene.absorbers), "one absorber less may do")
    return [
        f"{variable.path} rests on the least that is allowed: {fewer}; try without it (vibopt explain does)."
        for variable in scene.variables
        if variable.path.startswith("absorbers.")
        and variable.path.rsplit(".", 1)[-1] in ("mass", "mass_ratio", "inertia")
        and variable.values is None
        and chosen[variable.path] <= variable.low * (1.0 + 1e-9)
    ]


def soft_floor(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """A warning of bodies that are held less than ten times as stiffly as what stands on them, beams apart."""
    machine = machine_of(scene, chosen)
    mounts = [joint for joint in machine.joints if joint.name not in machine.tuned]
    beams = {name for name, link in scene.links.items() if link.beam is not None}
    softest: dict[str, tuple[float, str]] = {}
    for mount in mounts:
        floor = mount.ends[1]
        stands = mount.stiffness > 0.0 and mount.name not in beams
        if not stands or not all(machine.masses.get(one) for one in (floor, mount.ends[0])):
            continue
        under = sum(one.stiffness for one in mounts if floor in one.ends and one is not mount)
        if 0.0 < under < 10.0 * mount.stiffness:
            softest[floor] = min((under / mount.stiffness, mount.name), softest.get(floor, (np.inf, "")))
    if not softest:
        return []
    (floor, (ratio, name)), *more = softest.items()
    words = [f"{floor} is held only {ratio:.2g} times as stiffly as {name}, which stands on it"]
    words += [f"{other} {less:.2g} times as {above}" for other, (less, above) in more]
    moves = "they move too, and the answer counts with them" if more else "it moves too, and the answer counts with it"
    return [f"{', '.join(words)}: {moves}; on a rigid floor it would be another."]


def static_shapes(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """Of beams with a mass, how good their static shape is at the highest frequency that is asked."""
    if not any(link.spreads_mass for link in scene.links.values()):
        return []
    from vibopt.scene.drives import highest_asked

    machine, top, notes = machine_of(scene, chosen), highest_asked(scene), []
    for joint in heavy(machine):
        assert joint.borne is not None
        own, more = show(joint.borne.frequency, "Hz", "angular_rate"), heavier(machine, joint, top)
        upto = (
            f"up to {show(top, 'Hz', 'angular_rate')} what moves with its load is at most {100.0 * more:.2g} % heavier"
        )
        notes.append(
            f"links.{joint.name}: its mass is counted in its static shape. It vibrates by itself, load and supports "
            f"held, from {own} on" + (f", so that {upto}." if more < 1.0 and top else ".")
        )
    return notes


def ringing_notes(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """What is said of peaks in time of a machine without any damping or friction, which rings on for ever."""
    if rubbing(scene) or not any(response.sort == "transient" for response in scene.responses.values()):
        return []
    machine = machine_of(scene, chosen)
    damping = machine.matrices()[1]
    planes = getattr(machine, "bearings", {}).values()  # that differ in both planes: the matrices know nothing of them
    damped = bool(damping.any()) or any(bool(bearing.damping.any()) for bearing in planes)
    lasts = any(two.once is not None and two.once.endless and not two.once.holds for two in scene.excitations.values())
    if (len(damping) < 2 and not lasts) or (damped and not (lasts and _slow(machine))):
        return []
    if damped:
        return [
            "Some mode is hardly damped: what begins suddenly is followed over 400 000 periods of the slowest mode, "
            "and no further."
        ]
    if lasts:
        return ["Nothing is damped: what rings on meets what lasts in every way, and the greatest is that of all time."]
    return [
        "Nothing is damped: what rings on is followed over a thousand periods of its slowest mode, and no further.",
        *_far_later(scene, chosen),
    ]


def _far_later(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """By how much what nothing damps may be greater at some time that was not looked at."""
    from vibopt.program.pose import form_of
    from vibopt.scene.assemble import model_of

    model, notes = model_of(scene), []
    x = np.array([chosen[each.path] for each in scene.variables])
    for where, response in scene.responses.items():
        asked = members(scene, response) if response.sort == "transient" else ()
        forms = [form for one in asked if (form := form_of(scene, model, one).in_time) is not None]
        value = max((form.value(model, x) for form in forms), default=0.0)
        if not 0.0 < value < np.inf:
            continue
        ratio = max(form.never_more(model, x) for form in forms) / value
        if ratio > 1.0 + _LATER:
            notes.append(
                f"{where} may come to {ratio:.4g} times that far later, the sum of its amplitudes, and never beyond."
            )
    return notes


def duration_notes(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """At which duration each response to a pulse of unknown duration is greatest, and how that is known."""
    notes = []
    for where, response in scene.responses.items():
        between = (
            durations_of(scene, response)
            if isinstance(response, TransientResponse) and response.combine is None
            else None
        )
        if between is None:
            continue
        from vibopt.program.pose import form_of
        from vibopt.scene.assemble import model_of

        model = model_of(scene)
        x = np.array([chosen[each.path] for each in scene.variables])
        forms = [cast("PeakOverDurations", form_of(scene, model, one)) for one in members(scene, response)]
        value, found = max(form.worst_of(model, x) for form in forms)
        if np.isfinite(value):
            low, high, at = (show(each, best_unit(each, "time"), "time") for each in (*between, found))
            over = f"from {low} to {high}" if between[0] > 0.0 else f"up to {high}"
            notes.append(f"{where} is greatest at a duration of {at}, found by a search over all {over}, not proven.")
    return notes


def _slow(machine: Machine) -> bool:
    """Whether some mode has not faded after 400 000 periods of the slowest."""
    poles = machine.poles()
    return bool(np.abs(poles.imag).min() * _HORIZON * 2.0 * np.pi < -np.log(_FADED) * np.abs(poles).min())


def left_out(scene: Scene) -> list[str]:
    """Steady excitations that the greatest in time does not count."""
    steady = [name for name, excitation in scene.excitations.items() if excitation.sorts == ("steady",)]
    alone = [
        where
        for where, response in scene.responses.items()
        if isinstance(response, TransientResponse) and response.combine is None and response.due_to is None
    ]
    if not steady or not alone:
        return []
    return [
        f"{alone[0]} is of what comes once alone, without excitations.{steady[0]}, which is steady. To count both "
        'write combine = "sum", or begins = "suddenly" there.'
    ]


def random_notes(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """How noises add up, and why a root mean square is infinite."""
    random = {where: response for where, response in scene.responses.items() if isinstance(response, RandomResponse)}
    notes = []
    if any(len(names_for(scene, one)) > 1 for one in random.values()):
        notes.append("White noises are taken as independent: their mean squares add.")
    machine = machine_of(scene, chosen) if random else None
    for where, one in random.items():
        from vibopt.verify.rms import why_infinite

        first = cast("RandomResponse", members(scene, one)[0])
        why = why_infinite(scene, machine, first) if machine is not None else ""
        if why:
            notes.append(f"{where}: {one.response} is infinite, for {why}.")
    return notes
