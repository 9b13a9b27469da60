"""What is known of a form on boxes of designs and at many designs, from the speeds looked at so far."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.rational import TELLING
from vibopt.records import cached_property, dataclass

if TYPE_CHECKING:
    from vibopt.forms.form import Bounds, Form
    from vibopt.forms.rational import Sampled
    from vibopt.mechanics.model import Model

MOST_GROUPS = 12
"""Directions of a determinant that can be expanded: each doubles its terms."""
_ROUGH = 1e-6
"""Part of a bound by which a response at sampled speeds must miss it to count: determinants lose digits."""
CLOSE = 1e-8
"""The same where there are no speeds."""


@dataclass
class FormBounds:
    """Bounds of one form; of a response over speeds at those sampled so far.

    A sampled speed gives a valid lower bound of the worst and a valid upper bound of the least.

    reference
        A typical design (n_vars,).
    direct
        Whether designs are solved one by one: too many directions for polynomials.
    speeds, ranked
        Sampled speeds [rad/s] by excitation, in the order of the samples, and ascending.
    """

    model: Model
    form: Form
    reference: FloatArray
    direct: bool = False
    samples: dict[tuple[str, int], Sampled] = field(default_factory=dict)
    speeds: dict[str, list[float]] = field(default_factory=dict)
    ranked: dict[str, list[float]] = field(default_factory=dict)
    kept: dict[str, bool] = field(default_factory=dict)

    @cached_property
    def bounded(self) -> bool:
        """Whether this form has bounds on boxes at all."""
        return not self.direct and self.form.bounded(self.model) and self.directions <= MOST_GROUPS

    @cached_property
    def directions(self) -> int:
        """Of the determinants whose quotient the form is."""
        groups = self.form.groups(self.model)
        return 0 if groups is None else len(groups.members)

    @property
    def size(self) -> int:
        """Coefficients that are looked at on each box: all of those at the speeds that tell, one at each other."""
        groups = self.form.groups(self.model)
        return self._told(1 if groups is None else math.prod(2 * degree + 1 for degree in groups.degrees))

    @property
    def work(self) -> int:
        """What a box takes, in coefficients of small ones: values at nodes and their squares grow faster than these."""
        groups = self.form.groups(self.model)
        return self.size if groups is None or self.form.harmonic is None else self._told(groups.work)

    def _told(self, each: int) -> int:
        count = sum(len(known) for known in self.speeds.values())
        return each * min(max(count, 1), 2 * TELLING * max(len(self.speeds), 1)) + count

    @cached_property
    def known(self) -> bool:
        """Whether anything is known of this form without measuring it."""
        return self.form.known(self)

    @cached_property
    def resonant(self) -> bool:
        """Whether it is a resonance of one mass that only grows with what is beside it."""
        from vibopt.forms.one_resonance import applies

        return self.form.harmonic is not None and applies(self.model, self.form.harmonic)

    @property
    def exact(self) -> bool:
        """Whether values at designs are those of the machine, and no bounds."""
        return self.known and not self.form.drives

    @property
    def slack(self) -> float:
        """Part of a value that rounding may take."""
        return CLOSE if self.exact else _ROUGH

    def add(self, speeds: Mapping[str, float | Sequence[float]]) -> bool:
        """Sample more speeds, one or several an excitation [rad/s]; whether any of them is new."""
        added = False
        for name in [drive.name for drive in self.form.drives]:
            known, ranked = self.speeds.setdefault(name, []), self.ranked.setdefault(name, [])
            fresh = [speed for speed in np.ravel(speeds.get(name, ())).tolist() if _is_new(speed, ranked)]
            known += fresh
            if fresh and not self.direct and self.directions <= MOST_GROUPS:
                self._keep(name, np.array(fresh))
            added |= bool(fresh)
        return added

    def _keep(self, drive: str, speeds: FloatArray) -> None:
        assert self.form.harmonic is not None
        for key, made in self.form.harmonic.lines_at(self.model, drive, speeds, self.reference).items():
            old = self.samples.get(key)
            self.samples[key] = made if old is None else old.joined(made)

    def on(self, low: FloatArray, high: FloatArray) -> Bounds:
        """Lower and upper bound on boxes (n_boxes, n_vars), each (n_boxes,).

        Of a response over speeds: lower bound of the greatest, upper bound of the least.
        """
        if not self.bounded:
            return np.zeros(len(low)), np.full(len(low), np.inf)
        return self.form.on_boxes(self, low, high)

    def at(self, x: FloatArray) -> Bounds:
        """Lower bound of the greatest and upper bound of the least value at designs x (n, n_vars), each (n,)."""
        if not self.known:
            return np.full(len(x), -np.inf), np.full(len(x), np.inf)
        return self.form.on_points(self, x)


def _is_new(speed: float, ranked: list[float]) -> bool:
    """Whether a speed stands nowhere in the list, which then takes it up in its place."""
    place = bisect_left(ranked, speed)
    beside = ranked[max(place - 1, 0) : place + 1]
    if not math.isfinite(speed) or any(abs(speed - value) <= 1e-12 * abs(value) for value in beside):
        return False
    ranked.insert(place, speed)
    return True
