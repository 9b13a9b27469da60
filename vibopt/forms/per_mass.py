"""How peaks in time go by mass: of a whole machine that is made larger, and of a lone mass that is open.

With m z'' + c z' + k z = f only k / m, c / m and f / m count.  So where m is a monomial of the design what is read is
a power of it times the reading of a machine in which springs and dampers alone are open.
"""

from __future__ import annotations

from vibopt.arrays import FloatArray
from vibopt.mechanics.model import INERTIA, Model
from vibopt.records import dataclass
from vibopt.signals import Output


@dataclass(frozen=True, slots=True)
class PerMass:
    """What is read goes by the mass to the power `degree` where springs and dampers are held per kilogram, and motion
    by it to the power `motion`.

    exponents
        Of the variables in the mass, (n_vars,).
    """

    exponents: FloatArray
    degree: float
    motion: float


def by_size(output: Output, loads: FloatArray, n_free: int) -> tuple[float, float] | None:
    """Powers of s by which motions and what is read go under `loads` (n_coords, n_signals) where all masses, springs
    and dampers are s times as large.

    None of forces beside a base that moves, and of motions and forces that are read together.
    """
    forced = bool(loads[:n_free].any())
    if (forced and loads[n_free:].any()) or (output.signs.any() and output.row.any()):
        return None
    motion = -1.0 if forced else 0.0
    return motion, motion + float(output.signs.any())


def per_mass(model: Model, output: Output, loads: FloatArray) -> PerMass | None:
    """Of a lone mass that is open; None of several bodies, masses that do not go together, inertia between body and
    base, and where `by_size` says nothing.
    """
    heavy = model.kinds == INERTIA
    alike = model.exponents[heavy]
    if (
        model.n_free != 1
        or not alike.any()
        or (alike != alike[0]).any()
        or model.vectors[heavy, 1:].any()
        or output.signs[heavy].any()
    ):
        return None
    powers = by_size(output, loads, model.n_free)
    return None if powers is None else PerMass(alike[0], powers[1], powers[0])
