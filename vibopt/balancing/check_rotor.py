"""What the parts of a measured rotor must be among themselves: enough runs, different ones, at speeds as found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from vibopt.arrays import ComplexArray
from vibopt.balancing.conventions import Conventions
from vibopt.balancing.influence import SINGULAR, Ways, tells_apart
from vibopt.balancing.parse_runs import Measured
from vibopt.balancing.planes import Plane
from vibopt.balancing.question import tied
from vibopt.balancing.rotor_job import Run
from vibopt.document.mistakes import Mistakes
from vibopt.errors import counted
from vibopt.units import show
from vibopt.units.showing import plain

Influence = Mapping[tuple[int, int, int], complex]
Pairs = Sequence[tuple[str, int, int, float]]
_WITHIN = 1e-7
"""Part by which weights that are decided may differ from those of a run, as digits of a text do."""


def check_runs(
    measured: Measured, planes: Sequence[Plane], influence: Influence, conventions: Conventions, pairs: Pairs,
    mistakes: Mistakes, *, has_phase: bool,
) -> None:  # fmt: skip
    """Whether the runs can tell what each plane does; of pairs, and of weights that are decided, what these do."""
    if not any(run.is_initial for run in measured.runs):
        mistakes.add(
            ("runs",),
            "there is no initial run: every run has weights fitted. Add a run as found, with its speed and readings "
            "and without weights.",
        )
        return
    if _mismatched(measured, mistakes):
        return
    _check_verification(measured, mistakes)
    runout = np.array([sensor.runout for sensor in measured.sensors], dtype=complex)
    if not any((run.readings != runout).any() for run in measured.runs if run.is_initial):
        mistakes.add(
            ("runs",),
            "the initial vibration is zero at every sensor: there is nothing to balance. Check the readings as found.",
        )
        return
    if all(plane.keep for plane in planes):
        mistakes.add(("planes",), "every plane has keep = true: nothing may be changed. Leave one plane free.")
        return
    if not has_phase:
        _check_without_phase(measured, planes, mistakes)
        return
    trials: list[list[int]] = [[] for _ in measured.speeds]
    for place, run in enumerate(measured.runs):
        if not run.is_initial:
            trials[run.speed].append(place)
    W: ComplexArray = np.array([run.weights for run in measured.runs])
    told: set[tuple[bytes, frozenset[int]]] = set()
    asked = partial(_asked, planes, conventions, pairs)
    for speed, own in enumerate(trials):
        _check_speed(speed, measured, own, W[own], planes, influence, asked, pairs, told, mistakes)


def _asked(planes: Sequence[Plane], conventions: Conventions, pairs: Pairs) -> ComplexArray:
    """The sets of weights that a plan adds up, a row each (n, n_planes) [kg m]: pairs, and what is decided, as one."""
    tables = tied(len(planes), [(one, other, complex(ratio)) for _, one, other, ratio in pairs]).T
    still = np.array([plane.keep or plane.fitted is not None for plane in planes])
    made = [0j if plane.fitted is None else plane.made(plane.fitted, conventions) for plane in planes]
    tables = tables[~(tables != 0.0)[:, still].any(axis=1)]
    return np.vstack([tables, made]) if any(made) else tables


def _mismatched(measured: Measured, mistakes: Mistakes) -> bool:
    """Runs at a speed at which there is none as found."""
    initial = {run.speed for run in measured.runs if run.is_initial}
    if len(initial) == len(measured.speeds):
        return False
    value = measured.speeds[min(initial)]
    wrong = [(path, run) for path, run in zip(measured.paths, measured.runs, strict=True) if run.speed not in initial]
    for path, run in wrong:
        unit = measured.speed_units[run.speed]
        own, other = show(run.given_speed, unit, "angular_rate"), show(value, unit, "angular_rate")
        mistakes.add(
            (*path, "speed"),
            f'run "{run.name}" is at {own}, but as found was measured at {other}. A weight acts differently at each '
            f"speed: repeat the run at {other}, or add a run as found at {own}.",
        )
    return bool(wrong)


def _check_verification(measured: Measured, mistakes: Mistakes) -> None:
    """A verification run has weights, and all of them have the same: there is one rotor to trim."""
    marked = [(path, run) for path, run in zip(measured.paths, measured.runs, strict=True) if run.verification]
    for path, run in marked:
        if run.is_initial:
            mistakes.add(
                (*path, "verification"),
                f'run "{run.name}" has verification = true, but no weights: the weights of the correction are on in a '
                "verification run. Write them, or leave verification out.",
            )
    first = marked[0][1] if marked else None
    for path, run in marked[1:]:
        if first is not None and np.abs(run.weights - first.weights).max() > SINGULAR * np.abs(first.weights).max():
            mistakes.add(
                (*path, "verification"),
                f'runs "{first.name}" and "{run.name}" have verification = true and different weights, but only one '
                "set is on the rotor now. Mark the runs with that set.",
            )


def _check_speed(
    speed: int, measured: Measured, places: Sequence[int], W: ComplexArray, planes: Sequence[Plane],
    influence: Influence, asked: Callable[[], ComplexArray], pairs: Pairs, told: set[tuple[bytes, frozenset[int]]],
    mistakes: Mistakes,
) -> None:  # fmt: skip
    """Whether the runs with weights W (n_trials, n_planes) at a speed tell every plane; `told` are sets that do."""
    if influence:
        _check_coefficients(speed, measured, planes, influence, mistakes)
    given = frozenset(plane for at, _, plane in influence if at == speed)
    key = W.tobytes(), given
    if key in told:
        return
    weighed = (W != 0.0).any(axis=0).tolist()
    unknown = [index for index, plane in enumerate(planes) if index not in given and (not plane.keep or weighed[index])]
    idle = [planes[index].name for index in unknown if not weighed[index]]
    if not unknown or (len(W) >= len(unknown) and not idle and tells_apart(W[:, unknown])):
        told.add(key)
        return
    if len(W) and (Ways.of(W[:, unknown]).missed(asked()[:, unknown]) <= _WITHIN).all():
        told.add(key)  # as those of a pair, with one run of both its weights
        return
    trials = [measured.runs[place] for place in places]
    at = show(measured.speeds[speed], measured.speed_units[speed], "angular_rate")
    if len(trials) < len(unknown):
        mistakes.add(("runs",), f"{_too_few(planes, unknown, trials, at)}{_together(planes, unknown, pairs)}")
    elif idle:
        mistakes.add(
            ("runs",),
            f"no run at {at} has a weight in plane {idle[0]}, so nothing is known of it. Add such a run, or write "
            f"keep = true in [planes.{idle[0]}].",
        )
    else:
        mistakes.add(("runs",), _same_weights(trials, W[:, unknown], unknown, at, planes))


def _too_few(planes: Sequence[Plane], unknown: list[int], trials: Sequence[Run], at: str) -> str:
    names = " and ".join(planes[index].name for index in unknown)
    many = counted(len(trials), "runs with weights") if trials else "no run with weights"
    missing = [planes[index].name for index in unknown if not any(run.weights[index] for run in trials)]
    other = missing[0] if missing else planes[unknown[-1]].name
    return (
        f"fewer runs than planes: to learn what a weight does in {names}, "
        f"{counted(len(unknown), 'runs with weights')} {'are' if len(unknown) > 1 else 'is'} needed at {at}, "
        f"and there {'are' if len(trials) > 1 else 'is'} {many}. Add a run with a weight in {other}, write keep = "
        f"true in [planes.{other}], or give ready coefficients in [[influence]]."
    )


def _together(planes: Sequence[Plane], unknown: Sequence[int], pairs: Pairs) -> str:
    """That one run is enough for each pair of which nothing is known."""
    words = [
        f" For pairs.{name} one run is enough in which {planes[one].name} and {planes[other].name} have equal "
        f"unbalances {'at the same angle' if ratio > 0.0 else 'on opposite sides'}."
        for name, one, other, ratio in pairs
        if one in unknown and other in unknown
    ]
    return "".join(words)


def _check_coefficients(
    speed: int, measured: Measured, planes: Sequence[Plane], influence: Influence, mistakes: Mistakes
) -> None:
    at = show(measured.speeds[speed], measured.speed_units[speed], "angular_rate")
    for plane in sorted({one for where, _, one in influence if where == speed}):
        for sensor, one in enumerate(measured.sensors):
            if (speed, sensor, plane) not in influence:
                mistakes.add(
                    ("influence",),
                    f"plane {planes[plane].name} has no influence coefficient for sensor {one.name} at {at}. Add "
                    f'[[influence]] with sensor = "{one.name}", plane = "{planes[plane].name}".',
                )


def _same_weights(trials: Sequence[Run], W: ComplexArray, unknown: list[int], at: str, planes: Sequence[Plane]) -> str:
    """Which trial weights are not different enough, in words."""
    W = W / np.maximum(np.abs(W).max(axis=0), 1e-300)
    for i, first in enumerate(trials):
        for j in range(i):
            if np.linalg.matrix_rank(W[[j, i]], tol=SINGULAR) == 1:
                return (
                    f'runs "{trials[j].name}" and "{first.name}" have the same weights (up to a common factor), so '
                    f"planes {' and '.join(planes[p].name for p in unknown)} cannot be told apart: the equations are "
                    f"singular at {at}. Move one of the weights to another plane and repeat that run."
                )
    return (
        f"the trial weights of the runs at {at} depend on one another: the equations are singular. Repeat one run "
        f"with other weights."
    )


def _check_without_phase(measured: Measured, planes: Sequence[Plane], mistakes: Mistakes) -> None:
    for speed, value in enumerate(measured.speeds):
        at = show(value, measured.speed_units[speed], "angular_rate")
        runs = [run for run in measured.runs if run.speed == speed]
        for index, plane in enumerate(planes):
            if plane.keep:
                continue
            alone = {
                complex(run.weights[index]) for run in runs if run.weights[index] and np.count_nonzero(run.weights) == 1
            }
            if len(alone) < 2:
                mistakes.add(
                    ("runs",),
                    f"the readings have no angles, and plane {plane.name} has {plain(len(alone))} trial "
                    f"position{'s' if len(alone) != 1 else ''} of its own at {at}. "
                    'Write the readings with their angles, "8.6 mil pp @ 63 deg", or fit a weight in '
                    f"{plane.name} alone at three angles (two leave two answers).",
                )
                continue
            first, second, *more = alone
            if not more and abs((first.conjugate() * second).imag) <= SINGULAR * abs(first) * abs(second):
                mistakes.add(
                    ("runs",),
                    f"the two trial weights of plane {plane.name} at {at} lie on one line through the centre, so "
                    "the side cannot be told. Add a run with the weight at a right angle to them.",
                )
