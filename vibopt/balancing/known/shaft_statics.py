"""Known masses as vector sums: static and couple unbalance, and what the bearings feel of them.

Every sum is linear in the unbalances.  A row is a set of weights w(z), one per axial place: the sum of w(z) u.
The couple is taken about the middle between the bearings (of the masses and planes where there are none) and divided
by half that span, so that rms over (static, couple) is rms over the two bearings but for a constant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.grades import levers
from vibopt.balancing.known.known_job import KnownJob
from vibopt.balancing.question import combined
from vibopt.records import dataclass


@dataclass(frozen=True)
class Rows:
    """Rows of what is to vanish: `names` (n,), and the weights of masses (n, n_masses) and of planes (n, n_planes)."""

    names: tuple[str, ...]
    masses: FloatArray
    planes: FloatArray


def middle_and_arm(job: KnownJob) -> tuple[float, float]:
    """Place about which the couple is taken, and the arm it is divided by [m]."""
    places = [bearing.at for bearing in job.bearings]
    if not places:
        places = [at for some in _places(job) for at in some]
    low, high = min(places), max(places)
    return 0.5 * (low + high), 0.5 * (high - low) or 1.0


def balance_rows(job: KnownJob) -> Rows:
    """Static, and unless all is in one plane, couple over arm [kg m]."""
    middle, arm = middle_and_arm(job)
    mass_at, plane_at = (np.array(some, dtype=float) for some in _places(job))
    names, masses, planes = ["static"], [np.ones_like(mass_at)], [np.ones_like(plane_at)]
    if not job.flat:
        names.append("couple")
        masses.append((mass_at - middle) / arm)
        planes.append((plane_at - middle) / arm)
    return Rows(tuple(names), np.array(masses), np.array(planes).reshape(len(names), -1))


def bearing_rows(job: KnownJob) -> Rows:
    """Unbalance that each bearing carries [kg m], by the lever rule."""
    first, second = job.bearings
    masses, planes = (levers(first.at, second.at, np.array(some, dtype=float)) for some in _places(job))
    return Rows((first.name, second.name), masses, planes)


def _places(job: KnownJob) -> tuple[list[float], list[float]]:
    """Of the masses and of the planes [m]."""
    return [mass.at for mass in job.masses], [plane.place for plane in job.planes]


def end_rows(job: KnownJob) -> Rows:
    """Unbalance in the planes of both bearings, or of the outermost masses and planes where there are none [kg m]."""
    if job.bearings:
        return bearing_rows(job)
    rows = balance_rows(job)
    turn = 0.5 * np.array([[1.0, -1.0], [1.0, 1.0]])
    return Rows(("first", "last"), turn @ rows.masses, turn @ rows.planes)


@dataclass(frozen=True)
class Aim:
    """What a goal makes small: some rows, combined.

    rows
        Of the sums [kg m].
    scale
        Of a row in the unit of the goal.
    name, dimension
        As in the answer.
    """

    rows: Rows
    combine: str
    scale: float
    name: str
    dimension: str

    def value(self, job: KnownJob, u: ComplexArray) -> float:
        """The goal [SI] with the correction u."""
        left = self.scale * np.abs(self.rows.masses @ unbalances(job) + self.rows.planes @ u)
        return float(combined(self.combine, left))


def aim_of(job: KnownJob) -> Aim | None:
    """The aim of the goal; None without a goal and for the least correction."""
    goal = job.goal
    if goal is None or goal.minimise == "correction":
        return None
    how = {"rms": "root mean square of the ", "worst": "worst ", "sum": "sum of the "}[goal.combine]
    many = "s" * (goal.combine != "worst")
    if goal.minimise == "reaction":
        return Aim(bearing_rows(job), goal.combine, (job.speed or 1.0) ** 2, f"{how}bearing reaction{many}", "force")
    sums = balance_rows(job)
    if goal.minimise == "couple_unbalance":
        _, arm = middle_and_arm(job)
        return Aim(_only(sums, 1), "worst", arm, "couple unbalance", "couple_unbalance")
    if goal.minimise == "static_unbalance" or job.flat:
        return Aim(_only(sums, 0), "worst", 1.0, "static unbalance", "unbalance")
    where = "at the bearings" if job.bearings else "at both ends"
    return Aim(end_rows(job), goal.combine, 1.0, f"{how}unbalance{many} {where}", "unbalance")


def _only(rows: Rows, index: int) -> Rows:
    keep = slice(index, index + 1)
    return Rows(rows.names[keep], rows.masses[keep], rows.planes[keep])


def unbalances(job: KnownJob) -> ComplexArray:
    """The known unbalances, shape (n_masses,) [kg m]."""
    return np.array([mass.u for mass in job.masses], dtype=complex)


def reactions(job: KnownJob, u: Sequence[complex] | ComplexArray) -> dict[str, complex]:
    """Force of each bearing on the shaft [N], turning with it, as a vector from the axis; without speed none."""
    if len(job.bearings) != 2 or job.speed is None:
        return {}
    rows = bearing_rows(job)
    carried = rows.masses @ unbalances(job) + rows.planes @ np.asarray(u, dtype=complex)
    return {name: complex(-(job.speed**2) * one) for name, one in zip(rows.names, carried, strict=True)}


def turned_by_hand(job: KnownJob, u: ComplexArray, steps: int = 7, about: float | None = None) -> tuple[float, float]:
    """Greatest force [N] and greatest couple about the middle, or `about` a place [m], left on the shaft over one turn.

    The masses are put on the shaft as points, turned through `steps` positions, and summed in real components, at
    1 rad/s where there is no speed.  No vector sum of the optimiser is used; a balanced shaft shows zero for both.
    """
    middle = middle_and_arm(job)[0] if about is None else about
    points = [(mass.u, mass.at) for mass in job.masses] + [(z, p.place) for z, p in zip(u, job.planes, strict=True)]
    speed2 = job.speed**2 if job.speed is not None else 1.0
    force = couple = 0.0
    for step in range(steps):
        turn = 2.0 * np.pi * step / steps
        x = y = about_x = about_y = 0.0
        for one, at in points:
            fx = speed2 * abs(one) * np.cos(np.angle(one) + turn)
            fy = speed2 * abs(one) * np.sin(np.angle(one) + turn)
            x, y = x + fx, y + fy
            about_x, about_y = about_x - (at - middle) * fy, about_y + (at - middle) * fx
        force, couple = max(force, float(np.hypot(x, y))), max(couple, float(np.hypot(about_x, about_y)))
    return force, couple


def rows_by_hand(job: KnownJob, u: ComplexArray) -> FloatArray:
    """Sizes of what `balance_rows` and `bearing_rows` are, by the masses turned by hand (n_rows,) [kg m].

    What a bearing carries is the couple about the other one over their distance.
    """
    speed2 = job.speed**2 if job.speed is not None else 1.0
    force, couple = turned_by_hand(job, u)
    sizes = [force] if job.flat else [force, couple / middle_and_arm(job)[1]]
    if job.bearings:
        (first, second), span = job.bearings, abs(job.bearings[1].at - job.bearings[0].at)
        sizes += [turned_by_hand(job, u, about=other.at)[1] / span for other in (second, first)]
    return np.array(sizes) / speed2


def equilibrium(job: KnownJob, u: ComplexArray) -> float:
    """Force and moment (about the first bearing) that the reactions leave over, relative to all forces."""
    points = [(mass.u, mass.at) for mass in job.masses] + [(z, p.place) for z, p in zip(u, job.planes, strict=True)]
    back = reactions(job, u)
    if not back or job.speed is None:
        return 0.0
    first = job.bearings[0].at
    pushes = [(one * job.speed**2, at - first) for one, at in points]
    size = sum(abs(force) for force, _ in pushes) or 1.0
    arm = max(abs(at) for _, at in pushes) or 1.0
    pushes += [(back[bearing.name], bearing.at - first) for bearing in job.bearings]
    force_left = abs(sum(force for force, _ in pushes))
    moment_left = abs(sum(force * at for force, at in pushes))
    return float(max(force_left, moment_left / arm) / size)
