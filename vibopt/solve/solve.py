"""Scene to Design: pose, choose a method, answer, certify by another road."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.design.build import machine_of
from vibopt.design.certify import TOLERANCE, measure, measure_on
from vibopt.design.design import Checked, Chosen, Conflict, Design, Shown, Used
from vibopt.design.words import place_of
from vibopt.errors import InputError
from vibopt.forms import Modulus, Monomials
from vibopt.mechanics.machine import Machine
from vibopt.program.pose import on_needed, pose
from vibopt.program.program import Limit, Program
from vibopt.program.reduce import reason
from vibopt.responses import HarmonicResponse, Response
from vibopt.responses.natural_frequency import NaturalFrequency
from vibopt.scene.drives import names_for, speeds_for
from vibopt.scene.scene import Scene, Variable
from vibopt.solve.box import closed
from vibopt.solve.choose import choose
from vibopt.solve.conflict import loosenings, outward, smallest_conflict
from vibopt.solve.method import Found, Progress
from vibopt.solve.physical import Impossible, impossible
from vibopt.solve.rows import direction
from vibopt.units import si_unit
from vibopt.values import SpeedRange


def solve(scene: Scene, *, method: str | None = None, progress: Progress | None = None, explain: bool = True) -> Design:
    """Answer a scene.

    Parameters
    ----------
    scene
        A scene without mistakes, from `read` or the Python API.
    method
        Name of a method to force; None lets vibopt choose.
    progress
        Called now and then with a stage and the part that is done (0 to 1).
    explain
        For an infeasible scene, look for the limits that clash and the loosening that helps.

    Returns
    -------
    Design
        Status, claim, values and evidence; every number was measured on the machine as built.

    Raises
    ------
    InputError
        The forced method does not exist, or does not take this scene.
    """
    clock = _Clock()
    program = pose(scene)
    clock.stage("pose")
    if scene.find_all is not None:
        return _find_all(scene, program, clock)
    if scene.is_analysis:
        return _analysis(scene, program, clock)
    found, reason_text = answer(program, scene, method, progress)
    clock.stage("solve")
    if found.x is None or found.status == "unbounded":
        return _nothing(scene, program, found, reason_text, clock, explain)
    return _something(scene, program, found, clock)


def answer(program: Program, scene: Scene, method: str | None, progress: Progress | None) -> tuple[Found, str]:
    """What a method says, with the physical reason where there is one."""
    finite = closed(program)
    clash = impossible(finite)
    if clash is not None and method is None:
        claim = "proven by the balance of forces on the machine, for any isolator"
        return Found("infeasible", None, claim, "physical bound"), _physical_words(scene, clash)
    chosen = choose(finite, method)
    found = chosen.solve(finite, progress)
    return _open_ends(finite, found, exact=chosen.name.startswith("closed_form")), ""


def _open_ends(program: Program, found: Found, *, exact: bool) -> Found:
    """What half-open ranges mean for an answer: no best design at an open end, no proof beyond a far one."""
    opened = [axis for axis in program.axes if axis.open_high or axis.open_low]
    if not opened:
        return found
    if found.x is None:
        if exact or found.status != "infeasible" or not any(axis.open_high for axis in opened):
            return found
        ends = ", ".join(f"{axis.path} = {axis.high:.3g} (SI)" for axis in opened if axis.open_high)
        return replace(found, status="unproven", claim=f"no design up to {ends}; nothing is proven about larger values")
    for i, axis in enumerate(program.axes):
        up, down = axis.open_high and found.x[i] >= 0.999 * axis.high, axis.open_low and found.x[i] <= 1.001 * axis.low
        if not up and not down:
            continue
        way = "grows without end" if up else "goes to zero"
        if program.aim is not None and direction(program.aim, program.aim.model, i) is not None:
            claim = f"every limit holds and the goal keeps improving as {axis.path} {way}"
            return replace(found, status="unbounded", claim=claim)
        claim = f"every limit holds; the goal comes ever nearer to its best value as {axis.path} {way}"
        return replace(found, status="feasible", claim=claim)
    return found


def _physical_words(scene: Scene, clash: Impossible) -> str:
    from vibopt.units import show

    force, motion = clash.limits
    limit = scene.limits[motion]
    assert isinstance(limit, HarmonicResponse)
    excitation = scene.excitations[names_for(scene, limit)[0]]
    at = show(excitation.from_rotation(clash.speed), excitation.speed.unit, excitation.speed.dimension)
    return (
        f"At {at} the machine is shaken by {show(clash.force, '', 'force')}. {force} lets at most "
        f"{show(clash.transmitted, '', 'force')} through, and {motion} lets inertia carry at most "
        f"{show(clash.inertia, '', 'force')}: no stiffness and no damping can do it. "
        f"A mass of at least {show(clash.needed, '', 'mass')} instead of {show(clash.mass, '', 'mass')} could."
    )


class _Clock:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def stage(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = now - self._last
        self._last = now


def _used(program: Program) -> Used:
    declared = program.model.n_free
    used = program.used_dof
    return Used(declared, used, reason(declared, used))


def _used_by(scene: Scene, program: Program) -> Used:
    declared = program.model.n_free
    needs = [on_needed(scene, program.model, one) for one in (*scene.limits.values(), *scene.measures.values())]
    used = max((model.n_free for model, form in needs if not isinstance(form, Monomials)), default=program.used_dof)
    used = max(used, program.used_dof)
    return Used(declared, used, reason(declared, used))


def _notes(scene: Scene, chosen: Mapping[str, float]) -> tuple[str, ...]:
    notes = list(scene.notes)
    for name, excitation in scene.excitations.items():
        if excitation.variation is None and not excitation.inherent and not excitation.speed.is_one_speed:
            notes.append(f"excitations.{name}: the amplitude is taken as the same at each of its own speeds.")
    notes += soft_floor(scene, chosen)
    return tuple(notes)


def soft_floor(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """A warning for every mount that stands on a body held less than ten times as stiffly."""
    machine = machine_of(scene, chosen)
    notes = []
    for mount in machine.joints:
        floor = mount.ends[1]
        if mount.stiffness == 0.0 or floor not in machine.masses or mount.ends[0] not in machine.masses:
            continue
        under = sum(one.stiffness for one in machine.joints if floor in one.ends and one is not mount)
        if 0.0 < under < 10.0 * mount.stiffness:
            notes.append(
                f"{floor} is held only {under / mount.stiffness:.2g} times as stiffly as {mount.name}: "
                "a mount chosen for a rigid floor would not do here."
            )
    return notes


def _analysis(scene: Scene, program: Program, clock: _Clock) -> Design:
    limits = checked_limits(scene, {})
    measures = checked_measures(scene, {})
    clock.stage("measure")
    good = all(one.met for one in limits.values())
    broken = [name for name, one in limits.items() if not one.met]
    claim = "every limit holds" if good else f"broken: {', '.join(broken)}"
    if not limits:
        claim = "measured; there is no limit to judge"
    return Design(
        scene=scene,
        status="met" if good else "violated",
        claim=f"{claim} (measured at every speed of each range)",
        goal=None,
        variables={},
        x=(),
        limits=limits,
        measures=measures,
        model=_used_by(scene, program),
        method="analysis",
        timings=clock.seconds,
        notes=_notes(scene, {}),
    )


def _find_all(scene: Scene, program: Program, clock: _Clock) -> Design:
    from vibopt.solve.find_all import permitted_speeds

    name = str(scene.find_all).removesuffix(".speed")
    excitation = scene.excitations[name]
    own = {
        key
        for key, one in scene.limits.items()
        if isinstance(one, HarmonicResponse) and name in names_for(scene, one) and speeds_for(scene, one, name) is None
    }
    found = permitted_speeds(program, name, excitation.own_bands(), own)
    clock.stage("solve")
    unit, dimension = excitation.speed.unit, excitation.speed.dimension

    def shown(omega: float) -> Shown:
        return Shown.of(excitation.from_rotation(omega), dimension, si_unit(dimension), unit)

    intervals = tuple((shown(low), shown(high)) for low, high in found)
    return Design(
        scene=scene,
        status="met" if found else "infeasible",
        claim="the complete set of speeds, with exact ends" if found else "no speed in the range meets every limit",
        goal=None,
        variables={},
        x=(),
        limits=checked_limits(scene, {}),
        measures=checked_measures(scene, {}),
        model=_used(program),
        method="exact crossings",
        timings=clock.seconds,
        found=intervals,
        notes=_notes(scene, {}),
    )


def _something(scene: Scene, program: Program, found: Found, clock: _Clock) -> Design:
    assert found.x is not None
    chosen = {variable.path: float(v) for variable, v in zip(scene.variables, found.x, strict=True)}
    limits = checked_limits(scene, chosen)
    measures = checked_measures(scene, chosen)
    broken = [name for name, one in limits.items() if not one.met]
    clock.stage("certify")
    status, claim = found.status, found.claim
    if broken:
        status = "check_failed"
        claim = f"{found.method} claims a design, but on the built machine it breaks {', '.join(broken)}"
    return Design(
        scene=scene,
        status=status,
        claim=claim,
        goal=goal_of(scene, chosen),
        variables={v.path: chosen_of(v, chosen[v.path]) for v in scene.variables},
        x=tuple(float(v) for v in found.x),
        limits=limits,
        measures=measures,
        model=_used(program),
        method=found.method,
        timings=clock.seconds,
        notes=_notes(scene, chosen),
        details=found.details,
    )


def goal_of(scene: Scene, chosen: Mapping[str, float]) -> tuple[str, Shown] | None:
    """The goal's name and its value on the built machine."""
    if scene.goal is None:
        return None
    response = scene.goal.response
    side = "at_most" if scene.goal.sense == "minimise" else "at_least"
    value = measure(scene, chosen, response, side).value
    return scene.goal.name, shown_value(response, value, response.unit or "")


def chosen_of(variable: Variable, value: float) -> Chosen:
    """A chosen value with its text, and the end of its range on which it rests."""
    at = ""
    if variable.values is None:
        if value <= variable.low * (1 + 1e-9):
            at = "from"
        elif value >= variable.high * (1 - 1e-9):
            at = "to"
    return Chosen(Shown.of(value, variable.dimension, si_unit(variable.dimension), variable.unit), at)


def _nothing(
    scene: Scene, program: Program, found: Found, reason_text: str, clock: _Clock, explain: bool
) -> Design:
    conflict = _conflict(scene, program, found) if found.status == "infeasible" and explain else None
    clock.stage("conflict")
    return Design(
        scene=scene,
        status=found.status,
        claim=found.claim,
        goal=None,
        variables={},
        x=(),
        limits={},
        measures={},
        model=_used(program),
        method=found.method,
        timings=clock.seconds,
        conflict=conflict,
        reason=reason_text,
        notes=tuple(scene.notes),
        details=found.details,
    )


def _conflict(scene: Scene, program: Program, found: Found) -> Conflict | None:
    finite = closed(program)

    def ask(part: Program) -> Found:
        if part.aim is None and impossible(part) is not None:
            return Found("infeasible", None, "", "physical bound")
        return choose(part, None).solve(part)

    clash = smallest_conflict(finite, ask)
    rows = []
    for one in loosenings(finite, clash, ask):
        response = scene.limits[one.limit.name]
        now, new = user_bound(one.limit, one.limit.bound), user_bound(one.limit, one.bound)
        side = "at_most" if new > now else "at_least"
        given = response.at_most if side == "at_most" else response.at_least
        unit = getattr(given, "unit", "")
        shown = outward_shown(response, new, unit, side)
        rows.append((one.limit.name, shown_value(response, now, unit), shown))
    names = tuple(dict.fromkeys(limit.name for limit in clash))
    return Conflict(names, tuple(rows), found.claim) if names else None


def user_bound(limit: Limit, value: float) -> float:
    """A bound of the form as the user counts it."""
    return 1.0 - value if limit.complement else value


def outward_shown(response: Response, value: float, unit: str, side: str, digits: int = 3) -> Shown:
    """A bound rounded in the user's unit so that it still works [SI]."""
    from vibopt.units import read_quantity, to_unit

    text_unit = unit or Shown.of(value, response.dimension, "", "").shown.split(" ", 1)[-1]
    try:
        rounded = outward(to_unit(value, text_unit, response.dimension), side, digits)
        back = read_quantity(f"{rounded:.12g} {text_unit}".strip(), response.dimension, amplitude=response.amplitude)
    except ValueError:
        return shown_value(response, outward(value, side, digits), unit)
    return shown_value(response, back.value, unit)


def shown_value(response: Response, value: float, unit: str) -> Shown:
    """A response's value in the user's unit."""
    return Shown.of(value, response.dimension, si_unit(response.dimension), unit, amplitude=response.amplitude)


def checked_limits(scene: Scene, chosen: Mapping[str, float]) -> dict[str, Checked]:
    """Every limit on the built machine; a limit with two bounds has two rows."""
    rows: dict[str, Checked] = {}
    machine = machine_of(scene, chosen)
    for name, response in scene.limits.items():
        sides = [side for side in ("at_most", "at_least", "outside") if getattr(response, side, None) is not None]
        for side in sides:
            key = name if side == sides[0] else f"{name} ({side})"
            rows[key] = _checked(scene, machine, name, response, side)
    return rows


def checked_measures(scene: Scene, chosen: Mapping[str, float]) -> dict[str, Checked]:
    """Every measure on the built machine."""
    machine = machine_of(scene, chosen)
    return {name: _checked(scene, machine, name, one, "") for name, one in scene.measures.items()}


def _checked(scene: Scene, machine: Machine, name: str, response: Response, side: str) -> Checked:
    found = measure_on(scene, machine, response, side or _natural_side(response))
    given = getattr(response, side, None) if side else None
    unit = response.unit or getattr(given, "unit", "") or ""
    margin = 0.0
    limit = None
    if side == "outside":
        assert isinstance(given, SpeedRange)
        band = min(given.bands, key=lambda one: -min(found.value - one.low, one.high - found.value))
        depth = min(found.value - band.low, band.high - found.value)
        edge = band.low if found.value - band.low <= band.high - found.value else band.high
        margin = -depth / edge if edge else -depth
        limit = shown_value(response, edge, unit)
    elif given is not None:
        size = abs(1.0 - given.value if response.complement else given.value) or 1.0
        margin = (given.value - found.value) / size if side == "at_most" else (found.value - given.value) / size
        limit = shown_value(response, given.value, unit)
    return Checked(
        name=name,
        response=response.response,
        place=place_of(response),
        side=side,
        value=shown_value(response, found.value, unit),
        limit=limit,
        margin=float(margin) if np.isfinite(margin) else float("-inf") if margin < 0 else float("inf"),
        active=bool(side) and abs(margin) <= 1e-6,
        met=not side or margin >= -TOLERANCE,
        worst_at={key: _speed(scene, key, speed) for key, speed in found.speeds.items()},
    )


def _natural_side(response: Response) -> str:
    """The side that a measure without a bound shows: the worst."""
    return "at_least" if response.complement or response.response == "insertion_loss" else "at_most"


def _speed(scene: Scene, name: str, omega: float) -> Shown:
    excitation = scene.excitations[name]
    dimension = excitation.speed.dimension
    return Shown.of(excitation.from_rotation(omega), dimension, si_unit(dimension), excitation.speed.unit)


__all__ = ["InputError", "Modulus", "NaturalFrequency", "solve"]
