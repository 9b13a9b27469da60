"""A program on evenly sampled speeds, as a user of a general solver would write it down."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Form, Modulus
from vibopt.forms.drive_response import DriveResponse
from vibopt.forms.extremes import sampled_slopes
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import frequency_slopes
from vibopt.program.program import Aim, Limit, Program
from vibopt.signals import Drive
from vibopt.solve.ranges import log_box, starts

_HUGE = 1e12
START_POINTS = 32


class SampledRows:
    """Limits as rows `value <= 0` in y = log x: log(response / bound) at every sampled speed.

    Parameters
    ----------
    program
        The question.
    count
        Sampled speeds per band, its ends among them.
    """

    tolerance = 1e-9
    """What SLSQP is asked for."""

    def __init__(self, program: Program, count: int) -> None:
        self.program, self.count = program, count
        self.low, self.high = log_box(program)

    def limits(self, y: FloatArray) -> FloatArray:
        """Rows of all limits, each <= 0 where the limit is met."""
        return self._stacked(y)[0]

    def slopes(self, y: FloatArray) -> FloatArray:
        """Slopes of these rows, shape (n_rows, n_vars)."""
        return self._stacked(y)[1]

    def speeds(self, drive: Drive) -> FloatArray:
        """Speeds that are looked at [rad/s]."""
        return sampled_speeds(drive, self.count)

    def goal(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rows whose greatest is the goal to be minimised, and their slopes."""
        aim = self.program.aim
        if aim is None:
            return np.zeros(1), np.zeros((1, len(y)))
        values, slopes = self._part(aim, y)
        return aim.sense * values, aim.sense * slopes

    def missed(self, y: FloatArray) -> float:
        """Greatest row."""
        rows = self.limits(y)
        return float(rows.max()) if len(rows) else -1.0

    def starts(self, count: int) -> list[FloatArray]:
        """The least missed of a few spread points, and of those that miss nothing the best."""
        points = starts(self.program, START_POINTS)
        scored = [(max(self.missed(y), 0.0), float(self.goal(y)[0].max()), tuple(y)) for y in points]
        return [np.array(one[2]) for one in sorted(scored)[:count]]

    def _stacked(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, slopes = [np.zeros(0)], [np.zeros((0, len(y)))]
        for limit in self.program.limits:
            row, slope = self._limit(limit, y)
            values.append(row)
            slopes.append(slope)
        return np.concatenate(values), np.concatenate(slopes)

    def _limit(self, limit: Limit, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        if limit.side == "outside":
            return outside_rows(limit, y)
        sense = 1.0 if limit.side == "at_most" else -1.0
        values, slopes = self._part(limit, y)
        return sense * (values - np.log(max(limit.bound, 1e-300))), sense * slopes

    def _part(self, part: Limit | Aim, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        x = np.exp(y)
        form = part.form.harmonic
        if form is None:
            value = part.form.value(part.model, x)
            return np.log([max(value, 1e-300)]), part.form.slope(part.model, x)[None, :]
        least_wanted = part.least_wanted
        rows = [self._drive(part.model, form, drive, x) for drive in form.drives]
        values, slopes = rows[0] if len(rows) == 1 else _added(form, rows, least_wanted)
        return np.clip(np.nan_to_num(values, nan=30.0), -60.0, 60.0), slopes

    def _drive(self, model: Model, form: Modulus, drive: Drive, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        speeds = self.speeds(drive)
        with np.errstate(all="ignore"):
            if form.combine == "peak" and len(drive.lines) > 1:
                return _by_differences(model, form, drive, x, speeds)
            return sampled_slopes(model, form, drive, x, speeds)


def sampled_speeds(drive: Drive, count: int) -> FloatArray:
    """Even speeds over every band [rad/s]."""
    parts = [np.array([band.low]) if band.is_point else np.linspace(band.low, band.high, count) for band in drive.bands]
    return np.concatenate(parts)


def values_on(form: Form, model: Model, points: FloatArray, count: int, *, least_wanted: bool) -> FloatArray:
    """Worst value of a form at designs x (n_points, n_vars) over sampled speeds, shape (n_points,)."""
    asked = form.harmonic
    if asked is None:
        return form.values(model, points)
    totals = np.zeros((len(asked.drives), len(points)))
    for row, drive in enumerate(asked.drives):
        speeds = sampled_speeds(drive, count)
        for i, x in enumerate(points):
            values = np.nan_to_num(DriveResponse(model, asked, drive, x)(speeds), nan=_HUGE, posinf=_HUGE)
            totals[row, i] = values.min() if least_wanted else values.max()
    power = 2 if asked.combine == "rss" else 1
    total: FloatArray = (totals**power).sum(axis=0) ** (1.0 / power)
    return total


def outside_rows(limit: Limit, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Each mode's depth in the forbidden band, as log of frequencies."""
    omega, slopes = frequency_slopes(limit.model, np.exp(y))
    log = np.log(np.maximum(omega, 1e-300))
    low, high = np.log(max(limit.bound, 1e-300)), np.log(limit.upper)
    up = high - log < log - low
    return np.minimum(log - low, high - log), np.where(up[:, None], -slopes, slopes)


def _added(
    form: Modulus, rows: list[tuple[FloatArray, FloatArray]], least_wanted: bool
) -> tuple[FloatArray, FloatArray]:
    """Several excitations: their worst values added, one row."""
    picked = [(v.argmin() if least_wanted else v.argmax()) for v, _ in rows]
    power = 2.0 if form.combine == "rss" else 1.0
    logs = np.array([v[i] for (v, _), i in zip(rows, picked, strict=True)])
    weight = np.exp(power * np.clip(logs, -300.0, 300.0))
    slope = weight @ np.array([s[i] for (_, s), i in zip(rows, picked, strict=True)]) / weight.sum()
    return np.log([weight.sum()]) / power, slope[None, :]


def _by_differences(
    model: Model, form: Modulus, drive: Drive, x: FloatArray, speeds: FloatArray
) -> tuple[FloatArray, FloatArray]:
    def logs(at: FloatArray) -> FloatArray:
        value: FloatArray = np.log(DriveResponse(model, form, drive, at)(speeds))
        return value

    step = 1e-6
    shifts = step * np.eye(len(x))
    slopes = [(logs(x * (1 + d)) - logs(x * (1 - d))) / (2 * step) for d in shifts]
    return logs(x), np.array(slopes).T
