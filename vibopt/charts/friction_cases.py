"""Dry friction in the charts: how far one mass swings on a link that slips, stops or holds.

Asked are vibopt, DOP853 with events, and equivalent viscous damping; the truth goes from stop to stop in closed form,
from rest, until it repeats.  Time is counted in radians of the force, lengths in static deflections under it:
r^2 z'' + 2 zeta r z' + z + f sgn(z') = cos(theta).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.fidelity import Fidelity, of_kinds
from vibopt.charts.trial import DEFAULT, Case, Said, Table, greatest_in, judged_number
from vibopt.charts.verdicts import FEASIBLE
from vibopt.records import dataclass
from vibopt.scene.read import from_text

FRICTION = "friction"
CLOSE = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
"""Relative tolerances of the integrator."""
_REPEATS, _CYCLES, _PIECES = 100.0, 400, 200
"""Change of the greatest from cycle to cycle that ends it, over the tolerance; most cycles, and most stops in one."""
_SETTLED, _ROUND, _MOST, _LOOKS = 1e-13, 1e-15, 4000, 400
"""Of the truth: change of the state that ends it, as a part and by rounding; half cycles, looks in one."""


@dataclass(frozen=True)
class Slip:
    """One mass under a force of one.

    r, ratio, friction
        Frequency over the natural one; viscous damping over critical; friction over the amplitude of the force.
    """

    r: float
    ratio: float
    friction: float

    @property
    def text(self) -> str:
        """The problem file: a spring and a force of one, at 1 rad/s."""
        dash = f'damping = "{2.0 * self.ratio * self.r!r} N s/m"\n' if self.ratio else ""
        return (
            f'title = "Mass on a link that rubs"\n\n[bodies.mass]\nmass = "{self.r**2!r} kg"\n\n[links.mount]\n'
            f'between = ["mass", "ground"]\nstiffness = "1 N/m"\n{dash}friction_force = "{self.friction!r} N"\n\n'
            '[excitations.force]\nkind = "force"\non = "mass"\namplitude = "1 N"\nspeed = "1 rad/s"\n\n'
            '[measures.greatest]\nresponse = "displacement"\nof = "mass"\n'
        )


def by_vibopt(slip: Slip) -> Said:
    """The greatest in a cycle, as it is told of the problem file."""
    return greatest_in(from_text(slip.text, name="job"))


def by_dop853(slip: Slip, close: float = 1e-9) -> Said:
    """scipy's Runge-Kutta method, stopped and begun anew where the mass stops, from rest until the greatest repeats."""
    from scipy.integrate import solve_ivp

    theta, z, v, last, most = 0.0, 0.0, 0.0, 0.0, 0.0

    def stops(_: float, now: FloatArray) -> float:
        return float(now[1])

    stops.terminal = True  # type: ignore[attr-defined]
    for cycle in range(_CYCLES):
        last, most, until, pieces = most, 0.0, 2.0 * np.pi * (cycle + 1), 0
        while theta < until - 1e-12:
            pieces += 1
            if pieces > _PIECES:  # a coarse step turns back at once, for ever
                return Said("unproven", f"more than {_PIECES} stops in cycle {cycle + 1}", most)
            if v == 0.0:
                push = np.cos(theta) - z
                side = np.sign(push) if abs(push) > slip.friction else 0.0
                if not side:
                    theta, side = _leaves(slip, theta, z, until)
                    if theta >= until:
                        break
            else:
                side = np.sign(v)

            def rates(at: float, now: FloatArray, side: float = float(side)) -> list[float]:
                rest = np.cos(at) - side * slip.friction - now[0]
                return [now[1], rest / slip.r**2 - 2.0 * slip.ratio / slip.r * now[1]]

            stops.direction = -side  # type: ignore[attr-defined]
            found: Any = solve_ivp(rates, (theta, until), [z, v], "DOP853", events=stops, rtol=close, atol=1e-3 * close)
            theta, (z, v) = float(found.t[-1]), found.y[:, -1].tolist()
            v = 0.0 if found.status == 1 else v
            most = max(most, float(np.abs(found.y[0]).max()))
        theta, most = until, max(most, abs(z))
        if abs(most - last) <= _REPEATS * close * most:
            words = f"repeats to {_REPEATS * close:g} in cycle {cycle + 1}"
            return Said("feasible", words, most, within=10.0 * _REPEATS * close)
    return Said("unproven", f"does not repeat in {_CYCLES} cycles", most)


def by_equivalent_viscous(slip: Slip) -> Said:
    """A damper that takes as much in a cycle: (1 - r^2)^2 Z^2 + (2 zeta r Z + 4 f / pi)^2 = 1."""
    beside, push = 2.0 * slip.ratio * slip.r, 4.0 / np.pi * slip.friction
    square = (1.0 - slip.r**2) ** 2 + beside**2
    root = max((beside * push) ** 2 - square * (push**2 - 1.0), 0.0)
    size = max(float((np.sqrt(root) - beside * push) / square), 0.0)
    return Said("optimal", "a damper that takes as much in a cycle" if size else "nothing moves", size)


METHODS: dict[str, Callable[[Slip], Said]] = {
    DEFAULT: by_vibopt, **{f"dop853 {close:g}": partial(by_dop853, close=close) for close in CLOSE},
    "equivalent viscous": by_equivalent_viscous,
}  # fmt: skip
QUICK_METHODS = {name: one for name, one in METHODS.items() if name not in ("dop853 1e-05", "dop853 1e-09")}
HARD_METHODS = {name: METHODS[name] for name in (DEFAULT, "dop853 1e-09", "equivalent viscous")}


@cache
def truth(slip: Slip) -> float:
    """Slip for slip in closed form, each stop by Brent's method, from rest until half a cycle repeats with its sign."""
    state, best = np.zeros(2), 0.0
    for _ in range(_MOST):
        behind, best = _half(slip, state)
        if np.abs(state + behind).max() <= _SETTLED * best + _ROUND:
            return best
        state = -behind
    return best


def _half(slip: Slip, state: FloatArray) -> tuple[FloatArray, float]:
    """State behind half a cycle from theta = 0, and its greatest place."""
    from scipy.optimize import brentq

    theta, z, v, best = 0.0, float(state[0]), float(state[1]), abs(float(state[0]))
    while theta < np.pi:
        side = float(np.sign(v))
        if not side:
            push = np.cos(theta) - z
            side = float(np.sign(push)) if abs(push) > slip.friction else 0.0
        if not side:
            theta, side = _leaves(slip, theta, z, np.pi)
            if theta >= np.pi:
                break
        moved = _moved(slip, theta, z, v, side)
        tau = np.linspace(0.0, np.pi - theta, _LOOKS)[1:]
        back = np.flatnonzero(side * moved(tau)[1] <= 0.0)
        back = back[back > 0] if not v else back
        if len(back):
            low = tau[back[0] - 1] if back[0] else 0.0
            length = float(brentq(lambda at, moved=moved: float(moved(np.array([at]))[1][0]), low, tau[back[0]],
                                  xtol=1e-15))  # fmt: skip
        else:
            length = np.pi - theta
        places, speeds = moved(np.array([length]))
        theta, z, v = theta + length if len(back) else np.pi, float(places[0]), 0.0 if len(back) else float(speeds[0])
        best = max(best, abs(z))
    return np.array([z, v]), best


Moved = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


def _moved(slip: Slip, theta: float, z: float, v: float, side: float) -> Moved:
    """Place and speed so long behind the beginning of a slip."""
    fade, turn = slip.ratio / slip.r, np.sqrt(1.0 - slip.ratio**2) / slip.r
    driven = np.exp(1j * theta) / (1.0 - slip.r**2 + 2j * slip.ratio * slip.r)
    place = z - driven.real + side * slip.friction
    rate = (v + driven.imag + fade * place) / turn

    def moved(tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        shrunk, force = np.exp(-fade * tau), driven * np.exp(1j * tau)
        free = shrunk * (place * np.cos(turn * tau) + rate * np.sin(turn * tau))
        slope = shrunk * turn * (rate * np.cos(turn * tau) - place * np.sin(turn * tau)) - fade * free
        return free + force.real - side * slip.friction, slope - force.imag

    return moved


def _leaves(slip: Slip, theta: float, z: float, until: float) -> tuple[float, float]:
    """When friction holds no longer, and the sense of the slip; `until` where it holds to there."""
    found = []
    for side in (1.0, -1.0):
        level = z + side * slip.friction
        if abs(level) < 1.0:
            found.append((theta + (-side * np.arccos(level) - theta) % (2.0 * np.pi), side))
    first = min(found, default=(until, 0.0))
    return first if first[0] < until else (until, 0.0)


def speed(*, quick: bool) -> Table:
    """From half the resonance to twice it, with weak and strong friction."""
    rows = [Slip(r, 0.02, f) for r in ((0.6, 0.98, 1.5) if quick else (0.6, 0.9, 0.98, 1.05, 1.5)) for f in (0.2, 0.6)]
    cases = [(_case(row, FRICTION), row) for row in rows]
    left = ("0.9 and 1.05 of the resonance", "3 runs instead of 1", "dop853 at five tolerances") if quick else ()
    return Table(cases, QUICK_METHODS if quick else METHODS, judged_number, 1 if quick else 3, cases[-1:], left=left)


def hard(*, quick: bool) -> Table:
    """Next to the resonance, at the edge of holding, with stops."""
    rows = [
        ("friction next to resonance", Slip(1.02, 0.005, 0.79)), ("friction next to resonance", Slip(1.0, 0.01, 0.7)),
        ("at the edge of holding", Slip(0.8, 0.02, 0.95)), ("at the edge of holding", Slip(0.8, 0.02, 0.98)),
        ("at the edge of holding", Slip(1.5, 0.02, 0.98)),
        ("stops in the cycle", Slip(0.4, 0.02, 0.5)), ("stops in the cycle", Slip(0.15, 0.02, 0.3)),
        ("stops in the cycle", Slip(0.15, 0.3, 0.7)),
    ]  # fmt: skip
    cases = [(_case(slip, family), slip) for family, slip in rows]
    return Table(cases, HARD_METHODS, judged_number, 1, cases[-1:])


def fidelity(*, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    """Slip for slip, and with the damper that takes as much in a cycle."""
    runs = 1 if quick else 5
    rows: list[tuple[str, Callable[[], Sequence[Fidelity]]]] = []
    for r, friction in ((0.6, 0.6), (0.98, 0.6), (1.5, 0.6)) if quick else product((0.3, 0.6, 0.98, 1.5), (0.2, 0.6)):
        slip = Slip(r, 0.02, friction)
        name = f"friction of {friction:g} F at {r:g} of ω₀"
        whole, linear = (partial(_greatest, by, slip) for by in (by_vibopt, by_equivalent_viscous))
        rows.append((name, partial(of_kinds, name, ("friction", "damper"), whole, linear, runs)))
    return rows


def _greatest(by: Callable[[Slip], Said], slip: Slip) -> float:
    return float(by(slip).answer)


def _case(slip: Slip, family: str) -> Case:
    name = f"friction of {slip.friction:g} of the force at {slip.r:g} of the resonance, damping ratio {slip.ratio:g}"
    return Case(name, "", FEASIBLE, truth(slip), "slip for slip in closed form", family)
