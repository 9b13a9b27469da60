"""Random vibration of the machine as built, by adding up its response over all frequencies.

The other road to a root mean square: no Lyapunov equation and no state, but the steady response of
the machine at many frequencies, integrated with Gauss's rule on panels that shrink towards every
pole, and to infinity exactly by turning the last panels inside out.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.excitations.white_noise import WhiteNoise
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.responses import RandomResponse
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene

_ORDER = 20
_STILL, _LIGHT = 1e-9, 1e-6
"""Part of the fastest pole up to which one is at rest, and decay over frequency up to which one hardly decays."""
_UNDAMPED, _STRETCH = 1e-15, 1e-11
"""Part of what dampers take of a motion if none of it cancels, and stretch in it, up to which they take nothing."""
_NEAR, _ASIDE = 1e-5, 1e-12
"""Part of the way to the next pole up to which one that hardly decays is alone, and part of it to look beside it."""
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
    total, poles = 0.0, _poles(machine)
    for name in names_for(scene, response):
        noise = _noise(scene, name)
        spectrum = Spectrum(machine, response, noise)
        if endless(spectrum, poles) is not None:
            return float("inf")
        total += noise.density.value * _integral(spectrum, poles)
    return float(np.sqrt(total))


def why_infinite(scene: Scene, machine: Machine, response: RandomResponse) -> str:
    """The reason why a root mean square is infinite, as half a sentence; "" where it is finite."""
    for name in names_for(scene, response):
        noise = _noise(scene, name)
        found = endless(Spectrum(machine, response, noise), _poles(machine))
        if found is not None:
            at = f"{found.at / (2.0 * np.pi):.4g} Hz"
            return found.words.format(name=name, on=noise.on, at=at)
    return ""


def endless(spectrum: Spectrum, poles: ComplexArray) -> Infinite | None:
    """Whether the squared response cannot be added up: at a mode, towards rest, or towards infinity."""
    size = np.abs(poles)
    top = float(size.max(initial=0.0)) or 1.0
    for pole in poles[(poles.real > 0.0) & (poles.imag == 0.0)]:
        near, nearer = spectrum(pole.real * (1.0 + np.array([1e-4, 1e-7])))
        if nearer > 1e3 * near:
            return Infinite(RINGS, float(pole.real))
    low = float(size.min(initial=top))
    one, ten = spectrum(low * np.array([1e-4, 1e-3]))
    if one > 10.0 * ten:
        return Infinite(DRIFT)
    one, ten = spectrum(top * np.array([1e3, 1e4]))
    known = spectrum(size)
    nothing = _ROUNDING * float(known[np.isfinite(known)].max(initial=0.0))
    return Infinite(HIGH if spectrum.noise.displaced else DIRECT) if ten > 0.1 * one > nothing else None


def _noise(scene: Scene, name: str) -> WhiteNoise:
    noise = scene.excitations[name]
    assert isinstance(noise, WhiteNoise)
    return noise


def _poles(machine: Machine) -> ComplexArray:
    """Poles but those at zero; what hardly decays does by what dampers take of it, for rounding is as great as that.

    A damper between two coordinates takes of their difference, so that nothing cancels.
    """
    poles, (mass, damping, stiffness, _) = machine.held_poles(), machine.matrices()
    ground, between = damping.sum(axis=1), damping - np.diag(np.diag(damping))
    for i in np.flatnonzero(_light(poles)):
        speed, shape = poles[i].real * (1.0 + _ASIDE), np.cos(np.arange(len(mass)) + 1.0)
        for _ in range(3):
            shape = np.linalg.solve(stiffness - speed**2 * mass + 1j * speed * damping, mass @ shape)
            shape = shape / np.abs(shape).max()
        taken = ground @ np.abs(shape) ** 2 - 0.5 * np.sum(between * np.abs(shape[:, None] - shape) ** 2)
        known = taken > max(_UNDAMPED * np.abs(shape) @ np.abs(damping) @ np.abs(shape), _STRETCH**2 * damping.max())
        poles[i] = complex(poles[i].real, known * taken / (2.0 * (shape.conj() @ mass @ shape).real))
    return poles


def _light(poles: ComplexArray) -> BoolArray:
    return np.asarray((np.abs(poles.imag) <= _LIGHT * np.abs(poles)) & (poles.real > 0.0))


def _integral(spectrum: Spectrum, poles: ComplexArray) -> float:
    """Integral of the squared response over all frequencies; beside a pole that hardly decays in closed form."""
    kept = poles.real + 1j * np.abs(poles.imag)
    last, total, ends = 2.0 * float(np.abs(kept).max()), 0.0, [0.0]
    for pole in np.sort(kept[_light(kept)]):
        if pole.real <= ends[-1]:
            continue
        away = np.abs(kept - pole)
        near = _NEAR * float(min(pole.real, away[away > _STILL * pole.real].min(initial=np.inf)))
        aside = near * np.array([-1.0, -0.5, 0.5, 1.0])
        residue = spectrum(pole.real + aside) * (aside**2 + pole.imag**2) @ np.array([-1.0, 4.0, 4.0, -1.0]) / 6.0
        if pole.imag:  # an undamped one is neither shaken nor seen
            total += 2.0 * float(residue) / pole.imag * float(np.arctan(near / pole.imag))
        kept[away <= _STILL * pole.real] = complex(pole.real, near)
        ends += [pole.real - near, pole.real + near]
    edges = [_edges(kept, *one) for one in zip(ends[::2], [*ends[1::2], last], strict=True)]
    turned = np.array([0.0, 0.5, 1.0]) / last
    omega, weights = _gauss(edges)
    inverse, parts = _gauss([turned])
    return total + float(spectrum(omega) @ weights) + float((spectrum(1.0 / inverse) / inverse**2) @ parts)


def _gauss(panels: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss's rule on panels by their ends."""
    nodes, weights = np.polynomial.legendre.leggauss(_ORDER)
    middle = 0.5 * np.concatenate([one[1:] + one[:-1] for one in panels])[:, None]
    half = 0.5 * np.concatenate([np.diff(one) for one in panels])[:, None]
    return (middle + half * nodes).ravel(), (half * weights).ravel()


def _edges(poles: ComplexArray, low: float, high: float) -> FloatArray:
    """Ends of panels from `low` to `high`, none longer than its distance to any pole."""
    reach = np.abs(poles.imag)[:, None] * np.concatenate([[0.0], 0.5 * 2.0 ** np.arange(_FAR)])
    found = np.unique(
        np.concatenate([[low, high], (poles.real[:, None] + reach).ravel(), (poles.real[:, None] - reach).ravel()])
    )
    found = found[(found >= low) & (found <= high)]
    found = found[np.concatenate([[True], np.diff(found) > 1e-15 * high])]
    kept = [0]
    for end in range(2, len(found)):  # of many poles the others bring more than are needed
        start, stop = found[kept[-1]], found[end]
        away = np.hypot(np.maximum(np.maximum(start - poles.real, poles.real - stop), 0.0), poles.imag)
        if stop - start > away.min():
            kept.append(end - 1)
    return np.asarray(found[[*kept, -1]])
