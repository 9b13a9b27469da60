"""A base: a support that moves in a prescribed way."""

from collections.abc import Mapping
from typing import Any

from vibopt.devices.device import Device
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder


class BaseTable(Device):
    """`[bases.NAME]`: a support that moves; the table stays empty, its motion is an excitation."""

    @classmethod
    def supports_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    def declare(self, builder: ModelBuilder, name: str) -> None:
        if name in builder.spatial:
            builder.add_spatial_base(name)
        else:
            builder.add_base(name)

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Nothing: it has no mass and no springs of its own."""

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        assembly.bases.append(name)
