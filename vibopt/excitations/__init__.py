"""Excitations: what shakes the machine.  One kind a file, and a line here.

A new excitation:

1. `excitations/NAME.py`: an `Excitation` with its keys and class attributes: a force on bodies or a motion of bases
   (`family`), a moment and its like along a line (`moment`), known at every speed (`inherent`), steady,
   random or transient (`sort`).
2. `lines(direction)`: its harmonics, each with an order, a complex direction and an amplitude against the speed; in
   space `acts`: what it acts on, by name.
3. A line below; an entry in `tests/laws/test_kinds.py::SHAKERS` and in `tests/generator/shaking.py`; words for
   each key under "Keys" in its docstring, of which the manual is made.
"""

from vibopt.excitations.excitation import Excitation
from vibopt.values.kinds import Kinds

KINDS: Kinds[Excitation] = Kinds(
    __name__,
    {
        "force": "force.Force",
        "moment": "moment.Moment",
        "moment_harmonics": "moment.MomentHarmonics",
        "unbalance": "unbalance.Unbalance",
        "harmonics": "harmonics.Harmonics",
        "base_motion": "base_motion.BaseMotion",
        "road": "road.Road",
        "white_noise": "white_noise.WhiteNoise",
        "pulse": "pulse.Pulse",
        "drop": "drop.Drop",
        "release": "release.Release",
        "record": "record.Record",
    },
)

__all__ = ["KINDS", "Excitation"]
