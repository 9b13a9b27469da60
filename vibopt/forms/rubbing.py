"""Greatest response in the steady motion of a body on a link with dry friction, over the speeds of one excitation."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form, Local, Worst, log_of
from vibopt.records import dataclass
from vibopt.signals import Band, Drive, Output

if TYPE_CHECKING:
    from vibopt.mechanics.dry_friction import Rub
    from vibopt.mechanics.model import Model

_KEPT = 64
_SLOW, _QUASI = 0.03, 2e-3
"""Frequency over the natural one up to which a range is looked at by its limit at rest; below which a speed is."""
_EVEN, _NEAR = 12, (0.34, 0.6, 0.75, 0.86, 0.93, 0.97, 0.99, 1.0, 1.01, 1.03, 1.07, 1.15, 1.3, 1.5)
"""Speeds looked at in a range, and more of them as parts of the natural frequency."""
_STEP, _WITHIN = 1e-4, 0.8
"""Of differences, in logs; part of the greatest that another extreme has that may overtake it, each taking long."""
_ROUNDED = 1e-9
"""Part of the motion on a free spring by which an integration may be off, whatever friction leaves of it."""
_HOPE, _BEST, _LEFT = 0.6, 2, 1e-7
"""Part by which a rough look may be off; local extremes looked at more closely, and what may be left of their speed."""


@dataclass(frozen=True, slots=True)
class Rubbing(Form):
    """Greatest size of a response over a cycle and over bands of speeds, exact at each of them.

    drives
        One excitation of one harmonic.
    normalised
        Whether it is a ratio to the amplitude of that.
    """

    output: Output
    shaken: tuple[Drive, ...]
    normalised: bool
    no_bounds = "is a motion with dry friction, which has no bounds on boxes of designs"
    not_convex = "is a motion with dry friction, which is not convex in stiffness, damping and friction"
    rough = "is a motion with dry friction, which slips, stops or holds: no smooth function of the design"

    @property
    def searched(self) -> str:
        at_speeds = all(band.is_point for band in self.shaken[0].bands)
        return "" if at_speeds else "the greatest over a range of speeds with dry friction is found by a search"

    @property
    def screened(self) -> bool:
        return True

    def push(self, mass: float, speed: float) -> float:
        line = self.shaken[0].lines[0]
        vector = np.abs(line.vector) * np.abs(line.amplitude.at(np.array(speed / line.order)))
        return float(vector[0] or mass * speed**2 * vector[-1])

    def value(self, model: Model, x: FloatArray) -> float:
        return self.worst(model, x).value

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        value, speed = self.tops(model, x, least_wanted)[0]
        return Worst(value, {self.shaken[0].name: speed})

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return self.extremes(model, x, least_wanted=False)[0].slope

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """Local extremes over the speeds; moving one changes nothing to first order, and an end stays."""
        tops = self.tops(model, x, least_wanted)
        near = max(within, _WITHIN)
        return [self._local(model, x, *one) for one in tops if least_wanted or one[0] >= near * tops[0][0]]

    def _local(self, model: Model, x: FloatArray, value: float, speed: float) -> Local:
        """Slope and bend of the log by differences, in the logs of the design and, inside a band, of the speed."""
        if not 0.0 < value < np.inf:
            return Local(log_of(value) if np.isfinite(value) else np.inf, np.zeros(len(x)), (speed,))
        moves = all(speed not in (band.low, band.high) for band in self.shaken[0].bands)
        n, steps = len(x), _STEP * np.eye(len(x) + moves)

        def near(turn: FloatArray) -> float:
            return log_of(self.at(model, x * np.exp(turn[:n]), speed * float(np.exp(turn[n:].sum()))))

        here, ups, downs = log_of(value), [near(one) for one in steps], [near(-one) for one in steps]
        slope, bend = (np.array(ups) - downs) / (2.0 * _STEP), np.zeros(2 * steps.shape[:1])
        for i, j in combinations_with_replacement(range(len(steps)), 2):
            both = [near(steps[i] + steps[j]), near(-steps[i] - steps[j])] if i != j else []
            apart = (
                sum(both) + 2.0 * here - ups[i] - ups[j] - downs[i] - downs[j] if both else ups[i] + downs[i] - 2 * here
            )
            bend[i, j] = bend[j, i] = apart / ((2.0 if both else 1.0) * _STEP**2)
        if moves and bend[n, n]:  # the extreme moves with the design
            bend -= np.outer(bend[:, n], bend[n]) / bend[n, n]
        whole = np.isfinite(bend[:n, :n]).all()
        return Local(here, np.nan_to_num(slope[:n]), (speed,), bend[:n, :n] if whole else None)

    def candidates(self, model: Model, x: FloatArray, *, least_wanted: bool) -> list[tuple[tuple[float, ...], float]]:
        return [((speed,), value) for value, speed in self.tops(model, x, least_wanted)]

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """A ten-millionth, which an integration from stop to stop keeps, and less still of what a free spring gives."""
        ends = [end for band in self.shaken[0].bands for end in (band.low, band.high) if np.isfinite(end)]
        sizes = [abs(part) + abs(phasor) for _, _, (_, part, phasor) in (self.motion(model, x, end) for end in ends)]
        free = max((one for one in sizes if np.isfinite(one)), default=0.0) / self.per(model, x, max(ends, default=0.0))
        return 1e-7 * max([0.0, *(abs(one) for one in (value, other) if np.isfinite(one))]) + _ROUNDED * free

    def acting(self, model: Model) -> FloatArray:
        assert model.rubbing is not None
        return np.vstack([model.exponents, model.rubbing[1].row(model.n_vars)])

    def cost(self, model: Model) -> float:
        return sum(4.0 if band.is_point else 150.0 for band in self.shaken[0].bands)

    def tops(self, model: Model, x: FloatArray, least_wanted: bool = False) -> list[tuple[float, float]]:
        """Local extremes and their speeds [rad/s], the worst first; those of the last designs are kept."""
        known: dict[tuple[int, bool, bytes], tuple[Rubbing, list[tuple[float, float]]]]
        known = vars(model).setdefault("rubbing_tops", {})
        key = id(self), least_wanted, np.asarray(x, dtype=float).tobytes()
        if key not in known:
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            sign = -1.0 if least_wanted else 1.0
            found = [one for band in self.shaken[0].bands for one in self._over(model, x, band, sign)]
            known[key] = self, sorted(found, key=lambda one: -sign * one[0])  # the form stays, and so its number
        return known[key][1]

    def _over(self, model: Model, x: FloatArray, band: Band, sign: float) -> list[tuple[float, float]]:
        """The ends of a band and the best inside it."""
        if band.is_point:
            return [(self.at(model, x, band.low), band.low)]
        from scipy.optimize import minimize_scalar

        speeds = _looked_at(band, natural_frequency(model, x) / self.shaken[0].lines[0].order)
        rough = np.array([self.at(model, x, one, rough=True) for one in speeds])
        hopeful = sign * rough >= (1.0 - _HOPE * sign) * (sign * rough).max()
        hopeful[[0, -1]] = True
        values = np.full(len(speeds), -np.inf)
        values[hopeful] = sign * np.array([self.at(model, x, float(one)) for one in speeds[hopeful]])
        found = [(sign * float(values[i]), float(speeds[i])) for i in (0, len(speeds) - 1)]
        before, after = np.append(-np.inf, values[:-1]), np.append(values[1:], -np.inf)
        tops = np.flatnonzero((values >= before) & (values >= after) & hopeful)
        for i in tops[np.argsort(-values[tops], kind="stable")[:_BEST]]:
            if np.isinf(values[i]):
                return [(sign * float(values[i]), float(speeds[i]))]
            best = minimize_scalar(
                lambda one: -sign * self.at(model, x, float(one)),
                bounds=(speeds[max(i - 1, 0)], speeds[min(i + 1, len(speeds) - 1)]),
                method="bounded",
                options={"xatol": _LEFT * speeds[i]},
            )
            top, at = max((float(values[i]), float(speeds[i])), (-float(best.fun), float(best.x)))
            found.append((sign * top, at))
        return found

    def at(self, model: Model, x: FloatArray, speed: float, *, rough: bool = False) -> float:
        """Greatest size in a cycle at one speed [rad/s]; `rough` by equivalent damping alone."""
        if not 0.0 < self._amplitude(speed) < np.inf:
            return 1.0 if self.normalised else self._amplitude(speed)
        rub, _, (order, part, phasor) = self.motion(model, x, speed)
        count = self.per(model, x, speed)
        if rough and rub.r:
            return rub.equivalent(order, part, phasor) / count
        if rub.r >= _QUASI:
            return rub.greatest(order, part, phasor) / count
        slips = max(1.0 - rub.friction, 0.0)  # so slow that springs follow; certified nowhere but at rest
        quick = part * slips * (1.0, 2.0, 2.0 / rub.r if rub.r else 0.0)[order]
        return float(abs(phasor) if self.output.signs.any() else abs(quick) + abs(phasor)) / count

    def _amplitude(self, speed: float) -> float:
        """Of the force [N] or the base [m]."""
        line = self.shaken[0].lines[0]
        return float(np.abs(line.amplitude.at(np.array(speed))) * np.abs(line.vector).max())

    def per(self, model: Model, x: FloatArray, speed: float) -> float:
        """By what a reading is divided: the mounts that share it, and the amplitude of what moves them."""
        from vibopt.mechanics.harmonic import mount_count

        return mount_count(model, self.output, x) * (self._amplitude(speed) if self.normalised else 1.0)

    def motion(self, model: Model, x: FloatArray, speed: float) -> tuple[Rub, float, tuple[int, float, complex]]:
        """The motion at a speed [rad/s], the force [N] that drives it, and what is read: order, part and phasor."""
        from vibopt.mechanics.dry_friction import Rub
        from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS

        line, p = self.shaken[0].lines[0], model.values(x)
        omega, amplitude = line.order * speed, float(np.abs(line.amplitude.at(np.array(speed))))
        mass, damping, stiffness = (float(model.matrix(kind, p)[0, 0]) for kind in (INERTIA, DAMPING, STIFFNESS))
        vector = np.abs(line.vector) * amplitude
        base = float(vector[1]) if model.n_coords > 1 else 0.0
        push = float(vector[0]) if not base else mass * omega**2 * base
        natural = float(np.sqrt(stiffness / mass))
        friction = friction_of(model, x) / push if push else np.inf
        rub = Rub(omega / natural, damping / (2.0 * mass * natural), friction)
        if self.output.signs.any():
            return rub, push, (2, -push * rub.r**2, complex(push))
        own, whole, order = float(self.output.row[0]), float(self.output.row.sum()), self.output.power
        return rub, push, (order, own * push / stiffness * omega**order, whole * base * (1j * omega) ** order)


def friction_of(model: Model, x: FloatArray) -> float:
    """Dry friction of the whole link [N]."""
    assert model.rubbing is not None
    force = model.rubbing[1]
    return float(force.scale * np.prod([x[i] ** power for i, power in force.exponents.items()]))


def natural_frequency(model: Model, x: FloatArray) -> float:
    """While it slips [rad/s]."""
    from vibopt.mechanics.model import INERTIA, STIFFNESS

    p = model.values(x)
    return float(np.sqrt(model.matrix(STIFFNESS, p)[0, 0] / model.matrix(INERTIA, p)[0, 0]))


def _looked_at(band: Band, natural: float) -> FloatArray:
    """Speeds of a rough look at a band [rad/s], ascending; at rest and below a part of the natural frequency none."""
    slow = _SLOW * min(natural, band.high)
    low = band.low if band.low >= slow else slow
    near = natural * np.array(_NEAR)
    rest = [band.low] if band.low == 0.0 else []
    inside = near[(near > low) & (near < band.high)]
    return np.unique(np.concatenate([rest, [band.low], np.geomspace(low, band.high, _EVEN), inside]))


__all__ = ["Rubbing", "friction_of", "natural_frequency"]
