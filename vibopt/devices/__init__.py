"""Devices: what a scene is made of.  Each leaves names and terms on the model."""

from vibopt.devices.base import BaseTable
from vibopt.devices.body import BodyTable
from vibopt.devices.link import LinkTable

FAMILIES = {"bodies": BodyTable, "bases": BaseTable, "links": LinkTable}

__all__ = ["FAMILIES", "BaseTable", "BodyTable", "LinkTable"]
