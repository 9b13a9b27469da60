"""The engine turned in time: pistons where the geometry puts them, accelerations by a Fourier transform.

Neither the cosine series nor the arms of the orders are used, so this judges both.
"""

from __future__ import annotations

import numpy as np

from vibopt.balancing.engine.job import EngineJob
from vibopt.balancing.engine.shaking import carried_shares, free_shares, free_weights
from vibopt.balancing.engine.solve import Balanced
from vibopt.forms import ComplexArray, FloatArray

STEPS = 4096


def simulated(job: EngineJob, found: Balanced, couple: bool) -> float:
    """Greatest shaking force [N] (couple [N m]) over one turn of the simulated engine."""
    turn = np.arange(STEPS) * 2.0 * np.pi / STEPS
    total = np.zeros(STEPS, dtype=complex)
    shares = carried_shares(job, found.x)
    for one in job.cylinders:
        lever = one.at if couple else 1.0
        crank = turn + found.cranks[one.throw]
        along = -one.reciprocating * job.speed**2 * _second_derivative(_piston(crank - one.bank, job.ratio))
        opposite = sum(part * share.of(one) for share, part in zip(job.shares, shares, strict=True))
        carried = one.rotating - opposite
        total += lever * (along * np.exp(1j * one.bank) + carried * job.speed**2 * np.exp(1j * crank))
    free, first = free_weights(job), len(free_shares(job))
    for k, weight in enumerate(job.weights):
        u = weight.fixed
        if u is None:
            at = first + 2 * free.index(k)
            u = complex(*found.x[at : at + 2])
        lever = weight.at if couple else 1.0
        path = u * np.exp(1j * weight.sense * weight.order * turn)
        total += lever * -_second_derivative(path.real) * job.speed**2
        total += 1j * lever * -_second_derivative(path.imag) * job.speed**2
    return float(np.abs(total).max())


def _piston(crank: FloatArray, ratio: float) -> FloatArray:
    """Distance of the piston from the crank axis in crank radii."""
    return np.asarray(np.cos(crank) + np.sqrt(1.0 - (ratio * np.sin(crank)) ** 2) / ratio)


def _second_derivative(path: FloatArray) -> FloatArray:
    """d²/da² of a function of the crank angle given over one turn."""
    orders = np.fft.rfftfreq(len(path), 1.0 / len(path))
    spectrum: ComplexArray = np.fft.rfft(path)
    return np.asarray(np.fft.irfft(-(orders**2) * spectrum, len(path)))


__all__ = ["simulated"]
