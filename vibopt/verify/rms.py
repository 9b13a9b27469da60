"""Random vibration of the machine as built, by adding up its response over all frequencies.

The other road to a root mean square: no Lyapunov equation and no state, but the steady response of
the machine at many frequencies, integrated with Gauss's rule on panels that shrink towards every
pole, and to infinity exactly by turning the last panels inside out.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations.white_noise import WhiteNoise
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.responses import RandomResponse
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene

_ORDER = 20
_UNDAMPED = 1e-13
"""Decay over frequency of a pole below which it counts as undamped."""
_ROUNDING = 1e-28
"""Part of a squared response at its modes below which it is rounding."""
_FAR, _ENTRIES = 40, 3_000_000
"""Halvings of a panel towards a pole, and entries of matrices at once, at most."""

DIRECT = "white noise holds every frequency, and its force moves {on} at once"
HIGH = "white noise holds every frequency, and what is asked does not fall off fast enough above those of {on}"
DRIFT = "what the noise of {name} pushes drifts away without end"
RINGS = "an undamped mode at {at} is shaken by {name}, and nothing stops it"


@dataclass(frozen=True, slots=True)
class Infinite:
    """Why a root mean square has no end: a template of words above, and the frequency of it [rad/s]."""

    words: str
    at: float = 0.0


@dataclass(frozen=True)
class Spectrum:
    """Squared response of a built machine per unit of noise, against frequency; callable."""

    machine: Machine
    response: RandomResponse
    noise: WhiteNoise

    def __call__(self, omega: FloatArray) -> FloatArray:
        """Shape of `omega` (n,) [rad/s], greater than zero."""
        many = max(1, _ENTRIES // self.machine.n_free**2)
        if len(omega) > many:
            return np.concatenate([self(omega[k : k + many]) for k in range(0, len(omega), many)])
        one = np.ones(omega.shape, dtype=complex)
        with np.errstate(all="ignore"):
            moved = one if self.noise.family == "bodies" or self.noise.displaced else -one / omega**2
            acts = {place: np.asarray(moved * part, dtype=complex) for place, part in self.noise.acts.items()}
            motion = self.machine.shake(omega, *((acts, {}) if self.noise.family == "bodies" else ({}, acts)))
            value = np.abs(self.response.measure(self.machine, motion)) ** 2
        return np.where(np.isnan(value), np.inf, value)


def rms_of(scene: Scene, machine: Machine, response: RandomResponse) -> float:
    """Root mean square of a response on the built machine [SI]; inf where it has no end."""
    total = 0.0
    for name in names_for(scene, response):
        noise = _noise(scene, name)
        spectrum = Spectrum(machine, response, noise)
        if endless(spectrum) is not None:
            return float("inf")
        total += noise.density.value * _integral(spectrum, machine.poles())
    return float(np.sqrt(total))


def why_infinite(scene: Scene, machine: Machine, response: RandomResponse) -> str:
    """The reason why a root mean square is infinite, as half a sentence; "" where it is finite."""
    for name in names_for(scene, response):
        noise = _noise(scene, name)
        found = endless(Spectrum(machine, response, noise))
        if found is not None:
            at = f"{found.at / (2.0 * np.pi):.4g} Hz"
            return found.words.format(name=name, on=noise.on, at=at)
    return ""


def endless(spectrum: Spectrum) -> Infinite | None:
    """Whether the squared response cannot be added up: at a mode, towards rest, or towards infinity."""
    poles = spectrum.machine.poles()
    size = np.abs(poles)
    top = float(size.max(initial=0.0)) or 1.0
    real = poles[size > 1e-9 * top]
    for pole in real[(real.real > 0.0) & (np.abs(real.imag) <= _UNDAMPED * np.abs(real))]:
        near, nearer = spectrum(pole.real * (1.0 + np.array([1e-4, 1e-7])))
        if nearer > 1e3 * near:
            return Infinite(RINGS, float(pole.real))
    low = float(np.abs(real).min(initial=top))
    one, ten = spectrum(low * np.array([1e-4, 1e-3]))
    if one > 10.0 * ten:
        return Infinite(DRIFT)
    one, ten = spectrum(top * np.array([1e3, 1e4]))
    known = spectrum(size[size > 1e-9 * top])
    nothing = _ROUNDING * float(known[np.isfinite(known)].max(initial=0.0))
    return Infinite(HIGH if spectrum.noise.displaced else DIRECT) if ten > 0.1 * one > nothing else None


def _noise(scene: Scene, name: str) -> WhiteNoise:
    noise = scene.excitations[name]
    assert isinstance(noise, WhiteNoise)
    return noise


def _integral(spectrum: Spectrum, poles: Iterable[complex]) -> float:
    """Integral of the squared response over all frequencies."""
    kept = [complex(abs(pole.real), pole.imag) for pole in poles if abs(pole) > 0.0]
    last = 2.0 * max(abs(pole) for pole in kept)
    edges = _edges(kept, last)
    nodes, weights = np.polynomial.legendre.leggauss(_ORDER)
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    omega = (middle[:, None] + half[:, None] * nodes).ravel()
    below = float(spectrum(omega) @ (half[:, None] * weights).ravel())
    turned = np.array([0.0, 0.5, 1.0]) / last
    middle, half = 0.5 * (turned[1:] + turned[:-1]), 0.5 * np.diff(turned)
    inverse = (middle[:, None] + half[:, None] * nodes).ravel()
    return below + float((spectrum(1.0 / inverse) / inverse**2) @ (half[:, None] * weights).ravel())


def _edges(poles: list[complex], last: float) -> FloatArray:
    """Ends of panels from 0 to `last`, none longer than its distance to any pole."""
    steps = 2.0 ** np.arange(_FAR)
    edges = [np.array([0.0, last])]
    for pole in poles:
        reach = max(abs(pole.imag), 4.0 * _UNDAMPED * abs(pole)) * np.concatenate([[0.0], 0.5 * steps])
        reach = reach[reach < last]
        edges += [pole.real + reach, pole.real - reach]
    found = np.unique(np.concatenate(edges))
    found = found[(found >= 0.0) & (found <= last)]
    found = found[np.concatenate([[True], np.diff(found) > 1e-15 * last])]
    at, kept = np.array(poles), [0]
    for end in range(2, len(found)):  # of many poles the others bring more than are needed
        low, high = found[kept[-1]], found[end]
        away = np.hypot(np.maximum(np.maximum(low - at.real, at.real - high), 0.0), at.imag)
        if high - low > away.min():
            kept.append(end - 1)
    return np.asarray(found[[*kept, -1]])
