"""Run-ups in the charts: the greatest on the way through resonances, by vibopt, DOP853 and Fresnel's asymptote.

A force of one turns with a phasor e^(i phase) on the first of a chain of like masses, in steady vibration before; all
say the greatest distance of the last mass over every angle at which the force may begin.  The truth follows the chain
in the frame that turns with the force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.charts.fidelity import Fidelity, of_kinds
from vibopt.charts.machines import free_chain
from vibopt.charts.trial import DEFAULT, Case, Said, Table, greatest_in, judged_number
from vibopt.charts.verdicts import FEASIBLE, REFUSES
from vibopt.errors import counted
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
        swept = f'"{self.low!r} rad/s", to = "{self.high!r} rad/s", acceleration = "{self.rate!r} rad/s2"'
        return self._asked(f"run_up = {{ from = {swept} }}\n", "peak_displacement")

    @property
    def steady_text(self) -> str:
        """The same with every speed held for as long as it takes."""
        return self._asked("", "displacement")

    def _asked(self, run_up: str, response: str) -> str:
        low, high = sorted((self.low, self.high))
        return (
            f'title = "Run-up of a chain"\n\n{free_chain(self.bodies, "ground", 1.0, 2.0 * self.ratio)}\n\n'
            f'[excitations.force]\nkind = "force"\non = "m0"\namplitude = "1 N"\nspeed = "{low!r}..{high!r} rad/s"\n'
            f'{run_up}\n[measures.greatest]\nresponse = "{response}"\nof = "m{self.bodies - 1}"\n'
        )


def by_vibopt(passage: Passage) -> Said:
    """The greatest over all time and every angle, as it is told of the problem file."""
    return greatest_in(from_text(passage.text, name="job"))


def _integrated(passage: Passage, close: float) -> Said:
    from scipy.integrate import solve_ivp

    turns = passage.phase(passage.length + passage.behind) / (2.0 * np.pi)
    if turns > _MOST:
        return Said(REFUSES, f"{turns:.3g} turns one by one, more than {_MOST:g}")
    n, (damped, stiff) = passage.bodies, passage.matrices
    system = np.block([[np.zeros((n, n)), np.eye(n)], [-stiff, -damped]])
    load = np.concatenate([np.zeros(n), passage.pushed])

    def rates(when: float, now: ComplexArray) -> ComplexArray:
        return np.asarray(system @ now + load * np.exp(1j * passage.phase(when)))

    begun = passage.steady(passage.low)
    state = np.concatenate([begun, 1j * passage.low * begun])
    best, low, high, later = 0.0, 0.0, passage.length, np.inf
    held = passage.steady(passage.high)[n - 1]
    while best < later * (1.0 - close) and passage.phase(low) <= 2.0 * np.pi * _MOST:
        found: Any = solve_ivp(rates, (low, high), state, "DOP853", dense_output=True, rtol=close, atol=close * 1e-3)
        count = int(_LOOKS * (high - low)) + 100
        parts = np.linspace(low, high, min(count, 200_000))
        moved = found.sol(parts)[n - 1]
        best, state = max(best, float(np.abs(moved).max())), found.y[:, -1]
        if low > 0.0:  # what is left of the free motion only dies away
            turned = np.exp(1j * (passage.phase(passage.length) + passage.high * (parts - passage.length)))
            later = float(abs(held) + np.abs(moved - held * turned).max())
        low, high = high, high + passage.behind
    return Said("feasible", "the greatest of its samples until nothing greater can come", best, within=100.0 * close)


def by_asymptote(passage: Passage) -> Said:
    """The undamped passage by Fresnel's integrals, no more than the steady peak: one mass, slow, one way."""
    if passage.bodies > 1:
        return Said(REFUSES, "is of one mass")
    steady = 1.0 / (2.0 * passage.ratio * np.sqrt(1.0 - passage.ratio**2))
    return Said("feasible", "Fresnel's integrals, capped by the steady peak", min(steady, _FRESNEL / passage.rate**0.5))


METHODS: dict[str, Callable[[Passage], Said]] = {
    DEFAULT: by_vibopt, **{f"dop853 {close:g}": partial(_integrated, close=close) for close in CLOSE},
    "asymptote": by_asymptote,
}  # fmt: skip
QUICK_METHODS = {name: one for name, one in METHODS.items() if name not in ("dop853 1e-05", "dop853 1e-09")}
HARD_METHODS = {name: METHODS[name] for name in (DEFAULT, "dop853 1e-09", "asymptote")}


@cache
def truth(passage: Passage) -> tuple[float, float]:
    """The greatest, and when [s]: a tight integration in the turning frame, where a slow passage hardly moves.

    Behind it, where nothing depends on time in that frame, the free motion is followed in closed form to its end.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import minimize_scalar

    n = passage.bodies
    load = np.concatenate([np.zeros(n), passage.pushed])

    def at_speed(speed: float, by: tuple[ComplexArray, ...]) -> ComplexArray:
        return np.asarray(by[0] + speed * (by[1] + speed * by[2]))

    turning, begun = _turning(passage, passage.signed), np.concatenate([passage.steady(passage.low), np.zeros(n)])
    found: Any = solve_ivp(
        lambda when, now: load + at_speed(passage.speed(when), turning) @ now, (0.0, passage.length), begun,
        "DOP853", dense_output=True, rtol=_CLOSE, atol=_TINY,
    )  # fmt: skip
    last = at_speed(passage.high, _turning(passage, 0.0))
    held = np.linalg.solve(last, -load)
    poles, shapes = np.linalg.eig(last)
    shares = shapes[n - 1] * np.linalg.solve(shapes, found.y[:, -1] - held)

    def free(when: Any) -> Any:
        return held[n - 1] + np.exp(np.multiply.outer(when - passage.length, poles)) @ shares

    def driven(when: Any) -> Any:
        return found.sol(when)[n - 1]

    lasts = -np.log(_TINY) / passage.decay if passage.decay > 0.0 else 0.0
    best, at = 0.0, 0.0
    ways: list[tuple[Callable[[Any], Any], float, float]] = [
        (driven, 0.0, passage.length), (free, passage.length, passage.length + max(lasts, passage.behind)),
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


def _turning(passage: Passage, rate: float) -> tuple[ComplexArray, ...]:
    """Rates of places and their rates in the turning frame, (2 n, 2 n), by powers of the speed."""
    (damped, stiff), none, unit = passage.matrices, np.zeros((passage.bodies, passage.bodies)), np.eye(passage.bodies)
    return (
        np.block([[none, unit + 0j], [-stiff - 1j * rate * unit, -damped]]),
        np.block([[none, none + 0j], [-1j * damped, -2j * unit]]), np.block([[none, none + 0j], [unit, none]]),
    )  # fmt: skip


def speed(*, quick: bool) -> Table:
    """One and three masses through all their resonances, from nearly steady to nearly at once."""
    cases = []
    for bodies in (1, 3):
        for rate in (2e-2, 0.2, 5.0) if quick else (2e-4, 2e-3, 2e-2, 0.2, 5.0, 100.0):
            passage = Passage(bodies, 0.05, 0.3, 2.5, rate)
            cases.append((_case(f"{counted(bodies, 'masses')}, a run-up at {rate:g} rad/s²", RUN_UP, passage), passage))
    left = ("rates of 2e-4, 2e-3 and 100 rad/s²", "3 runs instead of 1", "dop853 at five tolerances") if quick else ()
    return Table(cases, QUICK_METHODS if quick else METHODS, judged_number, 1 if quick else 3, [cases[-1]], left=left)


def hard(*, quick: bool) -> Table:
    """Next to steady and next to at once, with hardly any damping, and down."""
    cases = []
    for rate in (2e-5,) if quick else (2e-5, 1e-5):
        passage = Passage(1, 0.3, 0.5, 2.0, rate)
        name, family = f"a passage next to steady, {rate:g} rad/s²", "a passage next to steady"
        cases.append((Case(name, "", FEASIBLE, _slow(passage), "closed form", family), passage))
    jump = Passage(1, 0.05, 0.5, 2.0, 1e9)
    cases.append((Case("a passage at once", "", FEASIBLE, _jumped(jump), "closed form", "a passage at once"), jump))
    more = [
        ("hardly any damping", Passage(1, 0.002, 0.5, 2.0, 1e-2)),
        ("hardly any damping", Passage(1, 0.002, 0.5, 2.0, 1.0)),
        ("a run-down", Passage(1, 0.05, 2.0, 0.3, 2e-2)),
        ("a run-down", Passage(3, 0.05, 2.5, 0.1, 5e-2)),
    ]
    for family, passage in more:
        said = f"{family}, {counted(passage.bodies, 'masses')} at {passage.rate:g} rad/s²"
        cases.append((_case(said, family, passage), passage))
    left = ("a passage at 1e-05 rad/s²",) if quick else ()
    return Table(cases, HARD_METHODS, judged_number, 1, cases[-1:], left=left)


def fidelity(*, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    """A passage followed, and every speed of it held as long as it takes."""
    runs = 1 if quick else 5
    rows: list[tuple[str, Callable[[], Sequence[Fidelity]]]] = []
    for rate in (1e-3, 1e-2, 0.1) if quick else (1e-4, 1e-3, 1e-2, 0.1, 1.0):
        passage = Passage(1, 0.05, 0.3, 2.5, rate)
        whole, steady = (partial(_greatest, text) for text in (passage.text, passage.steady_text))
        name = f"passage at {rate:g} of ω₀²"
        rows.append((name, partial(of_kinds, name, ("passage", "steady"), whole, steady, runs)))
    return rows


def _greatest(text: str) -> float:
    return float(greatest_in(from_text(text, name="job")).answer)


def _case(name: str, family: str, passage: Passage) -> Case:
    return Case(name, "", FEASIBLE, truth(passage)[0], "the turning frame, followed tightly", family)


def _slow(passage: Passage) -> float:
    """One mass: the steady vibration, and what the rate adds to first order."""
    from scipy.optimize import minimize_scalar

    def size(speed: float) -> float:
        held = 1.0 - speed**2 + 2j * passage.ratio * speed
        slope = (2.0 * speed - 2j * passage.ratio) / held**2
        return float(abs(1.0 / held - passage.rate / held * ((2j * speed + 2.0 * passage.ratio) * slope + 1j / held)))

    found = minimize_scalar(lambda speed: -size(speed), bounds=(1.0 - passage.ratio, 1.0), method="bounded")
    return -float(found.fun)


def _jumped(passage: Passage) -> float:
    """One mass whose force has another speed from one instant to the next."""
    pole = -passage.ratio + 1j * np.sqrt(1.0 - passage.ratio**2)
    before, behind = passage.steady(passage.low)[0], passage.steady(passage.high)[0]
    place, moved = before - behind, 1j * (passage.low * before - passage.high * behind)
    share = (moved - np.conj(pole) * place) / (pole - np.conj(pole))
    times = np.linspace(0.0, passage.behind, 400_001)
    free = share * np.exp(pole * times) + (place - share) * np.exp(np.conj(pole) * times)
    return float(np.abs(free + behind * np.exp(1j * passage.high * times)).max())
