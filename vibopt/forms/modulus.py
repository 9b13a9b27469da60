"""Responses over speeds: the modulus of what is linear in the motion."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice, product
from math import hypot
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.forms.form import WITHOUT_END, Against, AtWorst, Form, Local, Worst, kept
from vibopt.forms.monomials import mounts
from vibopt.forms.rational import TELLING, Groups, Sampled, box_coefficients, ratio_bounds, sampled, sampled_lines
from vibopt.records import dataclass
from vibopt.signals import Band, Combine, Drive, Line, Output

if TYPE_CHECKING:
    from vibopt.arrays import FloatArray, IntArray
    from vibopt.forms.asking import Proof
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.form import Bounds
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model

MOST = 24
"""Local extremes that are looked at."""
_MANY = 16
"""Designs from which on one harmonic at one speed is solved for all together."""


@dataclass(frozen=True, slots=True)
class Modulus(AtWorst):
    """Combined modulus of linear responses under equilibrium D(p) u = f, over bands of speeds.

    With `rigid_link` named, the value is the modulus with that link made rigid divided by the
    modulus as it is (insertion loss).  `endless` names the drives under which it is infinite at standstill,
    whatever the design.
    """

    output: Output
    drives: tuple[Drive, ...]
    combine: Combine
    rigid_link: str = ""
    endless: tuple[str, ...] = ()
    rank = 13

    @property
    def harmonic(self) -> Modulus:
        return self

    @property
    def line(self) -> Line | None:
        """Its only harmonic of its only excitation, as such; None where there are more, or a link is made rigid."""
        if len(self.drives) != 1 or len(self.drives[0].lines) != 1 or self.rigid_link:
            return None
        return self.drives[0].lines[0]

    @property
    def one_line(self) -> bool:
        return self.line is not None and not self.output.shared_by

    @property
    def ratio(self) -> bool:
        return self.line is not None

    @property
    def bands(self) -> list[Band]:
        """Of all excitations."""
        return [band for drive in self.drives for band in drive.bands]

    @property
    def _at_one_time(self) -> bool:
        """Whether several harmonics are taken at one instant."""
        return self.combine == "peak" and sum(len(drive.lines) for drive in self.drives) > 1

    @property
    def apart(self) -> tuple[tuple[Modulus, ...], ...]:
        """By excitation each of its harmonics by itself; none where the value is no sum of their sizes or squares."""
        if self.rigid_link or self._at_one_time:
            return ()
        if self.line is not None:
            return ((self,),)
        drives = [[replace(drive, lines=(line,)) for line in drive.lines] for drive in self.drives]
        return tuple(tuple(replace(self, drives=(drive,)) for drive in lines) for lines in drives)

    def cost(self, model: Model) -> float:
        poles = self.once + 4e-3 * min(model.n_free, 40) ** 2  # of more coordinates none are sought
        over = sum(len(drive.lines) ** 2 for drive in self.drives if not all(band.is_point for band in drive.bands))
        return poles * over + (0.08 + 2e-5 * model.n_free**2) * len(self.bands)

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        from vibopt.forms.drive_response import drive_extreme

        if self.endless and not least_wanted:
            return Worst(float("inf"), dict.fromkeys(self.endless, 0.0))
        if self._at_one_speed(model):
            (drive,) = self.drives
            return Worst(self._sizes(model, x[None])[0], {drive.name: drive.bands[0].low})
        found = {drive.name: drive_extreme(model, self, drive, x, least_wanted) for drive in self.drives}
        total = self._total([one.value for one in found.values()])
        return Worst(total, {name: one.speed for name, one in found.items()})

    def _total(self, values: list[float]) -> float:
        return hypot(*values) if self.combine == "rss" else sum(values)

    def against(self, model: Model, x: FloatArray, name: str, *, least_wanted: bool) -> Against:
        from vibopt.forms.drive_response import DriveResponse, drive_extreme, singularities

        (drive,), others = ([one for one in self.drives if (one.name == name) is own] for own in (True, False))
        rest = [drive_extreme(model, self, other, x, least_wanted).value for other in others]
        singular, breaks = singularities(model, self, drive, x)
        response = DriveResponse(model, self, drive, x)
        return Against(response, singular, breaks, self._total(rest), self.combine == "rss")

    def values(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> FloatArray:
        line, bands = self.line, self.bands
        alone = self.one_line and len(bands) == 1 and bands[0].is_point and not self.endless
        if line is None or not alone or len(x) < _MANY:
            return Form.values(self, model, x, least_wanted=least_wanted)
        from vibopt.forms.drive_response import solved

        found = solved(model, self.output, line, [bands[0].low], np.asarray(x, dtype=float))[:, 0]
        lost = np.flatnonzero(np.isnan(found))
        found[lost] = Form.values(self, model, x[lost], least_wanted=least_wanted)
        return found

    def ahead(self, model: Model, x: FloatArray) -> None:
        if self._at_one_speed(model):
            self._sizes(model, x)

    def _at_one_speed(self, model: Model) -> bool:
        """Whether one harmonic at one speed is all there is, of many coordinates."""
        return model.spins and self.one_line and [band.is_point for band in self.bands] == [True]

    def _sizes(self, model: Model, x: FloatArray) -> list[float]:
        """The response at the one speed, at designs x (n, n_vars)."""
        from vibopt.forms.drive_response import solved

        assert self.line is not None
        line, speed = self.line, self.bands[0].low
        return kept(model, self, x, lambda some: solved(model, self.output, line, [speed], some)[:, 0].tolist())

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        from vibopt.forms.extremes import of_drive, of_few

        few = of_few(model, self, x, within) if len(self.drives) == 1 and not least_wanted else None
        if few is not None:
            return few[:MOST]
        per_drive = [of_drive(model, self, drive, x, least_wanted, within) for drive in self.drives]
        found = [self._together(combo) for combo in islice(product(*per_drive), 4 * MOST)]
        return sorted(found, key=lambda local: local.value if least_wanted else -local.value)[:MOST]

    def glance(self, model: Model, x: FloatArray) -> FloatArray | None:
        from vibopt.forms.few import few_sampled

        return few_sampled(model, self, x)

    def outright(self, model: Model, x: FloatArray, speed: float) -> float:
        """The value at a design (n_vars,) and a speed [rad/s] by polynomials; nan where there are none."""
        from vibopt.forms.few import heights_of

        few = heights_of(model, self, x[None], np.array([speed]))
        return float("nan") if few is None else float(few[0, 0])

    def candidates(self, model: Model, x: FloatArray, *, least_wanted: bool) -> list[tuple[tuple[float, ...], float]]:
        from vibopt.forms.extremes import candidates_of

        [drive] = self.drives
        return [((one.speed,), one.value) for one in candidates_of(model, self, drive, x, least_wanted)]

    def watched(self, ends: tuple[float, ...]) -> list[float]:
        found: list[float] = []
        for drive in self.drives:
            edges = [end for band in drive.bands for end in (band.low, band.high)]
            found += [line.order * end for line in drive.lines for end in edges]
        return found

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        shared = self.output.shared_by
        share = model.counts[shared].row(model.n_vars)[order] if shared else np.zeros(0)
        drives = tuple((drive.name, drive.bands) for drive in self.drives)
        row, shares = (tuple(float(one) + 0.0 for one in some) for some in (self.output.row, share))
        return (row, self.output.power, shares, self.combine, self.rigid_link, drives)

    def groups(self, model: Model) -> Groups:
        return Groups.of(model, self.output.signs)

    def sampled(self, model: Model, speeds: FloatArray, reference: FloatArray) -> Sampled:
        return sampled(model, self.output, self.drives[0].lines[0], speeds, reference)

    def is_polynomial(self, model: Model, most_degree: int) -> bool:
        return self.groups(model).degrees[0] <= most_degree

    def sampleable(self, model: Model) -> bool:
        return not model.spins

    def not_smooth(self, model: Model) -> str:
        true_peak = self.combine == "peak" and any(len(drive.lines) > 1 for drive in self.drives)
        return "is the true peak of several harmonics over time, which jumps from one instant to another" * true_peak

    def bounded(self, model: Model) -> bool:
        return not model.mixed and not model.spins and not self._at_one_time

    def lines_at(
        self, model: Model, name: str, speeds: FloatArray, reference: FloatArray
    ) -> dict[tuple[str, int], Sampled]:
        """N and D of all lines of a drive at each of the speeds (n,), under 0; with the link rigid, too, under ~0."""
        lines = next(drive for drive in self.drives if drive.name == name).lines
        found = {(name, 0): sampled_lines(model, self.output, lines, speeds, reference)}
        if self.rigid_link:
            from vibopt.forms.drive_response import rigid_form

            rigid, output = rigid_form(model, self)
            bolted = [replace(line, vector=line.vector @ rigid.basis) for line in lines]
            found[name, ~0] = sampled_lines(rigid, output, bolted, speeds, reference)
        return found

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        count = len(low)
        lower, upper = np.zeros(count), np.zeros(count)
        for drive in self.drives:
            if not known.speeds.get(drive.name):
                return np.zeros(count), np.full(count, np.inf)
            rows = self._telling(known, drive, low, high)
            small, large = self._lines_on(known, drive, low, high, rows)
            if self.combine == "rss":
                lower += small.sum(axis=-1).max(axis=-1)
                upper += large.sum(axis=-1).min(axis=-1)
            else:
                lower += np.sqrt(small).sum(axis=-1).max(axis=-1)
                upper += np.sqrt(large).sum(axis=-1).min(axis=-1)
        if self.combine == "rss":
            lower, upper = np.sqrt(lower), np.sqrt(upper)
        if known.resonant:
            from vibopt.forms.one_resonance import resonant_floor

            lower = np.maximum(lower, resonant_floor(known.model, self, low, high))
        return lower, upper

    def _telling(self, known: FormBounds, drive: Drive, low: FloatArray, high: FloatArray) -> IntArray | None:
        """The speeds at which it is greatest, and least, at the middle of each box, (n_boxes, k); None for all.

        A bound at some speeds is a bound; on boxes so small that many are asked, that of the others is less.
        """
        if len(known.speeds[drive.name]) <= 2 * TELLING:
            return None
        middle = np.sqrt(np.maximum(low, high * 1e-6) * high)
        total = self._lines_at(known, drive, middle).sum(axis=-1)
        order = np.argsort(np.nan_to_num(total, nan=np.inf), axis=1, kind="stable")
        return np.concatenate([order[:, :TELLING], order[:, -TELLING:]], axis=1)

    def _lines_on(
        self, known: FormBounds, drive: Drive, low: FloatArray, high: FloatArray, rows: IntArray | None
    ) -> Bounds:
        """Bounds of the squared modulus of each line, (n_boxes, n_speeds, n_lines), or at `rows` of the speeds."""
        count = len(drive.lines)
        if rows is not None:
            rows = (rows[..., None] * count + np.arange(count)).reshape(len(rows), rows.shape[1] * count)
        lower, upper = ratio_bounds(*box_coefficients(known.samples[drive.name, 0], low, high, rows))
        if self.rigid_link:
            rigid = ratio_bounds(*box_coefficients(known.samples[drive.name, ~0], low, high, rows))
            with np.errstate(divide="ignore", invalid="ignore"):
                lower, upper = rigid[0] / upper, rigid[1] / lower
            lower, upper = np.nan_to_num(lower, nan=0.0), np.nan_to_num(upper, nan=np.inf, posinf=np.inf)
        elif self.output.shared_by:
            few, many = mounts(known.model, self.output).extent(low, high)
            lower, upper = lower / many[:, None] ** 2, upper / few[:, None] ** 2
        shape = len(low), lower.shape[1] // count, count
        return lower.reshape(shape), upper.reshape(shape)

    def known(self, at: FormBounds) -> bool:
        return not (self.rigid_link and at.direct) and not self._at_one_time

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        most, least = np.zeros(len(x)), np.zeros(len(x))
        for drive in self.drives:
            if not at.speeds.get(drive.name):
                return np.zeros(len(x)), np.full(len(x), np.inf)
            if at.direct:
                from vibopt.forms.drive_response import solved

                speeds = at.speeds[drive.name]
                squares = np.stack(
                    [solved(at.model, self.output, line, speeds, x) ** 2 for line in drive.lines], axis=-1
                )
            else:
                squares = self._lines_at(at, drive, x)
            total = np.sum(squares if self.combine == "rss" else np.sqrt(squares), axis=-1)
            most += np.where(np.isnan(total), 0.0, total).max(axis=-1)  # what is not known says nothing
            least += np.where(np.isnan(total), np.inf, total).min(axis=-1)
        if self.combine == "rss":
            most, least = np.sqrt(most), np.sqrt(least)
        if self.output.shared_by:
            single = mounts(at.model, self.output).at(x)
            most, least = most / single, least / single
        return most, least

    def _lines_at(self, at: FormBounds, drive: Drive, x: FloatArray) -> FloatArray:
        """Squared modulus of each line at the speeds, (n, n_speeds, n_lines); nan where it is not known."""
        value = at.samples[drive.name, 0].square(x)
        if self.rigid_link:
            with np.errstate(divide="ignore", invalid="ignore"):
                value = at.samples[drive.name, ~0].square(x) / value
        return value.reshape(len(x), value.shape[1] // len(drive.lines), len(drive.lines))

    def around(self, proof: Proof) -> bool:
        return proof.of_response(self)

    def reach(self, model: Model) -> Reach | None:
        from vibopt.forms.reduce import driven

        lines = [line.vector for drive in self.drives for line in drive.lines]
        loads = [part for line in lines for part in (line.real, line.imag) if part.any()]
        return None if self.rigid_link else driven(model, self.output, loads)

    def _together(self, combo: tuple[Local, ...]) -> Local:
        """Several excitations: sum or root of sum of squares of their extremes."""
        from vibopt.forms.bends import Curved, added

        if len(combo) == 1:
            return combo[0]
        speeds = tuple(local.speeds[0] for local in combo)
        endless = [local for local in combo if local.value == np.inf]
        if endless:
            return Local(np.inf, endless[0].slope, speeds)
        real = [local for local in combo if local.value > -WITHOUT_END]
        if not real:
            return Local(-WITHOUT_END, np.zeros(len(combo[0].slope)), speeds)
        none = np.full((len(combo[0].slope),) * 2, np.nan)
        parts = [Curved(local.value, local.slope, none if local.bend is None else local.bend) for local in real]
        made = added(parts, 2.0 if self.combine == "rss" else 1.0)
        return Local(made.log, made.slope, speeds, made.bend if np.isfinite(made.bend).all() else None)
