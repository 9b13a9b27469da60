"""Excitations: what shakes the machine.  One kind a file."""

from vibopt.excitations.base_motion import BaseMotion
from vibopt.excitations.force import Force
from vibopt.excitations.harmonics import Harmonics
from vibopt.excitations.kind import Excitation
from vibopt.excitations.moment import Moment
from vibopt.excitations.road import Road
from vibopt.excitations.spatial import MomentHarmonics
from vibopt.excitations.unbalance import Unbalance
from vibopt.excitations.white_noise import WhiteNoise

KINDS: dict[str, type[Excitation]] = {
    "force": Force,
    "moment": Moment,
    "moment_harmonics": MomentHarmonics,
    "unbalance": Unbalance,
    "harmonics": Harmonics,
    "base_motion": BaseMotion,
    "road": Road,
    "white_noise": WhiteNoise,
}

__all__ = ["KINDS", "Excitation"]
