"""Run-ups in the charts: the greatest on the way through resonances, by vibopt, DOP853 and Fresnel's asymptote.

A force of one turns with a phasor e^(i phase) on the first of a chain of like masses, in steady vibration before; all
say the greatest distance of the last mass over every angle at which the force may begin.  The truth follows the chain
in the frame that turns with the force.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.charts.machines import free_chain
from vibopt.charts.trial import DEFAULT, Case, Said, Table, greatest_in, judged_number
from vibopt.charts.verdicts import FEASIBLE, REFUSES
from vibopt.records import dataclass
from vibopt.scene.read import from_text

RUN_UP, CLOSE = "run-up", (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
_CLOSE, _TINY, _LOOKS, _BEHIND, _MOST = 1e-12, 1e-14, 24, 20.0, 2000.0
"""Tolerances of the truth, looks in a radian of the fastest motion, slowest periods behind that are followed at a time,
turns that are followed."""
_FRESNEL = 1.46728
"""Greatest of |integral of e^(i t^2 / 2) from minus infinity to T| over two: an edge in Fresnel's diffraction."""


@dataclass(frozen=True)
class Passage:
    """A chain on the ground, its masses and springs of one, and a force of one from a speed to another [rad/s].

    ratio
        Damping ratio of one mass on one spring.
    rate
        Size of the change of the speed [rad/s^2].
    """

    bodies: int
    ratio: float
    low: float
    high: float
    rate: float

    @property
    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Damping and stiffness, (n, n)."""
        table = np.eye(self.bodies) - np.eye(self.bodies, k=-1)
        stiff = table.T @ table
        return np.asarray(2.0 * self.ratio * stiff), np.asarray(stiff)

    @property
    def modes(self) -> FloatArray:
        return np.asarray(np.sqrt(np.linalg.eigvalsh(self.matrices[1])))

    @property
    def signed(self) -> float:
        return float(np.copysign(self.rate, self.high - self.low))

    @property
    def length(self) -> float:
        """How long the speed changes [s]."""
        return (self.high - self.low) / self.signed

    @property
    def decay(self) -> float:
        """Rate at which the free motion of the first mode dies away [1/s], the slowest."""
        return self.ratio * float(self.modes[0]) ** 2

    @property
    def behind(self) -> float:
        """How long it is followed at a time once the speed is reached [s]."""
        return _BEHIND * 2.0 * np.pi / float(self.modes[0])

    @property
    def pushed(self) -> FloatArray:
        return np.asarray(np.eye(self.bodies)[0])

    def steady(self, speed: float) -> ComplexArray:
        """Steady vibration under a force of one, (n,)."""
        damped, stiff = self.matrices
        return np.asarray(np.linalg.solve(stiff + 1j * speed * damped - speed**2 * np.eye(self.bodies), self.pushed))

    def speed(self, when: float) -> float:
        return self.low + self.signed * min(when, self.length)

    def phase(self, when: float) -> float:
        rising = min(when, self.length)
        return self.low * rising + 0.5 * self.signed * rising**2 + self.high * (when - rising)

    @property
    def text(self) -> str:
        """The problem file."""
        low, high = sorted((self.low, self.high))
        return (
            f'title = "Run-up of a chain"\n\n{free_chain(self.bodies, "ground", 1.0, 2.0 * self.ratio)}\n\n'
            f'[excitations.force]\nkind = "force"\non = "m0"\namplitude = "1 N"\nspeed = "{low!r}..{high!r} rad/s"\n'
            f'run_up = {{ from = "{self.low!r} rad/s", to = "{self.high!r} rad/s", '
            f'acceleration = "{self.rate!r} rad/s2" }}\n\n'
            f'[measures.greatest]\nresponse = "peak_displacement"\nof = "m{self.bodies - 1}"\n'
        )


def by_vibopt(one: Passage) -> Said:
    """The greatest over all time and every angle, as it is told of the problem file."""
    return greatest_in(from_text(one.text, name="job"))


def _integrated(one: Passage, close: float) -> Said:
    from scipy.integrate import solve_ivp

    turns = one.phase(one.length + one.behind) / (2.0 * np.pi)
    if turns > _MOST:
        return Said(REFUSES, f"{turns:.3g} turns one by one, more than {_MOST:g}")
    n, (damped, stiff) = one.bodies, one.matrices
    system = np.block([[np.zeros((n, n)), np.eye(n)], [-stiff, -damped]])
    load = np.concatenate([np.zeros(n), one.pushed])

    def rates(when: float, now: ComplexArray) -> ComplexArray:
        return np.asarray(system @ now + load * np.exp(1j * one.phase(when)))

    begun = one.steady(one.low)
    state = np.concatenate([begun, 1j * one.low * begun])
    best, low, high, later = 0.0, 0.0, one.length, np.inf
    held = one.steady(one.high)[n - 1]
    while best < later * (1.0 - close) and one.phase(low) <= 2.0 * np.pi * _MOST:
        found: Any = solve_ivp(rates, (low, high), state, "DOP853", dense_output=True, rtol=close, atol=close * 1e-3)
        count = int(_LOOKS * (high - low)) + 100
        parts = np.linspace(low, high, min(count, 200_000))
        moved = found.sol(parts)[n - 1]
        best, state = max(best, float(np.abs(moved).max())), found.y[:, -1]
        if low > 0.0:  # what is left of the free motion only dies away
            turned = np.exp(1j * (one.phase(one.length) + one.high * (parts - one.length)))
            later = float(abs(held) + np.abs(moved - held * turned).max())
        low, high = high, high + one.behind
    return Said("feasible", "the greatest of its samples until nothing greater can come", best, within=100.0 * close)


def by_asymptote(one: Passage) -> Said:
    """The undamped passage by Fresnel's integrals, no more than the steady peak: one mass, slow, one way."""
    if one.bodies > 1:
        return Said(REFUSES, "is of one mass")
    steady = 1.0 / (2.0 * one.ratio * np.sqrt(1.0 - one.ratio**2))
    return Said("feasible", "Fresnel's integrals, capped by the steady peak", min(steady, _FRESNEL / one.rate**0.5))


METHODS: dict[str, Callable[[Passage], Said]] = {
    DEFAULT: by_vibopt, **{f"dop853 {close:g}": partial(_integrated, close=close) for close in CLOSE},
    "asymptote": by_asymptote,
}  # fmt: skip
QUICK_METHODS = {name: one for name, one in METHODS.items() if name not in ("dop853 1e-05", "dop853 1e-09")}
HARD_METHODS = {name: METHODS[name] for name in (DEFAULT, "dop853 1e-09", "asymptote")}


def truth(one: Passage) -> tuple[float, float]:
    """The greatest, and when [s]: a tight integration in the turning frame, where a slow passage hardly moves.

    Behind it, where nothing depends on time in that frame, the free motion is followed in closed form to its end.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import minimize_scalar

    n = one.bodies
    load = np.concatenate([np.zeros(n), one.pushed])

    def at_speed(speed: float, by: tuple[ComplexArray, ...]) -> ComplexArray:
        return np.asarray(by[0] + speed * (by[1] + speed * by[2]))

    turning, begun = _turning(one, one.signed), np.concatenate([one.steady(one.low), np.zeros(n)])
    found: Any = solve_ivp(
        lambda when, now: load + at_speed(one.speed(when), turning) @ now, (0.0, one.length), begun,
        "DOP853", dense_output=True, rtol=_CLOSE, atol=_TINY,
    )  # fmt: skip
    last = at_speed(one.high, _turning(one, 0.0))
    held = np.linalg.solve(last, -load)
    poles, shapes = np.linalg.eig(last)
    shares = shapes[n - 1] * np.linalg.solve(shapes, found.y[:, -1] - held)

    def free(when: Any) -> Any:
        return held[n - 1] + np.exp(np.multiply.outer(when - one.length, poles)) @ shares

    def driven(when: Any) -> Any:
        return found.sol(when)[n - 1]

    lasts = -np.log(_TINY) / one.decay if one.decay > 0.0 else 0.0
    best, at = 0.0, 0.0
    ways: list[tuple[Callable[[Any], Any], float, float]] = [
        (driven, 0.0, one.length), (free, one.length, one.length + max(lasts, one.behind)),
    ]  # fmt: skip
    for place, low, high in ways:
        parts = np.linspace(low, high, int(_LOOKS * (high - low)) + 2000)
        sizes = np.abs(place(parts))
        top = int(sizes.argmax())
        if sizes[top] <= best:
            continue
        ends = float(parts[max(top - 1, 0)]), float(parts[min(top + 1, len(parts) - 1)])
        fine: Any = minimize_scalar(lambda when, place=place: -abs(place(when)), bounds=ends, method="bounded")
        best, at = max((float(sizes[top]), float(parts[top])), (-float(fine.fun), float(fine.x)))
    return best, at


def _turning(one: Passage, rate: float) -> tuple[ComplexArray, ...]:
    """Rates of places and their rates in the turning frame, (2 n, 2 n), by powers of the speed."""
    (damped, stiff), none, unit = one.matrices, np.zeros((one.bodies, one.bodies)), np.eye(one.bodies)
    return (
        np.block([[none, unit + 0j], [-stiff - 1j * rate * unit, -damped]]),
        np.block([[none, none + 0j], [-1j * damped, -2j * unit]]), np.block([[none, none + 0j], [unit, none]]),
    )  # fmt: skip


def speed(*, quick: bool) -> Table:
    """One and three masses through all their resonances, from nearly steady to nearly at once."""
    cases = []
    for bodies in (1, 3):
        for rate in (2e-2, 0.2, 5.0) if quick else (2e-4, 2e-3, 2e-2, 0.2, 5.0, 100.0):
            one = Passage(bodies, 0.05, 0.3, 2.5, rate)
            cases.append((_case(f"{bodies} mass{'es' * (bodies > 1)}, a run-up at {rate:g} rad/s²", RUN_UP, one), one))
    left = ("rates of 2e-4, 2e-3 and 100 rad/s²", "3 runs instead of 1", "dop853 at five tolerances") if quick else ()
    return Table(cases, QUICK_METHODS if quick else METHODS, judged_number, 1 if quick else 3, [cases[-1]], left=left)


def hard(*, quick: bool) -> Table:
    """Next to steady and next to at once, with hardly any damping, and down."""
    cases = []
    for rate in (2e-5,) if quick else (2e-5, 1e-5):
        one = Passage(1, 0.3, 0.5, 2.0, rate)
        name, family = f"a passage next to steady, {rate:g} rad/s²", "a passage next to steady"
        cases.append((Case(name, "", FEASIBLE, _slow(one), "closed form", family), one))
    jump = Passage(1, 0.05, 0.5, 2.0, 1e9)
    cases.append((Case("a passage at once", "", FEASIBLE, _jumped(jump), "closed form", "a passage at once"), jump))
    more = [
        ("hardly any damping", Passage(1, 0.002, 0.5, 2.0, 1e-2)),
        ("hardly any damping", Passage(1, 0.002, 0.5, 2.0, 1.0)),
        ("a run-down", Passage(1, 0.05, 2.0, 0.3, 2e-2)),
        ("a run-down", Passage(3, 0.05, 2.5, 0.1, 5e-2)),
    ]
    for family, one in more:
        said = f"{family}, {one.bodies} mass{'es' * (one.bodies > 1)} at {one.rate:g} rad/s²"
        cases.append((_case(said, family, one), one))
    left = ("a passage at 1e-05 rad/s²",) if quick else ()
    return Table(cases, HARD_METHODS, judged_number, 1, cases[-1:], left=left)


def _case(name: str, family: str, one: Passage) -> Case:
    return Case(name, "", FEASIBLE, truth(one)[0], "the turning frame, followed tightly", family)


def _slow(one: Passage) -> float:
    """One mass: the steady vibration, and what the rate adds to first order."""
    from scipy.optimize import minimize_scalar

    def size(speed: float) -> float:
        held = 1.0 - speed**2 + 2j * one.ratio * speed
        slope = (2.0 * speed - 2j * one.ratio) / held**2
        return float(abs(1.0 / held - one.rate / held * ((2j * speed + 2.0 * one.ratio) * slope + 1j / held)))

    found = minimize_scalar(lambda speed: -size(speed), bounds=(1.0 - one.ratio, 1.0), method="bounded")
    return -float(found.fun)


def _jumped(one: Passage) -> float:
    """One mass whose force has another speed from one instant to the next."""
    pole = -one.ratio + 1j * np.sqrt(1.0 - one.ratio**2)
    before, behind = one.steady(one.low)[0], one.steady(one.high)[0]
    place, moved = before - behind, 1j * (one.low * before - one.high * behind)
    share = (moved - np.conj(pole) * place) / (pole - np.conj(pole))
    times = np.linspace(0.0, one.behind, 400_001)
    free = share * np.exp(pole * times) + (place - share) * np.exp(np.conj(pole) * times)
    return float(np.abs(free + behind * np.exp(1j * one.high * times)).max())


__all__ = ["METHODS", "Passage", "hard", "speed", "truth"]
