"""Responses: what can be limited, measured or made best.  One kind a file."""

from vibopt.responses.damping import DampingOfModes, LossFactor, ModeDampingRatio
from vibopt.responses.insertion_loss import InsertionLoss
from vibopt.responses.kind import HarmonicResponse, Response
from vibopt.responses.motion import Acceleration, Displacement, RelativeDisplacement, Velocity
from vibopt.responses.natural_frequency import NaturalFrequency
from vibopt.responses.parameters import Count, Damping, Mass, Stiffness, TotalMass
from vibopt.responses.static_deflection import StaticDeflection
from vibopt.responses.transmitted import Isolation, Transmissibility, TransmittedForce

KINDS: dict[str, type[Response]] = {
    "transmitted_force": TransmittedForce,
    "transmissibility": Transmissibility,
    "isolation": Isolation,
    "displacement": Displacement,
    "velocity": Velocity,
    "acceleration": Acceleration,
    "relative_displacement": RelativeDisplacement,
    "static_deflection": StaticDeflection,
    "natural_frequency": NaturalFrequency,
    "damping_ratio": DampingOfModes,
    "insertion_loss": InsertionLoss,
    "total_mass": TotalMass,
    "mass": Mass,
    "stiffness": Stiffness,
    "damping": Damping,
    "loss_factor": LossFactor,
    "count": Count,
}

__all__ = ["KINDS", "HarmonicResponse", "ModeDampingRatio", "Response"]
