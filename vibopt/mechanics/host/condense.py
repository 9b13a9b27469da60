"""Coordinates without mass, left out of a structure exactly.

Where no mass and no load acts, the rows K_z u + i omega C_z u = 0 say how a coordinate follows the others: as in
statics, u_z = -K_zz^-1 K_za u_a, as long as the dampers pull at nothing there, C_z u = 0 for all of these motions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import IntArray
from vibopt.errors import counted
from vibopt.mechanics.host.matrices import Matrices, factored, negative_count

MOST_JOINED = 3000
"""Coordinates with mass that may be joined by those without: what is left of them has no zeros."""
_NOTHING = 1e-9
"""Part of their own size below which forces of dampers are rounding."""


class CondensationError(ValueError):
    """Coordinates without mass cannot be left out exactly; the text says why and which way out there is."""


def massless(mass: Any) -> IntArray:
    """Coordinates whose row of a mass matrix is empty."""
    return np.flatnonzero(abs(mass).sum(axis=1) == 0.0)


def condensed(whole: Matrices) -> Matrices:
    """The same structure on the coordinates that have mass, in their order.

    Raises
    ------
    CondensationError
        Nothing has mass, springs do not hold what has none, dampers pull at it, or too much is joined by it.
    """
    out = massless(whole.mass)
    if not len(out):
        return whole
    if len(out) == whole.size:
        raise CondensationError("has no mass at any coordinate. Give the mass matrix entries.")
    kept = np.setdiff1d(np.arange(whole.size), out)
    stiffness = whole.stiffness.tocsc()
    inner, across = stiffness[out][:, out].tocsc(), stiffness[out][:, kept].tocsc()
    joined = np.flatnonzero(np.diff(across.indptr))
    if len(joined) > MOST_JOINED:
        raise CondensationError(
            f"has {counted(len(out), 'coordinates')} without mass that join {len(joined)} with mass; {MOST_JOINED} are "
            "the most that are condensed. Give them their mass, or give modes instead."
        )
    follow = _follow(inner, across[:, joined], out)
    return Matrices(
        whole.mass.tocsc()[kept][:, kept].tocsc(),
        _damping(whole.damping.tocsc(), out, kept, joined, follow),
        _led(stiffness, across, kept, joined, follow),
        whole.loss_factor,
    )


def _follow(inner: Any, across: Any, out: IntArray) -> Any:
    """How the coordinates without mass follow those that they join, shape (n_out, n_joined)."""
    size = float(abs(inner.diagonal()).max()) or 1.0
    try:
        negative = negative_count(inner)
        found = -factored(inner).solve(across.toarray()) if negative == 0 else None
    except RuntimeError:
        found = None
    if found is None or not np.isfinite(found).all() or not _held(inner, size):
        raise CondensationError(
            f"has coordinates without mass that no stiffness holds, {out[0]} (counted from 0) the first of those "
            "without mass. Leave them out, or join them by springs."
        )
    return found


def _held(inner: Any, size: float) -> bool:
    """Whether the least pivot is more than rounding."""
    pivots = np.abs(factored(inner).U.diagonal())
    return bool(pivots.min() > 1e-12 * size)


def _led(matrix: Any, across: Any, kept: IntArray, joined: IntArray, follow: Any) -> Any:
    """K_aa + K_az T where what is left out follows by T, symmetric to the last bit; so of C too."""
    from scipy.sparse import csc_array

    rest = across[:, joined].T @ follow
    rest = 0.5 * (rest + rest.T)
    rows, columns = np.meshgrid(joined, joined, indexing="ij")
    added = csc_array((rest.ravel(), (rows.ravel(), columns.ravel())), shape=(len(kept), len(kept)))
    return (matrix[kept][:, kept] + added).tocsc()


def _damping(damping: Any, out: IntArray, kept: IntArray, joined: IntArray, follow: Any) -> Any:
    """T^T C T, which is C_aa where dampers pull at nothing without mass, and else less what they pull together."""
    inner, across = damping[out][:, out], damping[out][:, kept].tocsc()
    if not inner.nnz and not across.nnz:
        return damping[kept][:, kept].tocsc()
    pulled = across.toarray()
    pulled[:, joined] += inner @ follow
    size = float(max(abs(across).max() if across.nnz else 0.0, np.abs(inner @ follow).max(initial=0.0)))
    if np.abs(pulled).max(initial=0.0) > _NOTHING * size:
        raise CondensationError(
            f"has dampers at coordinates without mass, {out[0]} (counted from 0) the first of those without mass, that "
            "are not in proportion to their stiffness, so they cannot be left out exactly. Give them a small mass, or "
            "damping in proportion."
        )
    return _led(damping, across, kept, joined, follow)
