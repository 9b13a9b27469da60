"""Many designs looked at for little, to begin a search at the few that promise most."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain, cycle, product, zip_longest

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.few import applies, is_hosted
from vibopt.program.program import Aim, Limit, Program
from vibopt.solve.hanging import MassOnSpring, masses_on_springs
from vibopt.solve.least_pth import least_pth
from vibopt.solve.ranges import halton, log_box, natural_size, starts
from vibopt.work import worked

_TRIED, _ASKED = 512, 64
"""Designs looked at, and those of them at which forms that take longer are asked."""
_FOLLOWED, _ON_ONE, _BESIDE = 256, 32, 0.5
"""Designs with several devices that are followed together from anywhere, those of devices on one body alone, and what
part of them is in a batch beside one."""
_SPREAD, _LATE = 32, 3
"""Designs without devices of which each promises most in its part of the ranges, and the powers for which they and
those that promise most of all are followed."""
_APART, _FAR, _MEASURED, _FEWEST, _WORK = 0.05, 0.15, 256, 32, 5e3
"""Distances of two beginnings, in parts of the range of logs; designs that are measured in whole, at most and at least,
and the work of it all [nominal ms]."""
_WEIGHT = 10.0
_LIGHT, _LIGHTER, _LITTLE = 0.03, 0.2, 0.05
"""Least part of the greatest masses, of its host of one that rides on another, and of the damping of those between."""
_LEAST, _MOST = 0.005, 0.4
"""Damping ratios of devices of which each is tuned by itself."""
_WEIGHTS = (".mass", ".mass_ratio", ".inertia")


def is_cheap(part: Limit | Aim) -> bool:
    """Whether many speeds of many designs can be looked at in no time."""
    if part.form.powers is not None:
        return True
    greatest = part.sense > 0 if isinstance(part, Aim) else part.side == "at_most"
    return greatest and part.form.harmonic is not None and applies(part.model, part.form.harmonic)


def _is_followed(part: Limit | Aim) -> bool:
    """Whether slopes at many speeds of many designs are known in little time, and the less of it the better."""
    swung = part.form.harmonic
    if isinstance(part, Limit) and part.side == "outside":
        return False
    return part.form.powers is not None or (swung is not None and is_hosted(part.model, swung))


def screenable(program: Program) -> bool:
    """Whether something is asked over speeds, and the goal and every limit over speeds are cheap."""
    aims = () if program.aim is None else program.aim.pieces
    asked: list[Limit | Aim] = [part for part in program.parts if part.form.drives]
    if not all(aim.form.drives for aim in aims) and len(masses_on_springs(program)) < 2:
        return False  # of designs that are to be light or stiff those that promise most break limits
    return bool(aims) and bool(asked) and all(is_cheap(part) for part in [*aims, *asked])


def promising(program: Program, count: int) -> list[FloatArray]:
    """Up to `count` designs y = log x (n_vars,), apart from each other.

    Of several devices those to which devices tuned each by itself lead.  Else, of designs all over the ranges and on
    their corners, those that promise most of all and those that do of a part of them, for the most promising may all
    lead to the same: what both lead to, or the two in turn where slopes are not known in little time.
    """
    low, high = log_box(program)
    cheap = [part for part in program.parts if is_cheap(part)]
    own = tuned(program, _many(program))
    if len(own):
        return least_pth(cheap, np.clip(own, low, high), low, high)[:count]
    spread, free = np.clip(starts(program, _TRIED), low, high), (high > low).nonzero()[0].tolist()
    y = np.concatenate([_on_ends(low, low, high, free), spread])
    slow = [part for part in program.parts if not is_cheap(part)]
    merit = _merit(cheap, np.exp(y))
    asked = np.argsort(merit, kind="stable")[:_ASKED]
    if slow:
        merit[asked] += np.array([_merit(slow, np.exp(one)[None, :])[0] for one in y[asked]])
        asked = asked[np.argsort(merit[asked], kind="stable")]
    follow = not slow and all(_is_followed(part) for part in cheap)
    parts = np.array_split(np.arange(len(y))[-_TRIED:], _SPREAD if follow else max(count // 2, 1))
    spread = y[[part[merit[part].argmin()] for part in parts]]
    if follow:
        return least_pth(cheap, np.concatenate([y[asked], spread]), low, high, rungs=_LATE)[:count]
    both = [one for one in chain.from_iterable(zip_longest(y[asked], spread)) if one is not None]
    return _distinct(both, high - low, _APART)[:count]


def best_of_many(program: Program, count: int) -> list[FloatArray]:
    """Up to `count` designs y = log x (n_vars,) that promise most by all that is asked, well apart from each other."""
    low, high = log_box(program)
    y = np.clip(starts(program, int(np.clip(_WORK / program.cost, _FEWEST, _MEASURED))), low, high)
    worked(len(y) * program.cost)
    merit = _merit(list(program.parts), np.exp(y))
    return _distinct(y[np.argsort(merit, kind="stable")], high - low, _FAR)[:count]


def _distinct(many: Iterable[FloatArray], span: FloatArray, apart: float) -> list[FloatArray]:
    """Those of designs y (n_vars,) that are so far from all before them, in parts of the `span` of each variable."""
    chosen: list[FloatArray] = []
    span = np.where(span > 0.0, span, np.inf)
    for one in many:
        if all((np.abs(one - other) / span).max() > apart for other in chosen):
            chosen.append(one)
    return chosen


def on_one_body(program: Program) -> bool:
    """Whether nothing moves but devices and the one body that carries them: few ways to tune them are worth while."""
    return program.used_dof <= 1 + len(masses_on_springs(program))


def _many(program: Program) -> int:
    return _ON_ONE if on_one_body(program) else _FOLLOWED


def beside(program: Program, y: FloatArray, batch: int) -> list[FloatArray]:
    """Designs that a design y = log x (n_vars,) leads to with one or two devices tuned and heavy in other ways.

    Those of one batch and the next differ.  Each device is also put on its stiffest spring and damper, and made as
    light as it may be: the others may be better off without it.  Without several devices each variable, or
    each device, is put on its ends.
    """
    low, high = log_box(program)
    many, hung = _many(program), masses_on_springs(program)
    first, last = many + int(batch * _BESIDE * many), many + int((batch + 1) * _BESIDE * many)
    other, cheap = tuned(program, last)[first:], [part for part in program.parts if is_cheap(part)]
    if not len(other):
        return _turned(program, cheap, y, batch)
    begun = np.tile(y, (len(other) + 2 * len(hung), 1))
    for row, there, (one, two) in zip(begun, other, cycle(product(hung, hung)), strict=False):
        both = [*one.axes.values(), *two.axes.values()]
        row[both] = there[both]
    for row, one in zip(begun[len(other) :], [*hung, *hung], strict=True):
        own = list(one.axes.values())
        row[own] = [y[j] if j == one.weight else high[j] for j in own]
    for row, one in zip(begun[-len(hung) :], hung, strict=True):
        row[[*one.axes.values()]] = y[[*one.axes.values()]]
        row[one.weight] = low[one.weight] if one.weight >= 0 else y[one.weight]
    turned = [_on_ends(y, low, high, [j]) for j in _of_no_device(program, hung)]
    return least_pth(cheap, np.clip(np.concatenate([begun, *turned]), low, high), low, high, rungs=1 + batch % 2)


def _of_no_device(program: Program, devices: Sequence[MassOnSpring]) -> list[int]:
    """Variables of what carries the devices."""
    own = {index for device in devices for index in device.axes.values()}
    return [index for index in range(len(program.axes)) if index not in own]


def _on_ends(y: FloatArray, low: FloatArray, high: FloatArray, own: Sequence[int]) -> FloatArray:
    """A design with its `own` variables on all of their ends, (count, n_vars); none where these would be too many."""
    if 2 ** len(own) > _TRIED:
        return np.zeros((0, len(y)))
    found = np.tile(y, (2 ** len(own), 1))
    found[:, own] = np.where(list(product((False, True), repeat=len(own))), high[own], low[own])
    return found


def _turned(program: Program, cheap: list[Limit | Aim], y: FloatArray, batch: int) -> list[FloatArray]:
    """A design with each variable on each of its ends in turn, or all of one device; those that promise most first.

    Where a damper is next to nothing no slope in logs tells that a strong one would be better.
    """
    low, high = log_box(program)
    owners: dict[str, list[int]] = {}
    for j, axis in enumerate(program.axes):
        owners.setdefault(axis.path.rpartition(".")[0] if batch % 2 else axis.path, []).append(j)
    begun = np.concatenate([_on_ends(y, low, high, own) for own in owners.values()])
    begun = begun[(begun != y).any(axis=1)]
    return list(begun[np.argsort(_merit(cheap, np.exp(begun)), kind="stable")])


def tuned(program: Program, count: int) -> FloatArray:
    """Designs y = log x (count, n_vars) whose devices are tuned each by itself; none without several of them.

    Of several on each other those in the middle are damped little and each is lighter than what it rides on.
    """
    devices = masses_on_springs(program)
    bands = [band for part in program.parts for drive in part.form.drives for band in drive.bands if band.high]
    if len(devices) < 2 or not bands:
        return np.zeros((0, len(program.axes)))
    ends = np.array(sorted({(0.9 * max(band.low, 0.1 * band.high), 1.1 * band.high) for band in bands}))
    whole = sum(axis.high for axis in program.axes if axis.path.endswith(_WEIGHTS))
    about = float(np.sqrt(ends.min() * ends.max()))
    base = np.clip([natural_size(program, axis) for axis in program.axes], program.low, program.high)
    last, depth = np.array([(device.last, device.depth) for device in devices]).T
    found = np.tile(base, (count, 1))
    others = _of_no_device(program, devices)
    found[1:, others] = np.exp(starts(program, count))[1:, others]
    for x, one in zip(found, halton(count, 3 * len(devices) + 1), strict=True):
        place, damping, shares = one[:-1].reshape(3, -1)
        low, high = ends[(len(ends) * place).astype(int)].T
        speeds, ratios = low * (high / low) ** (len(ends) * place % 1.0), _LEAST * (_MOST / _LEAST) ** damping
        ratios, shares = ratios * np.where(last, 1.0, _LITTLE), shares * _LIGHTER**depth
        parts = whole * _LIGHT ** one[-1] * shares / shares.sum()
        for device, w, ratio, part in zip(devices, speeds, ratios, parts, strict=True):
            mass = device.mass or part
            own = {"frequency": w, "stiffness": mass * w * w, "damping_ratio": ratio, "damping": 2.0 * ratio * mass * w}
            own |= {f"torsional_{word}": own[word] for word in ("stiffness", "damping")}
            own |= {"mass": mass, "inertia": mass, "mass_ratio": part, "tuning": w / about}
            for word, index in device.axes.items():
                x[index] = own.get(word, x[index])
    return np.asarray(np.log(np.maximum(found, 1e-300)))


def _merit(parts: list[Limit | Aim], x: FloatArray) -> FloatArray:
    """Log of the goal, and what limits are missed by, of designs (n, n_vars); shape (n,)."""
    missed, goal = np.zeros(len(x)), np.full(len(x), -np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for part in parts:
            few = part.form.glance(part.model, x) if is_cheap(part) else None  # no greater than the worst
            log = np.log(part.form.values(part.model, x) if few is None else few)
            if isinstance(part, Aim):
                goal = np.maximum(goal, part.sense * np.nan_to_num(log, nan=700.0, posinf=700.0, neginf=-700.0))
            elif part.side != "outside":
                by = (1.0 if part.side == "at_most" else -1.0) * (log - np.log(max(part.bound, 1e-300)))
                missed = np.maximum(missed, np.nan_to_num(by, nan=700.0, posinf=700.0, neginf=0.0))
    return _WEIGHT * missed + np.where(np.isneginf(goal), 0.0, goal)
