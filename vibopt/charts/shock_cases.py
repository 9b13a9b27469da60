"""Shock in the charts: the greatest response of chains to pulses and records, by vibopt, DOP853 and pyyeti.

All say the greatest distance of the first mass from its base; the truth comes of modes in closed form, or of a formula.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.charts.machines import free_chain
from vibopt.charts.trial import DEFAULT, Case, Said, Table, filed, greatest_in, judged_number
from vibopt.charts.verdicts import FEASIBLE, MISSING, REFUSES
from vibopt.errors import counted
from vibopt.records import dataclass

SHOCK = "shock"
HALF_SINE, RECORD = "half sine", "record.csv"
HOW = "pip install pyyeti"
CLOSE, FINER = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11), (0.5, 1.0, 2.0, 4.0, 16.0)
"""Relative tolerances of the integrator; how many times as fine pyyeti steps."""
_PILED, _SAMPLES, _ROUND, _STEPS = 100.0, 200, 40, 2_000_000
"""How errors of single steps add up, at most; steps of pyyeti in a pulse, in the fastest period, and in all."""
_LOOKS, _TOPS, _BEHIND, _MORE = 32, 5, 2.0, 8.0
"""Of the truth: looks in the fastest period, tops that are refined; slowest periods behind the load, of rivals and of
the truth."""


@dataclass(frozen=True)
class Load:
    """A chain of like masses, springs and dampers on a base, and the base's acceleration.

    turns, ratio
        Frequency of one mass on one spring [Hz], and its damping ratio.
    times, points
        Joints [s] and the acceleration there [m/s^2], straight between them; a half sine of one where there are no
        points.
    """

    bodies: int
    turns: float
    ratio: float
    times: FloatArray
    points: FloatArray

    @property
    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Damping and stiffness of masses of one and of the base, the last, (n + 1, n + 1)."""
        w, n = 2.0 * np.pi * self.turns, self.bodies
        table = np.eye(n, n + 1) - np.eye(n, n + 1, k=-1)
        table[0, n] = -1.0
        stiff = w * w * table.T @ table
        return 2.0 * self.ratio / w * stiff, stiff

    @property
    def modes(self) -> tuple[FloatArray, FloatArray]:
        """Natural frequencies [rad/s], rising, and shapes."""
        squares, shapes = np.linalg.eigh(self.matrices[1][:-1, :-1])
        return np.sqrt(squares), shapes

    @property
    def size(self) -> float:
        """About how far it swings [m]."""
        w = float(self.modes[0][0])
        return min(1.0 / w**2, self.end / w)

    @property
    def end(self) -> float:
        return float(self.times[-1])

    def at(self, when: FloatArray) -> FloatArray:
        """Acceleration of the base; nothing behind the load."""
        inside = when <= self.end
        values = np.interp(when, self.times, self.points) if len(self.points) else np.sin(np.pi * when / self.end)
        return np.asarray(np.where(inside, values, 0.0))

    @property
    def text(self) -> str:
        """The problem file."""
        w = 2.0 * np.pi * self.turns
        how = f'kind = "record"\nfile = "{RECORD}"'
        if not len(self.points):
            how = f'kind = "pulse"\nshape = "{HALF_SINE}"\nacceleration = "1 m/s2"\nduration = "{self.end!r} s"'
        return (
            'title = "Chain on a base that is shaken"\n\n[bases.base]\n\n'
            f"{free_chain(self.bodies, 'base', w * w, 2.0 * self.ratio * w)}\n\n"
            f'[excitations.blow]\non = "base"\n{how}\n\n'
            '[measures.greatest]\nresponse = "peak_relative_displacement"\nacross = "s0"\n'
        )

    @property
    def beside(self) -> dict[str, str]:
        """The record, where there are points."""
        rows = "".join(f"{at!r},{one!r}\n" for at, one in zip(self.times.tolist(), self.points.tolist(), strict=False))
        return {RECORD: f"time [s],acceleration [m/s2]\n{rows}"} if len(self.points) else {}


def by_vibopt(load: Load) -> Said:
    """The greatest over all time, as it is told of the problem file."""
    return greatest_in(filed(Case("", "", FEASIBLE, np.nan, ""), load).scene())


def by_dop853(load: Load, close: float = 1e-11) -> Said:
    """scipy's Runge-Kutta method of eighth order, begun anew at every joint, with events where the distance turns."""
    from scipy.integrate import solve_ivp

    n = load.bodies
    damped, stiff = load.matrices
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-stiff[:n, :n], -damped[:n, :n]]])
    state, best, turns = np.zeros(2 * n), 0.0, a[0]

    def turning(_: float, z: FloatArray) -> float:
        return float(turns @ z)

    pushed = np.concatenate([np.zeros(n), np.ones(n)])
    for low, high in pairwise([*load.times.tolist(), _horizon(load, _BEHIND)]):

        def rates(when: float, z: FloatArray, loaded: bool = high <= load.end) -> FloatArray:
            return np.asarray(a @ z - pushed * load.at(np.array(when)) if loaded else a @ z)

        found = solve_ivp(
            rates, (low, high), state, "DOP853", events=turning, rtol=close, atol=1e-5 * close * load.size
        )
        state = found.y[:, -1]
        turned = found.y_events[0] if found.y_events is not None else ()
        best = max(best, float(np.abs(found.y[0]).max()), *(abs(float(one[0])) for one in turned))
    words = f"every turn up to {_BEHIND:g} slowest periods behind the load"
    return Said("feasible", words, best, within=_PILED * close)


def by_solve_exp2(load: Load, finer: float = 1.0) -> Said:
    """pyyeti's exponential stepping, straight between samples; the greatest sample."""
    if find_spec("pyyeti") is None:
        return Said(MISSING, HOW)
    ode: Any = import_module("pyyeti.ode")
    n = load.bodies
    damped, stiff = load.matrices
    fast = load.modes[0][-1]
    step = float(
        min(np.diff(load.times).min() / (1 if len(load.points) > 3 else _SAMPLES), np.pi * 2.0 / fast / _ROUND) / finer
    )
    steps = _horizon(load, _BEHIND) / step
    if steps > _STEPS:
        return Said(REFUSES, f"{steps:.1g} equal steps, more than {_STEPS:.0e}")
    when = np.arange(0.0, _horizon(load, _BEHIND), step)
    stepping = ode.SolveExp2(np.eye(n), damped[:n, :n], stiff[:n, :n], step)
    found = stepping.tsolve(np.outer(-np.ones(n), load.at(when)))
    return Said("feasible", "the greatest of its samples", float(np.abs(found.d[0]).max()))


METHODS: dict[str, Callable[[Load], Said]] = {
    DEFAULT: by_vibopt,
    **{f"dop853 {close:g}": partial(by_dop853, close=close) for close in CLOSE},
    **{f"solve_exp2 {_ROUND * finer:g}": partial(by_solve_exp2, finer=finer) for finer in FINER},
}  # fmt: skip
"""With tolerances, and steps in the fastest period."""
_SLOWER = ("dop853 1e-05", "dop853 1e-09", "solve_exp2 160", "solve_exp2 640")
QUICK_METHODS = {name: one for name, one in METHODS.items() if name not in _SLOWER}
HARD_METHODS = {name: METHODS[name] for name in (DEFAULT, "dop853 1e-11", "solve_exp2 40")}


def truth(load: Load) -> float:
    """By modes in closed form, on a fine grid and about its greatest tops."""
    from scipy.optimize import minimize_scalar

    w, shapes = load.modes
    ratio = load.ratio * w / (2.0 * np.pi * load.turns)
    poles = w * (-ratio + 1j * np.sqrt(1.0 - ratio**2))
    share = -shapes[0] * shapes.sum(axis=0) / poles.imag
    best, state = 0.0, np.zeros(len(w), dtype=complex)
    tops: list[tuple[float, float, float, int, ComplexArray]] = []
    step = 2.0 * np.pi / w[-1] / _LOOKS
    ends = [*load.times.tolist(), _horizon(load, _MORE)]
    for piece, (low, high) in enumerate(pairwise(ends)):
        parts = np.linspace(0.0, high - low, max(3, int(np.ceil((high - low) / step)) + 1))
        values = np.abs((_followed(load, piece, poles, state, parts) * share).sum(axis=1).imag)
        for i in np.flatnonzero(values >= np.maximum(np.roll(values, 1), np.roll(values, -1))):
            low_at, high_at = max(int(i) - 1, 0), min(int(i) + 1, len(parts) - 1)
            tops.append((float(values[i]), float(parts[low_at]), float(parts[high_at]), piece, state))
        best = max(best, float(values.max()))
        state = _followed(load, piece, poles, state, parts[-1:])[0]
    tops.sort(key=lambda one: one[0], reverse=True)
    for value, low, high, piece, begin in tops[:_TOPS]:
        if value < 0.9 * best or low == high:
            continue

        def under(at: float, piece: int = piece, begin: ComplexArray = begin) -> float:
            return -abs(float((_followed(load, piece, poles, begin, np.array([at])) * share).sum().imag))

        best = max(best, -float(minimize_scalar(under, bounds=(low, high), method="bounded",
                                                options={"xatol": 1e-9 * (high - low)}).fun))  # fmt: skip
    return best


def _followed(load: Load, piece: int, poles: ComplexArray, state: ComplexArray, parts: FloatArray) -> ComplexArray:
    """s' = pole s + acceleration over one piece, at times since its beginning (n,): (n, n_modes)."""
    x = np.outer(parts, poles)
    found = np.exp(x) * state
    if piece >= len(load.times) - 1:
        return np.asarray(found)
    if not len(load.points):
        turned = np.pi / load.end
        waves = [
            (np.exp(1j * s * turned * parts)[:, None] - np.exp(x)) / (1j * s * turned - poles) for s in (1.0, -1.0)
        ]
        return np.asarray(found + (waves[0] - waves[1]) / 2j)
    first, slope = load.points[piece], (load.points[piece + 1] - load.points[piece]) / np.diff(load.times)[piece]
    grown = np.expm1(x) / poles
    return np.asarray(found + first * grown + slope * (grown - parts[:, None]) / poles)


def _horizon(load: Load, periods: float) -> float:
    return load.end + periods * 2.0 * np.pi / float(load.modes[0][0])


def speed(*, quick: bool) -> Table:
    """Chains of one, five and twenty masses under a half sine, a triangle, a sawtooth and a record."""
    rng = np.random.default_rng(14)
    samples = 200 if quick else 20_000
    record = np.convolve(rng.normal(size=samples + 4), np.ones(5) / 5.0, "valid")
    loads = {
        HALF_SINE: (np.array([0.0, 0.05]), np.zeros(0)),
        "rectangle": (np.array([0.0, 0.05]), np.ones(2)),
        "triangle": (np.array([0.0, 0.025, 0.05]), np.array([0.0, 1.0, 0.0])),
        "sawtooth": (np.array([0.0, 0.05]), np.array([0.0, 1.0])),
        f"record of {samples} points": (0.005 * np.arange(samples), record),
    }
    cases = []
    for count in (1, 5, 20):
        for name, (times, points) in loads.items():
            load = Load(count, 5.0, 0.05, times, points)
            said = f"{name}, {counted(count, 'masses')}"
            cases.append((Case(said, "", FEASIBLE, truth(load), "modes in closed form", SHOCK), load))
    left = (
        ("a record of 20000 points instead of 200", "3 runs instead of 1", "dop853 and solve_exp2 at five settings")
        if quick
        else ()
    )
    methods = QUICK_METHODS if quick else METHODS
    return Table(cases, methods, judged_number, 1 if quick else 3, [cases[0]], left=left)


def hard(*, quick: bool) -> Table:
    """One mass without damping, with too much of it, under pulses far shorter and far longer than its period."""
    cases = [
        (Case(name, "", FEASIBLE, goal, "closed form", family), load)
        for family, name, goal, load in (*_undamped(), *_short(), *_long(100.0 if quick else 1e4))
    ]
    left = ("pulses of 1e4 periods instead of 100",) if quick else ()
    return Table(cases, HARD_METHODS, judged_number, 1, cases[:1], left=left)


_Row = tuple[str, str, float, Load]


def _lone(turns: float, ratio: float, half_sine: bool = False) -> Load:
    """One mass that turns so often in the second of a pulse."""
    return Load(1, turns, ratio, np.array([0.0, 1.0]), np.zeros(0) if half_sine else np.ones(2))


def _undamped() -> list[_Row]:
    found = []
    for turns in (0.3, 1.3, 40.0):
        most, w = 2.0 if turns >= 0.5 else 2.0 * float(np.sin(np.pi * turns)), 2.0 * np.pi * turns
        name = f"rectangle of {turns:g} periods, undamped"
        found.append(("no damping", name, most / w**2, _lone(turns, 0.0)))
    for turns in (0.05, 0.4):  # the greatest comes behind the pulse
        r, w = 0.5 / turns, 2.0 * np.pi * turns
        most = abs(2.0 * r * float(np.cos(np.pi * turns)) / (1.0 - r * r))
        found.append(("no damping", f"half sine of {turns:g} periods, undamped", most / w**2, _lone(turns, 0.0, True)))
    return found


def _short() -> list[_Row]:
    """The impulse alone counts."""
    found = []
    for turns in (1e-4, 1e-6):
        w = 2.0 * np.pi * turns
        half = 2.0 / np.pi * (1.0 - (np.pi**2 / 8.0 - 1.0) * 4.0 * turns**2) / w
        found.append(("a pulse far shorter than a period", f"rectangle of {turns:g} periods",
                      2.0 * float(np.sin(np.pi * turns)) / w**2, _lone(turns, 0.0)))  # fmt: skip
        found.append(("a pulse far shorter than a period", f"half sine of {turns:g} periods", half,
                      _lone(turns, 0.0, True)))  # fmt: skip
    return found


def _long(turns: float) -> list[_Row]:
    """The first swing counts; too much damping lets it creep."""
    w, found = 2.0 * np.pi * turns, []
    for ratio in (0.0, 0.05, 0.5):
        over = float(np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)))
        name = f"rectangle of {turns:g} periods, damping ratio {ratio:g}"
        found.append(("a pulse far longer than a period", name, (1.0 + over) / w**2, _lone(turns, ratio)))
    for ratio in (2.0, 20.0):
        d, w = float(np.sqrt(ratio**2 - 1.0)), 2.0 * np.pi
        slow, fast = w * (d - ratio), -w * (d + ratio)
        last = np.log(np.expm1(-fast) / np.expm1(-slow)) / (slow - fast)  # it creeps on behind the pulse
        crept = sum(
            side * (1.0 - (fast * np.exp(slow * at) - slow * np.exp(fast * at)) / (fast - slow))
            for side, at in ((1.0, last), (-1.0, last - 1.0))
        )
        name = f"rectangle of a period, damping ratio {ratio:g}"
        found.append(("far too much damping", name, float(crept) / w**2, _lone(1.0, ratio)))
    return found
