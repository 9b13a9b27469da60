"""Value of a form at a design: the exact worst over its speeds, and where it is."""

from __future__ import annotations

from dataclasses import field, replace
from math import hypot

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import (
    DecayRate,
    EnergyShare,
    Form,
    FreeMotion,
    ModeDamping,
    ModeFrequency,
    ModeGap,
    ModeRatio,
    Modulus,
    Monomials,
    PeakInTime,
    RootMeanSquare,
    StaticForce,
    StaticLoad,
    StaticRow,
)
from vibopt.mechanics.combine import combined
from vibopt.mechanics.harmonic import modal_of, mount_count, transfer
from vibopt.mechanics.modal import WORTH, Modal
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import damping_ratios, decay_rates, natural_frequencies, poles, sag
from vibopt.mechanics.onemass import Curve, curve
from vibopt.mechanics.peaks import Extreme, greatest, least
from vibopt.records import dataclass
from vibopt.signals import Drive, Output


@dataclass(frozen=True, slots=True)
class Worst:
    """Value of a form [SI], and per excitation the speed [rad/s] at which it is reached."""

    value: float
    speeds: dict[str, float] = field(default_factory=dict)


def worst(model: Model, form: Form, x: FloatArray, *, least_wanted: bool = False) -> Worst:
    """The greatest value (the least with `least_wanted`) of a form over its speeds at design x (n_vars,)."""
    if isinstance(form, Modulus):
        return _modulus(model, form, x, least_wanted)
    return Worst(plain_value(model, form, x))


def plain_value(model: Model, form: Form, x: FloatArray) -> float:
    """Value of a form that knows no speeds."""
    if isinstance(form, Monomials):
        return float(monomials(form, x))
    p = model.values(x)
    if isinstance(form, StaticRow):
        down = sag(model, x)
        return float("inf") if down is None else float(abs(form.row @ down))
    if isinstance(form, StaticLoad):
        down = sag(model, x)
        if down is None:
            return float("inf")
        squeezed = float(form.row @ down)
        return (squeezed if form.signed else abs(squeezed)) * float(monomials(form.factor, x))
    if isinstance(form, StaticForce | ModeGap | EnergyShare):
        from vibopt.program.rare_forms import spatial_value

        return spatial_value(model, form, x)
    if isinstance(form, ModeRatio | FreeMotion):
        from vibopt.program.rare_forms import free_value

        return free_value(model, form, p)
    if isinstance(form, ModeFrequency):
        return float(natural_frequencies(model, p)[max(form.mode - 1, 0)])
    if isinstance(form, RootMeanSquare):
        from vibopt.program.mean_square import root_mean_square

        return root_mean_square(model, form, x)
    if isinstance(form, PeakInTime):
        from vibopt.program.in_time import peak_value

        return peak_value(model, form, x)
    if isinstance(form, DecayRate):
        return float(decay_rates(model, p).min(initial=np.inf))
    assert isinstance(form, ModeDamping)
    ratios = damping_ratios(model, p)
    return float(ratios[form.mode - 1]) if len(ratios) >= form.mode else float("inf")


def monomials(form: Monomials, x: FloatArray) -> FloatArray:
    """Sum of monomials at designs x (..., n_vars), shape (...)."""
    with np.errstate(divide="ignore"):
        powers = np.where(form.exponents == 0.0, 1.0, np.asarray(x)[..., None, :] ** form.exponents)
    value: FloatArray = (form.scale * powers.prod(axis=-1)).sum(axis=-1)
    return value


def _modulus(model: Model, form: Modulus, x: FloatArray, least_wanted: bool) -> Worst:
    if form.endless and not least_wanted:
        return Worst(float("inf"), dict.fromkeys(form.endless, 0.0))
    found = {drive.name: drive_extreme(model, form, drive, x, least_wanted) for drive in form.drives}
    values = [one.value for one in found.values()]
    total = hypot(*values) if form.combine == "rss" else sum(values)
    return Worst(total, {name: one.speed for name, one in found.items()})


def drive_extreme(model: Model, form: Modulus, drive: Drive, x: FloatArray, least_wanted: bool) -> Extreme:
    """Extreme of the response to one excitation over its bands."""
    closed = closed_form(model, form, drive, x)
    if closed is not None:
        ends = [one for band in drive.bands for one in closed.candidates(band)]
        return (min if least_wanted else max)(ends, key=lambda one: one.value)
    if not least_wanted:
        from vibopt.program.few import few_peaks
        from vibopt.program.greatest_values import highest

        few = few_peaks(model, form, drive, x, 1.0)
        if few is not None:
            return few[0].at
        through = highest(model, form, drive, x, 1.0)
        if through is not None:
            return through[0]
    search = least if least_wanted else greatest
    modal = modal_of(model, model.values(x))
    singular, breaks = singularities(model, form, drive, x, modal)
    found = search(DriveResponse(model, form, drive, x, modal), drive.bands, singular, breaks)
    if model.n_free < WORTH or not np.isfinite(found.value):
        return found
    return Extreme(float(DriveResponse(model, form, drive, x)(np.array([found.speed]))[0]), found.speed)


def closed_form(model: Model, form: Modulus, drive: Drive, x: FloatArray) -> Curve | None:
    """The response as a closed form where there is one: one mass, one harmonic."""
    if model.n_free != 1 or len(drive.lines) != 1 or form.rigid_link:
        return None
    found = curve(model, model.values(x), form.output, drive.lines[0])
    share = mount_count(model, form.output, x)
    return found if found is None or share == 1.0 else replace(found, size=found.size / share**2)


def singularities(
    model: Model, form: Modulus, drive: Drive, x: FloatArray, modal: Modal | None = None
) -> tuple[ComplexArray, FloatArray]:
    """Complex speeds where the response to a drive is singular, real speeds where it is not smooth."""
    found = modal.poles if modal is not None else poles(model, model.values(x))
    if form.rigid_link:
        rigid = rigid_model(model, form.rigid_link)
        found = np.concatenate([found, poles(rigid, rigid.values(x))])
    orders = [line.order for line in drive.lines]
    breaks = sorted({speed for line in drive.lines for speed in line.amplitude.breaks()})
    return np.concatenate([found / order for order in orders]), np.array(breaks)


@dataclass(frozen=True)
class DriveResponse:
    """Modulus of the response to one excitation against its speed, at one design; callable.

    `modal` makes many frequencies of a large model cheap; None solves each directly.
    """

    model: Model
    form: Modulus
    drive: Drive
    x: FloatArray
    modal: Modal | None = None

    def __call__(self, speed: FloatArray) -> FloatArray:
        """Combined peak amplitude, shape of `speed` [rad/s]."""
        orders = tuple(line.order for line in self.drive.lines)
        value = combined(self._lines(self.model, self.form.output, speed), orders, self.form.combine)
        if not self.form.rigid_link:
            return value
        rigid, output = rigid_form(self.model, self.form)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio: FloatArray = combined(self._lines(rigid, output, speed), orders, self.form.combine) / value
        return ratio

    def _lines(self, model: Model, output: Output, speed: FloatArray) -> ComplexArray:
        """Complex amplitude of every line, all lines in one batch, shape (n_lines, ...)."""
        p, lines = model.values(self.x), self.drive.lines
        speed = np.asarray(speed, dtype=float)
        every = (len(lines), *[1] * speed.ndim)
        orders = np.array([line.order for line in lines]).reshape(every)
        vectors = np.array([line.vector if model is self.model else line.vector @ model.basis for line in lines])
        size = np.array([line.amplitude.at(speed) for line in lines]) / float(
            mount_count(model, self.form.output, self.x)
        )
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            modal = self.modal if model is self.model else None
            h = transfer(model, p, output, vectors.reshape(*every, -1), orders * speed, modal)
            value = np.where(np.isfinite(h) | (size == 0.0), h * size, np.inf)
            return np.where(np.isnan(value), np.inf, value)  # complex infinity times a real number


def rigid_model(model: Model, link: str) -> Model:
    """The model with the two ends of a link joined."""
    row = model.links[link][: model.n_free]
    basis = np.eye(model.n_free)
    first = int(np.abs(row).argmax())
    basis[first] = -row / row[first]
    return model.on_basis(np.delete(basis, first, axis=1))


def rigid_form(model: Model, form: Modulus) -> tuple[Model, Output]:
    """The model with the form's link rigid, and the output on its coordinates."""
    rigid = rigid_model(model, form.rigid_link)
    return rigid, replace(form.output, row=form.output.row @ rigid.basis)
