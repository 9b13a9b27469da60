"""Random vibrating systems as matrices, as a model of rank-one terms, and their response in numpy: a second route."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath as mp
import numpy as np
from numpy.typing import NDArray

from vibopt.forms import Modulus
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model, Term
from vibopt.signals import Amplitude, Band, Drive, Line, Output, Piece

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shaken:
    """M, C, K and structural damping H, each (n, n); what is pushed and what is read, (n,)."""

    mass: Array
    damping: Array
    stiffness: Array
    hysteretic: Array
    push: Array
    row: Array
    power: int
    pieces: tuple[Piece, ...]
    order: float
    bands: tuple[Band, ...]

    def model(self) -> Model:
        """The same as terms."""
        kinds = (
            (INERTIA, self.mass),
            (DAMPING, self.damping),
            (STIFFNESS, self.stiffness),
            (HYSTERETIC, self.hysteretic),
        )
        terms = [
            Term(kind, vector, float(value), np.zeros(0), "", float(value))
            for kind, matrix in kinds
            for value, vector in zip(*_spectrum(matrix), strict=True)
            if value > 0.0
        ]
        return Model({}, len(self.push), tuple(terms))

    def form(self, model: Model) -> Modulus:
        """The question."""
        line = Line(self.order, self.push.astype(complex), Amplitude(self.pieces))
        output = Output(self.row, np.zeros(len(model.terms)), self.power)
        return Modulus(output, (Drive("shaker", (line,), self.bands),), "sum")

    def size(self, speeds: Array) -> Array:
        """Modulus at speeds (n,), assembled and solved one by one."""
        w = self.order * speeds
        whole = (
            self.stiffness
            + 1j * self.hysteretic
            - w[:, None, None] ** 2 * self.mass
            + 1j * w[:, None, None] * self.damping
        )
        scale = 1.0 / np.sqrt(np.abs(np.diagonal(whole, axis1=1, axis2=2)))
        right = (scale * self.push)[:, :, None].astype(complex)
        moved = np.linalg.solve(scale[:, :, None] * whole * scale[:, None, :], right)[:, :, 0] * scale
        return np.abs(moved @ self.row) * w**self.power * np.abs(self.amplitude(speeds))

    def amplitude(self, speeds: Array) -> Array:
        """Of the force."""
        value = np.zeros_like(speeds)
        for piece in reversed(self.pieces):
            here = speeds <= piece.band.high
            value[here] = (piece.constant + piece.slope * speeds[here]) * speeds[here] ** piece.power
        return value

    def poles(self) -> NDArray[np.complex128]:
        """Complex speeds of free motion."""
        n = len(self.push)
        inverse = np.linalg.inv(self.mass)
        state = np.block(
            [
                [np.zeros((n, n)), np.eye(n)],
                [-inverse @ (self.stiffness + 1j * self.hysteretic), -inverse @ self.damping],
            ]
        )
        return np.asarray(-1j * np.linalg.eigvals(state) / self.order, dtype=complex)

    def exactly(self, model: Model, speed: float) -> float:
        """Modulus at one speed from the terms of the model, in 40 digits."""
        with mp.workdps(40):
            w = mp.mpf(self.order) * mp.mpf(speed)
            factor = {INERTIA: -(w**2), STIFFNESS: mp.mpf(1), DAMPING: 1j * w, HYSTERETIC: mp.mpc(0, 1)}
            whole = mp.zeros(len(self.push))
            for term in model.terms:
                vector = mp.matrix(term.vector.tolist())
                whole += factor[term.kind] * mp.mpf(term.scale) * vector * vector.T
            moved = mp.lu_solve(whole, mp.matrix(self.push.tolist()))
            read = mp.fsum(mp.mpf(a) * b for a, b in zip(self.row.tolist(), moved, strict=True))
            return float(abs(read) * w**self.power * mp.mpf(float(abs(self.amplitude(np.array([speed]))[0]))))

    @property
    def doubt(self) -> float:
        """Part of a value that rounding of the matrices may change: much where stiff meets lightly damped."""
        poles = self.poles()
        lowest = np.abs(poles)[np.abs(poles) > 1e-6 * np.abs(poles).max()].min()
        light = (np.abs(poles.imag) / np.maximum(np.abs(poles), 1e-300)).min()
        return float(1e-15 * (np.abs(poles).max() / lowest) ** 2 / max(light, 1e-7))

    def sampled(self) -> tuple[float, float]:
        """The greatest of many samples, denser near the poles and again around the highest, and its speed."""
        found = (-1.0, 0.0)
        poles = self.poles()
        for band in self.bands:
            near = [pole.real + np.abs(pole.imag) * np.sinh(np.linspace(-6.0, 6.0, 241)) for pole in poles]
            speeds = np.concatenate([np.linspace(band.low, band.high, 2001), *near])
            speeds = np.unique(np.clip(speeds, band.low, band.high))
            values = self.size(speeds)
            for top in np.argsort(values)[-3:]:
                low, high = speeds[max(top - 1, 0)], speeds[min(top + 1, len(speeds) - 1)]
                for _ in range(4):
                    fine = np.linspace(low, high, 101)
                    sizes = self.size(fine)
                    best = int(sizes.argmax())
                    found = max(found, (float(sizes[best]), float(fine[best])))
                    low, high = fine[max(best - 1, 0)], fine[min(best + 1, 100)]
        return found


def _spectrum(matrix: Array) -> tuple[Array, Array]:
    values, vectors = np.linalg.eigh(matrix)
    return np.where(values > 1e-14 * np.abs(values).max(initial=0.0), values, 0.0), vectors.T


def shaken(seed: int) -> Shaken:
    """A random system: near and equal modes, any damping, any scale, rigid motion now and then."""
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 9))
    unit = 10.0 ** random.uniform(-6.0, 6.0)
    natural = 10.0 ** random.uniform(-1.0, 1.0, n)
    if random.random() < 0.3:
        natural[-1] = natural[0] * (1.0 + random.choice([0.0, 1e-9, 1e-6, 1e-3]))
    if n > 1 and random.random() < 0.15:
        natural[0] = 0.0
    ratio = 10.0 ** random.uniform(-6.0, np.log10(2.0), n if random.random() < 0.5 else 1)
    turn = np.linalg.qr(random.normal(size=(n, n)))[0]
    mix = turn if random.random() < 0.5 else np.linalg.qr(turn + 0.1 * random.normal(size=(n, n)))[0]
    size = 10.0 ** random.uniform(-1.0, 1.0, n) * 10.0 ** random.uniform(-6.0, 6.0)
    kind = random.choice(["dashpots", "rubber", "both"], p=[0.6, 0.25, 0.15])

    def whole(axes: Array, values: Array) -> Array:
        return np.asarray(size[:, None] * (axes * values) @ axes.T * size[None, :])

    damping = whole(mix, 2.0 * ratio * natural * unit) if kind != "rubber" else np.zeros((n, n))
    stiffness = whole(turn, (natural * unit) ** 2)
    hysteretic = np.zeros((n, n)) if kind == "dashpots" else 2.0 * float(ratio.min()) * stiffness
    order = float(random.choice([1.0, 2.0, 0.5]))
    bands = _bands(random, natural * unit / order, unit / order)
    top = max(band.high for band in bands)
    return Shaken(
        whole(np.eye(n), np.ones(n)),
        damping,
        0.5 * (stiffness + stiffness.T),
        0.5 * (hysteretic + hysteretic.T),
        random.normal(size=n) * size,
        random.normal(size=n) * size,
        int(random.integers(0, 3)),
        _pieces(random, top),
        order,
        bands,
    )


def _bands(random: np.random.Generator, natural: Array, unit: float) -> tuple[Band, ...]:
    """A wide range, one that begins or ends on a mode, a very narrow one, or two of them; rigid motion not at rest."""
    kind = random.integers(0, 5)
    mode = float(random.choice(natural[natural > 0.0]))
    if kind == 0:
        return (Band(0.0 if natural.all() else 0.01 * unit, 20.0 * unit),)
    if kind == 1:
        return (Band(mode, 3.0 * mode),)
    if kind == 2:
        return (Band(0.2 * mode, mode),)
    if kind == 3:
        return (Band(mode * 0.99, mode * (1.0 + 10.0 ** random.uniform(-9.0, -1.0))),)
    return (Band(0.3 * mode, 0.8 * mode), Band(0.9 * mode, 30.0 * unit))


def _pieces(random: np.random.Generator, top: float) -> tuple[Piece, ...]:
    """A force that is constant, grows with the speed or its square, or follows a table."""
    kind = random.integers(0, 4)
    if kind < 3:
        return (Piece(Band(0.0, np.inf), float(random.uniform(0.5, 2.0)), 0.0, int(kind)),)
    edges = np.concatenate([[0.0], np.sort(random.uniform(0.05, 0.95, 3)) * top, [1.01 * top]])
    sizes = random.uniform(0.2, 2.0, 5)
    slopes = np.diff(sizes) / np.diff(edges)
    parts = zip(edges[:-1].tolist(), edges[1:].tolist(), sizes[:-1].tolist(), slopes.tolist(), strict=True)
    return tuple(Piece(Band(low, high), start - slope * low, slope) for low, high, start, slope in parts)
