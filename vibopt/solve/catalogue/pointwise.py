"""Forms at many designs at once: exact where there are no speeds, at the sampled speeds elsewhere."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import Form, ModeDamping, ModeFrequency, Modulus, Monomials, StaticForce, StaticLoad, StaticRow
from vibopt.forms.bounds import FormBounds
from vibopt.forms.rational import Groups, sampled_static
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.harmonic import transfer
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model
from vibopt.program.program import Limit
from vibopt.records import dataclass
from vibopt.signals import Drive, Line

ROUGH = 1e-6
"""Part of a bound by which a response at sampled speeds must miss it to count: determinants lose digits."""
CLOSE = 1e-8
"""The same where there are no speeds."""


_TOGETHER = 8192
"""Designs that are solved in one go."""
MOST_GROUPS = 6
"""Springs and dampers with directions of their own up to which polynomials are worth it."""


@dataclass
class Direct(FormBounds):
    """Speeds of a form that is solved directly: too many directions for polynomials."""

    @property
    def bounded(self) -> bool:
        return isinstance(self.form, Monomials | ModeFrequency)

    def _sample(self, drive: Drive, speeds: FloatArray) -> None:
        """The speed is kept, and nothing else is needed."""


def bounds_of(model: Model, form: Form, reference: FloatArray) -> FormBounds:
    """Bounds of a form by polynomials, or where they would be too large its speeds alone."""
    if isinstance(form, Modulus | StaticRow | StaticLoad | StaticForce):
        signs = form.output.signs if isinstance(form, Modulus) else None
        groups = Groups.of(model, signs, static=not isinstance(form, Modulus))
        if len(groups.members) > MOST_GROUPS or isinstance(form, StaticForce):
            return Direct(model, form, reference)
    return FormBounds(model, form, reference)


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
            if self.form.rigid_link and isinstance(self.bounds, Direct):
                return False
            return not (self.form.combine == "peak" and sum(len(drive.lines) for drive in self.form.drives) > 1)
        if isinstance(self.form, ModeDamping):
            return self.model.n_free == 1
        return isinstance(self.form, Monomials | StaticRow | StaticLoad | StaticForce | ModeFrequency)

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
            return form.at(x)
        if isinstance(form, StaticForce):
            return self._force(form, x)
        if isinstance(form, StaticRow):
            return np.abs(self._sag(form.row, x))
        if isinstance(form, StaticLoad):
            squeezed = self._sag(form.row, x)
            return (squeezed if form.signed else np.abs(squeezed)) * form.factor.at(x)
        if isinstance(form, ModeFrequency):
            return modes_at(self.model, x)[:, max(form.mode - 1, 0)]
        return self.bounds.on(x, x)[0]

    def _sag(self, row: FloatArray, x: FloatArray) -> FloatArray:
        if isinstance(self.bounds, Direct):
            found: FloatArray = self._down(x) @ row[: self.model.n_free]
            return found
        key = ("static", 0)
        if key not in self.bounds.samples:
            self.bounds.samples[key] = sampled_static(self.model, row, self.bounds.reference)
        top, bottom = self.bounds.samples[key].at(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            value: FloatArray = (top[:, 0] / bottom[:, 0]).real
        return np.where(np.isnan(value), np.inf, value)

    def _down(self, x: FloatArray) -> FloatArray:
        """Displacement of the free coordinates under the weights, (n, n_free); nan where nothing holds them."""
        products = self.model.products(x)
        springs, heavy = self.model.static_blocks()
        stiff, load = np.tensordot(products, springs, axes=1), products @ heavy
        try:
            return np.asarray(np.linalg.solve(stiff, GRAVITY * load[..., None])[..., 0], dtype=float)
        except np.linalg.LinAlgError:
            return np.full(load.shape, np.nan)

    def _force(self, form: StaticForce, x: FloatArray) -> FloatArray:
        model = self.model
        squeezed = self._down(x) @ model.vectors[:, : model.n_free].T
        found: FloatArray = ((model.values(x, static=True) * form.signs) * squeezed).sum(axis=-1)
        return found

    def _modulus(self, form: Modulus, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        most, least = np.zeros(len(x)), np.zeros(len(x))
        for drive in form.drives:
            if not self.bounds.speeds.get(drive.name):
                return np.zeros(len(x)), np.full(len(x), np.inf)
            if isinstance(self.bounds, Direct):
                squares = [self._solved(form, drive, line, x) for line in drive.lines]
            else:
                squares = [self._line(form, drive.name, i, x) for i in range(len(drive.lines))]
            total = np.sum(squares if form.combine == "rss" else np.sqrt(squares), axis=0)
            most += np.where(np.isnan(total), 0.0, total).max(axis=-1)  # what is not known says nothing
            least += np.where(np.isnan(total), np.inf, total).min(axis=-1)
        if form.combine == "rss":
            most, least = np.sqrt(most), np.sqrt(least)
        if form.output.shared_by:
            count = self.model.counts[form.output.shared_by]
            single = Monomials(np.array([count.scale]), count.row(self.model.n_vars)[None, :]).at(x)
            most, least = most / single, least / single
        return most, least

    def _solved(self, form: Modulus, drive: Drive, line: Line, x: FloatArray) -> FloatArray:
        """As `_line`, by solving at each speed."""
        columns = []
        for speed in self.bounds.speeds[drive.name]:
            parts = [
                transfer(self.model, self.model.values(part), form.output, line.vector, np.array(line.order * speed))
                for part in np.array_split(x, max(len(x) // _TOGETHER, 1))
            ]
            size = np.abs(np.concatenate(parts)) * float(line.amplitude.at(np.array([speed]))[0])
            columns.append(np.where(np.isfinite(size), size, np.nan) ** 2)
        return np.stack(columns, axis=-1)

    def _line(self, form: Modulus, name: str, index: int, x: FloatArray) -> FloatArray:
        """Squared modulus of one line at its speeds, (n, n_speeds); nan where it is not known."""
        value = _square(*self.bounds.samples[name, index].at(x))
        if form.rigid_link:
            with np.errstate(divide="ignore", invalid="ignore"):
                value = _square(*self.bounds.samples[name, ~index].at(x)) / value
        return value


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
