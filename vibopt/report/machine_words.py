"""A design in words: verdict, margins, places, what was assumed.  Shared by terminal, figures and report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from math import inf, isfinite

from vibopt.answer.answer import odds_said
from vibopt.answer.blocks import spoken
from vibopt.answer.entry import Entry
from vibopt.errors import InputError, counted
from vibopt.excitations import Excitation
from vibopt.scene.open_places import asked_positions
from vibopt.scene.places import bound_parts, place_of
from vibopt.scene.scene import MAXIMISE, Design, Scene, Variable
from vibopt.signals import Amplitude
from vibopt.units import plain, show
from vibopt.units.spelling import split_detector
from vibopt.values.fields import Fact, rule_of

ENDS = {"from": "at the lower end of its range", "to": "at the upper end of its range"}
PEAK = "An amplitude is peak (pk, zero to peak) unless pp or rms is written behind its unit."
MOST_LISTED = 12
THOROUGH = "`vibopt explain FILE --thorough`"
"""What computes all that an answer leaves out because of the work."""
"""More values than this are not listed one by one."""

HELD = ("optimal", "feasible", "met")
_PLAIN = {
    "optimal": "",
    "feasible": "all limits hold; that nothing better exists is not proven",
    "met": "all limits hold",
    "violated": "the machine breaks {broken}",
    "infeasible": "no design meets all limits",
    "unbounded": "the goal has no best value",
    "unproven": "no design was found, and none was proven impossible",
    "check_failed": "a method claimed this design, the independent check refused it",
}


def goal_words(design: Design) -> str:
    """What was made best, and how far: "greatest stiffness of mount is 6.957 MN/m"."""
    if design.goal is None or design.scene.goal is None or design.status == "unbounded":
        return ""
    best = "greatest" if design.scene.goal.sense == MAXIMISE else "least"
    response = design.scene.goal.response
    what = spoken(response.response, place_of(response))
    if "rounded" in design.details and design.status != "optimal":
        return f"{what} is {design.goal[1].shown} with rounded values"
    worst = design.tolerances is not None and design.tolerances.goal_off
    return f"{best} {what} is {design.goal[1].shown}{' in the worst machine' if worst else ''}"


def verdict(design: Design) -> str:
    """What the first line of the answer says behind its status, without its proof."""
    if design.found is not None and design.status != "check_failed":
        return found_words(design)
    said = status_words(design)
    if design.status == "met" and not design.limits:
        said = "no limit was set; the measures below are what was asked"
    if design.status in ("met", "feasible") and (odds := odds_said(design)):
        held, end, rest = said.partition(";")
        said = f"{held}, {odds}{end}{rest}"
    return "; ".join(filter(None, (goal_words(design), said)))


def status_words(design: Design) -> str:
    """What its status means; of limits that do not hold which."""
    broken = listed([f'"{name}"' for name, limit in design.limits.items() if not limit.met])
    if design.status == "violated" and not broken:
        return "a whirl of the machine grows without end"
    if design.status == "unproven" and odds_said(design):
        return "it cannot be told whether enough of all machines keep every limit"
    return _PLAIN["violated" if broken and design.status in HELD else design.status].format(broken=broken)


def found_words(design: Design) -> str:
    """How many intervals `find_all` gave."""
    count = len(design.found or ())
    asked = f"all limits hold for {design.scene.find_all} in"
    return f"{asked} {counted(count, 'intervals')}" if count else f"no {design.scene.find_all} meets all limits"


def interval(low: Entry, high: Entry) -> str:
    """One interval, "540 rpm to 749 rpm"; one point alone."""
    return low.shown if low.value == high.value else f"{low.shown} to {high.shown}"


def off_words(off: Mapping[str, float]) -> str:
    """By how much numbers are off: "links.mount.stiffness -20 %, mounts.foot.1 and 4 stiffness +20 %"."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for path, part in off.items():
        sign = "+" if part > 0.0 else "-"
        size = f"{plain(1e3 * abs(part), 3)} mm" if ".centre." in path else f"{plain(100.0 * abs(part), 3)} %"
        family, name, *steps = path.split(".")
        number = steps.pop(0) if family == "mounts" and steps[0].isdigit() else ""
        groups.setdefault((f"{family}.{name}", ".".join(steps), f"{sign}{size}"), []).append(number)
    return ", ".join(_off_group(owner, steps, size, numbers) for (owner, steps, size), numbers in groups.items())


def _off_group(owner: str, steps: str, size: str, numbers: list[str]) -> str:
    """One number of one device, or of several mounts of a group."""
    if numbers == [""]:
        return f"{owner}.{steps} {size}"
    return (
        f"{owner}.{numbers[0]}.{steps} {size}"
        if len(numbers) == 1
        else f"{owner}.[{', '.join(numbers)}].{steps} {size}"
    )


def tolerance_rows(design: Design) -> list[tuple[str, str, str]]:
    """The answer without tolerances beside the one with them: name, without, with."""
    both = design.tolerances
    if both is None or (both.goal is None and not both.variables):
        return []
    rows = []
    if design.goal is not None and both.goal is not None:
        rows.append((design.goal[0], both.goal.shown, design.goal[1].shown))
    bought = {path for part in bound_parts(design.scene) for path in part.paths}
    for path, name in both.parts.items():
        rows.append((path, name, design.places[path].value if path in design.places else "none"))
    for path, variable in both.variables.items():
        if path not in bought:
            rows.append(
                (path, variable.shown, design.variables[path].value.shown if path in design.variables else "none")
            )
    return rows


def worst_rows(design: Design) -> list[tuple[str, str]]:
    """Per limit, measure and the goal the machine on which it is worst."""
    rows = [
        (name, off_words(checked.off))
        for name, checked in (*design.limits.items(), *design.measures.items())
        if checked.off
    ]
    if design.tolerances is not None and design.tolerances.goal_off and design.goal is not None:
        rows.append((f"goal: {design.goal[0]}", off_words(design.tolerances.goal_off)))
    return rows


def ranges_of(scene: Scene) -> dict[str, str]:
    """What may be chosen in each variable, positions of mounts included, by path."""
    return {variable.path: range_words(variable) for variable in (*asked_positions(scene).values(), *scene.variables)}


def range_words(variable: Variable) -> str:
    """What may be chosen: "10 kN/m to 1 GN/m", "one of 1 MN/m, 2 MN/m"."""
    if variable.choice.options:
        if len(variable.choice.options) > MOST_LISTED:
            ends = (_short(value, variable) for value in (variable.low, variable.high))
            return f"one of {len(variable.choice.options)} values from {' to '.join(ends)}"
        return "one of " + ", ".join(_short(option, variable) for option in variable.choice.options)
    low, high = _short(variable.low, variable), _short(variable.high, variable)
    whole = ", whole" if variable.choice.whole else ""
    if not isfinite(variable.high):
        return f"{low} or more{whole}" if variable.low > 0 else f"any{whole}"
    return f"{low} to {high}{whole}" if variable.low else f"0 to {high}{whole}"


def _short(value: float, variable: Variable) -> str:
    """In the user's unit, unless another one saves a row of zeros."""
    text = show(value, variable.unit, variable.dimension)
    number = text.partition(" ")[0]
    return text if len(number) <= 5 else show(value, "", variable.dimension)


def quiet_notes(design: Design, notes: Iterable[str]) -> list[str]:
    """Without the reading of amplitudes where nothing that is asked is one: then it changes nothing."""
    asked = design.scene.responses.values()
    return [note for note in notes if note != PEAK or any(response.amplitude for response in asked)]


def model_words(design: Design) -> str:
    """Degrees of freedom declared and used."""
    if design.model is None:
        return ""
    count, used, why = design.model.declared_dof, design.model.used_dof, design.model.why
    said = f"{counted(count, 'degrees of freedom')} declared, {used} needed"
    if not why:
        return said
    return why if "declared" in why else f"{said}: {why}"


def conflict_words(design: Design) -> list[str]:
    """Which limits cannot hold together, how that is known, and what mends it."""
    conflict = design.conflict
    if conflict is None:
        return []
    proof = [f"  {conflict.proof}"] if conflict.proof and conflict.proof != design.claim else []
    one = [f"Smallest loosening of one: {', or '.join(conflict.steps)}."] if conflict.steps else []
    every = design.nearest.together if design.nearest is not None else ()
    return [conflict.said('"'), *proof, *conflict.others_said('"'), *one, *every]


def listed(words: list[str], last: str = "and") -> str:
    """The words in a row: `a, b and c`."""
    return f" {last} ".join(filter(None, (", ".join(words[:-1]), words[-1]))) if words else ""


def next_step(design: Design) -> tuple[str, str]:
    """What to type next, with FILE for the file, and what for; "" where nothing helps."""
    scene = design.scene
    if design.status == "infeasible":
        loosened = _loosened(design)
        return (f"vibopt solve FILE {loosened}", "with the smallest loosening") if loosened else _WHY
    if design.status in ("unproven", "unbounded"):
        return ("vibopt report FILE -o NAME.html", "see its curves") if odds_said(design) else _WHY
    if design.status == "check_failed":
        return "", ""
    exact = any(variable.values is None for variable in scene.variables) and "rounded" not in design.details
    if scene.finds == "values":
        (one,) = scene.variables
        ends = "..".join(show(end, one.unit, one.dimension, digits=6) for end in (one.low, one.high))
        return f'vibopt sweep FILE --vary {one.path}="{ends}" --figure NAME.svg', "see its limits over the range"
    wider = _wider(design) if design.status in ("optimal", "feasible") and exact else ""
    if wider:
        return f"vibopt solve FILE {wider}", "see what a wider range gives, where it rests at its end"
    if design.status in ("optimal", "feasible") and exact:
        return "vibopt solve FILE --round 3", "round the values for the drawing"
    if design.found is not None or design.status == "violated":
        return "vibopt report FILE -o NAME.html", "see its curves"
    return "vibopt report FILE --sheet -o NAME.html", "print a page to sign"


_WHY = ("vibopt explain FILE --thorough", "learn why, with all that can be said")


def _wider(design: Design) -> str:
    """The range of the first number that rests at its end, half or twice as far, as a change of the file; "" if none.

    What the file may not say (a ratio above its greatest) is not proposed.
    """
    from vibopt.scene.read import with_changes

    for variable in design.scene.variables:
        chosen = design.variables.get(variable.path)
        end = chosen.at_bound if chosen is not None else ""
        wide = {"from": 0.5 * variable.low, "to": 2.0 * variable.high}.get(end, 0.0)
        if not 0.0 < wide < inf:
            continue
        change = show(wide, variable.unit, variable.dimension, digits=3)
        with suppress(InputError):
            with_changes(design.scene, {f"{variable.path}.{end}": change})
            return f'--set {variable.path}.{end}="{change}"'
    return ""


def _loosened(design: Design) -> str:
    """The least loosening that helps, as a change of the file; "" where there is none."""
    least = None if design.conflict is None else design.conflict.least
    if least is None:
        return ""
    name, now, then = least
    response = design.scene.limits.get(name)
    for side in ("at_most", "at_least"):
        bound = getattr(response, side, None)
        if bound is not None and abs(bound.value - now.value) <= 1e-9 * abs(now.value):
            return f'--set limits.{name}.{side}="{then.shown}"'
    return ""


def notes_of(scene: Scene) -> list[str]:
    """Readings of units and assumptions that an answer rests on."""
    notes = list(scene.notes)
    if _says_amplitude(scene):
        notes.append(PEAK)
    for name, excitation in scene.excitations.items():
        varies = _varies(excitation)
        if varies:
            notes.append(f"{name}: {varies}")
    return notes


def _says_amplitude(scene: Scene) -> bool:
    """Whether an amplitude is given or bounded without a word that says peak, pp or rms."""
    given = [getattr(excitation, key) for excitation in scene.excitations.values() for key in _amplitudes(excitation)]
    if any(isinstance(fact, Fact) and not split_detector(fact.unit)[1] for fact in given):
        return True
    bounds = [bound for limit in scene.limits.values() if limit.amplitude for bound in (limit.at_most, limit.at_least)]
    return any(bound is not None and bound.detector is None for bound in bounds) or any(
        measure.amplitude and not measure.unit for measure in scene.measures.values()
    )


def _amplitudes(excitation: Excitation) -> list[str]:
    rules = {key: rule_of(type(excitation), key) for key in type(excitation).model_fields}
    return [key for key, rule in rules.items() if rule is not None and rule.amplitude]


def _varies(excitation: Excitation) -> str:
    """How its amplitude goes with speed, as the file says."""
    variation = excitation.variation
    what = {"base_motion": "the motion"}.get(excitation.kind, "the force")
    if isinstance(variation, Amplitude):
        return f"{what} follows the table given for it, linear between its rows."
    if variation == "constant":
        return f"{what} keeps its amplitude at every speed."
    if variation is not None:
        return f"the amplitude of {what} grows with {str(variation).replace('^2', ' squared')}."
    return ""
