"""Shock spectra of what comes once in a file: as a table, and as figures with the point of the machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibopt.answer.tabular import Tabular
from vibopt.arrays import FloatArray
from vibopt.errors import InputError, way_out
from vibopt.excitations.segments import together
from vibopt.mechanics.built import GROUND
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.shock_spectrum import Spectrum, spectra
from vibopt.records import dataclass
from vibopt.report.series import Mark, Panel, known_curve
from vibopt.report.what_to_build import machine_in
from vibopt.scene.scene import Design, Scene
from vibopt.signals import Segment
from vibopt.units import best_unit, plain, show, to_unit
from vibopt.values import Fact

DAMPING = (0.0, 0.05, 0.2, 1.0, 2.0)
"""Ratios of a spectrum unless others are asked for: undamped to overdamped."""
_USUAL = 0.05
_POINTS, _SOFT, _HARD, _AROUND = 240, 0.03, 10.0, 10.0
"""Natural frequencies of a curve; their products with the load's duration; span about a mount where it has none."""
_RECORD, _SAMPLE = 200, 0.2
"""Segments from which a load is a record, and the highest natural frequency times the time between its points."""


@dataclass(frozen=True)
class ShockSpectrum(Tabular):
    """Greatest responses of lone masses on mounts to one load, by damping ratio and natural frequency.

    name, on
        What comes, and where: on a base as its motion, on a body as a force.
    moves
        Whether it moves a base; absolute and pseudo-acceleration are forces [N] where it does not.
    rates, ratios
        Natural frequencies (n,) [rad/s] and damping ratios (k,).
    found
        Each (k, n).
    """

    name: str
    on: str
    moves: bool
    rates: FloatArray
    ratios: FloatArray
    found: Spectrum

    def table(self) -> list[dict[str, Any]]:
        """A row for each mount; accelerations in m/s^2, of a pushed body forces in N, displacements in m."""
        spectrum, rows = self.found, []
        kind = "acceleration" if self.moves else "force"
        for (i, ratio), (j, rate) in (
            (each, other) for each in enumerate(self.ratios.tolist()) for other in enumerate(self.rates.tolist())
        ):
            primary, residual = float(spectrum.absolute[i, j]), float(spectrum.absolute_after[i, j])
            pseudo = max(float(spectrum.pseudo[i, j]), float(spectrum.pseudo_after[i, j]))
            rows.append(
                {"natural_frequency_hz": rate / (2.0 * np.pi), "damping_ratio": ratio}
                | {f"{kind}_maximax": max(primary, residual), f"{kind}_primary": primary}
                | {f"{kind}_residual": residual, f"pseudo_{kind}": pseudo}
                | ({"relative_displacement": pseudo / rate**2} if self.moves else {})
            )
        return rows

    def heading(self) -> tuple[str, ...]:
        return (f"Shock spectrum of {self.name} on {self.on}",)


def shock_spectrum(
    scene: Scene, *, on: str | None = None, frequencies: Sequence[float] = (), damping: Sequence[float] = DAMPING
) -> ShockSpectrum:
    """Shock spectrum of what comes once on one base or body: maximax, primary (during) and residual (after).

    Parameters
    ----------
    scene
        A problem file as read, or a machine of Python.
    on
        The base or body; may be left out where there is one.
    frequencies
        Natural frequencies [Hz]; a few hundred over what the load asks for if left out.
    damping
        Damping ratios, 0 to overdamped.

    Raises
    ------
    InputError
        Nothing comes once there, or it has no one spectrum; a frequency or a ratio that no mount has.
    """
    loads = _loads(scene)
    if not loads:
        raise InputError(f"{scene.name}: {_nothing(scene)}")
    if on is None and len(loads) > 1:
        raise InputError(f"{scene.name}: what comes once acts on {' and on '.join(loads)}. Say on which: on = ...")
    if on is not None and on not in loads:
        raise InputError(f"{scene.name}: nothing comes once on {on}.{way_out(on, loads)}")
    place = on or next(iter(loads))
    names, segments = loads[place]
    given = np.asarray(frequencies, dtype=float)
    rates = 2.0 * np.pi * given if given.size else _rates(segments, None)
    ratios = np.asarray(damping, dtype=float)
    if not (np.isfinite(rates) & (rates > 0.0)).all() or not (np.isfinite(ratios) & (ratios >= 0.0)).all():
        raise InputError(
            f"{scene.name}: natural frequencies are above zero, in Hz, and damping ratios zero or more. Leave them out "
            "for the usual ones."
        )
    spectrum = spectra(np.ones(1), _summed(segments), rates, ratios[:, None])
    return ShockSpectrum(" and ".join(names), place, place in scene.bases, rates, ratios, spectrum)


def _loads(scene: Scene) -> dict[str, tuple[list[str], tuple[Segment, ...]]]:
    """By place what comes once there and is over: names, and signals that are read by several rows."""
    places: dict[str, list[str]] = {}
    for name, excitation in scene.excitations.items():
        if (
            excitation.once is not None
            and excitation.ramp is None
            and (excitation.once.holds or not excitation.once.endless)
            and excitation.once.durations is None
            and not any(excitation.once.start)
        ):
            places.setdefault(excitation.on, []).append(name)
    found = {}
    for place, names in places.items():
        every = [scene.excitations[name].once for name in names]
        found[place] = names, together([one.segments() for one in every if one is not None])
    return found


def _summed(segments: tuple[Segment, ...]) -> tuple[Segment, ...]:
    """Several signals as their sum."""
    from dataclasses import replace

    return tuple(
        replace(segment, read=segment.read.sum(axis=0, keepdims=True), blows=segment.blows.sum(keepdims=True))
        for segment in segments
    )


def _nothing(scene: Scene) -> str:
    if any(
        excitation.once is not None and excitation.once.durations is not None
        for excitation in scene.excitations.values()
    ):
        return "a pulse that may have any duration has one shock spectrum for each. Write its duration."
    return "a shock spectrum is of what comes once and is over, and nothing does. Add a pulse, a drop or a record."


def _rates(segments: tuple[Segment, ...], own: float | None) -> FloatArray:
    """Natural frequencies that tell something of a load [rad/s], rising, that of the machine among them."""
    load = [segment.length for segment in segments if (segment.start != 0.0).any() and not segment.endless]
    middle = own / (2.0 * np.pi) if own is not None else 10.0
    if not load:
        low, high = middle / _AROUND, middle * _AROUND
    elif len(load) > _RECORD:
        low, high = 2.0 / sum(load), _SAMPLE / min(load)
    else:
        low, high = _SOFT / sum(load), _HARD / min(load)
    if own is not None:
        low, high = min(low, 0.5 * middle), max(high, 2.0 * middle)
    spread = 2.0 * np.pi * np.geomspace(low, high, _POINTS)
    return np.union1d(spread, [own]) if own is not None else spread


@dataclass(frozen=True, slots=True)
class _Mount:
    """The one mount of a machine of one mass: natural frequency [rad/s], damping ratio, mass [kg]."""

    rate: float
    ratio: float
    mass: float


def _mount(scene: Scene, machine: Machine | None, on: str) -> _Mount | None:
    """Where one mass stands on the base that moves, or is pushed on one support."""
    if machine is None or machine.in_space or machine.on_structures or len(machine.masses) != 1:
        return None
    [(body, mass)] = machine.masses.items()
    supports = {end for joint in machine.joints for end in joint.ends if end != body}
    one_support = supports == {on} if on in scene.bases else body == on and supports <= {GROUND, *scene.bases}
    if not one_support or len(supports) != 1 or any(joint.inertance for joint in machine.joints) or mass <= 0.0:
        return None
    stiff, damped = (sum(getattr(joint, word) for joint in machine.joints) for word in ("stiffness", "damping"))
    if stiff <= 0.0:
        return None
    return _Mount(float(np.sqrt(stiff / mass)), float(damped / (2.0 * np.sqrt(stiff * mass))), mass)


def spectrum_panels(design: Design) -> list[Panel]:
    """For every place on which something comes once: by time of the peak, by damping ratio, and as displacement."""
    machine, panels = machine_in(design), list[Panel]()
    for place, (names, segments) in _loads(design.scene).items():
        mount = _mount(design.scene, machine, place)
        own = mount.ratio if mount is not None else _USUAL
        rates = _rates(segments, mount.rate if mount is not None else None)
        ratios = np.union1d(DAMPING, [own])
        spectrum = spectra(np.ones(1), _summed(segments), rates, ratios[:, None])
        of = ShockSpectrum(" and ".join(names), place, place in design.scene.bases, rates, ratios, spectrum)
        sudden = not any((segment.start != 0.0).any() for segment in segments)
        panels += _Drawn(design.scene, of, own, mount, sudden, segments[-1].endless).panels()
    return panels


def spectrum_asked(design: Design) -> list[Panel]:
    """The same, where it was asked for by name.

    Raises
    ------
    InputError
        Nothing comes once and is over.
    """
    panels = spectrum_panels(design)
    if not panels:
        raise InputError(f"{design.name}: {_nothing(design.scene)}")
    return panels


@dataclass(frozen=True, slots=True)
class _Drawn:
    """The panels of one spectrum; a damping ratio of its own is drawn with its parts.

    A `sudden` load is over at once: all is residual, and rises without end with the frequency.  What `stays` is never
    over.
    """

    scene: Scene
    of: ShockSpectrum
    own: float
    mount: _Mount | None
    sudden: bool
    stays: bool

    def panels(self) -> list[Panel]:
        spectrum, kind = self.of.found, "acceleration" if self.of.moves else "force"
        most = np.maximum(spectrum.absolute, spectrum.absolute_after)
        row, ratio = int(self.of.ratios.searchsorted(self.own)), plain(self.own, 3)
        parts = {"maximax": most[row]}
        if not (self.sudden or self.stays):
            parts |= {
                "primary, during the load": spectrum.absolute[row],
                "residual, after it": spectrum.absolute_after[row],
            }
        listed = {f"damping ratio {plain(z, 3)}": each for z, each in zip(self.of.ratios.tolist(), most, strict=True)}
        name = f"Shock spectrum of {self.of.name} on {self.of.on}"
        quantity = "absolute acceleration" if self.of.moves else "force on the support"
        found = [
            self._panel(f"{name}, damping ratio {ratio}", quantity, kind, parts, most[row], log=self.sudden),
            self._panel(f"{name}, maximax", quantity, kind, listed, most[row], log=self.sudden),
        ]
        if self.of.moves:
            across = np.maximum(spectrum.pseudo, spectrum.pseudo_after) / self.of.rates**2
            words = {f"damping ratio {plain(z, 3)}": each for z, each in zip(self.of.ratios, across, strict=True)}
            title = f"{name}, relative displacement"
            found.append(self._panel(title, "relative displacement", "length", words, across[row], log=True))
        return found

    def _panel(
        self, title: str, quantity: str, kind: str, curves: Mapping[str, FloatArray], own: FloatArray, log: bool = False
    ) -> Panel:
        most = float(own.max())
        unit = self._unit(kind, float(np.median(own)) if log else most)
        per, x = to_unit(1.0, unit, kind), self.of.rates / (2.0 * np.pi)
        drawn = tuple(known_curve(words, x, per * y) for words, y in curves.items())
        marks: tuple[Mark, ...] = ()
        if self.mount is not None:
            at = int(self.of.rates.searchsorted(self.mount.rate))
            shown = f"machine: {show(float(own[at]), unit, kind)} at {show(self.mount.rate, 'Hz', 'angular_rate')}"
            marks = (Mark("machine", shown, float(x[at]), per * float(own[at])),)
        values = per * np.concatenate(list(curves.values()))
        top, least = float(values.max()), float(values[values > 0.0].min(initial=np.inf))
        return Panel(
            title=title, x_label="natural frequency [Hz]", y_label=f"{quantity} [{unit}]", curves=drawn,
            marks=marks, excitation=self.of.name, log_x=True, log_y=log, x_span=(float(x[0]), float(x[-1])),
            y_span=(0.7 * least, 1.6 * top) if log else (0.0, 1.15 * top),
        )  # fmt: skip

    def _unit(self, kind: str, size: float) -> str:
        """That of the load where it is of this kind, else by size."""
        given = (getattr(self.scene.excitations[name], kind, None) for name in self.of.name.split(" and "))
        return next((str(one.unit) for one in given if isinstance(one, Fact)), "") or best_unit(size, kind)
