"""What boxes of all variables can bound, and in words why not what they cannot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vibopt.forms.hung_on_boxes import PLACES, places_of
from vibopt.forms.monomials import mounts
from vibopt.mechanics.model import INERTIA
from vibopt.program.program import Aim, Axis, Limit, Program
from vibopt.solve.method import Found

GROUPS, FREE, HUNG = 6, 6, 12
"""Groups of impedances of a response, and variables, up to which boxes are looked at: each doubles the work.

Where all that is chosen acts on a few places it does not, and there are more variables."""
FAR = float(np.log(3.0))
"""Log of the ratio of a goal to a bound that says next to nothing of it."""


def with_reason(program: Program, found: Found, unasked: str = "") -> Found:
    """An answer that is not proven with the words why nothing useful is known of how far the best may be.

    `unasked` is why boxes were not looked at although they could be.
    """
    aim = program.aim
    if found.status != "feasible" or found.x is None or aim is None:
        return found
    value = max(piece.sense * piece.form.value(piece.model, found.x) for piece in aim.pieces)
    if not np.isfinite(value) or _near(value, found.bound):
        return found
    why = _left_out(program) or refusal(program, aim.pieces) or unasked
    if not why or (aim.form.poles is not None and not unbounded(aim.pieces) and why.startswith("the goal")):
        why = "boxes of all variables leave too much open"
    return replace(found, claim=f"{found.claim}; no useful bound: {why}")


def _left_out(program: Program) -> str:
    """The limit whose lack of bounds keeps a mean square without a useful one; empty where it is something else."""
    if program.aim is None or not program.aim.form.random or unbounded(program.aim.pieces):
        return ""
    loose = unbounded(program.limits)
    return f"limit {loose.name} {loose.form.no_bounds}" if isinstance(loose, Limit) else ""


def _near(value: float, bound: float) -> bool:
    """Whether a goal to be made small, and a bound of it, are of one size."""
    if not np.isfinite(bound):
        return False
    return bound == value or (bound * value > 0.0 and abs(np.log(value / bound)) <= FAR)


def refusal(program: Program, asked: Sequence[Limit | Aim]) -> str:
    """Why boxes say nothing of what is asked; empty where they do."""
    free = [axis for axis in program.axes if axis.high > axis.low]
    listed = [axis for axis in free if axis.values is not None]
    endless = [axis.path for axis in program.axes if axis.open_high or not np.isfinite(axis.high)]
    zero = [axis.path for i, axis in enumerate(program.axes) if not (_above(axis) or _fades(program, i))]
    if program.ties and program.ranged is None:
        return "parts of a catalogue are compared with each other, not with what lies between them"
    if free and len(listed) == len(free):
        return "all that may be chosen is listed: combinations are compared with each other"
    if endless:
        return f"the range of {endless[0]} has no end: write one"
    if zero:
        return f"the range of {zero[0]} begins at zero: begin it above"
    most = HUNG if len(free) > FREE and on_few_places(program) else FREE
    if len(free) > most:
        return f"{len(free)} numbers are open, and bounds are known of up to {most}"
    unknown = [why for one in asked if not isinstance(one, Limit) and (why := no_rows(one))]
    if unknown:
        return f"the goal {unknown[0]}"
    moved = any(one.form.powers is None for one in asked)
    said = any(not no_rows(one) for one in (asked if moved else program.limits))
    return "" if free and said else "no limit has bounds on boxes of designs"


def on_few_places(program: Program, most: int = PLACES) -> bool:
    """Whether all that can be chosen acts on so many places of a machine that something is asked of."""
    for part in program.parts:
        form = part.form.harmonic
        if form is not None and form.line is not None:
            hosted = places_of(part.model, form.line.vector, form.output.signs)
            if hosted is not None and len(hosted.places) <= most:
                return True
    return False


def _above(axis: Axis) -> bool:
    return axis.low > 0.0 and not axis.open_low


def _fades(program: Program, index: int) -> bool:
    """Whether a range begins at zero, and what its variable adds, which is no inertia, is nothing there."""
    axis = program.axes[index]
    if axis.low < 0.0 or axis.high <= 0.0 or axis.values is not None:
        return False
    steps = [part.form.powers.exponents[:, index] for part in program.parts if part.form.powers is not None]
    for part in program.parts:
        own = part.model.exponents[:, index]
        steps += [own, -np.abs(own[part.model.kinds == INERTIA])]
        if part.form.harmonic is not None:
            steps.append(mounts(part.model, part.form.harmonic.output).exponents[:, index])
    return all((some >= 0.0).all() for some in steps)


def unbounded(parts: Sequence[Limit | Aim]) -> Limit | Aim | None:
    """The first that has no bounds on boxes; of a pole's number they are of the most, and none of a least one."""
    from vibopt.forms.bounds import FormBounds

    def told(part: Limit | Aim) -> bool:
        most = isinstance(part, Aim) and part.form.closed_to(part.model) > 0.0
        return FormBounds(part.model, part.form, np.zeros(0)).bounded and (part.least_wanted or not most)

    return next((part for part in parts if not told(part)), None)


def no_rows(part: Limit | Aim) -> str:
    """Why what is asked has no rows on boxes, behind its name; empty where it has."""
    form, powers = part.form.harmonic, part.form.powers
    most = part.sense > 0.0 if isinstance(part, Aim) else part.side == "at_most"
    if not isinstance(part, Aim) and not 0.0 < part.bound < np.inf:
        return "has a bound of zero or none"
    if powers is not None:
        kept = bool((powers.scale > 0.0).all()) and (most or (len(powers.scale) == 1 and part.least_wanted))
        return "" if kept else "is a sum that is to be great, or a difference: of those no bounds are known"
    if form is None and not (part.form.ratio and part.form.bounded(part.model)):
        return part.form.no_bounds
    if not most:
        return "is the least of a response, of which bounds are known of the greatest only"
    if form is not None and form.line is None:
        return "counts several harmonics or excitations, and bounds are known of one"
    if form is not None and (part.model.spins or form.endless):
        return "is a response of what spins or has no end at standstill, of which no bounds are known"
    groups = part.form.groups(part.model)
    count = 0 if groups is None else len(groups.members)
    return f"hangs on {count} links and masses, and bounds are known of up to {GROUPS}" if count > GROUPS else ""
