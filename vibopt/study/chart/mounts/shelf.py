"""Shelves of parts drawn with the laws of real rubber mounts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vibopt.forms import FloatArray

HEADS = (
    "part", "rated load min [N]", "rated load max [N]", "stiffness [N/mm]", "shear stiffness [N/mm]",
    "static stiffness [N/mm]", "loss factor", "price [EUR]",
)  # fmt: skip
_PER_MM = 1e3
"""N/m in one N/mm."""


@dataclass(frozen=True)
class Shelf:
    """Columns of a catalogue [SI, EUR], each of shape (n_parts,).

    least, most
        Rated load [N].
    k, shear, static
        Dynamic stiffness along and across the axis, static stiffness along it [N/m].
    loss
        Loss factor.
    price
        Of one part.
    """

    least: FloatArray
    most: FloatArray
    k: FloatArray
    shear: FloatArray
    static: FloatArray
    loss: FloatArray
    price: FloatArray

    def __len__(self) -> int:
        return len(self.k)

    def names(self) -> list[str]:
        """P0, P1, ..."""
        return [f"P{index}" for index in range(len(self))]

    def write(self, path: Path) -> None:
        """As a catalogue; every digit is kept."""
        scale = (1.0, 1.0, _PER_MM, _PER_MM, _PER_MM, 1.0, 1.0)
        columns = (self.least, self.most, self.k, self.shear, self.static, self.loss, self.price)
        rows = zip(self.names(), *(column / one for column, one in zip(columns, scale, strict=True)), strict=True)
        lines = [";".join([name, *(repr(float(cell)) for cell in cells)]) for name, *cells in rows]
        path.write_text("\n".join([";".join(HEADS), *lines]) + "\n", encoding="utf-8")


def drawn(seed: int, parts: int, low: float, high: float, *, steel: bool = False) -> Shelf:
    """Parts for loads from `low` to `high` [N].

    Makers' rows of rubber mounts keep a working deflection of 2 to 8 mm, whatever their load; harder rubber has more
    loss and is stiffer against fast than against slow motion; price grows with about the square root of the load.
    Steel springs have the same stiffness fast and slow, and a tenth of the loss.
    """
    rng = np.random.default_rng(seed)
    most = rounded(10.0 ** rng.uniform(np.log10(low), np.log10(high), parts))
    hard = rng.uniform(0.0, 1.0, parts)
    static = rounded(most / (8e-3 * 0.25**hard) * rng.lognormal(0.0, 0.1, parts))
    loss = rounded((0.06 + 0.14 * hard) * rng.lognormal(0.0, 0.15, parts))
    return Shelf(
        least=rounded(0.2 * most),
        most=most,
        k=static if steel else rounded(static * (1.1 + 0.4 * hard)),
        shear=rounded(static * rng.uniform(0.3, 0.7, parts)),
        static=static,
        loss=rounded(0.1 * loss) if steel else loss,
        price=rounded((3.0 + 0.4 * most**0.55) * rng.lognormal(0.0, 0.2, parts)),
    )


def alike(parts: int, **columns: float | FloatArray) -> Shelf:
    """Parts that differ in the columns given as arrays only; sound values for the others."""
    own: dict[str, Any] = {
        "least": 0.0, "most": 1e5, "k": 1e6, "shear": 5e5, "static": 8e5, "loss": 0.1,
        "price": 10.0 + np.arange(parts),
    }  # fmt: skip
    return Shelf(**{name: np.broadcast_to(value, parts).astype(float) for name, value in (own | columns).items()})


def rounded(values: FloatArray) -> FloatArray:
    """To four digits, as on a data sheet."""
    return np.array([float(f"{one:.4g}") for one in values])
