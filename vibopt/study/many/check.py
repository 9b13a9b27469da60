"""Many answers measured on the machines as built, by another road than the one that found them.

Motion and forces are those of `LoneMachine` with arrays as its numbers, read by the responses themselves, and the
worst speeds come afresh from the equation of the peaks in w / w_n.  No form is asked.
"""

from __future__ import annotations

import numpy as np

from vibopt.forms import ComplexArray, FloatArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.lone import LoneMachine
from vibopt.responses import HarmonicResponse, Response
from vibopt.responses.damping import DampingOfModes, LossFactor
from vibopt.responses.motion import Displacement, RelativeDisplacement
from vibopt.responses.natural_frequency import NaturalFrequency
from vibopt.responses.parameters import Count, Damping, Mass, Stiffness, TotalMass
from vibopt.responses.static_deflection import StaticDeflection
from vibopt.responses.transmitted import Transmissibility, TransmittedForce
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene
from vibopt.study.many.lower import RefusedError
from vibopt.study.many.numbers import Numbers

_BETWEEN = np.array([0.11, 0.37, 0.63, 0.89])
"""Further places in a band, as parts of it, at which nothing may be worse than the worst."""


def margins(scene: Scene, built: LoneMachine, shaken: Numbers, count: int) -> dict[str, FloatArray]:
    """Part of each bound that is left over (negative: broken), by the names that a `Design` uses.

    Raises
    ------
    RefusedError
        A response is not one that can be measured many at a time.
    """
    found = {}
    for name, response in scene.limits.items():
        sides = [side for side in ("at_most", "at_least") if getattr(response, side) is not None]
        for side in sides:
            value = measured(scene, built, shaken, name, response, side, count)
            given = shaken[f"{name}.{side}"]
            scale = np.abs(1.0 - given if response.complement else given)
            size = np.where(scale == 0.0, 1.0, scale)
            left = (given - value) / size if side == "at_most" else (value - given) / size
            found[name if side == sides[0] else f"{name} ({side})"] = np.broadcast_to(left, (count,))
    return found


def measured(
    scene: Scene, built: LoneMachine, shaken: Numbers, name: str, response: Response, side: str, count: int
) -> FloatArray:
    """Worst value of a response on each machine [SI], shape (count,)."""
    if not isinstance(response, HarmonicResponse):
        return np.broadcast_to(plain(built, response), (count,))
    want_least = (side == "at_least") != response.complement
    value = _worst(scene, built, shaken, name, response, want_least, count)
    return 1.0 - value if response.complement else value


def plain(built: LoneMachine, response: Response) -> FloatArray:
    """A response without speeds on each machine [SI]."""
    mass, stiffness = _mass(built), _total(built, "stiffness")
    if isinstance(response, TotalMass):
        return mass
    if isinstance(response, NaturalFrequency) and response.mode == 1 and response.outside is None:
        return np.sqrt(stiffness / mass)
    if isinstance(response, StaticDeflection):
        with np.errstate(divide="ignore"):
            return np.asarray(mass * GRAVITY / _total(built, "static_stiffness"))
    if isinstance(response, DampingOfModes) and response.of is None and response.mode == 1:
        if np.any(_hysteretic(built)) or not np.all(stiffness > 0.0):
            raise RefusedError
        return _total(built, "damping") / (2.0 * np.sqrt(stiffness * mass))
    if isinstance(response, Mass | Stiffness | Damping | Count | LossFactor | DampingOfModes) and response.of:
        return np.asarray(response.measure_static(built))
    raise RefusedError


def _mass(built: LoneMachine) -> FloatArray:
    return np.asarray(next(iter(built.masses.values())))


def _total(built: LoneMachine, quantity: str, names: list[str] | None = None) -> FloatArray:
    """Sum of a number over joints (None: over all)."""
    chosen = [one for one in built.joints if names is None or one.name in names]
    return np.asarray(sum((getattr(one, quantity) for one in chosen), np.zeros(())))


def _hysteretic(built: LoneMachine, names: list[str] | None = None) -> FloatArray:
    chosen = [one for one in built.joints if names is None or one.name in names]
    return np.asarray(sum((one.stiffness * one.loss_factor for one in chosen), np.zeros(())))


def _worst(
    scene: Scene,
    built: LoneMachine,
    shaken: Numbers,
    name: str,
    response: HarmonicResponse,
    want_least: bool,
    count: int,
) -> FloatArray:
    """Greatest (or least) amplitude over the bands of a limit, shape (count,)."""
    power = next(int(key.rsplit(".", 1)[1]) for key in shaken if key.startswith(f"{name}.amplitude."))
    place = scene.excitations[names_for(scene, response)[0]].on
    omega = _speeds(built, shaken, name, response, place, power, count)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = np.abs(_reading(built, response, place, omega)) * shaken[f"{name}.amplitude.{power}"] * omega**power
    value = np.where(np.isnan(value), np.inf, value)
    return np.asarray(value.min(axis=0) if want_least else value.max(axis=0))


def _speeds(
    built: LoneMachine, shaken: Numbers, name: str, response: HarmonicResponse, place: str, power: int, count: int
) -> FloatArray:
    """Frequencies to look at [rad/s], shape (n, count): ends, peaks and a few places between."""
    bands = [key for key in shaken if key.startswith(f"{name}.low")]
    inner = None
    if not all(key.endswith(".point") for key in bands):
        inner = peaks(built, response, place, power, count)
    found = []
    for b, key in enumerate(bands):
        low, high = (np.broadcast_to(one, (count,)) for one in (shaken[key], shaken[f"{name}.high{b}"]))
        found.append(low[None])
        if not key.endswith(".point") and inner is not None:
            found += [
                high[None],
                low + (high - low) * _BETWEEN[:, None],
                np.where((inner >= low) & (inner <= high), inner, low),
            ]
    return np.concatenate(found)


def _reading(built: LoneMachine, response: HarmonicResponse, place: str, omega: FloatArray) -> ComplexArray:
    """What is read per unit of what shakes, complex, shape of `omega`."""
    shaken = {place: np.ones(omega.shape, dtype=complex)}
    on_body = place in built.masses
    return response.measure(built, built.shake(omega, shaken if on_body else {}, {} if on_body else shaken))


def peaks(built: LoneMachine, response: HarmonicResponse, place: str, power: int, count: int) -> FloatArray:
    """Frequencies of all stationary points [rad/s] and the natural frequency, shape (n, count); 0 where not real.

    With u = (w / w_n)^2 the square of the reading is u^p (a + b u) / ((1 - u)^2 + z u + h), and its
    slope vanishes at the roots of a polynomial of degree three at most.
    """
    names, more = _numerator(built, response, place)
    p = power + more + (response.power if isinstance(response, Displacement) else 0)
    k = np.broadcast_to(_total(built, "stiffness"), (count,))
    if not np.all(k > 0.0):
        raise RefusedError
    natural = k / _mass(built)
    z = _total(built, "damping") ** 2 / (_mass(built) * k)
    h = (_hysteretic(built) / k) ** 2
    a, b = np.ones(count), np.zeros(count)
    if names is not None:
        a = a * (_total(built, "stiffness", names) ** 2 + _hysteretic(built, names) ** 2) / k**2
        b = b + _total(built, "damping", names) ** 2 / (_mass(built) * k)
    line, rest = z - 2.0, 1.0 + h
    coefficients = (
        (p - 1) * b, p * (a + b * line) - 2.0 * a, p * (a * line + b * rest) + b * rest - a * line, p * a * rest
    )  # fmt: skip
    with np.errstate(invalid="ignore"):
        found = np.sqrt(_roots(*(np.broadcast_to(one, (count,)) for one in coefficients)) * natural)
    return np.concatenate([np.sqrt(natural)[None], np.where(np.isfinite(found), found, 0.0)])


def _roots(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Real roots of a u^3 + b u^2 + c u + d by eigenvalues, of quadratics by halves; nan where there is none."""
    if not a.any():
        with np.errstate(all="ignore"):
            root = np.sqrt(c * c - 4.0 * b * d)
            large = -0.5 * (c + np.copysign(root, c))
            return np.stack([large / b, d / large])
    if not d.any():
        return _roots(np.zeros_like(a), a, b, c)
    matrix = np.zeros((len(a), 3, 3))
    # in 1 / u, so that light damping (a small against d) leaves the eigenvalues of size one
    lead = np.where(d == 0.0, 1e-300, d)
    matrix[:, 0] = -np.stack([c / lead, b / lead, a / lead], axis=1)
    matrix[:, 1, 0] = matrix[:, 2, 1] = 1.0
    inverse = np.linalg.eigvals(matrix).T
    with np.errstate(all="ignore"):
        real = np.where(np.abs(inverse.imag) <= 1e-7 * np.abs(inverse), 1.0 / inverse.real, np.nan)
        for _ in range(3):
            real = real - (((a * real + b) * real + c) * real + d) / ((3.0 * a * real + 2.0 * b) * real + c)
    return np.asarray(real)


def _numerator(built: LoneMachine, response: HarmonicResponse, place: str) -> tuple[list[str] | None, int]:
    """Links whose impedance is the numerator (None: a constant), and the extra power of w from inertia."""
    kinds = Displacement | RelativeDisplacement | Transmissibility | TransmittedForce
    if not isinstance(response, kinds) or getattr(response, "through", None) is not None:
        raise RefusedError
    into, names = getattr(response, "into", None), [one.name for one in built.joints]
    if place in built.masses:
        if into is None:
            return None, 0
        return (names if into == place else [one.name for one in built.joints if into in one.ends]), 0
    joined = [one.name for one in built.joints if place in one.ends]
    if into is None and not isinstance(response, RelativeDisplacement):
        return joined, 0
    if joined != names:
        raise RefusedError
    return (names, 2) if into is not None else (None, 2)


__all__ = ["margins", "measured", "plain"]
