"""Devices: what a scene is made of.  Each leaves names and terms on the model."""

from vibopt.devices.device import Device
from vibopt.values.kinds import Kinds

FAMILIES: Kinds[Device] = Kinds(
    __name__,
    {
        "bodies": "body.BodyTable",
        "bases": "base.BaseTable",
        "structures": "structure.StructureTable",
        "absorbers": "absorber.AbsorberTable",
        "links": "link.LinkTable",
        "inerters": "inerter.InerterTable",
        "points": "point.PointTable",
        "mounts": "mount.MountTable",
    },
)
"""By table of the problem file, in the order in which they add to the model."""

__all__ = ["FAMILIES", "Device"]
