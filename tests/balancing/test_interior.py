"""The interior-point method within discs: its answers keep every bound, and their pulls prove that none is better."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing import interior
from vibopt.balancing.interior import least_within

Rows = tuple[ComplexArray, ComplexArray]


def discs(seed: int, n: int, many: int, n_limits: int) -> tuple[Rows, Rows, FloatArray]:
    """Goal rows, limits that some point keeps, and caps of which some bind and some are none."""
    dice = np.random.default_rng(seed)
    G, F = (dice.normal(size=(rows, n)) + 1j * dice.normal(size=(rows, n)) for rows in (many, n_limits))
    g = dice.normal(size=many) + 1j * dice.normal(size=many)
    best = np.linalg.lstsq(G, -g, rcond=None)[0]
    caps = np.abs(best) * dice.uniform(0.3, 1.5, n)
    caps[dice.random(n) < 0.3] = np.inf
    there = 0.9 * best * np.minimum(caps / np.abs(best), 1.0)
    f = 0.9 * np.exp(2j * np.pi * dice.random(n_limits)) - F @ there
    return (G, g), (F, f), caps


@pytest.mark.parametrize("worst", [False, True])
@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6), n=st.integers(1, 8), spare=st.integers(2, 40), n_limits=st.integers(0, 12),
)  # fmt: skip
def test_pulls_of_rows_that_hold_balance_each_other(worst: bool, seed: int, n: int, spare: int, n_limits: int) -> None:
    """Conditions that no better point within the discs allows (Karush, Kuhn and Tucker), from the arrays alone."""
    (G, g), (F, f), caps = discs(seed, n, 2 * n + spare, n_limits)
    found = least_within(G, g, F, f, caps, worst=worst)
    if found is None:  # it did not settle, and says so
        return
    x, z, v = found
    left, held = G @ x + g, F @ x + f
    assert (np.abs(held) <= 1.0 + 1e-9).all()
    assert (np.abs(x) <= caps * (1.0 + 1e-9)).all()
    for pulls, along in ((z, left), (v, held)):  # outward
        assert np.abs(pulls * along.conj() - np.abs(pulls) * np.abs(along)).max(initial=0.0) <= 1e-9
    assert np.abs(v[np.abs(held) < 1.0 - 1e-4]).max(initial=0.0) <= 1e-6
    if worst:
        level = float(np.abs(left).max())
        assert np.abs(z).sum() == pytest.approx(level, rel=1e-6)
        assert np.abs(z[np.abs(left) < level * (1.0 - 1e-4)]).max(initial=0.0) <= 1e-6 * level
    else:
        np.testing.assert_allclose(z, left)
    slope = G.conj().T @ z + F.conj().T @ v
    free = np.abs(x) < caps * (1.0 - 1e-4)
    assert np.abs(slope[free]).max(initial=0.0) <= 1e-6
    inward = slope[~free] * np.exp(-1j * np.angle(x[~free]))
    assert np.abs(inward.imag).max(initial=0.0) <= 1e-6
    assert inward.real.max(initial=0.0) <= 1e-6


@pytest.mark.parametrize("worst", [False, True])
def test_nearly_all_settle(worst: bool) -> None:
    dice = np.random.default_rng(1)
    sizes = [(int(n), int(n + dice.integers(8, 50)), int(dice.integers(1, 20))) for n in dice.integers(1, 9, 100)]
    asked = [discs(seed, *size) for seed, size in enumerate(sizes)]
    settled = [least_within(*goal, *limits, caps, worst=worst) is not None for goal, limits, caps in asked]
    assert np.mean(settled) >= 0.95


@pytest.mark.parametrize(("n", "many"), [(8, 40), (20, 53), (20, 100)])
def test_steps_are_few(monkeypatch: pytest.MonkeyPatch, n: int, many: int) -> None:
    """Of a worst residual under caps that are much smaller than what is read."""
    monkeypatch.setattr(interior, "STEPS", 13)
    settled = []
    for seed in range(40):
        (G, g), (F, f), _ = discs(seed, n, many, 0)
        caps = np.full(n, 0.7 * np.median(np.abs(np.linalg.lstsq(G, -g, rcond=None)[0])))
        settled.append(least_within(G, g, F, f, caps, worst=True) is not None)
    assert np.mean(settled) >= 0.6


def test_limits_that_nothing_keeps_are_not_answered() -> None:
    G = np.eye(3, dtype=complex)[:, :2]
    F, f = np.ones((2, 2), dtype=complex), np.array([4.0, -4.0], dtype=complex)
    assert least_within(G, np.ones(3, dtype=complex), F, f, np.full(2, np.inf), worst=True) is None
