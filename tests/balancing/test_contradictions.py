"""Runs that contradict each other: the odd one is left out, or it is said that nobody can tell; bands hold what is true."""

from __future__ import annotations

import cmath
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
import pytest

from rotor_jobs import FAN, polar, read_text, solve_text
from vibopt.balancing.contradictions import Heard, heard, held_bands
from vibopt.balancing.influence import leverage
from vibopt.balancing.job import RotorJob
from vibopt.balancing.pose import pose
from vibopt.balancing.prices import solve_question
from vibopt.forms import ComplexArray, FloatArray

SIGMA = 1e-6


@dataclass(frozen=True)
class Case:
    """A rotor as it is, and a job on it with scatter and perhaps one bad run."""

    y0: ComplexArray
    H: ComplexArray
    job: RotorJob
    bad: int | None


def text_of(planes: int, sensors: int, runs: int, given: bool) -> str:
    lines = ['title = "law"', 'speed = "1500 rpm"', "[conventions]", 'phase = "lead"', 'readings = "phase"']
    lines += ['angles = "with rotation"', 'detector = "pk"', 'zero = "mark"']
    lines += [f'[planes.p{k}]\nradius = "100 mm"' for k in range(planes)]
    for run in range(runs):
        weights = ", ".join(f'p{k} = "{7 + run + k} g @ {(60 * run + 100 * k) % 360} deg"' for k in range(planes)) if run else ""
        readings = ", ".join(f's{k} = "{10 + run + k} µm @ {40 * run * k % 360} deg"' for k in range(sensors))
        lines.append(f"[[runs]]\nweights = {{ {weights} }}\nreadings = {{ {readings} }}")
    return "\n".join([*lines, '[scatter]\namplitude = "1 µm"\n' if given else ""])


def blank(planes: int, sensors: int, spare: int, given: bool) -> RotorJob:
    return read_text(text_of(planes, sensors, planes + 1 + spare, given))


def case(template: RotorJob, dice: np.random.Generator, spare: int, sigmas: float = 0.0) -> Case:
    """A random rotor measured with SIGMA of scatter; one run, every sensor, off by so many of it."""
    planes, sensors = len(template.planes), len(template.sensors)

    def phasors(low: float, high: float, *shape: int) -> ComplexArray:
        return dice.uniform(low, high, shape) * np.exp(2j * np.pi * dice.random(shape))

    y0, H = phasors(1e-5, 1e-4, sensors), phasors(1e-2, 4e-2, sensors, planes)
    W = np.concatenate([np.zeros((1, planes)), np.diag(phasors(5e-4, 2e-3, planes)), phasors(5e-4, 2e-3, spare, planes)])
    noise = dice.standard_normal((2, len(W), sensors))
    Y = y0 + W @ H.T + SIGMA * (noise[0] + 1j * noise[1])
    bad = int(dice.integers(len(W))) if sigmas else None
    if bad is not None:
        Y[bad] += sigmas * SIGMA * np.exp(2j * np.pi * dice.random(sensors))
    runs = tuple(replace(run, weights=w, readings=y) for run, w, y in zip(template.runs, W, Y, strict=True))
    return Case(y0, H, replace(template, runs=runs), bad)


def planned(one: Case) -> tuple[Heard, ComplexArray, FloatArray]:
    """The plan and its bands."""
    of = heard(one.job)
    u = solve_question(pose(of.job, of.identified, of.noise).question).u
    assert u is not None
    ends = held_bands(of, u)
    assert ends is not None
    return of, u, ends


def inside(one: Case, u: ComplexArray, ends: FloatArray) -> float:
    """Part of the sensors whose true residual lies in its band."""
    left = np.abs(one.y0 + one.H @ u)
    return float(((ends[:, 0] <= left) & (left <= ends[:, 1])).mean())


def least(claimed: float, many: int) -> float:
    """What a share of so many independent trials falls short of once in a thousand."""
    return claimed - 3.1 * float(np.sqrt(claimed * (1.0 - claimed) / many))
