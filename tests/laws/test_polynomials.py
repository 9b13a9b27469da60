"""Real roots of polynomials: those that a polynomial was made of, and no others."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vibopt.mechanics.polynomials import real_roots, roots

apart = st.lists(st.integers(-20, 20), min_size=1, max_size=4, unique=True)
"""Roots that are apart: whole numbers."""


@given(apart, st.booleans(), st.sampled_from([1.0, -3.0, 1e6]))
def test_the_roots_a_polynomial_was_made_of_are_found(made: list[int], pair: bool, lead: float) -> None:
    ascending = lead * np.polynomial.polynomial.polyfromroots(made)
    if pair:  # two more that are not real
        ascending = np.convolve(ascending, [2.0, 0.0, 1.0])
    found = np.sort(real_roots(ascending, 1e-7, 3))
    assert np.allclose(found, np.sort(made), rtol=1e-9, atol=1e-12)
    assert len(roots(ascending)) == len(made) - made.count(0) + 2 * pair


@given(apart.map(lambda made: [one or 21 for one in made]), st.integers(1, 30), st.integers(2, 30))
def test_coefficients_that_are_next_to_nothing_take_no_digits(made: list[int], low: int, high: int) -> None:
    """Roots that are apart move by no more than rounding of the greatest coefficient, in each of them, moves them."""
    ascending = np.polynomial.polynomial.polyfromroots(made)
    for far in ([10.0**-low, 1.0], [1.0, 10.0**-high]):  # a root next to zero, and one next to infinity
        ascending = np.convolve(ascending, far)
    found, order = roots(ascending), np.arange(len(ascending))
    for one in map(float, made):
        slope = ascending[1:] @ (order[1:] * one ** order[:-1])
        off = np.finfo(float).eps * np.abs(ascending).max() * (np.abs(one) ** order).sum() / abs(slope)
        assert np.abs(found - one).min() <= 100.0 * off  # what eigenvalues of matrices of order 6 take


def test_what_has_no_roots_gives_none() -> None:
    for row in ([], [0.0], [3.0], [0.0, 0.0]):
        assert len(real_roots(np.array(row), 1e-7, 3)) == 0
