"""What a box of designs can do at best: valid bounds of every limit and of the goal on it."""

from __future__ import annotations

from dataclasses import field, replace
from functools import cached_property

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import (
    DecayRate,
    EnergyShare,
    Form,
    ModeDamping,
    ModeFrequency,
    ModeGap,
    Modulus,
    Monomials,
    PeakInTime,
    RootMeanSquare,
    StaticForce,
    StaticLoad,
    StaticRow,
)
from vibopt.forms.drive_response import rigid_form
from vibopt.forms.rational import Groups, Sampled, box_coefficients, ratio_bounds, sampled, sampled_static
from vibopt.mechanics.harmonic import bordered
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, factors
from vibopt.records import dataclass
from vibopt.signals import Drive

MOST_GROUPS = 12


@dataclass
class FormBounds:
    """Bounds of one form on boxes; harmonic forms at the speeds sampled so far.

    A sampled speed gives a valid lower bound of the worst and a valid upper bound of the least.
    """

    model: Model
    form: Form
    reference: FloatArray
    samples: dict[tuple[str, int], Sampled] = field(default_factory=dict)
    speeds: dict[str, list[float]] = field(default_factory=dict)

    @property
    def bounded(self) -> bool:
        """Whether this form has bounds on boxes at all."""
        if isinstance(self.form, Modulus | StaticRow | StaticLoad) and (self.model.mixed or self._too_many):
            return False
        if isinstance(self.form, Modulus):
            several = sum(len(drive.lines) for drive in self.form.drives) > 1
            return not (self.form.combine == "peak" and several)
        if isinstance(self.form, RootMeanSquare | PeakInTime | DecayRate | StaticForce | ModeGap | EnergyShare):
            return False
        return not isinstance(self.form, ModeDamping) or self.model.n_free == 1

    @cached_property
    def _too_many(self) -> bool:
        """Whether a determinant has more directions than can be expanded: each doubles its terms."""
        signs = self.form.output.signs if isinstance(self.form, Modulus) else None
        return len(Groups.of(self.model, signs, static=not isinstance(self.form, Modulus)).members) > MOST_GROUPS

    def add(self, speeds: dict[str, float]) -> bool:
        """Sample more speeds, per excitation [rad/s]; whether any of them is new."""
        if not isinstance(self.form, Modulus):
            return False
        fresh = False
        for drive in self.form.drives:
            speed = speeds.get(drive.name)
            known = self.speeds.setdefault(drive.name, [])
            if speed is None or not np.isfinite(speed) or any(abs(speed - one) <= 1e-12 * abs(one) for one in known):
                continue
            known.append(float(speed))
            self._sample(drive, np.array([speed]))
            fresh = True
        return fresh

    def _sample(self, drive: Drive, speeds: FloatArray) -> None:
        assert isinstance(self.form, Modulus)
        if self._too_many:
            return
        for index, line in enumerate(drive.lines):
            self._keep((drive.name, index), sampled(self.model, self.form.output, line, speeds, self.reference))
            if self.form.rigid_link:
                rigid, output = rigid_form(self.model, self.form)
                bolted = replace(line, vector=line.vector @ rigid.basis)
                self._keep((drive.name, ~index), sampled(rigid, output, bolted, speeds, self.reference))

    def _keep(self, key: tuple[str, int], made: Sampled) -> None:
        old = self.samples.get(key)
        self.samples[key] = made if old is None else old.joined(made)

    def on(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bound on boxes (n_boxes, n_vars), each (n_boxes,).

        For a harmonic form: lower bound of the greatest, upper bound of the least over its speeds.
        """
        form = self.form
        if not self.bounded:
            return np.zeros(len(low)), np.full(len(low), np.inf)
        if isinstance(form, Modulus):
            return self._modulus(form, low, high)
        if isinstance(form, Monomials):
            return monomial_bounds(form, low, high)
        if isinstance(form, StaticLoad):
            small, large = monomial_bounds(form.factor, low, high)
            lower, upper = FormBounds(self.model, StaticRow(form.row), self.reference, self.samples).on(low, high)
            return -large * upper if form.signed else small * lower, large * upper
        if isinstance(form, StaticRow):
            key = ("static", 0)
            if key not in self.samples:
                self.samples[key] = sampled_static(self.model, form.row, self.reference)
            top, bottom = box_coefficients(self.samples[key], low, high)
            lower, upper = ratio_bounds(top, bottom)
            return np.sqrt(lower[:, 0]), np.sqrt(upper[:, 0])
        if isinstance(form, ModeFrequency):
            return self.frequencies(low, high, max(form.mode, 1))
        return self._damping(low, high)

    def _modulus(self, form: Modulus, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        count = len(low)
        lower, upper = np.zeros(count), np.zeros(count)
        for drive in form.drives:
            if not self.speeds.get(drive.name):
                return np.zeros(count), np.full(count, np.inf)
            squares = [self._line_bounds(form, drive, i, low, high) for i in range(len(drive.lines))]
            small, large = (np.array([one[side] for one in squares]) for side in (0, 1))
            if form.combine == "rss":
                lower += small.sum(axis=0).max(axis=-1)
                upper += large.sum(axis=0).min(axis=-1)
            else:
                lower += np.sqrt(small).sum(axis=0).max(axis=-1)
                upper += np.sqrt(large).sum(axis=0).min(axis=-1)
        if form.combine == "rss":
            lower, upper = np.sqrt(lower), np.sqrt(upper)
        if self._resonant:
            lower = np.maximum(lower, resonant_floor(self.model, form, low, high))
        return lower, upper

    @cached_property
    def _resonant(self) -> bool:
        return isinstance(self.form, Modulus) and applies(self.model, self.form)

    def _line_bounds(
        self, form: Modulus, drive: Drive, index: int, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Bounds of the squared modulus of one line, each (n_boxes, n_samples)."""
        line = self.samples[drive.name, index]
        lower, upper = ratio_bounds(*box_coefficients(line, low, high))
        if form.rigid_link:
            rigid = ratio_bounds(*box_coefficients(self.samples[drive.name, ~index], low, high))
            with np.errstate(divide="ignore", invalid="ignore"):
                lower, upper = rigid[0] / upper, rigid[1] / lower
            return np.nan_to_num(lower, nan=0.0), np.nan_to_num(upper, nan=np.inf, posinf=np.inf)
        if form.output.shared_by:
            count = self.model.counts[form.output.shared_by]
            single = Monomials(np.array([count.scale]), np.array([count.row(self.model.n_vars)]))
            few, many = monomial_bounds(single, low, high)
            lower, upper = lower / many[:, None] ** 2, upper / few[:, None] ** 2
        return lower, upper

    def frequencies(self, low: FloatArray, high: FloatArray, mode: int) -> tuple[FloatArray, FloatArray]:
        """Natural frequency bounds: it rises with every stiffness and falls with every mass."""
        soft, hard = self._corner(low, high)
        return self._frequency(*soft, mode), self._frequency(*hard, mode)

    def _corner(
        self, low: FloatArray, high: FloatArray
    ) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        small, large = self.model.extent(low, high)
        return (small, large), (large, small)

    def _frequency(self, springs: FloatArray, masses: FloatArray, mode: int) -> FloatArray:
        model = self.model
        n = model.n_free
        vectors = model.vectors[:, :n]
        stiff = np.einsum("bt,ti,tj->bij", springs * (model.kinds == STIFFNESS), vectors, vectors)
        mass = np.einsum("bt,ti,tj->bij", masses * (model.kinds == INERTIA), vectors, vectors)
        if n == 1:
            only: FloatArray = np.sqrt(stiff[:, 0, 0] / mass[:, 0, 0])
            return only
        root = np.linalg.inv(np.linalg.cholesky(mass))
        squares = np.linalg.eigvalsh(root @ stiff @ np.swapaxes(root, 1, 2))
        return np.sqrt(np.maximum(squares[:, mode - 1], 0.0))

    def _damping(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        if not self.bounded:
            return np.zeros(len(low)), np.full(len(low), np.inf)
        model = self.model
        small, large = model.extent(low, high)
        square = model.vectors[:, 0] ** 2

        def total(values: FloatArray, kind: int) -> FloatArray:
            one: FloatArray = (values * (model.kinds == kind)) @ square
            return one

        with np.errstate(divide="ignore", invalid="ignore"):
            least = total(small, DAMPING) / (2.0 * np.sqrt(total(large, STIFFNESS) * total(large, INERTIA)))
            most = total(large, DAMPING) / (2.0 * np.sqrt(total(small, STIFFNESS) * total(small, INERTIA)))
        return np.nan_to_num(least, nan=0.0), np.nan_to_num(most, nan=np.inf, posinf=np.inf)


def monomial_bounds(form: Monomials, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Exact range of a sum of monomials with positive scales, term by term, each (n_boxes,)."""
    rising = form.exponents > 0.0
    lower = np.zeros(len(low))
    upper = np.zeros(len(low))
    for scale, exponents, up in zip(form.scale, form.exponents, rising, strict=True):
        one = Monomials(np.array([scale]), exponents[None, :])
        lower += one.at(np.where(up, low, high))
        upper += one.at(np.where(up, high, low))
    return lower, upper


def applies(model: Model, form: Modulus) -> bool:
    """Whether numerators grow with every spring, damper, mass and frequency: all links between the same two points."""
    if model.inerters.any() or model.n_free != 1 or len(form.drives) != 1 or len(form.drives[0].lines) != 1:
        return False
    if form.rigid_link or form.output.shared_by or len(form.drives[0].lines[0].amplitude.pieces) != 1:
        return False
    links = model.vectors[model.kinds != INERTIA]
    same = bool(len(links)) and bool(np.all(np.abs(links) == np.abs(links[0])))
    signs = set(form.output.signs[model.kinds != INERTIA] * links[:, 0]) if same else {0.0, 1.0}
    return same and len(signs) == 1 and not form.drives[0].lines[0].amplitude.pieces[0].slope


def resonant_floor(model: Model, form: Modulus, low: FloatArray, high: FloatArray) -> FloatArray:
    """Lower bound of the greatest value on boxes (n_boxes, n_vars), shape (n_boxes,); 0 where it says nothing."""
    small, large = model.extent(low, high)
    square = model.vectors[:, 0] ** 2

    def total(values: FloatArray, kind: int) -> FloatArray:
        return np.asarray((values * (model.kinds == kind)) @ square, dtype=float)

    with np.errstate(divide="ignore", invalid="ignore"):
        slow = np.sqrt(total(small, STIFFNESS) / total(large, INERTIA))
        fast = np.sqrt(total(large, STIFFNESS) / total(small, INERTIA))
    drive = form.drives[0]
    line = drive.lines[0]
    inside = np.zeros(len(low), dtype=bool)
    for band in drive.bands:
        inside |= (slow >= line.order * band.low) & (fast <= line.order * band.high)
    floor = np.zeros(len(low))
    if not inside.any():
        return floor
    slow, fast = slow[inside], fast[inside]
    z = small[inside] * factors(model.kinds, slow)
    _, border = bordered(model, z, form.output, line.vector)
    top = np.abs(border[:, 0, 0] * border[:, 1, 1] - border[:, 0, 1] * border[:, 1, 0])
    piece = line.amplitude.pieces[0]
    power = form.output.power + piece.power
    weight = abs(piece.constant) * (slow if power >= 0 else fast) ** power / line.order**piece.power
    bottom = fast * total(large[inside], DAMPING) + total(large[inside], HYSTERETIC)
    with np.errstate(divide="ignore", invalid="ignore"):
        floor[inside] = np.nan_to_num(top * weight / bottom, nan=0.0, posinf=np.inf)
    return floor
