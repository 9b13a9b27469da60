"""A bound that physics sets on every isolator: m w^2 X >= F - T for one excited rigid body.

The forces of all links on the body sum to its excitation plus m w^2 times its displacement, in
amplitude; whatever stiffness and damping, |m w^2 u| + |force of the links| >= |F|.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Modulus
from vibopt.mechanics.model import INERTIA
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Band

_MARGIN = 1e-9


@dataclass(frozen=True, slots=True)
class Impossible:
    """Two limits that no isolator meets together.

    limits
        Names: of the force, of the motion.
    speed
        Speed at which they clash most [rad/s].
    force, transmitted, inertia
        Amplitudes there [N]: excitation, allowed force, m w^2 times the allowed displacement.
    mass, needed
        Greatest mass that may be chosen, and the least mass with which both could hold [kg].
    """

    limits: tuple[str, str]
    speed: float
    force: float
    transmitted: float
    inertia: float
    mass: float
    needed: float


def impossible(program: Program) -> Impossible | None:
    """The clash that holds for every design, or None where this bound says nothing."""
    model = program.model
    if program.several or model.n_free != 1 or model.n_coords != 1:
        return None
    plain = [
        (limit, limit.form.harmonic)
        for limit in program.limits
        if limit.side == "at_most" and limit.form.harmonic is not None and limit.form.ratio
    ]
    forces = [one for one in plain if _is_total_force(*one)]
    motions = [one for one in plain if not one[1].output.signs.any() and abs(one[1].output.row[0]) == 1.0]
    found = [clash for a in forces for b in motions if (clash := _clash(program, a, b)) is not None]
    return max(found, key=lambda one: one.needed, default=None)


def _is_total_force(limit: Limit, form: Modulus) -> bool:
    """All links of the body are counted, with one sign."""
    links = limit.model.across | (limit.model.kinds != INERTIA)
    signs = form.output.signs * limit.model.vectors[:, 0]
    return (
        bool(links.any())
        and bool(np.all(np.abs(signs[links]) == 1.0))
        and len(set(signs[links])) == 1
        and (not form.output.shared_by)
    )


def _clash(program: Program, pushed: tuple[Limit, Modulus], moved: tuple[Limit, Modulus]) -> Impossible | None:
    (force, push), (motion, move) = pushed, moved
    first, second = push.drives[0], move.drives[0]
    if first.name != second.name:
        return None
    speeds = _common(first.bands, second.bands)
    if not len(speeds):
        return None
    line, other = first.lines[0], second.lines[0]
    omega = line.order * speeds
    shaken = np.abs(line.amplitude.at(speeds) * line.vector[0])
    really = np.abs(other.amplitude.at(speeds) * other.vector[0])
    with np.errstate(divide="ignore", invalid="ignore"):
        allowed = force.bound * really / shaken
        stroke = motion.bound / omega**move.output.power
        needed = np.nan_to_num((really - allowed) / (omega**2 * stroke), nan=0.0, posinf=0.0, neginf=0.0)
    worst = int(np.argmax(needed))
    chosen = (program.model.kinds == INERTIA) & ~program.model.inerters
    mass = float(program.model.extent(program.low, program.high)[1][chosen].sum())
    if not needed[worst] > mass * (1.0 + _MARGIN):
        return None
    return Impossible(
        (force.name, motion.name),
        float(speeds[worst]),
        float(really[worst]),
        float(allowed[worst]),
        float(mass * omega[worst] ** 2 * stroke[worst]),
        mass,
        float(needed[worst]),
    )


def _common(first: tuple[Band, ...], second: tuple[Band, ...]) -> FloatArray:
    """Speeds that both limits look at; ends and points between, any one of which is a proof."""
    found: list[FloatArray] = []
    for a in first:
        for b in second:
            low, high = max(a.low, b.low), min(a.high, b.high)
            if low <= high:
                found.append(np.linspace(low, high, 33 if low < high else 1))
    return np.concatenate(found) if found else np.zeros(0)
