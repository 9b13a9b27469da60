"""Mean square under a base whose displacement is white noise.

With v = x' + M^-1 C_b u the derivative of the base's motion u drops out of the equations of motion, and the noise
drives a plain state x' = A x + B u.  A reading y = c x + d u is finite where d is nothing; each derivative of it is
c A x + c B u + d u', finite as long as that holds again.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.signals import Noise, Output

Numbers = np.ndarray[Any, np.dtype[Any]]
_NOTHING = 1e-11
"""Part of its own size below which a share of the noise that is read at once is rounding."""
_STILL = 1e-10
"""Part of the fastest rate below which a motion is not held by any spring."""
_LASTS = 1e-12
"""Damping ratio below which a motion counts as one that does not die away."""
_RESIDUE = 1e-9


def states(model: Model, noise: Noise, p: Numbers) -> tuple[Numbers, Numbers]:
    """A (2n, 2n) and B (2n,) at coefficients p (n_terms,), real or complex."""
    n, vectors = model.n_free, model.vectors
    pulled = vectors[:, n:] @ noise.vector[n:]
    mass, damping, stiffness = (
        (vectors[:, :n].T * (p * (model.kinds == kind))) @ vectors[:, :n] for kind in (INERTIA, DAMPING, STIFFNESS)
    )
    dash, spring = (vectors[:, :n].T @ (p * (model.kinds == kind) * pulled) for kind in (DAMPING, STIFFNESS))
    inverse = np.linalg.inv(mass)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    first = -inverse @ dash
    return a, np.concatenate([first, -inverse @ (spring + damping @ first)])


def reading(model: Model, output: Output, noise: Noise, p: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """c (2n,) per state, and the parts (2,) read at once per noise and per its derivative, each with its size (2,)."""
    n, vectors = model.n_free, model.vectors
    pulled = vectors[:, n:] @ noise.vector[n:]
    weight = output.signs * p
    springs, dampers = weight * (model.kinds == STIFFNESS), weight * (model.kinds == DAMPING)
    c = np.concatenate([output.row[:n] + springs @ vectors[:, :n], dampers @ vectors[:, :n]])
    direct = [output.row[n:] @ noise.vector[n:] + springs @ pulled, dampers @ pulled]
    size = [np.abs(output.row[n:]).sum() + np.abs(springs * pulled).sum(), np.abs(dampers * pulled).sum()]
    return c, np.array(direct), np.array(size)


def reduced(model: Model, output: Output, noise: Noise, p: Numbers) -> tuple[Numbers, Numbers, Numbers] | None:
    """A, B, c of the reading, its derivatives taken; None where some of the noise is read at once."""
    n = model.n_free
    a, b = states(model, noise, p)
    c, direct, size = reading(model, output, noise, p)
    if abs(direct[1]) > _NOTHING * size[1]:
        return None
    through = c[n:] @ b[:n]  # of the rates themselves: x' = v + B_1 u
    if abs(direct[0] + through) > _NOTHING * (size[0] + np.abs(c[n:] * b[:n]).sum()):
        return None
    for _ in range(output.power):
        if abs(c @ b) > _NOTHING * np.abs(c * b).sum():
            return None
        c = a.T @ c
    return a, b, c


def decaying(a: Numbers, b: Numbers, c: Numbers) -> tuple[Numbers, Numbers, Numbers] | None:
    """The states that die away; None where one that does not is both shaken and seen."""
    from scipy.linalg import schur

    rates = np.linalg.eigvals(a).astype(complex)
    top = float(np.abs(rates).max(initial=0.0))

    def lasts(rate: Any) -> bool:
        return bool(abs(rate) <= _STILL * top or rate.real > -_LASTS * abs(rate))

    if not any(map(lasts, rates)):
        return a, b, c
    sorted_by: Any = schur  # its stubs know no function of a complex number
    form, turn, count = sorted_by(a.astype(complex), output="complex", sort=lasts)
    load, row = turn.conj().T @ b, c @ turn
    if np.abs(row[:count]).max(initial=0.0) <= _RESIDUE * np.linalg.norm(np.abs(c) @ np.abs(turn)):
        return form[count:, count:], load[count:], row[count:]
    form, turn, count = sorted_by(a.astype(complex), output="complex", sort=lambda rate: not lasts(rate))
    load, row = turn.conj().T @ b, c @ turn
    if np.abs(load[count:]).max(initial=0.0) > _RESIDUE * np.linalg.norm(np.abs(turn.conj().T) @ np.abs(b)):
        return None
    return form[:count, :count], load[:count], row[:count]


__all__ = ["decaying", "reduced"]
