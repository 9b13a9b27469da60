"""What runs that contradict each other mean for a plan: what is left out, what the bands hold, plans side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.plan import Remedy
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.agreement import Agreement, Runs, agreements, without
from vibopt.balancing.cautions import remedy_of
from vibopt.balancing.influence import Identified, identify
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_question import pose
from vibopt.balancing.trust import Noise, bands, noise_of, seen_noise
from vibopt.records import dataclass, replace

MOST_BESIDE = 6
"""Plans shown side by side."""
_AGAINST = (", which contradicts the others", ", which contradict the others")
MET = 1e-6
"""A limit is met to this part of itself."""
_SEEN = 0.02
"""Part of the greatest reading from which a misfit of one spare run is worth a word."""


@dataclass(frozen=True)
class Heard:
    """A measured rotor as the runs tell it that agree: the job without odd runs, its rotor and scatter."""

    whole: RotorJob
    job: RotorJob
    identified: Identified
    noise: Noise | None
    found: tuple[Agreement, ...]

    @property
    def told(self) -> bool:
        return all(agreement.told for agreement in self.found)


def heard(job: RotorJob) -> Heard:
    """The rotor by the runs that agree with each other."""
    identified = identify(job)
    noise = noise_of(job, identified)
    found = agreements(job, identified, noise)
    out = [run for agreement in found for run in agreement.out]
    if not out:
        return Heard(job, job, identified, noise, found)
    kept = without(job, out)
    again = identify(kept)
    return Heard(job, kept, again, noise_of(kept, again), found)


def held_bands(of: Heard, u: ComplexArray) -> FloatArray | None:
    """95 % bands (n_rows, 2) that hold what is left whichever possible runs are odd; None without any scatter."""
    if of.noise is None or not of.identified.learnt:
        return None
    ends = bands(of.job, of.identified, of.noise, u)
    speeds = np.array([speed for speed, _ in of.job.readings])
    for agreement in of.found:
        rows = speeds == agreement.speed
        others = [_other(of.job, out, u) for out in agreement.possible or agreement.alone]
        seen = None if agreement.told else seen_noise(of.identified)  # which may be more than was given
        for more in (*others, *(() if seen is None else (bands(of.job, of.identified, seen, u),))):
            ends[rows, 0] = np.fmin(ends[rows, 0], more[rows, 0])
            ends[rows, 1] = np.fmax(ends[rows, 1], more[rows, 1])
    return ends


def _other(job: RotorJob, out: Runs, u: ComplexArray) -> FloatArray:
    """Without these runs; what the others predict where they leave no run to learn the scatter from."""
    fewer = without(job, out)
    identified = identify(fewer)
    noise = noise_of(fewer, identified)
    left = np.abs(identified.residual(u))[:, None].repeat(2, axis=1)
    if noise is None:
        return left
    ends = bands(fewer, identified, noise, u)
    return np.where(np.isnan(ends), left, ends)


def beside(of: Heard, u: ComplexArray) -> tuple[Remedy, ...]:
    """The plan with other runs beside the one with u: with all of them, or without each that may be odd."""
    sets: list[tuple[str, RotorJob]] = []
    for agreement in of.found:
        if agreement.out:
            again = tuple(run for run in of.job.odd if run not in agreement.out)
            name = f"with {_named(of.whole, agreement.out)}{_AGAINST[len(agreement.out) > 1]}"
            sets.append((name, replace(of.job, odd=again)))
        elif not agreement.told:
            sets += [(f"without {_named(of.whole, out)}", without(of.job, out)) for out in agreement.possible]
    if not sets:
        return ()
    name = "this plan" if of.told else "all runs, as here"
    plans = [remedy_of(of.job, name, u, of.identified, of.noise)]
    for name, job in sets[: MOST_BESIDE - 1]:
        identified = identify(job)
        noise = noise_of(job, identified)
        solved = solve_question(pose(job, identified, noise).question)
        if solved.u is not None:
            plans.append(remedy_of(job, name, solved.u, identified, None if name.endswith(_AGAINST) else noise))
    return tuple(plans)


def judged(of: Heard, plan: Answer[RotorJob]) -> Answer[RotorJob]:
    """The plan with what its runs say against each other; unproven where nobody can tell which is wrong."""
    if notes := _notes(of):
        plan = replace(plan, notes=(*notes, *plan.notes))
    if of.told:
        return _kept_by_bands(of, plan) if plan.plan.fittings else plan
    if not plan.plan.fittings and plan.status != "infeasible":
        return plan
    doubtful = [agreement for agreement in of.found if not agreement.told]
    where = " and at ".join(of.job.show_speed(agreement.speed) for agreement in doubtful)
    odd = "; ".join(_either(of.whole, agreement.possible) for agreement in doubtful)
    claim = f"the runs at {where} contradict each other, and it cannot be told which is wrong ({odd})"
    if not plan.plan.fittings:
        said = f"{claim}; as they stand, {plan.claim}"
        return replace(plan, status="unproven", claim=said, reason="", conflict=None)
    bands = "; the bands hold what is left whichever it is" if plan.plan.rows and plan.plan.rows[0].band else ""
    return _to_repeat(plan, f"{claim}{bands}", odd)


def _to_repeat(plan: Answer[RotorJob], claim: str, odd: str) -> Answer[RotorJob]:
    """Unproven until one of the runs is made again."""
    todo = f"Repeat one of these runs before anything is fitted, add it to the file and solve again: {odd}."
    return replace(plan, status="unproven", claim=claim).with_plan(words=(todo, *plan.plan.words))


def _kept_by_bands(of: Heard, plan: Answer[RotorJob]) -> Answer[RotorJob]:
    """Unproven where one spare run, which any run may have spoilt, leaves open whether a limit is met."""
    alone = {agreement.speed: agreement.alone for agreement in of.found if agreement.alone}
    if not alone:
        return plan
    open_rows = [
        (float(row.band[1].value) / float(row.limit.value), speed, row)
        for (speed, _), row in zip(of.job.readings, plan.plan.rows, strict=True)
        if speed in alone and row.band is not None and row.limit is not None
    ]
    worst, speed, row = max(open_rows, key=lambda one: one[0], default=(0.0, 0, None))
    if worst <= 1.0 + MET or row is None or row.band is None or row.limit is None:
        return plan
    at, either = of.job.show_speed(speed), _either(of.whole, alone[speed])
    claim = (
        f"whether the limit of {row.limit.shown} on {row.sensor} at {at} is met is not known: with one run to spare "
        f"and no scatter given up to {row.band[1].shown} can be left, and any run may be wrong ({either})"
    )
    return _to_repeat(plan, claim, either)


def _named(job: RotorJob, runs: Sequence[int]) -> str:
    return " and ".join(f'run "{job.runs[run].name}"' for run in runs)


def _either(job: RotorJob, sets: Sequence[Runs]) -> str:
    """All that may be odd, each set once."""
    said = [_named(job, one) for one in sets]
    shown = said if len(said) <= MOST_BESIDE else [*said[:MOST_BESIDE], f"{len(said) - MOST_BESIDE} more"]
    return f"{', '.join(shown[:-1])} or {shown[-1]}" if len(shown) > 1 else shown[0]


def _notes(of: Heard) -> tuple[str, ...]:
    found: list[str] = []
    for agreement in of.found:
        found += [_left_out(of, agreement.speed, run) for run in agreement.out]
        if agreement.possible and agreement.told:
            found.append(
                f"The runs at {of.job.show_speed(agreement.speed)} do not agree as well as they should: by chance one "
                f"job in {1.0 / agreement.chance:.0f} would look so. The bands hold what each alone could have spoilt: "
                f"{_either(of.whole, agreement.possible)}."
            )
        if agreement.unchecked:
            found.append(
                f"No other run checks {_named(of.whole, agreement.unchecked)} at "
                f"{of.job.show_speed(agreement.speed)}: were it wrong, nothing here would show it."
            )
        found += _one_spare(of, agreement.speed)
    return tuple(found)


def _left_out(of: Heard, speed: int, run: int) -> str:
    learnt, odd, job = of.identified.learnt[speed], of.whole.runs[run], of.job
    predicted = learnt.weights_of(odd.weights) @ learnt.readings + learnt.known @ odd.weights
    off = np.abs(odd.readings - job.runout - predicted)
    sensor = job.sensors[int(np.argmax(off))]
    return (
        f'Run "{odd.name}" at {job.show_speed(speed)} does not agree with the others and is left out: they predict a '
        f"reading at {sensor.name} that is {sensor.show(float(off.max()), 3)} away. Repeat it; the plan with it stands "
        f"beside this one."
    )


def _one_spare(of: Heard, speed: int) -> list[str]:
    """With one spare run and no scatter given only the disagreement itself can be told, not whose it is."""
    learnt, job = of.identified.learnt[speed], of.job
    if job.scatter is not None or learnt.spare != 1:
        return []
    worst = float(np.abs(learnt.misfit).max(initial=0.0))
    if worst < _SEEN * float(np.abs(learnt.readings).max()):
        return []
    run, place = np.unravel_index(int(np.argmax(np.abs(learnt.misfit))), learnt.misfit.shape)
    sensor = job.sensors[int(place)]
    return [
        f"The runs at {job.show_speed(speed)} do not agree: the fit misses by up to {sensor.show(worst, 3)} at "
        f'{sensor.name} (in run "{learnt.runs[int(run)].name}"). With one run to spare and no scatter given nobody can '
        f"tell which is wrong: repeat one of them."
    ]
