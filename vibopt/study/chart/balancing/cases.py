"""The questions of the chart of speed: built round their answers, or small enough to try every choice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.balancing.holes import hole_options
from vibopt.balancing.question import Question
from vibopt.forms import FloatArray
from vibopt.study.chart.balancing.built import BUILT, Asked, asked, least_squares, normal, plain, worst
from vibopt.study.chart.balancing.rotor_file import HOLES, WEIGHTS

SIZES, QUICK_SIZES = ((8, 2), (1000, 20), (5000, 8)), ((8, 2), (1000, 20))


def stock(*, quick: bool) -> list[Asked]:
    """Least squares and smallest worst residual at several sizes, then weights that exist."""
    found = []
    for n, p in QUICK_SIZES if quick else SIZES:
        found.append(asked(f"least squares, {n}x{p}", *least_squares(n, p), BUILT))
        found.append(asked(f"worst with caps, {n}x{p}", worst(n, p), 1.0, BUILT))
    return [*found, *shelf()]


def shelf() -> list[Asked]:
    """24 holes, five shelf weights and three planes: the smallest worst residual, and the least mass under limits."""
    rng = np.random.default_rng(1)
    options = hole_options(np.arange(HOLES) * 2 * np.pi / HOLES, np.array([1.0]), np.array(WEIGHTS))
    question = replace(
        plain(normal(rng, 8), normal(rng, 8, 3), "worst"),
        options=(options.unbalances,) * 3,
        option_masses=(options.masses,) * 3,
    )
    left, masses = every_choice(question, options.masses)
    best = float(left.min())
    limit = 1.1 * best
    lighter = replace(question, goal="correction", limits=np.full(8, limit))
    least = float(masses[left <= limit].min())
    words, size = f"all {left.size} choices tried", f"{HOLES} holes, {len(WEIGHTS)} weights, 3 planes"
    return [asked(f"worst, {size}", question, best, words), asked(f"least mass, {size}", lighter, least, words)]


def every_choice(question: Question, masses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Worst residual and mass of every choice in three planes with the same list, (n_options,) * 3."""
    effects = [
        np.outer(option, column)
        for option, column in zip(question.options, question.H.T, strict=True)
        if option is not None
    ]
    pair = effects[1][:, None, :] + effects[2][None, :, :]
    left = np.stack([np.abs(question.y0 + first + pair).max(axis=-1) for first in effects[0]])
    return left, masses[:, None, None] + masses[:, None] + masses
