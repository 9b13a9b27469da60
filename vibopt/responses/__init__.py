"""Responses: what can be limited, measured or made best.  One kind a file, and a line here.

A new response:

1. `responses/NAME.py`: a `Response`, or a `HarmonicResponse` where something shakes; its keys and class attributes:
   which keys name something (`names`), dimension, whether it is an amplitude, whether it `doubles` with what shakes
   (an energy does not), of what moves along a line or about an axis (`moves`, `twin`), how it is asked of a body in
   space (`in_space`) or of a mount, how many `modes` it needs.
2. `form(model, ...)` (of a harmonic one `output(model)`), the first route: one of the forms of `vibopt.forms`.
   One over speeds that is none of these has `drives` and `against`, by which its curve is drawn.
3. `measure_static(machine)` (of a harmonic one `measure(machine, motion)`), the second route: by other physics
   where there is some.  A motion is of one harmonic, and knows its frequency but not its order.  What is asked
   where something rubs, or of what comes once, has a `trace` beside it, the same read off a course in time.
4. A line below, and where it has a new dimension one in `units/dimensions.py`, behind any other of the same units,
   and the units in `units/definitions.txt`; words for each key under "Keys" in its docstring, of which the manual is
   made.

`tests/laws/test_kinds.py` and `test_every_question.py` then ask it of every place, way, motion and excitation by
both routes; `tests/generator` asks it of random scenes.
"""

from collections import ChainMap

from vibopt.responses.response import HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.values.kinds import Kinds

KINDS: Kinds[Response] = Kinds(
    __name__,
    {
        "transmitted_force": "transmitted.TransmittedForce",
        "transmissibility": "transmitted.Transmissibility",
        "isolation": "transmitted.Isolation",
        "displacement": "motion.Displacement",
        "velocity": "velocity.Velocity",
        "acceleration": "velocity.Acceleration",
        "jerk": "jerk.Jerk",
        "angular_jerk": "jerk.AngularJerk",
        "relative_displacement": "relative_displacement.RelativeDisplacement",
        "bending_stress": "stress.BendingStress",
        "static_bending_stress": "stress.StaticBendingStress",
        "combined_bending_stress": "stress.CombinedBendingStress",
        "bearing_force": "stress.BearingForce",
        "shear_stress": "stress.ShearStress",
        "static_deflection": "static_deflection.StaticDeflection",
        "combined_displacement": "combined_displacement.CombinedDisplacement",
        "natural_frequency": "natural_frequency.NaturalFrequency",
        "critical_speed": "natural_frequency.CriticalSpeed",
        "amplification_factor": "peak_sharpness.AmplificationFactor",
        "damping_ratio": "damping.DampingOfModes",
        "logarithmic_decrement": "damping.LogarithmicDecrement",
        "insertion_loss": "insertion_loss.InsertionLoss",
        "total_mass": "masses.TotalMass",
        "mass": "masses.Mass",
        "stiffness": "parameters.Stiffness",
        "damping": "parameters.Damping",
        "loss_factor": "damping.LossFactor",
        "friction_force": "parameters.FrictionForce",
        "count": "parameters.Count",
        "price": "price.TotalPrice",
        "rotation": "torsion.Rotation",
        "twist": "torsion.Twist",
        "transmitted_moment": "torsion.TransmittedMoment",
        "inertia": "torsion.Inertia",
        "torsional_stiffness": "torsion.TorsionalStiffness",
        "torsional_damping": "torsion.TorsionalDamping",
        "stroke": "absorber_responses.Stroke",
        "own_frequency": "absorber_responses.OwnFrequency",
        "mass_ratio": "absorber_responses.MassRatio",
        "tuning": "absorber_responses.Tuning",
        "absorber_mass": "absorber_responses.AbsorberMass",
        "static_load": "space_responses.StaticLoadOfMount",
        "tilt": "space_responses.Tilt",
        "travel": "space_responses.Travel",
        "energy_share": "space_responses.EnergyShareOfBody",
        "frequency_separation": "space_responses.FrequencySeparation",
        "stability_threshold": "stability_threshold.StabilityThreshold",
        "decay_rate": "decay_rate.DecayRateOfModes",
        "mode_ratio": "mode_ratio.RatioInMode",
        "free_displacement": "free_displacement.FreeDisplacement",
        "rms_displacement": "unsteady.RmsDisplacement",
        "rms_velocity": "unsteady.RmsVelocity",
        "rms_acceleration": "unsteady.RmsAcceleration",
        "rms_relative_displacement": "unsteady.RmsRelativeDisplacement",
        "rms_force": "unsteady.RmsForce",
        "rms_travel": "unsteady.RmsTravel",
        "rms_bending_stress": "stress.RmsBendingStress",
        "peak_displacement": "unsteady.PeakDisplacement",
        "peak_velocity": "unsteady.PeakVelocity",
        "peak_acceleration": "unsteady.PeakAcceleration",
        "peak_relative_displacement": "unsteady.PeakRelativeDisplacement",
        "peak_force": "unsteady.PeakForce",
        "peak_travel": "unsteady.PeakTravel",
        "peak_bending_stress": "stress.PeakBendingStress",
        "gear_torque": "torsion.GearTorque",
    },
)

GOALS = ChainMap[str, type[Response]](KINDS, Kinds[Response](__name__, {"margin": "margin.Margin"}))
"""What can be made best: every response, and what is no response of its own."""

__all__ = ["GOALS", "KINDS", "HarmonicResponse", "RandomResponse", "Response", "TransientResponse"]
