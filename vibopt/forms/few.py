"""The peaks of a form on a model of few coordinates by its polynomials, where they can be trusted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.harmonic import mount_count
from vibopt.mechanics.model import DAMPING, STIFFNESS, Model
from vibopt.mechanics.receptance import Attached, Wanted, slopes_of
from vibopt.mechanics.small import MOST, Moebius, Peak, Ratio, ratio_of
from vibopt.signals import Band, Drive

if TYPE_CHECKING:
    from vibopt.forms.modulus import Modulus

_MANY, _SOME, _FINE = 160, (60, 480), 0.0067
"""Speeds of a band at which designs are looked at; at which they are followed, at least and at most, and their distance
in logs: between speeds too far from each other hide sharp peaks."""
_LOWEST = 0.003
Picked = Callable[[FloatArray], BoolArray]
"""Which of some logs of values are looked at more closely, in their shape."""


def few_peaks(model: Model, form: Modulus, drive: Drive, x: FloatArray, within: float) -> list[Peak] | None:
    """Local maxima of the response to one excitation over its bands, the highest first.

    Parameters
    ----------
    model, form, drive
        What is asked.
    x
        Design, all values positive, shape (n_vars,).
    within
        Part of the greatest value that a peak must have to be counted.

    Returns
    -------
    list[Peak] | None
        None where the polynomials do not apply or leave a doubt.
    """
    made = _ratio(model, form, drive)
    if made is None or all(band.is_point for band in drive.bands):
        return None
    found = made.peaks(x, drive.bands, within)
    if found is None:
        return None
    return _shared(model, form, found) if all(0.0 < peak.at.value < np.inf for peak in found) else None


def followed(model: Model, form: Modulus, x: FloatArray, speeds: FloatArray) -> list[Peak] | None:
    """The peaks near `speeds` (n,) [rad/s] at a near design x (n_vars,), the highest first.

    None where the polynomials do not apply, or leave a doubt, or the value is least there.
    """
    made = _ratio(model, form, form.drives[0]) if len(form.drives) == 1 else None
    found = None if made is None else made.followed(x, speeds)
    return None if found is None else _shared(model, form, found)


def _shared(model: Model, form: Modulus, found: list[Peak]) -> list[Peak]:
    """Peaks of a load, of which each of several mounts has its share."""
    share = _share(model, form)
    if share == 1.0:
        return found
    return [replace(peak, at=Extreme(peak.at.value / share, peak.at.speed)) for peak in found]


def _share(model: Model, form: Modulus) -> float:
    return model.counts[form.output.shared_by].scale if form.output.shared_by else 1.0


def applies(model: Model, form: Modulus) -> bool:
    """Whether `few_sampled` tells anything: harmonics that add up, on what is no shaft."""
    lines = [one for lines in _apart(model, form) for one in lines]
    return bool(lines) and all(_ratio(model, one, one.drives[0]) is not None or _has_host(model, one) for one in lines)


def few_sampled(model: Model, form: Modulus, x: FloatArray) -> FloatArray | None:
    """The greatest value at many speeds within the bands, at designs x (n, n_vars), shape (n,).

    No greater than the worst, and near it but for sharp peaks; by the polynomials, or where there are none by the
    receptance of all that no variable touches.  None where neither applies.
    """
    if not applies(model, form):
        return None
    power, total = _power(form), np.zeros(len(x))
    for lines in _apart(model, form):
        total += sum((_looked(model, one, x) ** power for one in lines), np.zeros(1)).max(axis=1)
    return np.asarray(total ** (1.0 / power))


def _looked(model: Model, form: Modulus, x: FloatArray) -> FloatArray:
    """Sizes of one harmonic at many speeds, (n, n_speeds)."""
    found = heights_of(model, form, x)
    if found is None:
        counts = np.array([mount_count(model, form.output, one) for one in x])
        found = np.concatenate([np.abs(hosted.response(some)) for hosted, some in _hosted(model, form).at_once(x)])
        found = found.reshape(len(x), -1) / counts[:, None]
    return np.asarray(np.nan_to_num(found, nan=np.inf))


def _power(form: Modulus) -> float:
    """That of the sizes which is added up."""
    return 2.0 if form.combine == "rss" else 1.0


def _apart(model: Model, form: Modulus) -> tuple[tuple[Modulus, ...], ...]:
    """`form.apart`, the same forms whenever asked."""
    known: dict[int, tuple[Modulus, tuple[tuple[Modulus, ...], ...]]] = vars(model).setdefault("apart", {})
    if id(form) not in known:
        known[id(form)] = form, form.apart
    return known[id(form)][1]


def along(asked: Sequence[tuple[Model, Modulus, Picked | None]], x: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Of each form on its model logs of the values at speeds spread over the bands, and their slopes in log x.

    At designs x (n, n_vars), (n, n_speeds) and (n_slopes, n_vars): the slopes of the values alone that are picked by
    their logs, design by design, and of all where it is None.  Of several excitations each goes through its speeds in
    turn, the others at their worst.
    """
    several = [_apart(model, form) for model, form, _ in asked]
    lines = [
        (model, one, pick if len(drives) == len(each) == 1 else None)
        for (model, _, pick), drives in zip(asked, several, strict=True)
        for each in drives
        for one in each
    ]
    found = iter(_each_along(lines, x))
    made = []
    for (_, form, pick), drives in zip(asked, several, strict=True):
        every = [[next(found) for _ in each] for each in drives]
        made.append(every[0][0] if len(drives) == len(every[0]) == 1 else _added_up(every, _power(form), pick))
    return made


def _added_up(
    drives: list[list[tuple[FloatArray, FloatArray]]], power: float, pick: Picked | None
) -> tuple[FloatArray, FloatArray]:
    """Logs and their slopes of sums of powers: of the harmonics of each excitation, then of all excitations."""
    parts, steps = [], []
    for lines in drives:
        sizes = [np.exp(power * np.minimum(log, 300.0 / power)) for log, _ in lines]
        parts.append(np.sum(sizes, axis=0))
        slopes = [slope.reshape(*size.shape, -1) for size, (_, slope) in zip(sizes, lines, strict=True)]
        slopes = [np.where(size[..., None] > 0.0, slope, 0.0) for size, slope in zip(sizes, slopes, strict=True)]
        steps.append(np.sum([size[..., None] * slope for size, slope in zip(sizes, slopes, strict=True)], axis=0))
    worst = [part.argmax(axis=1)[:, None] for part in parts]
    top = [np.take_along_axis(part, at, axis=1) for part, at in zip(parts, worst, strict=True)]
    way = [np.take_along_axis(step, at[..., None], axis=1) for step, at in zip(steps, worst, strict=True)]
    value = np.concatenate([part - most for part, most in zip(parts, top, strict=True)], axis=1) + sum(top)
    slope = np.concatenate([step - most for step, most in zip(steps, way, strict=True)], axis=1) + sum(way)
    logs, slope = np.log(value) / power, slope / value[..., None]
    return logs, slope[np.ones(logs.shape, dtype=bool) if pick is None else pick(logs)]


def _each_along(
    asked: Sequence[tuple[Model, Modulus, Picked | None]], x: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """The same of single harmonics.  What reads one machine under one load is found together."""
    hosted = [_hosted(model, form, fine=True) for model, form, _ in asked]
    alike: dict[Any, list[int]] = {}
    for place, ((model, *_), one) in enumerate(zip(asked, hosted, strict=True)):
        alike.setdefault((id(model), one.alike), []).append(place)
    found: dict[int, tuple[FloatArray, FloatArray]] = {}
    for places in alike.values():
        rows = []
        for batch in zip(*(hosted[place].at_once(x) for place in places), strict=True):
            some = batch[0][1]
            rows.append(slopes_of([one for one, _ in batch], some, [_wanted(*asked[place], some) for place in places]))
        for place, batches in zip(places, zip(*rows, strict=True), strict=True):
            value, slope = (np.concatenate(each) for each in zip(*batches, strict=True))
            logs = _logs(*asked[place][:2], x, value)
            pick = asked[place][2]
            value = value if pick is None else value[pick(logs).ravel()]
            found[place] = logs, np.asarray((slope / value[:, None]).real)
    return [found[place] for place in range(len(asked))]


def _wanted(model: Model, form: Modulus, pick: Picked | None, x: FloatArray) -> Wanted | None:
    return None if pick is None else lambda value: pick(_logs(model, form, x, value)).ravel()


def _logs(model: Model, form: Modulus, x: FloatArray, response: ComplexArray) -> FloatArray:
    """Logs (n, n_speeds) of the values at designs x (n, n_vars), of the response of each at all speeds, one by one."""
    counts = np.array([mount_count(model, form.output, one) for one in x])
    return np.asarray(np.log(np.abs(response).reshape(len(x), -1) / counts[:, None]))


def is_hosted(model: Model, form: Modulus) -> bool:
    """Whether harmonics that add up act on more than one mass of what does not turn."""
    lines = [one for lines in _apart(model, form) for one in lines]
    return bool(lines) and all(_has_host(model, one) for one in lines)


def _has_host(model: Model, form: Modulus) -> bool:
    return form.line is not None and not model.spins and model.n_free > 1


def _hosted(model: Model, form: Modulus, *, fine: bool = False) -> Attached:
    """The model at many speeds, its fixed part solved once."""
    assert form.line is not None
    known: dict[tuple[int, bool], tuple[Modulus, Attached]] = vars(model).setdefault("hosted", {})
    key = id(form), fine
    if key not in known:
        known[key] = form, Attached.of(model, form.output, form.line, _many(form.drives[0].bands, fine=fine))
    return known[key][1]


def heights_of(model: Model, form: Modulus, x: FloatArray, speeds: FloatArray | None = None) -> FloatArray | None:
    """The values at designs x (n, n_vars) and speeds [rad/s], or many within the bands, (n, n_speeds).

    None where the polynomials do not apply; without care for rounding.
    """
    made = _ratio(model, form, form.drives[0]) if len(form.drives) == 1 else None
    if made is None:
        return None
    return made.at(x, _many(form.drives[0].bands) if speeds is None else speeds) / _share(model, form)


def about_link(model: Model, form: Modulus, speeds: FloatArray) -> Moebius | None:
    """n0, n1, d0, d1 of (n0 + n1 kappa) / (d0 + d1 kappa) at speeds [rad/s]; kappa = k + s c of the link that varies.

    None where the polynomials do not apply, or something else varies.
    """
    varied = {int(model.kinds[t]): int(t) for t in np.flatnonzero(model.exponents.any(axis=1)).tolist()}
    made = _ratio(model, form, form.drives[0]) if len(form.drives) == 1 else None
    if made is None or varied.keys() != {STIFFNESS, DAMPING} or np.count_nonzero(model.exponents.any(axis=1)) > 2:
        return None
    n0, n1, d0, d1 = made.about(varied[STIFFNESS], varied[DAMPING], speeds)
    share = _share(model, form)
    return n0 / share, n1 / share, d0, d1


@lru_cache(maxsize=32)
def _many(bands: tuple[Band, ...], *, fine: bool = False) -> FloatArray:
    """Speeds spread over the bands, denser for lower ones, shape (n,)."""
    parts = []
    for band in bands:
        low = band.low if band.is_point else max(band.low, _LOWEST * band.high)
        count = int(np.clip(np.log(band.high / low) / _FINE, *_SOME)) if fine and not band.is_point else _MANY
        parts.append(np.array([band.low]) if band.is_point else np.geomspace(low, band.high, count))
    return np.concatenate(parts)


def _ratio(model: Model, form: Modulus, drive: Drive) -> Ratio | None:
    if model.spins or not 1 < model.n_free <= MOST or len(drive.lines) != 1 or form.rigid_link:
        return None
    if form.output.shared_by and model.counts[form.output.shared_by].exponents:
        return None
    return ratio_of(model, form.output, drive.lines[0])
