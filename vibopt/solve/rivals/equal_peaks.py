"""Newton on equal peaks: the equations of the optimum of absorbers on one mass, as a hand-written script solves them.

n absorbers leave n + 1 peaks, which are equally high and flat in the speed, and some mean of the slopes of their
heights in tunings and dampings is nothing: 4 n + 3 equations for design, speeds, weights and the height, all in logs.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.forms.extremes import sampled_slopes
from vibopt.mechanics.modes import free_matrices
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.method import Found, Progress
from vibopt.solve.ranges import log_box
from vibopt.solve.rivals.general import Continuous
from vibopt.solve.rivals.sampled import sampled_speeds

_SPEEDS, _STEPS = 400, 40
_BESIDE = 3e-5
"""Distance of the speeds [log] over which the height of a peak is differenced."""
_FLAT, _CLOSE, _ABOVE = 0.1, 1e-18, 1e-9
"""Weight of a slope beside a height; half the sum of squares that may be left; how much higher other speeds may be."""
_APART, _PARTS, _FEW = (1.0, 0.5, 1.5, 0.75, 2.0), (0.5, 0.35, 0.7, 0.25, 0.15, 1.0), 3
"""Starts: tunings over the root of the mass ratio apart, parts of Den Hartog's damping, and up to how many absorbers
each takes every place."""
_AGREE = 12
"""Starts that end at the best one, after which no more are tried."""


@dataclass
class EqualPeaks(Continuous):
    """Newton's method with differenced slopes and Levenberg's damping (MINPACK), from tunings evenly apart."""

    name: str = "equal_peaks"
    summary: str = "Newton on the equations of equal peaks, absorbers on one mass"

    def refuses(self, program: Program) -> str | None:
        """All but the least worst response to one excitation of one mass and its absorbers, no limits."""
        aim = program.aim
        least = aim is not None and aim.sense > 0 and len(aim.form.drives) == 1
        many = program.model.n_free - 1
        own = many > 0 and sorted(_words(program)) == ["damping_ratio"] * many + ["tuning"] * many
        if not least or not own or program.limits or not _on_one_mass(program):
            return f"{self.name} takes absorbers on the one excited mass, for the least worst response, without limits."
        return super().refuses(program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Claims success where Newton converges inside the ranges, and no other speed is worse."""
        heights, ends = _Heights(program), list[tuple[float, FloatArray]]()
        for y in heights.starts():
            end = heights.solved(y)
            if end is not None:
                ends.append(end)
                tops = [top for top, _ in ends]
                if sum(top <= min(tops) + _ABOVE for top in tops) >= _AGREE:
                    break
        if not ends:
            return Found("unproven", None, "Newton finds no equal peaks from any start", self.name)
        x = np.clip(np.exp(min(ends, key=lambda one: one[0])[1]), program.low, program.high)
        words = f"{counted(heights.peaks, 'peaks')} equal, the best of {counted(len(ends), 'ends')} of Newton"
        return Found("feasible", x, words, self.name)


def _words(program: Program) -> list[str]:
    return [axis.path.rsplit(".", 1)[-1] for axis in program.axes]


def _on_one_mass(program: Program) -> bool:
    """Whether the excitation acts on one of the coordinates alone."""
    aim = program.aim
    drives = aim.form.drives if aim is not None else ()
    return all(np.count_nonzero(line.vector) == 1 for drive in drives for line in drive.lines)


class _Heights:
    """Logs of the response and its slopes in y = log x."""

    def __init__(self, program: Program) -> None:
        self.low, self.high = log_box(program)
        self.words = _words(program)
        aim = program.aim
        assert aim is not None
        assert aim.form.harmonic is not None
        self.model, self.form, self.drive = aim.model, aim.form.harmonic, aim.form.drives[0]
        speeds = sampled_speeds(self.drive, _SPEEDS)
        self.speeds = speeds[speeds > 0.0]
        self.peaks = len(self.words) // 2 + 1

    def starts(self) -> Iterator[FloatArray]:
        """Tunings about Den Hartog's, 1/(1 + mu), and parts of his damping ratio, sqrt(3 mu / (8 (1 + mu)))."""
        vector, many = np.abs(self.drive.lines[0].vector), self.peaks - 1
        masses = np.diag(free_matrices(self.model, self.model.values(np.exp(self.low)))[0])
        own = masses[vector == 0.0]
        mu = float(own.sum() / masses[vector.argmax()])
        tuned = np.array([word == "tuning" for word in self.words])
        every = permutations(range(many)) if many <= _FEW else [tuple(range(many))]
        orders = {tuple(own[np.argsort(order)].tolist()): order for order in every}.values()  # one of like masses
        for apart, part, order in product(_APART if many > 1 else (0.0,), _PARTS, orders):
            y = np.full(2 * many, np.log(part * np.sqrt(0.375 * mu / (1.0 + mu))))
            y[tuned] = apart * np.sqrt(mu) * (np.array(order) / max(many - 1, 1) - 0.5) - np.log1p(mu)
            yield np.clip(y, self.low, self.high)

    def solved(self, y: FloatArray) -> tuple[float, FloatArray] | None:
        """Log of the height and the design to which Newton comes; None where it comes to none."""
        from scipy.optimize import least_squares

        n, m = len(y), self.peaks
        seen, _ = self._at(y, self.speeds)
        inner = np.flatnonzero((seen[1:-1] > seen[:-2]) & (seen[1:-1] >= seen[2:])) + 1
        if len(inner) != m:
            return None
        places = np.log(self.speeds[inner])
        heights, slopes = self._at(y, self.speeds[inner])
        weights = np.linalg.lstsq(np.vstack([slopes.T, np.ones(m)]), np.append(np.zeros(n), 1.0), rcond=None)[0]
        begun = np.concatenate([y, places, weights, [heights.max()]])
        found: Any = least_squares(self.missed, begun, method="lm", xtol=1e-14, ftol=1e-14, max_nfev=_STEPS)
        design, weights, top = found.x[:n], found.x[n + m : n + 2 * m], float(found.x[-1])
        inside = (design >= self.low).all() and (design <= self.high).all()
        if not inside or found.cost > _CLOSE or (weights < -_ABOVE).any():
            return None
        return (top, design) if self._at(design, self.speeds)[0].max() <= top + _ABOVE else None

    def missed(self, z: FloatArray) -> FloatArray:
        """What the equations leave at (design, logs of speeds, weights, height), (4 n + 3,)."""
        n, m = len(self.words), self.peaks
        v, weights = z[n : n + m], z[n + m : n + 2 * m]
        heights, slopes = self._at(z[:n], np.exp(np.concatenate([v, v + _BESIDE, v - _BESIDE])))
        flat = (heights[m : 2 * m] - heights[2 * m :]) / (2.0 * _BESIDE)
        return np.concatenate([heights[:m] - z[-1], _FLAT * flat, weights @ slopes[:m], [weights.sum() - 1.0]])

    def _at(self, y: FloatArray, speeds: FloatArray) -> tuple[FloatArray, FloatArray]:
        return sampled_slopes(self.model, self.form, self.drive, np.exp(y), speeds)
