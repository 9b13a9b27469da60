"""Points without mass: what only springs hold follows at once, what a damper holds follows at a rate of first order.

Of all free coordinates those with mass come first, then those that a damper holds; what no damper reaches is a static
function of the others and drops out exactly.  Coefficients may be complex, an imaginary part being a slope.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import IntArray
from vibopt.records import dataclass

Numbers = np.ndarray[Any, np.dtype[Any]]
"""Real, or complex with the imaginary part as a slope."""
_HELD, _FOLLOWS = 1e6, 1e-9
"""Condition of the stiffness up to which bodies follow a base that moves slowly; rounding of how far."""


@dataclass(frozen=True, slots=True)
class Condensed:
    """A machine in the coordinates that are left: with mass, held by dampers, bases.

    mass, damping, stiffness
        (..., n + n_bases, n + n_bases) each.
    n, heavy
        Number of free coordinates, and of those of them that have mass.
    lift
        All coordinates from these, (..., n_coords, n + n_bases).
    kept, quick
        Free coordinates that are left, (n,), and that dropped out: only springs hold them.
    """

    mass: Numbers
    damping: Numbers
    stiffness: Numbers
    n: int
    heavy: int
    lift: Numbers
    kept: IntArray
    quick: IntArray


def massless(mass: Numbers, n_free: int) -> IntArray:
    """Free coordinates that no mass resists, ascending; none without a mass of its own has one with another."""
    found: IntArray = (np.diagonal(mass)[:n_free] == 0.0).nonzero()[0]
    return found


class UnlikeError(ArithmeticError):
    """Machines side by side of which some have states that others have not."""


def condensed(mass: Numbers, damping: Numbers, stiffness: Numbers, n_free: int) -> Condensed:
    """The machine without the coordinates that only springs hold; matrices (..., n_coords, n_coords).

    Raises
    ------
    UnlikeError
        Of several machines not all drop the same.
    """
    count, diagonal = mass.shape[-1], np.diagonal(mass, axis1=-2, axis2=-1)[..., :n_free].reshape(-1, n_free)
    if diagonal.all():
        lift = np.broadcast_to(np.eye(count), mass.shape)
        return Condensed(mass, damping, stiffness, n_free, n_free, lift, np.arange(n_free), np.arange(0))
    braked = np.diagonal(damping, axis1=-2, axis2=-1)[..., :n_free].reshape(-1, n_free).real > 0.0
    light = (diagonal[0] == 0.0).nonzero()[0]
    slow = braked[0, light]
    if ((diagonal == 0.0) != (diagonal[0] == 0.0)).any() or (braked[:, light] != slow).any():
        raise UnlikeError
    heavy = np.setdiff1d(np.arange(n_free), light)
    own = np.concatenate([heavy, light[slow]])
    kept, quick = np.concatenate([own, np.arange(n_free, count)]), light[~slow]
    lift = np.zeros((*mass.shape[:-1], len(kept)), dtype=np.result_type(mass, damping, stiffness))
    lift[..., kept, np.arange(len(kept))] = 1.0
    if len(quick):
        held, led = (stiffness[..., quick[:, None], one] for one in (quick, kept))
        lift[..., quick, :] = -np.linalg.solve(held, led)
    whole = (..., kept[:, None], kept)
    return Condensed(mass[whole], damping[whole], lift.mT @ stiffness @ lift, len(own), len(heavy), lift, own, quick)


def eliminated(elastic: Numbers, braked: Numbers, heavy: int) -> Numbers:
    """Accelerations of what has mass, rates of the rest, from places and rates of all that has mass or is prescribed.

    elastic, braked (..., n, half) are forces per place and rate, where all masses are one; the result (..., n, 2 half)
    has nothing in the columns of rates that are no states.
    """
    n, half = elastic.shape[-2:]
    rows = -np.concatenate([elastic, braked], axis=-1)
    if heavy == n:
        return rows
    rows[..., half + heavy : half + n] = 0.0
    rest = np.linalg.solve(braked[..., heavy:, heavy:n], rows[..., heavy:, :])
    rows[..., :heavy, :] -= braked[..., :heavy, heavy:n] @ rest
    rows[..., heavy:, :] = rest
    return rows


@dataclass(frozen=True, slots=True)
class FirstOrder:
    """z' = rates z + struck f + shaken a, under forces on the free coordinates and accelerations of the bases.

    The states z are places of free coordinates, their rates, places of bases, their rates.

    rates, struck, shaken
        (N, N), (N, n_free) and (N, n_bases).
    places
        All coordinates from the states, (n_coords, N).
    kept, heavy
        Free coordinates whose places are states, (n,), and how many of them, the first, have mass: their rates are
        states, too.
    """

    rates: Numbers
    struck: Numbers
    shaken: Numbers
    places: Numbers
    kept: IntArray
    heavy: int

    @property
    def own(self) -> int:
        """Number of states of the free coordinates, which are the first."""
        return len(self.kept) + self.heavy

    def state(self, place: Numbers, rate: Numbers, base: Numbers, base_rate: Numbers) -> Numbers:
        """z (N,) of places and rates of all free coordinates (n_free,) and of the bases (n_bases,)."""
        return np.concatenate([place[self.kept], rate[self.kept[: self.heavy]], base, base_rate])


def first_order(mass: Numbers, damping: Numbers, stiffness: Numbers, n_free: int) -> FirstOrder:
    """A machine as one system of first order, of mass, damping, stiffness (n_coords, n_coords) with the bases last."""
    one = condensed(mass, damping, stiffness, n_free)
    n, half, heavy = one.n, len(one.mass), one.heavy
    inverse = np.linalg.inv(one.mass[:heavy, :heavy])
    parts = [np.concatenate([inverse @ both[:heavy], both[heavy:n]]) for both in (one.stiffness, one.damping)]
    rows = eliminated(parts[0], parts[1], heavy)
    whole = np.zeros((2 * half, 2 * half), dtype=rows.dtype)
    bases = np.arange(n, half)
    moving = np.concatenate([np.arange(heavy), bases])
    whole[moving, half + moving] = 1.0
    whole[heavy:n] = rows[heavy:]
    whole[half : half + heavy] = rows[:heavy]
    pushed = np.zeros((2 * half, n), dtype=rows.dtype)
    pushed[half : half + heavy, :heavy] = inverse
    if heavy < n:
        pushed[heavy:n, heavy:] = np.linalg.inv(one.damping[heavy:n, heavy:n])
        pushed[half : half + heavy, heavy:] = -parts[1][:heavy, heavy:n] @ pushed[heavy:n, heavy:]
    shaken = np.zeros((2 * half, half - n), dtype=rows.dtype)
    shaken[half : half + heavy] = -inverse @ one.mass[:heavy, n:]
    shaken[half + n :] = np.eye(half - n)
    order = np.concatenate([np.arange(n), np.arange(half, half + heavy), bases, half + bases])
    places = np.zeros((len(mass), 2 * half), dtype=rows.dtype)
    places[:, :half] = one.lift
    lifted = one.lift[:n_free, :n].T
    struck = (pushed @ lifted)[order]
    return FirstOrder(whole[order[:, None], order], struck, shaken[order], places[:, order], one.kept, heavy)


def riding(stiffness: Numbers, n: int) -> Numbers:
    """How the n free coordinates follow bases that move slowly, (..., n, n_bases), zero where nothing holds them."""
    held, led = stiffness[..., :n, :n], stiffness[..., :n, n:]
    if not led.shape[-1]:
        return np.zeros(led.shape)
    loose = np.asarray(np.linalg.cond(held.real) > _HELD)[..., None, None]
    back = np.linalg.inv(np.where(loose, np.eye(n), held.real))
    found, whole = -back @ led.real, np.rint(-back @ led.real)
    found = np.where(np.abs(found - whole) < _FOLLOWS, whole, found)
    if not np.iscomplexobj(stiffness):
        return np.where(loose, 0.0, found)
    turned = held.imag @ found + led.imag
    size = np.abs(back) @ (np.abs(held.imag) @ np.abs(found) + np.abs(led.imag))
    slopes = np.where(np.abs(back @ turned) > _FOLLOWS * size, back @ turned, 0.0)
    return np.where(loose, 0.0, found - 1j * slopes)
