"""Excitations: what shakes the machine.  One kind a file."""

from vibopt.excitations.kind import Excitation
from vibopt.values.kinds import Kinds

KINDS: Kinds[Excitation] = Kinds(
    __name__,
    {
        "force": "force.Force",
        "moment": "moment.Moment",
        "moment_harmonics": "spatial.MomentHarmonics",
        "unbalance": "unbalance.Unbalance",
        "harmonics": "harmonics.Harmonics",
        "base_motion": "base_motion.BaseMotion",
        "road": "road.Road",
        "white_noise": "white_noise.WhiteNoise",
    },
)

__all__ = ["KINDS", "Excitation"]
