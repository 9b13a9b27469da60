"""Responses as methods of a machine: one method a response, named as in the file.

Values are the worst over all the speeds that are looked at; amplitudes are peak.  A word that a response
does not have is refused by the reader of scenes, with a suggestion.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict, Unpack

from vibopt.scene.language.limit import Measure
from vibopt.scene.language.values import Speeds


class Shown(TypedDict, total=False):
    """`unit`: how the value is shown, as "mm rms"."""

    unit: str


class Looked(Shown, total=False):
    """Speeds and excitations to look at.

    at, over
        Single speeds, or ranges ("start-up": from rest to the highest own speed); neither: every own
        speed of the excitation.
    due_to
        Excitations that count; without it all.
    combine
        "sum", "rss" or "peak"; compulsory when there is more than one harmonic or excitation.
    """

    at: Speeds
    over: Speeds
    due_to: Sequence[str]
    combine: str


class Responses:
    """What can be limited, measured or made best."""

    def transmitted_force(
        self, *, into: str | None = None, through: str | None = None, **words: Unpack[Looked]
    ) -> Measure:
        """Dynamic force, without the weight: total over all links `into` a place, or in each mount of a link [N]."""
        return Measure("transmitted_force", into=into, through=through, **words)

    def transmissibility(self, *, into: str | None = None, of: str | None = None, **words: Unpack[Looked]) -> Measure:
        """Force `into` a place over the force that shakes, or motion `of` a body over that of its base."""
        return Measure("transmissibility", into=into, of=of, **words)

    def isolation(self, *, into: str | None = None, of: str | None = None, **words: Unpack[Looked]) -> Measure:
        """One minus the transmissibility, as "80 %"."""
        return Measure("isolation", into=into, of=of, **words)

    def displacement(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Motion of a body, absolute [m]."""
        return Measure("displacement", of=of, **words)

    def velocity(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Velocity of a body, absolute [m/s]."""
        return Measure("velocity", of=of, **words)

    def acceleration(self, *, of: str, **words: Unpack[Looked]) -> Measure:
        """Acceleration of a body, absolute [m/s^2]."""
        return Measure("acceleration", of=of, **words)

    def relative_displacement(self, *, across: str, **words: Unpack[Looked]) -> Measure:
        """Relative motion of the two ends of a link [m]."""
        return Measure("relative_displacement", across=across, **words)

    def insertion_loss(self, *, across: str, **words: Unpack[Looked]) -> Measure:
        """Motion of the receiver with the link rigid over that with the link; a ratio, usually in dB."""
        return Measure("insertion_loss", across=across, **words)

    def static_deflection(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Under the weights alone: compression of a link, or sag of a body [m]."""
        return Measure("static_deflection", of=of, **words)

    def natural_frequency(self, *, mode: int | None = None, **words: Unpack[Shown]) -> Measure:
        """Undamped natural frequency [rad/s]; mode 1, the lowest, without a `mode`."""
        return Measure("natural_frequency", mode=mode, **words)

    def damping_ratio(self, *, of: str | None = None, mode: int | None = None, **words: Unpack[Shown]) -> Measure:
        """Damping ratio `of` a link, or of the `mode`-th least damped mode; without both, the least damped."""
        return Measure("damping_ratio", of=of, mode=mode, **words)

    def total_mass(self, **words: Unpack[Shown]) -> Measure:
        """Mass of all bodies [kg]."""
        return Measure("total_mass", **words)

    def mass(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Mass of one body [kg]."""
        return Measure("mass", of=of, **words)

    def stiffness(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Dynamic stiffness of one single mount of a link [N/m]."""
        return Measure("stiffness", of=of, **words)

    def damping(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Viscous damping of one single mount of a link [N s/m]."""
        return Measure("damping", of=of, **words)

    def loss_factor(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Loss factor of a link."""
        return Measure("loss_factor", of=of, **words)

    def count(self, *, of: str, **words: Unpack[Shown]) -> Measure:
        """Number of mounts in a link."""
        return Measure("count", of=of, **words)
