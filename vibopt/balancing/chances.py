"""Limits `with_probability` of a measured rotor: the share of all rotors that its readings leave possible.

The rotors that would have given the readings within their scatter differ in what is left: per sensor and speed by a
normal error in the plane, of the covariance that the weights carry (`vibopt.balancing.trust`), each by itself.  Their
radii and directions are drawn; beyond 99.9 % only rotors of which one radius is far off, the others within it being
known to keep the limit.  Another sampler, of readings and their signals, says the same (`verification.kept_with`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.answer.answer import Answer, Tolerances
from vibopt.answer.entry import Checked
from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.begin import goal_of
from vibopt.balancing.fitting import plan_text
from vibopt.balancing.influence import Identified
from vibopt.balancing.question import Question, Solved
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_question import rows_of
from vibopt.balancing.trust import Noise, covariances
from vibopt.balancing.verification import kept_with
from vibopt.program.drawn import (
    MET,
    RARE,
    Sampled,
    clopper_pearson,
    looks,
    shares_of,
    sure_share,
    until_told,
)
from vibopt.program.told import judged_by, odds_of, percent, row_told
from vibopt.records import dataclass
from vibopt.values.tolerance import SIGMAS
from vibopt.work import worked

_WORK = 1e-4
"""Of one reading of one rotor [nominal ms]."""
_TIMES = 100.0
"""By how many times more rotors are far off than may break a limit, where hardly any may."""
_ROUNDING = 1e-9
_AGAIN, _BY_CHANCE = 4096, 1e-6
"""Rotors of the other sampler, and how rarely it contradicts by chance."""


@dataclass(frozen=True)
class Left:
    """What is left at the readings of one limit with a probability, over the scatter.

    rows, names
        Of the readings, (n_rows,); what is drawn of each follows from its name.
    z, root
        The prediction (n_rows,), and a root of the covariance of its error (n_rows, 2, 2) [SI peak].
    """

    rows: IntArray
    names: tuple[str, ...]
    z: ComplexArray
    root: FloatArray
    bound: float
    wanted: float

    @property
    def spread(self) -> FloatArray:
        """Greatest standard deviation in any direction (n_rows,)."""
        return np.asarray(np.linalg.norm(self.root, 2, axis=(1, 2)))

    @property
    def part(self) -> float:
        """Share of all rotors that is drawn: those with some reading far off, where hardly any may break the limit."""
        return min(_TIMES * (1.0 - self.wanted), 1.0) if self.wanted > RARE else 1.0

    @property
    def near(self) -> float:
        """Within how many standard deviations each reading of the rotors is that are not drawn; 0 where all are."""
        return float(radius((1.0 - self.part) ** (1.0 / len(self.z))))

    @property
    def needed(self) -> float:
        """The share that must keep the bound so that a verdict hardly ever fails; nan where none can be reached."""
        sizes, confidence = looks(_WORK * len(self.z))
        share = sure_share(1.0 - (1.0 - self.wanted) / self.part, sizes[-1], confidence)
        return 1.0 - self.part * (1.0 - share)

    @property
    def sure(self) -> float:
        """A share that is proven to keep the bound: that within the greatest disc around each prediction."""
        room = np.maximum(self.bound - np.abs(self.z), 0.0) / np.maximum(self.spread, 1e-300)
        return float(np.prod(-np.expm1(-0.5 * room**2)))

    def drawn(self, some: slice) -> FloatArray:
        """Greatest amplitude on each of some rotors (n_drawn,) [SI peak]; always the same ones.

        The first reading that is far off is drawn by its chance; those before it are not, those behind it anywhere.
        """
        near = (1.0 - self.part) ** (1.0 / len(self.z))
        ends = np.cumsum((1.0 - near) * near ** np.arange(len(self.z))) / self.part
        first = np.searchsorted(ends, shares_of(["first far off"], some.stop)[some, 0], side="right")
        first = np.minimum(first, len(self.z) - 1)
        greatest = np.zeros(len(first))
        for k, (name, z, root) in enumerate(zip(self.names, self.z, self.root, strict=True)):
            share, turn = shares_of([f"{name} radius", f"{name} direction"], some.stop)[some].T
            share = np.where(first > k, near * share, np.where(first == k, near + (1.0 - near) * share, share))
            x, y = root @ (radius(share) * np.stack([np.cos(2.0 * np.pi * turn), np.sin(2.0 * np.pi * turn)]))
            greatest = np.maximum(greatest, np.hypot(z.real + x, z.imag + y))
        worked(_WORK * len(greatest) * len(self.z))
        return greatest

    @property
    def told(self) -> Sampled:
        """Rotors drawn until a verdict is reached, or the work is done."""
        sizes, confidence = looks(_WORK * len(self.z))
        farthest = float((np.abs(self.z) + self.near * self.spread).max())
        of = self if farthest <= self.bound else replace(self, wanted=RARE)

        def sample(some: slice) -> Sampled:
            values = of.drawn(some)
            return Sampled(values, values <= self.bound * (1.0 + _ROUNDING), confidence, of.part)

        return until_told(sample, sizes, self.wanted)

    @property
    def holds(self) -> bool:
        return self.told.verdict(self.wanted) == MET


def radius(share: FloatArray | float) -> FloatArray:
    """Within how many standard deviations a share of normal errors in the plane lies."""
    return np.asarray(np.sqrt(-2.0 * np.log1p(-np.asarray(share))))


def farthest(z: complex, steps: ComplexArray) -> float:
    """Greatest amplitude of z and steps (n,), each taken -1 to 1 times: at a corner of the polygon that they span."""
    upward = np.where((steps.imag < 0.0) | ((steps.imag == 0.0) & (steps.real < 0.0)), -steps, steps)
    half = 2.0 * np.cumsum(upward[np.argsort(np.angle(upward), kind="stable")]) - upward.sum()
    return float(np.abs(z + np.concatenate([half, -half])).max(initial=abs(z)))


@dataclass(frozen=True)
class Rotors:
    """All rotors that would have given the readings within their scatter."""

    job: RotorJob
    identified: Identified
    noise: Noise

    def left(self, u: ComplexArray) -> dict[str, Left]:
        """Per limit with a probability what the correction u leaves."""
        z, found = self.identified.residual(u), {}
        values, axes = np.linalg.eigh(covariances(self.job, self.identified, self.noise, u))
        root = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :] @ axes.transpose(0, 2, 1)  # moves smoothly with u
        for limit in self.job.residual_limits:
            if limit.share is not None:
                rows = np.array(rows_of(self.job, limit.sensor, limit.speed))
                names = tuple(map(self.job.row_name, rows.tolist()))
                found[limit.name] = Left(rows, names, z[rows], root[rows], limit.at_most, limit.share)
        return found

    def rows_told(self, u: ComplexArray, rows: Mapping[str, Checked]) -> dict[str, Checked]:
        """Rows of limits at a correction u, of those with a probability what that share of all rotors stays within."""
        lefts = self.left(u).items()
        return {**rows, **{name: row_told(rows[name], left.told, left.wanted) for name, left in lefts}}

    def worst(self, u: ComplexArray, rows: IntArray) -> FloatArray:
        """Greatest amplitude at each row where no reading is off by more than the worst within the tolerances."""
        found = []
        for row in rows.tolist():
            speed, sensor = self.job.readings[row]
            learnt, sizes = self.identified.learnt[speed], (self.noise.along[speed], 1j * self.noise.across[speed])
            turn = SIGMAS * learnt.weights_of(u) * learnt.turn[:, sensor]
            steps = np.concatenate([turn * size[:, sensor] for size in sizes])
            found.append(farthest(self.identified.residual(u)[row], steps))
        return np.array(found)

    def with_odds(self, plan: Answer[RotorJob], question: Question, first: Solved) -> Answer[RotorJob]:
        """The plan with what is drawn of each limit with a probability, and what another sampler says against it."""
        fitting = plan.plan.fittings[0]
        u = np.array([plane.u for plane in fitting.planes])
        lefts = self.left(u)
        bounds = [(left.rows, left.bound) for left in lefts.values()]
        again = kept_with(self.job, plan_text(self.job, fitting), bounds, _AGAIN)
        rows, odds = dict(plan.limits), {}
        for (name, left), kept in zip(lefts.items(), again, strict=True):
            row, seen = rows[name], left.told
            size = float(self.worst(u, left.rows).max())
            worst = replace(row, value=replace(row.value, value=size), margin=1.0 - size / left.bound)
            odds[name] = odds_of(worst, seen, left.wanted)
            low, high = replace(seen, confidence=1.0 - _BY_CHANCE).share
            other = clopper_pearson(kept, _AGAIN, 1.0 - _BY_CHANCE)
            doubt = f"{name} is kept by {kept} of {_AGAIN} machines of another draw, which {percent(low)} contradicts"
            rows[name] = row_told(row, seen, left.wanted, doubt if other[0] > high or other[1] < low else "")
        chosen = first.u if self.job.choices else None
        goal = None if chosen is None else goal_of(self.job, question, chosen, self.job.n_rows)[1]
        status, claim = judged_by(rows, odds)
        doubts = [row.doubt for row in rows.values() if row.doubt]
        if doubts:
            status, claim = "check_failed", doubts[0]
        elif chosen is not None and status == MET:
            status, claim = plan.status, f"{claim}; {plan.claim}"
        told = Tolerances("" if goal is None else first.status, goal, {}, {}, odds=odds)
        return replace(plan, status=status, claim=claim, limits=rows, tolerances=told)
