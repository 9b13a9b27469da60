"""A named place on a body in space: asked about and acted on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibopt.devices.device import Device
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.values.vectors import Place


class PointTable(Device):
    """`[points.NAME]`: a place that moves with a body."""

    on: str
    at: Place

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    @classmethod
    def freedoms_in(cls, name: str, given: Mapping[str, Any]) -> int:
        return 0

    def declare(self, builder: ModelBuilder, name: str) -> None:
        builder.fix(name, self.on, self.at)

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Nothing: it moves as its body does."""

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        assembly.fixed[name] = (self.on, np.array(self.at))
