"""The response to one excitation at a design: against the speed, and its exact extremes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.combine import Extreme, combined
from vibopt.mechanics.harmonic import modal_of, mount_count, transfer
from vibopt.mechanics.modal import WORTH, Modal, Undamped
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import poles
from vibopt.mechanics.onemass import Curve, curve
from vibopt.records import cached_property, dataclass
from vibopt.signals import Drive, Line, Output, sizes

if TYPE_CHECKING:
    from vibopt.forms.modulus import Modulus

_TOGETHER = 8192
"""Designs that are solved in one go."""


def drive_extreme(model: Model, form: Modulus, drive: Drive, x: FloatArray, least_wanted: bool) -> Extreme:
    """Extreme of the response to one excitation over its bands."""
    closed = closed_form(model, form, drive, x)
    if closed is not None:
        ends = [candidate for band in drive.bands for candidate in closed.candidates(band)]
        return (min if least_wanted else max)(ends, key=lambda one: one.value)
    if not least_wanted:
        from vibopt.forms.few import few_peaks
        from vibopt.forms.greatest_values import highest

        few = few_peaks(model, form, drive, x, 1.0)
        if few is not None:
            return few[0].at
        through = highest(model, form, drive, x, 1.0)
        if through is not None:
            return through[0]
    from vibopt.mechanics.peaks import greatest, least

    search = least if least_wanted else greatest
    modal, singular, breaks = modes_for(model, form, drive, x)
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


def modes_for(
    model: Model, form: Modulus, drive: Drive, x: FloatArray
) -> tuple[Modal | Undamped | None, ComplexArray, FloatArray]:
    """Modes of a model that is worth it, and the singularities; nothing of both where single speeds are looked at."""
    if all(band.is_point for band in drive.bands):
        return None, np.zeros(0, dtype=complex), np.zeros(0)
    top = max(line.order for line in drive.lines) * max(band.high for band in drive.bands)
    modal = modal_of(model, model.values(x), top)
    return modal, *singularities(model, form, drive, x, modal)


def singularities(
    model: Model, form: Modulus, drive: Drive, x: FloatArray, modal: Modal | Undamped | None = None
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
    modal: Modal | Undamped | None = None

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
        own, speed = model is self.model, np.asarray(speed, dtype=float)
        p, orders, vectors, count = self._own if own else self._of(model)
        every = (len(orders), *[1] * speed.ndim)
        size = sizes(self.drive.lines, speed) / count
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            at = orders.reshape(every) * speed
            h = transfer(model, p, output, vectors.reshape(*every, -1), at, self.modal if own else None)
            value = np.where(np.isfinite(h) | (size == 0.0), h * size, np.inf)
            return np.where(np.isnan(value), np.inf, value)  # complex infinity times a real number

    def _of(self, model: Model) -> tuple[FloatArray, FloatArray, ComplexArray, float]:
        """Coefficients (n_terms,), orders (n_lines,), vectors (n_lines, n_coords), mounts that share the value."""
        lines = self.drive.lines
        vectors = [line.vector if model is self.model else line.vector @ model.basis for line in lines]
        count = float(mount_count(model, self.form.output, self.x))
        return model.values(self.x), np.array([line.order for line in lines]), np.array(vectors), count

    @cached_property
    def _own(self) -> tuple[FloatArray, FloatArray, ComplexArray, float]:
        return self._of(self.model)


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


def solved(model: Model, output: Output, line: Line, speeds: list[float], x: FloatArray) -> FloatArray:
    """Size of one harmonic at designs x (n, n_vars) and speeds [rad/s], solved directly, shape (n, n_speeds).

    Not a number where it has no end.
    """
    columns = []
    for speed in speeds:
        parts = [
            transfer(model, model.values(part), output, line.vector, np.array(line.order * speed))
            for part in np.array_split(x, max(len(x) // _TOGETHER, 1))
        ]
        size = np.abs(np.concatenate(parts)) * float(line.amplitude.at(np.array([speed]))[0])
        columns.append(np.where(np.isfinite(size), size, np.nan))
    return np.stack(columns, axis=-1)
