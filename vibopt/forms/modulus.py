"""Responses over speeds: the modulus of what is linear in the motion."""

from __future__ import annotations

from itertools import islice, product
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from vibopt.forms.form import WITHOUT_END, Form, Local, Worst
from vibopt.records import dataclass
from vibopt.signals import Combine, Drive, Output

if TYPE_CHECKING:
    from vibopt.arrays import FloatArray
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model

MOST = 24
"""Local extremes that are looked at."""


@dataclass(frozen=True, slots=True)
class Modulus(Form):
    """Combined modulus of linear responses under equilibrium D(p) u = f, over bands of speeds.

    With `rigid_link` named, the value is the modulus with that link made rigid divided by the
    modulus as it is (insertion loss).  `endless` names the drives under which it is infinite at standstill,
    whatever the design.
    """

    output: Output
    drives: tuple[Drive, ...]
    combine: Combine
    rigid_link: str = ""
    endless: tuple[str, ...] = ()

    @property
    def harmonic(self) -> Modulus:
        return self

    def value(self, model: Model, x: FloatArray) -> float:
        return self.worst(model, x).value

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        from vibopt.forms.drive_response import drive_extreme

        if self.endless and not least_wanted:
            return Worst(float("inf"), dict.fromkeys(self.endless, 0.0))
        found = {drive.name: drive_extreme(model, self, drive, x, least_wanted) for drive in self.drives}
        values = [one.value for one in found.values()]
        total = hypot(*values) if self.combine == "rss" else sum(values)
        return Worst(total, {name: one.speed for name, one in found.items()})

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        """Of the greatest value."""
        return self.extremes(model, x, least_wanted=False)[0].slope

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        from vibopt.forms.extremes import of_drive, of_few

        few = of_few(model, self, x, within) if len(self.drives) == 1 and not least_wanted else None
        if few is not None:
            return few[:MOST]
        per_drive = [of_drive(model, self, drive, x, least_wanted, within) for drive in self.drives]
        found = [self._together(combo) for combo in islice(product(*per_drive), 4 * MOST)]
        return sorted(found, key=lambda one: one.value if least_wanted else -one.value)[:MOST]

    def reach(self, model: Model) -> Reach | None:
        from vibopt.forms.reduce import driven

        lines = [line.vector for drive in self.drives for line in drive.lines]
        loads = [part for one in lines for part in (one.real, one.imag) if part.any()]
        return None if self.rigid_link else driven(model, self.output, loads)

    def _together(self, combo: tuple[Local, ...]) -> Local:
        """Several excitations: sum or root of sum of squares of their extremes."""
        from vibopt.forms.bends import Curved, added

        if len(combo) == 1:
            return combo[0]
        speeds = tuple(one.speeds[0] for one in combo)
        endless = [one for one in combo if one.value == np.inf]
        if endless:
            return Local(np.inf, endless[0].slope, speeds)
        real = [one for one in combo if one.value > -WITHOUT_END]
        if not real:
            return Local(-WITHOUT_END, np.zeros(len(combo[0].slope)), speeds)
        none = np.full((len(combo[0].slope),) * 2, np.nan)
        parts = [Curved(one.value, one.slope, none if one.bend is None else one.bend) for one in real]
        made = added(parts, 2.0 if self.combine == "rss" else 1.0)
        return Local(made.log, made.slope, speeds, made.bend if np.isfinite(made.bend).all() else None)
