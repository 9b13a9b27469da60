"""Devices: what a scene is made of.  One kind a file, and a line here.

A new device:

1. `devices/NAME.py`: a `Device` whose fields are the keys of its table, `number(...)` with dimension and sign, and
   what makes no sense together refused in a sentence (`word`).
2. `links_in`, `joins`, `moving_in`, `supports_in`, `springs`: the names that it brings; `parts`: what a `tolerance`
   of the whole table makes uncertain; class attributes: what checks must know (`between_points`, `in_space`,
   `passes`, ...).
3. `add_to(builder, name, symbols)`, the first route: coordinates, points, and terms b b^T whose coefficients are
   products of powers (`add_link`, `add_stiffness`, `add_damping`, `add_hysteretic`, `add_inertance`,
   `add_inertia`).  With the frequency these go as 1, i w, i and -w^2 alone; what goes otherwise has a point without
   mass inside (`massless`, `declare`, `moving_in`, and `freedoms_in` of 0).
4. `built(assembly, name, numbers)`, the second route: masses, and forces between points by how far, how fast and
   how suddenly these move apart (`Joint`, `Spring3`, or one with a `dynamic` and `four` of its own), from the
   file's own words by other formulas.
5. A line below; one in `machines` of `tests/laws/test_kinds.py`; a word in `tests/generator/machines.py`, so that
   random scenes have it; words for each key under "Keys" in its docstring, of which the manual is made.

`tests/laws/test_kinds.py` then holds it: both routes said, registered, symmetric, of positive energy, one value by
both routes under every excitation, for every number that is chosen or off; an answer whose routes differ is
`check_failed`.
"""

from vibopt.devices.device import Device
from vibopt.values.kinds import Kinds

FAMILIES: Kinds[Device] = Kinds(
    __name__,
    {
        "bodies": "body.BodyTable",
        "bases": "base.BaseTable",
        "structures": "structure.StructureTable",
        "rotors": "rotor.RotorTable",
        "absorbers": "absorber.AbsorberTable",
        "links": "link.LinkTable",
        "bearings": "bearing.BearingTable",
        "inerters": "inerter.InerterTable",
        "points": "point.PointTable",
        "mounts": "mount.MountTable",
    },
)
"""By table of the problem file, in the order in which they add to the model."""

__all__ = ["FAMILIES", "Device"]
