"""Forms at many designs at once: exact where there are no speeds, at the sampled speeds elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vibopt.forms import (
    ComplexArray,
    FloatArray,
    Form,
    ModeDamping,
    ModeFrequency,
    Modulus,
    Monomials,
    StaticLoad,
    StaticRow,
)
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model
from vibopt.program.bounds import FormBounds
from vibopt.program.program import Limit
from vibopt.program.rational import sampled_static
from vibopt.program.worst import monomials

ROUGH = 1e-6
"""Part of a bound by which a response at sampled speeds must miss it to count: determinants lose digits."""
CLOSE = 1e-8
"""The same where there are no speeds."""


@dataclass(frozen=True)
class Pointwise:
    """One form at designs x (n, n_vars); `bounds` holds the speeds sampled so far."""

    bounds: FormBounds

    @property
    def model(self) -> Model:
        return self.bounds.model

    @property
    def form(self) -> Form:
        return self.bounds.form

    @property
    def known(self) -> bool:
        """Whether anything is known of this form without measuring it."""
        if isinstance(self.form, Modulus):
            return not (self.form.combine == "peak" and sum(len(drive.lines) for drive in self.form.drives) > 1)
        if isinstance(self.form, ModeDamping):
            return self.model.n_free == 1
        return isinstance(self.form, Monomials | StaticRow | StaticLoad | ModeFrequency)

    @property
    def exact(self) -> bool:
        """Whether the values are those of the machine, and no bounds."""
        return self.known and not isinstance(self.form, Modulus)

    @property
    def slack(self) -> float:
        """Part of a value that rounding may take."""
        return CLOSE if self.exact else ROUGH

    def on(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lower bound of the greatest and upper bound of the least value, each (n,)."""
        form = self.form
        if not self.known:
            return np.full(len(x), -np.inf), np.full(len(x), np.inf)
        if isinstance(form, Modulus):
            return self._modulus(form, x)
        value = self._plain(form, x)
        return value, value

    def _plain(self, form: Form, x: FloatArray) -> FloatArray:
        if isinstance(form, Monomials):
            return monomials(form, x)
        if isinstance(form, StaticRow):
            return self._sag(form.row, x)
        if isinstance(form, StaticLoad):
            return self._sag(form.row, x) * monomials(form.factor, x)
        if isinstance(form, ModeFrequency):
            return modes_at(self.model, x)[:, max(form.mode - 1, 0)]
        return self.bounds.on(x, x)[0]

    def _sag(self, row: FloatArray, x: FloatArray) -> FloatArray:
        key = ("static", 0)
        if key not in self.bounds.samples:
            self.bounds.samples[key] = sampled_static(self.model, row, self.bounds.reference)
        top, bottom = self.bounds.samples[key].at(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            value: FloatArray = np.abs(top[:, 0] / bottom[:, 0])
        return np.where(np.isnan(value), np.inf, value)

    def _modulus(self, form: Modulus, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        most, least = np.zeros(len(x)), np.zeros(len(x))
        for drive in form.drives:
            if not self.bounds.speeds.get(drive.name):
                return np.zeros(len(x)), np.full(len(x), np.inf)
            squares = [self._line(form, drive.name, i, x) for i in range(len(drive.lines))]
            total = np.sum(squares if form.combine == "rss" else np.sqrt(squares), axis=0)
            most += total.max(axis=-1)
            least += total.min(axis=-1)
        if form.combine == "rss":
            most, least = np.sqrt(most), np.sqrt(least)
        if form.output.shared_by:
            count = self.model.counts[form.output.shared_by]
            single = monomials(Monomials(np.array([count.scale]), count.row(self.model.n_vars)[None, :]), x)
            most, least = most / single, least / single
        return most, least

    def _line(self, form: Modulus, name: str, index: int, x: FloatArray) -> FloatArray:
        """Squared modulus of one line at its speeds, (n, n_speeds); where it is not known it says nothing."""
        value = _square(*self.bounds.samples[name, index].at(x))
        if form.rigid_link:
            with np.errstate(divide="ignore", invalid="ignore"):
                value = _square(*self.bounds.samples[name, ~index].at(x)) / value
        return np.where(np.isnan(value), 0.0, value)


def _square(top: ComplexArray, bottom: ComplexArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        value: FloatArray = np.abs(top / bottom) ** 2
    return value


def modes_at(model: Model, x: FloatArray) -> FloatArray:
    """Undamped natural frequencies at designs x (n, n_vars) [rad/s], ascending, shape (n, n_free)."""
    p, n = model.values(x), model.n_free
    vectors = model.vectors[:, :n]
    pairs = vectors[:, :, None] * vectors[:, None, :]
    stiff = np.tensordot(p * (model.kinds == STIFFNESS), pairs, axes=1)
    mass = np.tensordot(p * (model.kinds == INERTIA), pairs, axes=1)
    if n == 1:
        only: FloatArray = np.sqrt(stiff[:, :, 0] / mass[:, :, 0])
        return only
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares = np.linalg.eigvalsh(root @ stiff @ np.swapaxes(root, 1, 2))
    found: FloatArray = np.sqrt(np.maximum(squares, 0.0))
    return found


def fails(limit: Limit, values: Pointwise, x: FloatArray, slack: float | None = None) -> FloatArray:
    """By how much of its bound each design is proven to miss a limit; negative where it is not, shape (n,)."""
    if limit.side == "outside":
        modes = modes_at(limit.model, x)
        depth: FloatArray = np.minimum(modes - limit.bound, limit.upper - modes).max(axis=1)
        return depth / max(limit.bound, 1e-300) - CLOSE
    most, least = values.on(x)
    size = abs(limit.bound) or 1.0
    missed = (most - limit.bound) / size if limit.side == "at_most" else (limit.bound - least) / size
    return np.nan_to_num(missed, nan=-np.inf, posinf=np.inf, neginf=-np.inf) - (
        values.slack if slack is None else slack
    )


__all__ = ["Pointwise", "fails", "modes_at"]
