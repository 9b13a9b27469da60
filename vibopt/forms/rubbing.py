"""Greatest response in the steady motion of a body on a link with dry friction, over the speeds of one excitation."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import chebyshev

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.errors import InputError
from vibopt.forms.form import AtWorst, Local, Worst, top_by_differences
from vibopt.mechanics.slipping import radians_at
from vibopt.records import dataclass
from vibopt.signals import Band, Drive, Output
from vibopt.units import show
from vibopt.values.speeds import ROTATION
from vibopt.work import metered, worked

if TYPE_CHECKING:
    from vibopt.mechanics.dry_friction import Rub
    from vibopt.mechanics.model import Model

_KEPT = 4096
_SLOW, _RADIANS, LEAST = 0.03, 6000.0, 1e-8
"""Frequency over the natural one up to which a range is looked at by its limit at rest; radians of free vibration that
are followed in half a cycle, and frequency over the natural one below which rounding hides it."""
_EVEN, _NEAR = 12, (0.34, 0.6, 0.75, 0.86, 0.93, 0.97, 0.99, 1.0, 1.01, 1.03, 1.07, 1.15, 1.3, 1.5)
"""Speeds looked at in a range, and more of them as parts of the natural frequency."""
_WITHIN = 0.8
"""Part of the greatest that another extreme has that may overtake it, each taking long."""
_BEHIND, _LEVEL = (1.0, 1.03, 1.08, 1.14, 1.2, 1.27, 1.36, 1.5), 1e-9
"""Speeds as parts of that at which what held begins to slip; part of itself within which a response stays level."""
_ROUNDED = 1e-9
"""Part of the motion on a free spring by which an integration may be off, whatever friction leaves of it."""
_HOPE, _BEST, _SECOND, _LEFT = 0.6, 3, 0.5, 1e-7
"""Part by which a rough look may be off; local extremes looked at more closely, all but the first from which part of it
on, and what may be left of their speed."""
_DEGREE, _ROUNDS, _CLOSER, _SETTLED, _ODD = 8, 4, 0.2, 1e-11, 0.3717
"""Of polynomials on a range with a top; how often it is made narrower and by how much on each side; what they may leave
over at the top and at one more place."""
TIMES, _DEGENERATE, _ENDLESS = 100, 1e-6, 1e5
"""Instants of half a cycle; how near a natural frequency is to a whole multiple of that of the force, to be one; the
multiple from which on a cycle is endless beside the vibration."""
_NODES = -np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_INTO = np.linalg.inv(chebyshev.chebvander(_NODES, _DEGREE))


@dataclass(frozen=True, slots=True)
class Rubbing(AtWorst):
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
    once, over = 0.6, 150.0  # at a speed, and over a band of them, which takes as much where nothing is damped

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

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        value, speed = self.tops(model, x, least_wanted)[0]
        return Worst(value, {self.shaken[0].name: speed})

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """Local extremes over the speeds; moving one changes nothing to first order, and an end stays."""
        tops = self.tops(model, x, least_wanted)
        near = max(within, _WITHIN)
        kept = [top for top in tops if least_wanted or top[0] >= near * tops[0][0]]
        ends = [end for band in self.shaken[0].bands for end in (band.low, band.high)]
        at = partial(self.each, model)
        return [top_by_differences(at, x, value, speed, moves=speed not in ends) for value, speed in kept]

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """A ten-millionth, which an integration from stop to stop keeps, and less still of what a free spring gives."""
        ends = [end for band in self.shaken[0].bands for end in (band.low, band.high) if np.isfinite(end)]
        reads = [self.motion(model, x, end)[2] for end in ends]
        sizes = [float(np.abs(parts).sum()) + abs(phasor) for parts, phasor in reads]
        at = np.array(max(ends, default=0.0))
        free = max((size for size in sizes if np.isfinite(size)), default=0.0) / float(self.per(model, x, at))
        return 1e-7 * max([0.0, *(abs(one) for one in (value, other) if np.isfinite(one))]) + _ROUNDED * free

    def acting(self, model: Model) -> FloatArray:
        return acting_with_friction(model)

    def cost(self, model: Model) -> float:
        return sum(self.once if band.is_point else self.over for band in self.shaken[0].bands)

    def tops(self, model: Model, x: FloatArray, least_wanted: bool = False) -> list[tuple[float, float]]:
        """Local extremes and their speeds [rad/s], the worst first; those of the last designs are kept."""
        known: dict[tuple[int, bool, bytes], tuple[Rubbing, list[tuple[float, float]], float]]
        known = vars(model).setdefault("rubbing_tops", {})
        key = id(self), least_wanted, np.asarray(x, dtype=float).tobytes()
        if key not in known:
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            sign = -1.0 if least_wanted else 1.0
            with metered() as meter:
                found = [one for band in self.shaken[0].bands for one in self._over(model, x, band, sign)]
            found.sort(key=lambda one: -sign * one[0])
            known[key] = self, found, meter.done  # the form stays, and so its number
        else:
            worked(known[key][2])  # who asks again does the same work, whoever asked before
        return known[key][1]

    def _over(self, model: Model, x: FloatArray, band: Band, sign: float) -> list[tuple[float, float]]:
        """The ends of a band and the best inside it."""
        if band.is_point:
            return [(self.at(model, x, band.low), band.low)]

        def seen(some: FloatArray) -> FloatArray:
            return sign * self.sizes(model, x, some)

        speeds = _looked_at(band, self.naturals(model, x) / self.shaken[0].lines[0].order)
        speeds = np.union1d(speeds, self._freed(model, x, speeds))
        values = sign * self.sizes(model, x, speeds, hope=sign)
        found = [(sign * float(values[i]), float(speeds[i])) for i in (0, len(speeds) - 1)]
        before, after = np.append(-np.inf, values[:-1]), np.append(values[1:], -np.inf)
        level = np.isclose(values, after, rtol=_LEVEL, atol=0.0)  # what holds stays so: of many alike the last counts
        tops = np.flatnonzero((values >= before) & (values >= after) & (values > -np.inf) & ~level)
        for i in tops[np.argsort(-values[tops], kind="stable")[:_BEST]]:
            if np.isinf(values[i]):
                return [(sign * float(values[i]), float(speeds[i]))]
            if values[i] < sign * found[-1][0] * _SECOND**sign:
                break
            top, at = _top(seen, float(speeds[max(i - 1, 0)]), float(speeds[min(i + 1, len(speeds) - 1)]))
            top, at = max((float(values[i]), float(speeds[i])), (top, at))
            found.append((sign * top, at))
        return found

    def _freed(self, model: Model, x: FloatArray, speeds: FloatArray) -> FloatArray:
        """Speeds behind those at which what holds first slips, up to the last of the speeds."""
        with np.errstate(divide="ignore", invalid="ignore"):
            held = np.log(self.grasp(model, x, speeds))
            k = np.flatnonzero((held[:-1] >= 0.0) & (held[1:] < 0.0))
            part = np.where(np.isfinite(held[k]), held[k] / (held[k] - held[k + 1]), 1.0)
            found = speeds[k] ** (1.0 - part) * speeds[k + 1] ** part
        every = np.outer(found, _BEHIND).ravel()
        return np.asarray(every[(every > speeds[0]) & (every < speeds[-1])])

    def grasp(self, model: Model, x: FloatArray, speeds: FloatArray) -> FloatArray:
        """Friction over what it must hold at speeds [rad/s], (n,)."""
        return self._motions(model, x, speeds)[0][2]

    def naturals(self, model: Model, x: FloatArray) -> FloatArray:
        """Natural frequencies beside which it is looked at, ascending [rad/s]."""
        from vibopt.mechanics.model import INERTIA, STIFFNESS

        p = model.values(x)
        return np.asarray(np.sqrt(model.matrix(STIFFNESS, p)[0, :1] / model.matrix(INERTIA, p)[0, :1]))

    def at(self, model: Model, x: FloatArray, speed: float, *, rough: bool = False) -> float:
        """Greatest size in a cycle at one speed [rad/s]; `rough` by equivalent damping alone."""
        worked(self.once)  # slopes look at it, too, which no cost says
        if not rough or not 0.0 < self._amplitude(np.array(speed)) < np.inf or not speed:
            return float(self.sizes(model, x, np.array([speed]))[0])
        rub, _, read = self.motion(model, x, speed)
        return float(rub.equivalent(*read) / self.per(model, x, np.array(speed)))

    def each(self, model: Model, x: FloatArray, speeds: FloatArray) -> FloatArray:
        """Greatest sizes in a cycle at designs (m, n_vars), each at a speed of its own [rad/s], (m,)."""
        worked(len(x) * self.once)
        alone = [(one, speeds[k : k + 1]) for k, one in enumerate(x)]
        own, _, reads = zip(*(self._motions(model, *one) for one in alone), strict=True)
        rubs, parts, phasor = np.hstack(own), *(np.hstack(read) for read in zip(*reads, strict=True))
        count = np.concatenate([np.atleast_1d(self.per(model, *one)) for one in alone])
        return self._sizes(speeds, (rubs[0], rubs[1], rubs[2]), (parts, phasor), count)

    def sizes(self, model: Model, x: FloatArray, speeds: FloatArray, *, hope: float = 0.0) -> FloatArray:
        """Greatest sizes in a cycle at speeds [rad/s], (n,).

        With a `hope` of 1 or -1 only those that may be the greatest or the least, and both ends; others are infinite
        against it.
        """
        own, _, read = self._motions(model, x, speeds)
        return self._sizes(speeds, own, read, self.per(model, x, speeds), hope)

    def _sizes(
        self, speeds: FloatArray, own: tuple[FloatArray, ...], read: tuple[FloatArray, ComplexArray],
        count: FloatArray, hope: float = 0.0,
    ) -> FloatArray:  # fmt: skip
        """As `sizes`, of motions and readings at speeds [rad/s]."""
        from vibopt.mechanics.dry_friction import rub_of
        from vibopt.mechanics.slipping import Slipping

        (r, ratio, friction), (parts, phasor), amplitude = own, read, self._amplitude(speeds)
        found = np.where(self.normalised, 1.0, amplitude)
        moves = (amplitude > 0.0) & (amplitude < np.inf)
        still = moves & (r == 0.0)
        pulled = np.abs(parts[0] * np.maximum(1.0 - friction, 0.0) + phasor)
        found = np.where(still, pulled / count, found)
        quick_enough = moves & ~still
        slips = quick_enough & (friction < 1.0)
        poles = Slipping(np.where(slips, r, 1.0), ratio, friction).poles
        rings = np.max([radians_at(pole) for pole in poles], axis=0) > _RADIANS
        for k in np.flatnonzero(slips & (rings | (r < LEAST))).tolist():
            raise InputError(self.too_slow(float(speeds[k]), float(speeds[k] / r[k]), _RADIANS * rings[k]))
        sizes = np.full(speeds.shape, np.nan)
        sizes[slips] = Slipping(r[slips], ratio[slips], friction[slips]).greatest(parts[:, slips], phasor[slips])
        left = np.flatnonzero(quick_enough & np.isnan(sizes)).tolist()
        rubs = {k: rub_of(float(r[k]), float(ratio[k]), float(friction[k])) for k in left}
        if hope:
            for k, rub in rubs.items():
                sizes[k] = rub.equivalent(parts[:, k], complex(phasor[k]))
            known = hope * np.where(quick_enough, sizes / count, found)
            left = [k for k in left if known[k] >= (1.0 - _HOPE * hope) * known.max() or k in (0, len(r) - 1)]
            sizes[list(rubs.keys() - set(left))] = -hope * np.inf
        for k in left:
            sizes[k] = rubs[k].greatest(parts[:, k], complex(phasor[k]))
        return np.where(quick_enough, sizes / count, found)

    def too_slow(self, speed: float, natural: float, radians: float) -> str:
        """Why a speed is not answered, and what to write; both [rad/s], the natural one as a speed.

        `radians` are those that are followed, of what vibrates on and on; 0 where only rounding hides it.
        """
        least = 1.01 * natural * (np.pi / radians if radians else LEAST)
        return (
            f"excitations.{self.shaken[0].name} at {show(speed, 'rpm', ROTATION)}: what rubs vibrates by itself "
            f'{natural / speed:.2g} times in a turn of it, more than is followed. Write speed = "0 rpm", where springs '
            f"and friction carry all, {show(least, 'rpm', ROTATION)} or more{', or more damping' if radians else ''}."
        )

    def _amplitude(self, speed: FloatArray) -> FloatArray:
        """Of the force [N] or the base [m]."""
        line = self.shaken[0].lines[0]
        return np.asarray(np.abs(line.amplitude.at(speed)) * np.abs(line.vector).max())

    def per(self, model: Model, x: FloatArray, speed: FloatArray) -> FloatArray:
        """By what a reading is divided: the mounts that share it, and the amplitude of what moves them."""
        from vibopt.mechanics.harmonic import mount_count

        return np.asarray(mount_count(model, self.output, x) * (self._amplitude(speed) if self.normalised else 1.0))

    def motion(self, model: Model, x: FloatArray, speed: float) -> tuple[Rub, float, tuple[FloatArray, complex]]:
        """The motion at a speed [rad/s], the force [N] that drives it, and what is read: parts and phasor."""
        from vibopt.mechanics.dry_friction import Rub

        own, push, (parts, phasor) = self._motions(model, x, np.array([speed]))
        return Rub(*(float(one[0]) for one in own)), float(push[0]), (parts[:, 0], complex(phasor[0]))

    def half_cycle(self, model: Model, x: FloatArray, speed: float) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Times [s] in half a cycle, the response at them and whether friction holds, (n,) each; (0,) without end."""
        rub, _, (parts, phasor) = self.motion(model, x, speed)
        found = [np.zeros((3, 0))]
        for piece in rub.half_cycle or ():
            tau = np.linspace(0.0, piece.length, max(3, round(TIMES * piece.length / np.pi)))
            turned = (phasor * np.exp(1j * (piece.begin + tau))).real
            found.append(
                np.array([piece.begin + tau, parts @ rub.at(piece, tau) + turned, tau * 0.0 + (piece.side == 0)])
            )
        theta, read, held = np.hstack(found)
        count = float(self.per(model, x, np.array(speed)))
        return theta / (speed * self.shaken[0].lines[0].order), read / count, held > 0.0

    def left_to_the_start(self, model: Model, x: FloatArray, speed: float) -> bool:
        """Whether what it began with swings on beside the motion."""
        rub = self.motion(model, x, speed)[0]
        order = 1.0 / rub.r if rub.r else 0.0
        if rub.ratio or not 1.5 < order < _ENDLESS or abs(order - round(order)) >= _DEGENERATE:
            return False
        return all(piece.side for piece in rub.half_cycle or ())

    def _motions(
        self, model: Model, x: FloatArray, speeds: FloatArray
    ) -> tuple[tuple[FloatArray, ...], FloatArray, tuple[FloatArray, ComplexArray]]:
        """As `motion` at speeds (n,), parts (3, n); a motion by its frequency, damping and friction.

        What slips is told beside a motion `along` with which nothing slips; friction is what all else leaves to it.
        """
        from vibopt.mechanics.harmonic import impedances
        from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS

        assert model.rubbing is not None
        line, p, name = self.shaken[0].lines[0], model.values(x), model.rubbing[0]
        omega, size = line.order * speeds, np.abs(line.amplitude.at(speeds))
        amplitude = np.where(np.isfinite(size), size, 0.0)
        own, across, signs = model.vectors[:, 0], model.links[name], self.output.signs
        along = np.append(-across[0] * (across[1:] @ line.vector[1:]), line.vector[1:])
        pulls = impedances(model, p, omega) * (model.vectors @ along)
        with np.errstate(divide="ignore", invalid="ignore"):
            push = amplitude * (line.vector[0] - pulls @ own)
            friction = friction_of(model, x) / np.abs(push)
        turn = np.exp(1j * np.angle(push))
        kinds = [model.kinds == kind for kind in (STIFFNESS, DAMPING, INERTIA)]
        stiffness, damping, mass = (float((p * own**2)[some].sum()) for some in kinds)
        natural = float(np.sqrt(stiffness / mass))
        grip = across[0] * grip_of(model, signs)
        left = p * own * (signs - grip * own)
        parts = np.array([np.full(speeds.shape, left[some].sum()) for some in kinds])
        parts[self.output.power] += float(self.output.row[0])
        parts *= np.abs(push) / stiffness * np.array([omega**0, omega, omega**2])
        swung = (self.output.row @ along) * (1j * omega) ** self.output.power + pulls @ signs
        r = omega / natural
        rub = r, np.full(r.shape, damping / (2.0 * mass * natural)), friction
        return rub, np.abs(push), (parts, (amplitude * swung + grip * push) / turn)


def _top(value: Callable[[FloatArray], FloatArray], low: float, high: float) -> tuple[float, float]:
    """Greatest of a function that is smooth, or smooth but for a bend, between two places, and where."""
    from scipy.optimize import minimize_scalar

    best = -np.inf, low
    for _ in range(_ROUNDS):
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        values = value(middle + half * _NODES)
        if not np.isfinite(values).all():
            break
        line = _INTO @ values
        turns = chebyshev.chebroots(chebyshev.chebder(line))
        inside = np.append(_NODES, turns.real[(np.abs(turns.imag) < _CLOSER) & (np.abs(turns.real) <= 1.0)])
        asked = np.array([inside[int(chebyshev.chebval(inside, line).argmax())], _ODD])
        there = value(middle + half * asked)
        seen = np.append(values, there), middle + half * np.append(_NODES, asked)
        i = int(seen[0].argmax())
        best = max(best, (float(seen[0][i]), float(seen[1][i])))
        if (np.abs(there - chebyshev.chebval(asked, line)) <= _SETTLED * np.abs(there)).all():
            return best
        low, high = max(low, best[1] - 2.0 * _CLOSER * half), min(high, best[1] + 2.0 * _CLOSER * half)
    found = minimize_scalar(
        lambda one: -float(value(np.array([one]))[0]), bounds=(low, high), method="bounded",
        options={"xatol": _LEFT * high},
    )  # fmt: skip
    return max(best, (-float(found.fun), float(found.x)))


def friction_of(model: Model, x: FloatArray) -> float:
    """Dry friction of the whole link [N]."""
    assert model.rubbing is not None
    return sum(
        force.scale * float(np.prod([x[i] ** power for i, power in force.exponents.items()]))
        for force in model.rubbing[1]
    )


def acting_with_friction(model: Model) -> FloatArray:
    """Exponents of all coefficients and of friction, (n, n_vars)."""
    assert model.rubbing is not None
    return np.vstack([model.exponents, *(force.row(model.n_vars) for force in model.rubbing[1])])


def grip_of(model: Model, signs: FloatArray) -> float:
    """Part of friction, against a stretch of the link, in what takes forces with such signs (n_terms,)."""
    assert model.rubbing is not None
    name = model.rubbing[0]
    owned = [term.owner == name and term.across for term in model.terms]
    return float(signs[owned][0])


def _looked_at(band: Band, naturals: FloatArray) -> FloatArray:
    """Speeds of a rough look at a band [rad/s], ascending; at rest and far below all natural frequencies none."""
    slow = _SLOW * min(float(naturals.min()), band.high)
    low = band.low if band.low >= slow else slow
    near = np.outer(naturals, _NEAR).ravel()
    rest = [band.low] if band.low == 0.0 else []
    inside = near[(near > low) & (near < band.high)]
    return np.unique(np.concatenate([rest, [band.low], np.geomspace(low, band.high, _EVEN), inside]))
