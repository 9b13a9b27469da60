"""Newton on equal peaks: the equations of the optimum of one absorber, as a hand-written script solves them.

Two peaks are equally high, each is flat in the speed, and the slopes of their heights in tuning and damping point
against each other: four equations for two variables and two speeds, all in logs.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.forms.extremes import sampled_slopes
from vibopt.mechanics.modes import free_matrices
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.method import Found, Progress
from vibopt.solve.ranges import log_box
from vibopt.solve.rivals.general import discrete
from vibopt.solve.rivals.sampled import sampled_speeds

_SPEEDS, _STEPS, _LONGEST = 400, 60, 0.2
_BESIDE = 3e-5
"""Distance of the speeds [log] over which the height of a peak is differenced."""
_NUDGE = 1e-7
_CLOSE = 1e-11


@dataclass
class EqualPeaks:
    """Newton's method with differenced slopes of the equations, steps cut to a fifth."""

    name: str = "equal_peaks"
    summary: str = "Newton on the equations of equal peaks, one absorber"

    def refuses(self, program: Program) -> str | None:
        """All but the least worst response to one excitation, two variables, no limits."""
        aim = program.aim
        least = aim is not None and aim.sense > 0 and len(aim.form.drives) == 1
        one = program.model.n_free == 2 and sorted(_words(program)) == ["damping_ratio", "tuning"]
        if not least or not one or program.limits or not _on_one_mass(program):
            return f"{self.name} takes one absorber on one excited mass, for the least worst response, without limits."
        return discrete(self.name, program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Claims success where Newton converges inside the ranges."""
        heights = _Heights(program)
        start = heights.start()
        if start is None:
            return Found("unproven", None, "Den Hartog's absorber has no two peaks here", self.name)
        z = start
        for step in range(_STEPS):
            missed = heights.missed(z)
            try:
                move = np.linalg.solve(heights.slopes(z, missed), -missed)
            except np.linalg.LinAlgError:
                return Found("unproven", None, "the equations are singular", self.name)
            size = float(np.abs(move).max())
            z = z + move * min(1.0, _LONGEST / max(size, 1e-300))
            if not np.isfinite(z).all() or not heights.inside(z):
                return Found("unproven", None, "Newton leaves the ranges", self.name)
            if size < _CLOSE:
                x = np.clip(np.exp(z[:2]), program.low, program.high)
                return Found("feasible", x, f"two peaks equal after {counted(step + 1, 'steps of Newton')}", self.name)
        return Found("unproven", None, f"no end after {_STEPS} steps of Newton", self.name)


def _words(program: Program) -> list[str]:
    return [axis.path.rsplit(".", 1)[-1] for axis in program.axes]


def _on_one_mass(program: Program) -> bool:
    """Whether the excitation acts on one of the coordinates alone."""
    aim = program.aim
    drives = aim.form.drives if aim is not None else ()
    return all(np.count_nonzero(line.vector) == 1 for drive in drives for line in drive.lines)


class _Heights:
    """Logs of the response and its slopes in y = log x, at z = (y, logs of two speeds)."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.low, self.high = log_box(program)
        aim = program.aim
        assert aim is not None
        assert aim.form.harmonic is not None
        self.model, self.form, self.drive = aim.model, aim.form.harmonic, aim.form.drives[0]
        speeds = sampled_speeds(self.drive, _SPEEDS)
        self.speeds = speeds[speeds > 0.0]

    def start(self) -> FloatArray | None:
        """Den Hartog's absorber, tuning 1/(1 + mu) and damping ratio sqrt(3 mu / (8 (1 + mu))), and its two peaks."""
        vector = np.abs(self.drive.lines[0].vector)
        masses = np.diag(free_matrices(self.model, self.model.values(np.exp(self.low)))[0])
        mu = float(masses[vector.argmin()] / masses[vector.argmax()])
        best = {"tuning": 1.0 / (1.0 + mu), "damping_ratio": np.sqrt(0.375 * mu / (1.0 + mu))}
        y = np.clip(np.log([best[word] for word in _words(self.program)]), self.low, self.high)
        heights, _ = self._at(y, self.speeds)
        inner = np.flatnonzero((heights[1:-1] > heights[:-2]) & (heights[1:-1] >= heights[2:])) + 1
        return np.concatenate([y, np.log(self.speeds[inner])]) if len(inner) == 2 else None

    def inside(self, z: FloatArray) -> bool:
        """Whether the design lies in its ranges and the speeds apart and among those of the excitation."""
        y, v = z[:2], z[2:]
        apart = abs(v[1] - v[0]) > 1e-9
        within = (v >= np.log(self.speeds[0])).all() and (v <= np.log(self.speeds[-1])).all()
        return bool(apart and within and (y >= self.low).all() and (y <= self.high).all())

    def missed(self, z: FloatArray) -> FloatArray:
        """What the four equations leave, (4,)."""
        v = z[2:]
        heights, slopes = self._at(z[:2], np.exp(np.concatenate([v, v + _BESIDE, v - _BESIDE])))
        flat = (heights[2:4] - heights[4:]) / (2.0 * _BESIDE)
        return np.array([heights[0] - heights[1], *flat, slopes[0, 0] * slopes[1, 1] - slopes[0, 1] * slopes[1, 0]])

    def slopes(self, z: FloatArray, missed: FloatArray) -> FloatArray:
        """Their slopes by differences, (4, 4)."""
        return np.stack([(self.missed(z + _NUDGE * one) - missed) / _NUDGE for one in np.eye(4)], axis=1)

    def _at(self, y: FloatArray, speeds: FloatArray) -> tuple[FloatArray, FloatArray]:
        return sampled_slopes(self.model, self.form, self.drive, np.exp(y), speeds)
