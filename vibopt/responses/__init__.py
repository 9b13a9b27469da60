"""Responses: what can be limited, measured or made best.  One kind a file."""

from vibopt.responses.kind import HarmonicResponse, RandomResponse, Response
from vibopt.values.kinds import Kinds

KINDS: Kinds[Response] = Kinds(
    __name__,
    {
        "transmitted_force": "transmitted.TransmittedForce",
        "transmissibility": "transmitted.Transmissibility",
        "isolation": "transmitted.Isolation",
        "displacement": "motion.Displacement",
        "velocity": "motion.Velocity",
        "acceleration": "motion.Acceleration",
        "relative_displacement": "motion.RelativeDisplacement",
        "static_deflection": "static_deflection.StaticDeflection",
        "natural_frequency": "natural_frequency.NaturalFrequency",
        "damping_ratio": "damping.DampingOfModes",
        "insertion_loss": "insertion_loss.InsertionLoss",
        "total_mass": "parameters.TotalMass",
        "mass": "parameters.Mass",
        "stiffness": "parameters.Stiffness",
        "damping": "parameters.Damping",
        "loss_factor": "damping.LossFactor",
        "count": "parameters.Count",
        "price": "price.TotalPrice",
        "rotation": "torsion.Rotation",
        "twist": "torsion.Twist",
        "transmitted_moment": "torsion.TransmittedMoment",
        "inertia": "torsion.Inertia",
        "torsional_stiffness": "torsion.TorsionalStiffness",
        "torsional_damping": "torsion.TorsionalDamping",
        "stroke": "absorbers.Stroke",
        "own_frequency": "absorbers.OwnFrequency",
        "mass_ratio": "absorbers.MassRatio",
        "tuning": "absorbers.Tuning",
        "absorber_mass": "absorbers.AbsorberMass",
        "static_load": "spatial.StaticLoadOfMount",
        "tilt": "spatial.Tilt",
        "travel": "spatial.Travel",
        "energy_share": "spatial.EnergyShareOfBody",
        "frequency_separation": "spatial.FrequencySeparation",
        "decay_rate": "decay_rate.DecayRateOfModes",
        "mode_ratio": "mode_ratio.RatioInMode",
        "free_displacement": "free_displacement.FreeDisplacement",
        "rms_displacement": "random.RmsDisplacement",
        "rms_velocity": "random.RmsVelocity",
        "rms_acceleration": "random.RmsAcceleration",
        "rms_relative_displacement": "random.RmsRelativeDisplacement",
        "rms_force": "random.RmsForce",
    },
)

__all__ = ["KINDS", "HarmonicResponse", "RandomResponse", "Response"]
