"""Excitations: what shakes the machine.  One kind a file."""

from vibopt.excitations.base_motion import BaseMotion
from vibopt.excitations.force import Force
from vibopt.excitations.harmonics import Harmonics
from vibopt.excitations.kind import Excitation
from vibopt.excitations.road import Road
from vibopt.excitations.unbalance import Unbalance

KINDS: dict[str, type[Excitation]] = {
    "force": Force,
    "unbalance": Unbalance,
    "harmonics": Harmonics,
    "base_motion": BaseMotion,
    "road": Road,
}

__all__ = ["KINDS", "Excitation"]
