"""The trim: what changes the weights that are on the rotor since its verification run into those of the plan."""

from __future__ import annotations

from collections.abc import Sequence

from vibopt.answer.entry import Entry
from vibopt.answer.plan import Fitting, PlaneAnswer
from vibopt.balancing.fitting import NOTHING, sentence
from vibopt.balancing.job import RotorJob, Run

OFF = "Take every trial weight off first: the plan is added to the rotor as found."
ANEW = "Or take every weight off and fit the whole anew, on the rotor as found:"


def todo(job: RotorJob, fitting: Fitting) -> tuple[str, ...]:
    """What to do, one sentence a line: the trim first where a verification run was made."""
    whole = tuple(one.words for one in fitting.planes)
    run = verification_run(job.runs)
    if run is None:
        return (OFF, *whole)
    stays = f'The weights of run "{run.name}" stay on. What changes them into the best ones:'
    return (stays, *(_trim(job, run, k, one) for k, one in enumerate(fitting.planes)), ANEW, *whole)


def trims(job: RotorJob, fitting: Fitting) -> dict[str, Entry]:
    """The trim of each plane by path, as one weight at its greatest radius."""
    run = verification_run(job.runs)
    if run is None:
        return {}
    found = {}
    for index, (plane, answer) in enumerate(zip(job.planes, fitting.planes, strict=True)):
        if not plane.keep:
            u = _change(run, index, answer)
            angle = job.conventions.weight_angle(-u if plane.remove else u) if u else 0.0
            found[f"trim.{plane.name}.{plane.dimension}"] = Entry(plane.amount(u), plane.dimension, plane.unit)
            found[f"trim.{plane.name}.angle"] = Entry(angle, "angle", "deg")
    return found


def shows_whole(job: RotorJob) -> bool:
    """Whether weights are on that the plan's whole weights stand instead of."""
    return verification_run(job.runs) is not None


def verification_run(runs: Sequence[Run]) -> Run | None:
    """A run that was made with the correction on; None where there is none."""
    return next((run for run in runs if run.verification), None)


def _change(run: Run, index: int, answer: PlaneAnswer) -> complex:
    """Unbalance to add to what is on [kg m]; zero where it is rounding."""
    on = complex(run.weights[index])
    change = complex(answer.u) - on
    return change if abs(change) > NOTHING * max(abs(on), abs(answer.u)) else 0j


def _trim(job: RotorJob, run: Run, index: int, answer: PlaneAnswer) -> str:
    plane, change = job.planes[index], _change(run, index, answer)
    if change == 0j or plane.keep:
        return f"{plane.name}: leave as it is."
    if not (plane.holes or plane.shelf or len(plane.radii) > 1):
        return sentence(job, index, change).replace(": fit ", ": add ", 1)
    return f"{plane.name}: take off what is fitted; {answer.words.partition(': ')[2]}"
