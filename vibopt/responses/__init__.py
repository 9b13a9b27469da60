"""Responses: what can be limited, measured or made best.  One kind a file."""

from vibopt.responses.absorbers import AbsorberMass, MassRatio, OwnFrequency, Stroke, Tuning
from vibopt.responses.damping import DampingOfModes, LossFactor, ModeDampingRatio
from vibopt.responses.decay_rate import DecayRateOfModes
from vibopt.responses.free_displacement import FreeDisplacement
from vibopt.responses.insertion_loss import InsertionLoss
from vibopt.responses.kind import HarmonicResponse, Response
from vibopt.responses.mode_ratio import RatioInMode
from vibopt.responses.motion import Acceleration, Displacement, RelativeDisplacement, Velocity
from vibopt.responses.natural_frequency import NaturalFrequency
from vibopt.responses.parameters import Count, Damping, Mass, Stiffness, TotalMass
from vibopt.responses.price import TotalPrice
from vibopt.responses.random import (
    RandomResponse,
    RmsAcceleration,
    RmsDisplacement,
    RmsForce,
    RmsRelativeDisplacement,
    RmsVelocity,
)
from vibopt.responses.spatial import EnergyShareOfBody, FrequencySeparation, StaticLoadOfMount, Tilt, Travel
from vibopt.responses.static_deflection import StaticDeflection
from vibopt.responses.torsion import Inertia, Rotation, TorsionalDamping, TorsionalStiffness, TransmittedMoment, Twist
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
    "price": TotalPrice,
    "rotation": Rotation,
    "twist": Twist,
    "transmitted_moment": TransmittedMoment,
    "inertia": Inertia,
    "torsional_stiffness": TorsionalStiffness,
    "torsional_damping": TorsionalDamping,
    "stroke": Stroke,
    "own_frequency": OwnFrequency,
    "mass_ratio": MassRatio,
    "tuning": Tuning,
    "absorber_mass": AbsorberMass,
    "static_load": StaticLoadOfMount,
    "tilt": Tilt,
    "travel": Travel,
    "energy_share": EnergyShareOfBody,
    "frequency_separation": FrequencySeparation,
    "decay_rate": DecayRateOfModes,
    "mode_ratio": RatioInMode,
    "free_displacement": FreeDisplacement,
    "rms_displacement": RmsDisplacement,
    "rms_velocity": RmsVelocity,
    "rms_acceleration": RmsAcceleration,
    "rms_relative_displacement": RmsRelativeDisplacement,
    "rms_force": RmsForce,
}

__all__ = ["KINDS", "HarmonicResponse", "ModeDampingRatio", "RandomResponse", "Response"]
