"""Devices: what a scene is made of.  Each leaves names and terms on the model."""

from vibopt.devices.absorber import AbsorberTable
from vibopt.devices.base import BaseTable
from vibopt.devices.body import BodyTable
from vibopt.devices.device import Device
from vibopt.devices.link import LinkTable
from vibopt.devices.mount import MountTable
from vibopt.devices.point import PointTable
from vibopt.devices.structure import StructureTable

FAMILIES: dict[str, type[Device]] = {
    "bodies": BodyTable,
    "bases": BaseTable,
    "structures": StructureTable,
    "absorbers": AbsorberTable,
    "links": LinkTable,
    "points": PointTable,
    "mounts": MountTable,
}
"""By table of the problem file, in the order in which they add to the model."""

__all__ = [
    "FAMILIES",
    "AbsorberTable",
    "BaseTable",
    "BodyTable",
    "Device",
    "LinkTable",
    "MountTable",
    "PointTable",
    "StructureTable",
]
