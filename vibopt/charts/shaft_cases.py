"""Shafts in the charts: the lightest whose critical speeds and whirl hold, by vibopt and on 2-node elements.

Rivals measure a shaft on so many two-node Timoshenko elements a section, as a script would; the judge extrapolates from
three.  In a forward whirl as fast as the spin tilting meets its diametral less its polar inertia.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.trial import DEFAULT, Case, Said, Trial, judged, said_of
from vibopt.charts.verdicts import FEASIBLE
from vibopt.records import dataclass
from vibopt.scene.read import from_text

MODULUS, DENSITY, RATIO = 207e9, 7850.0, 0.3
LOW, HIGH = 0.02, 0.2
"""Ends of every diameter [m]."""
ELEMENTS = (2, 4, 8, 16)
FINE = (8, 16, 32)
"""Elements a section that the judge extrapolates from."""
_STARTS, _PENALTY, _TOLD, _HAIR = 5, 1e3, 12, 1e-9


@dataclass(frozen=True)
class Shaft:
    """Two sections, one disc, two bearings.

    lengths
        Of the two sections [m]; the left bearing stands at their left end.
    given
        Diameters [m]; 0 where it is to be chosen.
    overhung
        Whether the second bearing stands between the sections and the disc at the right end, else the other way round.
    mass, diametral, polar
        Of the disc [kg, kg m2].
    stiffness, damping
        Of each bearing [N/m, N s/m].
    unbalance, speed
        [kg m], [rad/s].
    band
        Between what no critical speed may lie [rad/s]; from 0 on where all shall lie above.
    whirl
        Most amplitude of the disc [m].
    """

    lengths: tuple[float, float]
    given: tuple[float, float]
    overhung: bool
    mass: float
    diametral: float
    polar: float
    stiffness: float
    damping: float
    unbalance: float
    speed: float
    band: tuple[float, float]
    whirl: float

    @property
    def free(self) -> list[int]:
        """Sections whose diameter is to be chosen."""
        return [i for i, value in enumerate(self.given) if not value]

    def diameters(self, x: FloatArray) -> FloatArray:
        """All of them [m], (2,), from those that are chosen."""
        full = np.array(self.given)
        full[self.free] = x
        return full

    def total(self, x: FloatArray) -> float:
        """Mass of shaft and disc [kg]."""
        return float(self.mass + DENSITY * np.pi / 4.0 * (np.array(self.lengths) @ self.diameters(x) ** 2))

    @property
    def text(self) -> str:
        """The problem file."""
        chosen = f'{{ from = "{LOW!r} m", to = "{HIGH!r} m" }}'
        rows = [
            f'  {{ length = "{long!r} m", diameter = {f"{chr(34)}{d!r} m{chr(34)}" if d else chosen} }},'
            for long, d in zip(self.lengths, self.given, strict=True)
        ]
        middle, end = self.lengths[0], sum(self.lengths)
        right, disc = (middle, end) if self.overhung else (end, middle)
        low, high = self.band
        apart = f'outside = "{low!r}..{high!r} rad/s"' if low else f'at_least = "{high!r} rad/s"'
        bearings = "".join(
            f'\n[links.{name}]\nbetween = ["{place}", "ground"]\nstiffness = "{self.stiffness!r} N/m"\n'
            f'damping = "{self.damping!r} N s/m"\n'
            for name, place in (("first", "left"), ("second", "right"))
        )
        return "\n".join((
            'title = "Lightest shaft"\n\n[rotors.shaft]',
            f'modulus = "{MODULUS!r} Pa"', f'density = "{DENSITY!r} kg/m3"',
            "sections = [", *rows, "]", f'stations = {{ left = "0 m", right = "{right!r} m" }}',
            f'discs = [{{ name = "disc", at = "{disc!r} m", mass = "{self.mass!r} kg", diametral = "{self.diametral!r} '
            f'kg m2", polar = "{self.polar!r} kg m2" }}]', bearings,
            f'[excitations.imbalance]\nkind = "unbalance"\non = "disc"\nunbalance = "{self.unbalance!r} kg m"\n'
            f'speed = "{self.speed!r} rad/s"\n', f'[limits.apart]\nresponse = "critical_speed"\n{apart}\n',
            f'[limits.whirl]\nresponse = "displacement"\nof = "disc"\nat_most = "{self.whirl!r} m"\n',
            '[goal]\nminimise = "total_mass"\n',
        ))  # fmt: skip


def element(long: float, diameter: float) -> tuple[FloatArray, FloatArray]:
    """Stiffness, and inertia in a forward whirl with the spin, (4, 4), of a piece of shaft, by its static shapes.

    After Przemieniecki, "Theory of Matrix Structural Analysis", 1968; shear coefficient of Cowper.
    """
    area, second = np.pi * diameter**2 / 4.0, np.pi * diameter**4 / 64.0
    shear = MODULUS / (2.0 * (1.0 + RATIO)) * area * 6.0 * (1.0 + RATIO) / (7.0 + 6.0 * RATIO)
    phi = 12.0 * MODULUS * second / (shear * long**2)
    near, far = (4.0 + phi) * long**2, (2.0 - phi) * long**2
    bend = np.array([[12.0, 6.0 * long, -12.0, 6.0 * long], [6.0 * long, near, -6.0 * long, far],
                     [-12.0, -6.0 * long, 12.0, -6.0 * long], [6.0 * long, far, -6.0 * long, near]])  # fmt: skip
    moved = (_SHAPES[0] + phi * _SHAPES[1]) * np.array([1.0, long, 1.0, long])[:, None]
    tilted = (_SHAPES[2] + phi * _SHAPES[3]) * np.array([1.0 / long, 1.0, 1.0 / long, 1.0])[:, None]
    carried, turned = ((one * _WEIGHTS) @ one.T * long / (1.0 + phi) ** 2 for one in (moved, tilted))
    return MODULUS * second / (long**3 * (1.0 + phi)) * bend, DENSITY * (area * carried - second * turned)


_AT, _WEIGHTS = (part * 0.5 for part in np.polynomial.legendre.leggauss(4))
_S = _AT + 0.5
_NONE = np.zeros_like(_S)
_SHAPES = (
    np.array([1 - 3 * _S**2 + 2 * _S**3, _S - 2 * _S**2 + _S**3, 3 * _S**2 - 2 * _S**3, _S**3 - _S**2]),
    np.array([1 - _S, (_S - _S**2) / 2, _S, (_S**2 - _S) / 2]),
    np.array([6 * (_S**2 - _S), 1 - 4 * _S + 3 * _S**2, 6 * (_S - _S**2), 3 * _S**2 - 2 * _S]),
    np.array([_NONE, 1 - _S, _NONE, _S]),
)
"""Deflection and tilt over a piece of length 1: of bending, and what shear adds for each phi."""


def measured(shaft: Shaft, x: FloatArray, many: int) -> tuple[FloatArray, float]:
    """Lowest critical speeds [rad/s], rising, and the whirl of the disc [m], on so many elements a section."""
    from scipy.linalg import eigh

    size = 2 * (2 * many + 1)
    stiff, inert = np.zeros((size, size)), np.zeros((size, size))
    for i, (length, diameter) in enumerate(zip(shaft.lengths, shaft.diameters(x), strict=True)):
        parts = element(length / many, float(diameter))
        for j in range(i * many, (i + 1) * many):
            here = slice(2 * j, 2 * j + 4)
            stiff[here, here] += parts[0]
            inert[here, here] += parts[1]
    ends = (2 * many, 2 * 2 * many)
    right, disc = ends if shaft.overhung else ends[::-1]
    for place in (0, right):
        stiff[place, place] += shaft.stiffness
    inert[disc, disc] += shaft.mass
    inert[disc + 1, disc + 1] += shaft.diametral - shaft.polar
    slow = eigh(inert, stiff, eigvals_only=True)[::-1]  # stiff is positive, inert need not be
    drag = np.zeros(size)
    drag[[0, right]] = shaft.damping
    force = np.zeros(size)
    force[disc] = shaft.unbalance * shaft.speed**2
    moved = np.linalg.solve(stiff - shaft.speed**2 * inert + 1j * shaft.speed * np.diag(drag), force)
    return np.asarray(1.0 / np.sqrt(slow[slow > 0.0])[:_TOLD]), float(abs(moved[disc]))


def extrapolated(shaft: Shaft, x: FloatArray) -> tuple[FloatArray, float]:
    """The same without the error of elements: its parts of second and fourth order are taken away (Romberg)."""
    seen = [measured(shaft, x, many) for many in FINE]
    count = min(len(own) for own, _ in seen)
    rows = [np.append(own[:count], whirl) for own, whirl in seen]
    once = [fine + (fine - coarse) / 3.0 for coarse, fine in pairwise(rows)]
    last = once[1] + (once[1] - once[0]) / 15.0
    return last[:-1], float(last[-1])


def missed(shaft: Shaft, seen: tuple[FloatArray, float]) -> float:
    """Greatest violation, as a part of the bound."""
    low, high = shaft.band
    own = seen[0]
    below = own / low - 1.0 if low else np.full(len(own), np.inf)
    return max(float(np.minimum(below, 1.0 - own / high).max()), seen[1] / shaft.whirl - 1.0, 0.0)


def _vibopt(shaft: Shaft) -> Said:
    said = said_of(from_text(shaft.text, name="shaft"), DEFAULT)
    return replace(said, seconds=np.nan)


def _slsqp(shaft: Shaft, many: int) -> Said:
    """Least mass with so many critical speeds below the band, none to three, each from several starts."""
    found = _least(shaft, partial(measured, many=many), np.linspace(0.1, 0.9, _STARTS))
    return _said(found, f"best of {_STARTS} starts, {many} elements a section")


def _polished(shaft: Shaft) -> Said:
    """The same on 8 elements a section, then once more from there on the model without their error."""
    begun = _least(shaft, partial(measured, many=8), np.linspace(0.1, 0.9, _STARTS))
    found = begun and _least(shaft, extrapolated, [], begun[1])
    return _said(found, f"best of {_STARTS} starts, extrapolated elements")


def _said(found: tuple[float, FloatArray] | None, words: str) -> Said:
    if found is None:
        return Said("unproven", "no start ends within the limits")
    return Said("feasible", words, found[1])


def _least(
    shaft: Shaft,
    model: Callable[[Shaft, FloatArray], tuple[FloatArray, float]],
    parts: Any,
    begun: FloatArray | None = None,
) -> tuple[float, FloatArray] | None:
    """Mass and design by SLSQP from every start, parts of the way through the ranges or a design; None without one."""
    from scipy.optimize import minimize

    low, high = shaft.band
    count = len(shaft.free)
    best: tuple[float, FloatArray] | None = None
    seen: dict[bytes, tuple[FloatArray, float]] = {}

    def looked(y: FloatArray) -> tuple[FloatArray, float]:
        if y.tobytes() not in seen:
            seen[y.tobytes()] = model(shaft, np.exp(y))
        return seen[y.tobytes()]

    def weight(y: FloatArray) -> float:
        return shaft.total(np.asarray(np.exp(y))) / shaft.total(np.full(count, HIGH))

    ends: Any = [(np.log(LOW), np.log(HIGH))] * count
    starts = [np.full(count, np.log(LOW) + part * np.log(HIGH / LOW)) for part in parts]
    starts += [] if begun is None else [np.log(begun)]
    for under in range(4 if low else 1):

        def room(y: FloatArray, under: int = under) -> FloatArray:
            own, whirl = looked(y)
            own = np.append(own, [1e9] * (under + 1))  # a motion that has none never meets it
            below = [np.log(low / own[under - 1])] if under else []
            return np.array([np.log(own[under] / high), np.log(shaft.whirl / whirl), *below]) - _HAIR

        kept: Any = [{"type": "ineq", "fun": room}]
        for start in starts:
            found: Any = minimize(
                weight, start, method="SLSQP", bounds=ends, constraints=kept,
                options={"ftol": 1e-12, "maxiter": 200},
            )  # fmt: skip
            if found.success and room(found.x).min() > -_HAIR and (best is None or found.fun < best[0]):
                best = float(found.fun), np.exp(found.x)
    return best


def _evolution(shaft: Shaft, most: int) -> Said:
    """Scipy's differential evolution with a penalty, 8 elements a section, so many designs in all."""
    from scipy.optimize import differential_evolution

    count, many = len(shaft.free), 8
    ends: Any = [(np.log(LOW), np.log(HIGH))] * count

    def cost(y: FloatArray) -> float:
        x = np.exp(y)
        return shaft.total(x) / shaft.total(np.full(count, HIGH)) + _PENALTY * missed(shaft, measured(shaft, x, many))

    rounds = max(most // (15 * count) - 1, 1)
    found: Any = differential_evolution(
        cost, ends, maxiter=rounds, popsize=15, tol=0.0, polish=False, rng=0,
        init="sobol",
    )  # fmt: skip
    x = np.exp(np.asarray(found.x))
    if missed(shaft, measured(shaft, x, many)) > 0.0:
        return Said("unproven", "no design within the limits")
    return Said("feasible", f"best of {most} designs", x)


def _bisection(shaft: Shaft, many: int) -> Said:
    """One diameter: 60 of them looked at, the first that holds and the one below it halved between."""
    from vibopt.charts.verdicts import REFUSES

    if len(shaft.free) > 1:
        return Said(REFUSES, "takes one diameter")
    tried = np.geomspace(LOW, HIGH, 60)
    holds = (np.array([missed(shaft, measured(shaft, np.array([d]), many)) for d in tried]) <= 0.0).tolist()
    if not any(holds):
        return Said("unproven", "none of 60 diameters holds")
    first = holds.index(True)
    if not first:
        return Said("feasible", "the thinnest", tried[:1])
    low, high = tried[first - 1], tried[first]
    while high - low > 1e-12 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if missed(shaft, measured(shaft, np.array([middle]), many)) <= 0.0 else (middle, high)
    return Said("feasible", f"halved, {many} elements a section", np.array([high]))


def judge(case: Case, shaft: Shaft, method: str, said: Said) -> Trial:
    """A shaft measured without the error of elements; the least mass is looked for among all."""
    if said.answer is None:
        return judged(case, method, said, np.nan, np.nan)
    x = np.asarray(said.answer)
    return judged(case, method, said, missed(shaft, extrapolated(shaft, x)), 0.0, shaft.total(x))


METHODS: Mapping[str, Callable[[Shaft], Said]] = {
    DEFAULT: _vibopt,
    **{f"slsqp {many}": partial(_slsqp, many=many) for many in ELEMENTS},
    "slsqp extrapolated": _polished,
    **{f"bisection {many}": partial(_bisection, many=many) for many in ELEMENTS},
    **{f"evolution {most}": partial(_evolution, most=most) for most in (300, 1000)},
}  # fmt: skip
QUICK_METHODS = {name: METHODS[name] for name in (DEFAULT, "slsqp 4", "slsqp extrapolated", "bisection 16")}


def drawn(rng: np.random.Generator, name: str) -> tuple[Case, Shaft]:
    """One diameter or two, a disc between its bearings or beyond them; limits beside what a drawn shaft has."""
    lengths = (float(rng.uniform(0.2, 0.8)), float(rng.uniform(0.15, 0.5)))
    true = np.exp(rng.uniform(np.log(0.03), np.log(0.12), 2))
    mass = float(10.0 ** rng.uniform(0.5, 2.0))
    polar = mass * float(rng.uniform(0.02, 0.12))
    shaft = Shaft(
        lengths, (0.0, 0.0), bool(rng.integers(2)), mass, 0.6 * polar, polar, float(10.0 ** rng.uniform(7.0, 9.0)),
        float(10.0 ** rng.uniform(3.0, 4.5)), mass * float(10.0 ** rng.uniform(-6.0, -4.0)), 1.0, (0.0, 1.0), 1.0,
    )  # fmt: skip
    own = extrapolated(shaft, true)[0]
    above = float(own[0] / rng.uniform(1.01, 1.2))
    band = (0.0, above)
    speed = float(above * rng.uniform(0.5, 0.9))
    if rng.integers(2) and len(own) > 1 and own[1] > 1.5 * own[0]:
        speed = float(own[0] * (own[1] / own[0]) ** rng.uniform(0.4, 0.6))
        band = (float(max(own[0] * 1.01, speed * 0.8)), float(min(own[1] / 1.01, speed * 1.2)))
    whirl = extrapolated(replace(shaft, speed=speed), true)[1] * float(rng.uniform(1.05, 2.0))
    given = (0.0, 0.0)
    if rng.integers(2):
        given = ((0.0, float(true[1])), (float(true[0]), 0.0))[int(rng.integers(2))]
    shaft = replace(shaft, speed=speed, band=band, whirl=whirl, given=given)
    return Case(name, shaft.text, FEASIBLE, np.nan, "the best of all methods", "shafts"), shaft
