"""Whirl of a rotor whose bearings are not alike in both planes: forward and backward parts of one frequency.

The shaft couples them nowhere; bearings do, and they and all dampers reach few stretches.  So the shaft is said by its
undamped whirls, forward ones and backward ones, held by springs alike in both planes, and what is left of bearings and
dampers acts between these stretches.
"""

from __future__ import annotations

from contextlib import suppress
from itertools import pairwise
from typing import cast

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.bearings import Bearing
from vibopt.mechanics.growth import first_growth, states
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, factors, kept
from vibopt.mechanics.modes import free_matrices
from vibopt.records import cached_property
from vibopt.signals import Output

_NEAR, _NOTHING = 1e-6, 1e-30
"""How near a frequency may come to one of the undamped whirls, whose receptance then has too few digits."""
FARTHEST = 50.0
"""Spin over the lowest frequency at rest up to which growth is looked for where nothing says how far."""
_LOWEST, _FOLLOWED, _FEWEST, _FASTER = 12, 12, 6, 16.0
"""Undamped whirls of either sense by which singular speeds are looked for, and by which growth is; of these at least,
where whirls up to a frequency are looked for, and those up to so many times as fast as that."""
_STRAIGHT = 1e-3
"""Part of a motion by which one along a line goes round."""
_REAL, _AROUND, _STILL, _BENT = 1e-9, 0.05, 1e-12, 1e-8
"""Part of itself by which a speed without damping may lie off its axis, that by which it moves when solved in full,
the part of the longest period below which one is rounding, and that of the greatest bend below which one is another."""


class Spun:
    """A rotor at one design x (n_vars,); matrices over its free coordinates, (n, n)."""

    def __init__(self, model: Model, x: FloatArray) -> None:
        self.model, self.x, n = model, x, model.n_free
        p = self.p = model.values(x)
        forward, _, stiffness, _ = free_matrices(model, p)
        polar = np.array([term.polar for term in model.terms])
        self.polar = -model.matrix(INERTIA, np.where(polar, p, 0.0))[:n, :n]
        self.mass = forward + self.polar
        self._lossy = np.flatnonzero(np.isin(model.kinds, (DAMPING, HYSTERETIC)) & (p != 0.0))
        rotating = [(term.vector[:n], _size(term.scale, term.exponents, x)) for term in model.rotating]
        self._rotating = np.array([size for _, size in rotating])
        rows = [*model.vectors[self._lossy, :n], *(row for row, _ in rotating), *(b.row[:n] for b in model.bearings)]
        self.rows = np.array(rows).reshape(-1, n)
        self._reference = _reference(model, x)
        bearings = self.rows[len(self.rows) - len(self._reference) :]
        self.held = stiffness + (bearings.T * self._reference) @ bearings
        self._lines: dict[tuple[int, int], tuple[float, ComplexArray, ComplexArray]] = {}

    @cached_property
    def _whirls(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Of forward and of backward whirl with the spin 1 / w^2 (n,) and motions (n, n), as `held`."""

        def found(each: FloatArray) -> list[tuple[tuple[FloatArray, FloatArray], ...]]:
            root = self._root
            both = (np.linalg.eigh(root @ (self.mass - sense * self.polar) @ root.T) for sense in (1.0, -1.0))
            return [tuple((squares, root.T @ ways) for squares, ways in both)]

        return kept(self.model, "whirls in planes", self._held_by, found, most=4)[0]

    @cached_property
    def _lower(self) -> FloatArray:
        """L with L L^T = `held`, (n, n): of the roots of springs, which once added up round away the softer of them."""
        springs = self.model.kinds == STIFFNESS
        if (self.p[springs] < 0.0).any():
            return np.asarray(np.linalg.cholesky(self.held))
        bearings = self.rows[len(self.rows) - len(self._reference) :]
        each = np.concatenate([self.p[springs], self._reference])
        rows = np.sqrt(each)[:, None] * np.vstack([self.model.vectors[springs, : len(self.mass)], bearings])
        rows = rows[np.argsort(-np.linalg.norm(rows, axis=1), kind="stable")]  # the stiffest first keep all digits
        upper: FloatArray = np.linalg.qr(rows)[1]
        return upper.T

    @cached_property
    def _root(self) -> FloatArray:
        """Inverse of `_lower`, (n, n)."""
        return np.asarray(np.linalg.inv(self._lower))

    @property
    def _held_by(self) -> FloatArray:
        """What `held`, masses and gyroscopic moments hang on, (1, n): bearings of other numbers share their whirls."""
        return np.where(np.isin(self.model.kinds, (DAMPING, HYSTERETIC)), 0.0, self.p)[None]

    @cached_property
    def _bearings(self) -> list[tuple[IntArray, Bearing]]:
        """Where the stretch of each stands among forward and backward ones (2,), and the bearing."""
        r, begin = len(self.rows), len(self.rows) - len(self.model.bearings)
        return [(np.array([j, r + j]), bearing) for j, bearing in enumerate(self.model.bearings, start=begin)]

    @cached_property
    def _even(self) -> tuple[ComplexArray, ComplexArray]:
        """Stiffness beside `held` and damping of bearings that are the same at every spin, each (2 r, 2 r)."""
        still, moving = np.zeros((2, 2 * len(self.rows), 2 * len(self.rows)), dtype=complex)
        for (at, bearing), held in zip(self._bearings, self._reference, strict=True):
            still[at, at] = -held
            if not len(bearing.speeds):
                stiff, damp = bearing.whirling(self.x, np.zeros(()))
                still[at[:, None], at] += stiff
                moving[at[:, None], at] = damp
        return still, moving

    @cached_property
    def _tabled(self) -> list[tuple[IntArray, Bearing]]:
        """Those that change with the spin."""
        return [(at, bearing) for at, bearing in self._bearings if len(bearing.speeds)]

    def coupling(
        self, omega: ComplexArray | FloatArray, spin: FloatArray, turned: FloatArray | None = None
    ) -> ComplexArray:
        """What acts between the stretches beside `held`, at frequencies and spins (k,) [rad/s], (k, 2 r, 2 r).

        `turned` is the spin of dampers that turn with a shaft, where coefficients are those at another.
        """
        r, first = len(self.rows), len(self._lossy)
        found = np.zeros((len(spin), 2 * r, 2 * r), dtype=complex)
        turned = spin if turned is None else turned
        own = self._braked(omega)
        for begin, sense in ((0, 1.0), (r, -1.0)):
            at = np.arange(begin, begin + first)
            found[:, at, at] = own
            at = np.arange(begin + first, begin + first + len(self._rotating))
            found[:, at, at] = 1j * (omega - sense * turned)[:, None] * self._rotating
        still, moving = self._even
        found += still + 1j * omega[:, None, None] * moving
        for at, bearing in self._tabled:
            stiff, damp = bearing.whirling(self.x, spin)
            found[:, at[:, None], at] += stiff + 1j * omega[:, None, None] * damp
        return found

    def _braked(self, omega: ComplexArray | FloatArray) -> ComplexArray:
        """What dampers at rest act by, (k, n_lossy)."""
        return self.p[self._lossy] * factors(self.model.kinds[self._lossy], cast("FloatArray", omega))

    def seen(self, lines: FloatArray, load: ComplexArray, omega: ComplexArray | FloatArray) -> ComplexArray:
        """Forward and backward motion of lines (m, n) under a force that goes round with the spin, (2, k, m).

        `load` (n,) is the force per unit, `omega` (k,) the speed [rad/s].
        """
        alike = not self.model.bearings and np.isrealobj(omega)  # nothing goes backward, and what turns does nothing
        acting, whirls = (self.rows[: len(self._lossy)], self._whirls[:1]) if alike else (self.rows, self._whirls)
        r, both = len(acting), len(whirls) * len(acting)
        reads, flexible, gains, moved = [], np.zeros((len(omega), both, both), dtype=complex), [], []
        for begin, (squares, ways) in zip((0, r), whirls, strict=False):
            left = 1.0 - omega[:, None] ** 2 * squares
            gain = 1.0 / np.where(left == 0.0, _NOTHING, left)
            rows, here = acting @ ways, slice(begin, begin + r)
            flexible[:, here, here] = (rows * gain[:, None, :]) @ rows.T
            reads.append((lines @ ways) * gain[:, None, :])
            gains.append(gain)
            moved.append(rows)
        pushed = self._whirls[0][1].T @ load
        acts = self._braked(omega)[:, None] * np.eye(r) if alike else self.coupling(omega, np.real(omega))
        still = np.zeros((len(omega), both), dtype=complex)
        still[:, :r] = (gains[0] * pushed) @ moved[0].T
        stretch = _solved(np.eye(both) + flexible @ acts, still)
        back = (acts @ stretch[..., None])[..., 0]
        forward = reads[0] @ pushed - np.einsum("kmn,rn,kr->km", reads[0], moved[0], back[:, :r])
        backward = -np.einsum("kmn,rn,kr->km", reads[-1], moved[-1], back[:, r:]) if not alike else 0.0 * forward
        found = np.stack([forward, backward])
        close = np.flatnonzero(np.min([np.abs(1.0 / gain).min(axis=1) for gain in gains], axis=0) < _NEAR)
        for k in close:
            found[:, k] = self._direct(lines, load, omega[k])
        return found

    def dynamic(self, omega: complex, spin: float) -> ComplexArray:
        """Dynamic stiffness over forward and backward whirl, (2 n, 2 n)."""
        return self._resistance((self.held, self.mass, self.polar, self._both), omega, spin)

    def _resistance(self, parts: tuple[FloatArray, ...], omega: complex, spin: float) -> ComplexArray:
        """Dynamic stiffness of `held`, mass, polar (n, n) and the rows of stretches (2 r, 2 n) in some coordinates."""
        held, mass, polar, rows = parts
        n = len(mass)
        found = np.zeros((2 * n, 2 * n), dtype=complex)
        for begin, sense in ((0, 1.0), (n, -1.0)):
            here = slice(begin, begin + n)
            found[here, here] = held - omega**2 * mass + sense * omega * spin * polar
        return np.asarray(found + rows.T @ self.coupling(np.array([omega]), np.array([spin]))[0] @ rows)

    def balanced(self, omega: complex, spin: float) -> ComplexArray:
        """Forces f (2 n,) with f^T D = 0 of the resistance to a free whirl, which is singular."""
        root = np.sqrt(np.tile(np.diag(self.held), 2))
        return np.asarray(np.linalg.svd(self.dynamic(omega, spin) / self._scale)[0][:, -1].conj() / root)

    @cached_property
    def _both(self) -> FloatArray:
        return np.kron(np.eye(2), self.rows)

    def _direct(self, lines: FloatArray, load: ComplexArray, omega: complex) -> ComplexArray:
        whole = np.concatenate([load, np.zeros(len(load))]).astype(complex)
        motion = _solved(self.dynamic(omega, float(np.real(omega)))[None], whole[None])[0]
        return np.stack([lines @ half for half in np.split(motion, 2)])

    def reading(self, output: Output, load: ComplexArray, omega: FloatArray) -> ComplexArray:
        """Forward and backward part of what an output reads, without its power, (2, k)."""
        model, n = self.model, self.model.n_free
        taken = np.flatnonzero(output.signs)
        pulled = dict(output.held)
        bearings = [one for one in model.bearings if pulled.get(one.name)]
        turning = [one for one in model.rotating if pulled.get(one.owner)]
        lines = np.array([
            output.row[:n], *model.vectors[taken, :n], *(b.row[:n] for b in bearings), *(t.vector[:n] for t in turning)
        ])  # fmt: skip
        seen = self.seen(lines, load, omega)
        value = seen[..., 0].copy()
        shares = output.signs[taken] * self.p[taken] * factors(model.kinds[taken], omega)
        polar = np.array([model.terms[t].polar for t in taken], dtype=bool)
        for plane, each in enumerate((shares, np.where(polar, -shares, shares))):
            value[plane] += (each * seen[plane][:, 1 : 1 + len(taken)]).sum(axis=-1)
        for j, one in enumerate(bearings, start=1 + len(taken)):
            stiff, damp = one.whirling(self.x, omega)
            force = (stiff + 1j * omega[:, None, None] * damp) @ np.moveaxis(seen[..., j], 0, -1)[..., None]
            value += pulled[one.name] * np.moveaxis(force[..., 0], -1, 0)
        for j, term in enumerate(turning, start=1 + len(taken) + len(bearings)):
            size = _size(term.scale, term.exponents, self.x)
            value[1] += pulled[term.owner] * 2j * omega * size * seen[1, :, j]  # with the spin it feels nothing
        return value

    def singular(self, spins: FloatArray) -> ComplexArray:
        """Complex speeds [rad/s] near which the response to an unbalance has no end, coefficients as at each spin."""
        both, r = [(squares[-_LOWEST:], ways[:, -_LOWEST:]) for squares, ways in self._whirls], len(self.rows)
        squares = np.concatenate([one for one, _ in both])
        rows, few = np.zeros((2 * r, len(squares))), len(squares) // 2
        for k, (_, ways) in enumerate(both):
            rows[k * r : (k + 1) * r, k * few : (k + 1) * few] = self.rows @ ways
        found = []
        for spin in spins.tolist():
            at, none, one = np.array([spin]), np.zeros(1), np.ones(1)
            still = self.coupling(none, at, none)[0]
            fast = self.coupling(one, at, one)[0] - still
            found.append(roots(-np.diag(squares), rows.T @ fast @ rows, np.eye(len(squares)) + rows.T @ still @ rows))
        near = np.concatenate(found)
        real = (np.abs(near.imag) <= _REAL * np.abs(near)) & (near.real > 0.0) & (near.real <= 1.1 * spins.max())
        near[real] = [self._met(float(one)) for one in near[real].real]
        return near

    def _met(self, at: float) -> float:
        """The speed near one [rad/s] at which some undamped motion is resisted no more, to all digits."""

        def least(omega: float) -> float:
            values = np.linalg.eigvals(self.dynamic(omega, abs(omega)) / self._scale)
            return float(values[np.abs(values).argmin()].real)

        before, here = at * (1.0 + 1e-6), at
        low = least(before)
        for _ in range(12):
            high = least(here)
            if high == low or abs(here - before) <= 1e-15 * abs(here):
                break
            before, here, low = here, here - high * (here - before) / (high - low), high
        return here if abs(here - at) <= _AROUND * abs(at) else at

    @cached_property
    def _at_rest(self) -> tuple[FloatArray, FloatArray]:
        """Squares of frequencies at rest, as `held` (m,) [rad^2/s^2], and motions of unit mass (n, m).

        The `_FOLLOWED` lowest, and behind them by what else bearings and dampers bend the shaft at rest.
        """

        def found(each: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
            root = self._root
            periods, ways = np.linalg.eigh(root @ self.mass @ root.T)
            told = np.argsort(-periods)[: int((periods > _STILL * periods.max()).sum())]
            squares, shapes = 1.0 / periods[told], (root.T @ ways[:, told]) / np.sqrt(periods[told])
            above, rest = squares[_FOLLOWED:], shapes[:, _FOLLOWED:]
            bent, sizes, _ = np.linalg.svd((self.rows @ rest / above).T, full_matrices=False)
            bent = bent[:, sizes > _BENT * sizes.max(initial=0.0)]
            more, turned = np.linalg.eigh((bent.T * above) @ bent)
            lowest = np.append(squares[:_FOLLOWED], more), np.hstack([shapes[:, :_FOLLOWED], rest @ bent @ turned])
            return [lowest]

        return kept(self.model, "rest in planes", self._held_by, found, most=4)[0]

    def rates(self, spin: float, few: int = _FOLLOWED) -> ComplexArray:
        """Of states of the `few` lowest free motions of either sense at a spin [rad/s]; straight between rows."""
        piece = max(int(np.searchsorted(self.knots[:-1], spin)) - 1, 0)
        if (piece, few) not in self._lines:
            low, high = self.knots[piece : piece + 2] if len(self.knots) else (0.0, self.slowest)
            first = self._rates(low, few)
            self._lines[piece, few] = low, first, (self._rates(high, few) - first) / (high - low)
        low, first, slope = self._lines[piece, few]
        return first + (spin - low) * slope

    def _rates(self, spin: float, few: int) -> ComplexArray:
        squares, shapes = self._at_rest[0][:few], self._at_rest[1][:, :few]
        rows, turned = np.kron(np.eye(2), self.rows @ shapes), spin * (shapes.T @ self.polar @ shapes)
        at, none, one = np.array([spin]), np.zeros(1), np.ones(1)
        still = self.coupling(none, at)[0]
        damping = -1j * (rows.T @ (self.coupling(one, at)[0] - still) @ rows)
        damping += np.kron(np.diag([-1j, 1j]), turned)
        lossy = np.add.outer([0, len(self.rows)], np.arange(len(self._lossy)))
        still[lossy, lossy] = 0.0  # a loss factor speaks of steady motion alone, and dampers have nothing at rest
        return states(np.tile(squares, 2), damping, rows.T @ still @ rows)

    def enough(self, top: float) -> int:
        """How many of the lowest motions at rest tell about where the free whirls up to a frequency [rad/s] are."""
        lowest = self._at_rest[0][:_FOLLOWED]
        return max(_FEWEST, int((lowest <= (_FASTER * top) ** 2).sum())) if top else _FOLLOWED

    @property
    def slowest(self) -> float:
        """Lowest frequency at rest [rad/s]."""
        return float(np.sqrt(self._at_rest[0].min()))

    def motions(self, ways: ComplexArray) -> ComplexArray:
        """Forward and backward motion (2 n, k) of states (4 few, k) of the `few` lowest free motions."""
        half = ways[: len(ways) // 2]
        shapes = (self._at_rest[1] / np.sqrt(self._at_rest[0]))[:, : len(half) // 2]
        return np.concatenate([shapes @ each for each in np.split(half, 2)])

    def powers(self, spin: float) -> tuple[ComplexArray, FloatArray]:
        """What the dynamic stiffness at a spin has in the frequency and in its square, each (2 n, 2 n)."""
        first = 0.5 * (self.dynamic(1.0, spin) - self.dynamic(-1.0, spin))
        return first, np.asarray(-np.kron(np.eye(2), self.mass))

    def undamped_ways(self) -> tuple[FloatArray, ComplexArray] | None:
        """Squares of speeds at which a whirl is free as fast as it spins, ascending, (m,), and its motions (2 n, m).

        Where nothing damps or changes with the spin and springs have a potential, K - w^2 (M - s P) of forward whirl, s
        = 1, and of backward whirl, s = -1, coupled by bearings, are one Hermitian problem; else None.
        """
        still, moving = (self.coupling(at * np.ones(1), np.zeros(1))[0] for at in (0.0, 1.0))
        if self._tabled or (still != moving).any() or not np.allclose(still, still.conj().T, 1e-12, 0.0):
            return None
        root, n = np.kron(np.eye(2), self._root), len(self.mass)
        rows, whirls = self._both @ root.T, (self.mass - self.polar, self.mass + self.polar)
        stiffness = np.eye(2 * n) + rows.T @ still @ rows
        inertia = root @ np.block([[whirls[0], np.zeros((n, n))], [np.zeros((n, n)), whirls[1]]]) @ root.T
        try:
            turned = np.linalg.inv(np.linalg.cholesky(0.5 * (stiffness + stiffness.conj().T)))
        except np.linalg.LinAlgError:  # springs that push
            return None
        periods, ways = np.linalg.eigh(turned @ inertia @ turned.conj().T)
        told = np.argsort(-periods)[: int((periods > _STILL * periods.max()).sum())]
        return 1.0 / periods[told], root.T @ turned.conj().T @ ways[:, told]

    def sense(self, way: ComplexArray) -> float:
        """Of a motion (2 n,): 1 with the spin, -1 against it, by the greater mass; 0 along a line."""
        ahead, against = (float(np.vdot(one, self.mass @ one).real) for one in np.split(way, 2))
        return 0.0 if abs(ahead - against) <= _STRAIGHT * (ahead + against) else float(np.sign(ahead - against))

    @cached_property
    def knots(self) -> FloatArray:
        """Speeds of the rows of all tables [rad/s], ascending; those within the ends of each."""
        tables = [bearing.speeds for bearing in self.model.bearings if len(bearing.speeds)]
        if not tables:
            return np.zeros(0)
        every = np.unique(np.concatenate(tables))
        inside = (every >= max(table[0] for table in tables)) & (every <= min(table[-1] for table in tables))
        return np.asarray(every[inside])

    def threshold(self, top: float = 0.0) -> float:
        """Least spin [rad/s] beyond which a whirl grows, up to `top` and as far as tables go; infinite where none does.

        Without a `top` it is looked for up to `FARTHEST` times the lowest frequency at rest.
        """
        unit = self.slowest
        top = top or FARTHEST * unit
        knots = self.knots if len(self.knots) else np.array([0.0, top])
        knots = np.unique(np.append(knots[knots < top], min(top, knots[-1])))
        idle = [self._idle(knot) for knot in knots.tolist()]
        for (low, high), both in zip(pairwise(knots.tolist()), pairwise(idle), strict=True):
            if all(both):  # so it is between them, as coefficients are straight there
                continue
            first, last = (self.rates(end, len(self._at_rest[0])) for end in (low, high))
            slope = (last - first) / (high - low)
            value = first_growth(first - low * slope, slope, low, high, unit)
            if value is not None:
                return self._neutral(value) if value > low else value
        return float("inf")

    def _idle(self, spin: float) -> bool:
        """Whether nothing can feed a whirl at a spin [rad/s]: springs pull back and have a potential, no damper pushes.

        Gyroscopic moments do no work (Kelvin, Tait and Chetaev), and no energy that falls lets a whirl grow.
        """
        if self._rotating.any() or (self.p[np.isin(self.model.kinds, (STIFFNESS, DAMPING))] < 0.0).any():
            return False
        eight = np.array([one.coefficients(self.x, np.array(spin)) for one in self.model.bearings]).reshape(-1, 2, 2, 2)
        (yy, yz), (zy, zz) = np.moveaxis(eight, (2, 3), (0, 1))  # (n_bearings, 2) each: stiffness and damping
        turns = (yz[:, 0] != zy[:, 0]).any()
        return not turns and bool(np.all((yy >= 0.0) & (zz >= 0.0) & (yy * zz >= 0.25 * (yz + zy) ** 2)))

    def _neutral(self, spin: float) -> float:
        """The spin near one at which a whirl neither grows nor fades, in all coordinates.

        They are turned so that `held` is one: its stiffest parts would round away what resists the whirl, and the spin
        would not settle.
        """
        rates, ways = np.linalg.eig(self.rates(spin, len(self._at_rest[0])))  # as many as told that it grows
        which = int(rates.real.argmax())
        whirl, n = float(rates[which].imag), len(self.mass)
        mass, polar = (self._root @ one @ self._root.T for one in (self.mass, self.polar))
        parts = np.eye(n), mass, polar, np.asarray(np.kron(np.eye(2), self.rows @ self._root.T), dtype=float)
        force = np.kron(np.eye(2), self._lower.T) @ self.motions(ways[:, which])
        read = force.conj()

        def resists(at: FloatArray) -> complex:
            return complex(1.0 / (read @ np.linalg.solve(self._resistance(parts, at[0], float(at[1])), force)))

        here = np.array([whirl, spin])
        for _ in range(20):
            steps = 1e-6 * np.abs(here)
            slopes = [(resists(here + move) - resists(here - move)) / (2.0 * move.sum()) for move in np.diag(steps)]
            value = resists(here)
            table = [[slope.real for slope in slopes], [slope.imag for slope in slopes]]
            step = np.linalg.solve(table, [-value.real, -value.imag])
            here = here + step
            if np.all(np.abs(step) <= 1e-13 * np.abs(here)):
                break
        return float(here[1])

    @cached_property
    def _scale(self) -> FloatArray:
        root = np.sqrt(np.tile(np.diag(self.held), 2))
        return np.asarray(np.outer(root, root))


class Half(Spun):
    """Whirl of a rotor with the spin (1) or against it (-1) alone, where no bearing couples both: of half the size."""

    def __init__(self, whole: Spun, sense: float) -> None:
        self.__dict__.update(whole.__dict__)
        self.whole, self.known, n = whole, sense, len(whole.mass)
        self._here = slice(0, n) if sense > 0.0 else slice(n, 2 * n)

    def dynamic(self, omega: complex, spin: float) -> ComplexArray:
        return self.whole.dynamic(omega, spin)[self._here, self._here]

    def rates(self, spin: float, few: int = _FOLLOWED) -> ComplexArray:
        rates = self.whole.rates(spin, few)
        own = np.arange(len(rates)).reshape(2, 2, -1)[:, int(self._here.start > 0)].ravel()
        return rates[np.ix_(own, own)]

    def motions(self, ways: ComplexArray) -> ComplexArray:
        few = len(ways) // 2
        return np.asarray((self._at_rest[1] / np.sqrt(self._at_rest[0]))[:, :few] @ ways[:few])

    def powers(self, spin: float) -> tuple[ComplexArray, FloatArray]:
        first, second = self.whole.powers(spin)
        return first[self._here, self._here], second[self._here, self._here]

    def sense(self, way: ComplexArray) -> float:
        return self.known


def _reference(model: Model, x: FloatArray) -> FloatArray:
    """Stiffness alike in both planes by which each bearing holds the shaft whose whirls are taken, (n_bearings,) [N/m].

    Any will do: that of the first design that is asked for.
    """
    known: dict[str, FloatArray] = vars(model)
    if "held alike" not in known:
        middle = [np.mean(bearing.speeds) if len(bearing.speeds) else 0.0 for bearing in model.bearings]
        eight = [bearing.coefficients(x, np.array(at)) for bearing, at in zip(model.bearings, middle, strict=True)]
        known["held alike"] = np.array([max(0.5 * float(one[0] + one[3]), 0.0) for one in eight])
    return known["held alike"]


def spun(model: Model, x: FloatArray) -> Spun:
    """The rotor at a design; those of the last designs are kept."""
    return kept(
        model, "spun", np.asarray(x, dtype=float)[None], lambda each: [Spun(model, one) for one in each], most=8
    )[0]


def roots(second: FloatArray, first: ComplexArray, zero: ComplexArray) -> ComplexArray:
    """Frequencies w with det(zero + w first + w^2 second) = 0, of a zero that is not singular: by those of 1 / w."""
    n = len(zero)
    unit = float(np.sqrt(1.0 / np.abs(second).max()))
    still = np.linalg.solve(zero, np.hstack([-second * unit**2, -first * unit]))
    state = np.block([[np.zeros((n, n)), np.eye(n)], [still]])
    inverse = np.linalg.eigvals(state)
    return np.asarray(unit / inverse[np.abs(inverse) > _STILL * np.abs(inverse).max()], dtype=complex)


def _size(scale: float, powers: FloatArray, x: FloatArray) -> float:
    return scale * float(np.where(powers == 0.0, 1.0, np.asarray(x) ** powers).prod())


def _solved(matrix: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Solve each system (k, n, n) for its right side (k, n); a singular one gives inf."""
    try:
        return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0], dtype=complex)
    except np.linalg.LinAlgError:
        found = np.full(right.shape, np.inf, dtype=complex)
        for k, (one, load) in enumerate(zip(matrix, right, strict=True)):
            with suppress(np.linalg.LinAlgError):
                found[k] = np.linalg.solve(one, load)
        return found
