"""What a limit is made of once the words are gone.

A response lowers itself to one of the forms below.  Each is data, and says beside it what the methods ask of a form:
its value, slope, bounds and rows, or in words why there are none (`vibopt.forms.form`).
"""

from typing import TYPE_CHECKING

from vibopt.forms.form import Form
from vibopt.values.kinds import Kinds

FORMS: Kinds[Form] = Kinds(
    __name__,
    {
        "Added": "added.Added",
        "Amplification": "amplification.Amplification",
        "DampedCriticalSpeed": "whirling.DampedCriticalSpeed",
        "DecayRate": "damped.DecayRate",
        "EnergyShare": "undamped.EnergyShare",
        "FreeMotion": "damped.FreeMotion",
        "LogDecrement": "damped.LogDecrement",
        "ModeDamping": "damped.ModeDamping",
        "ModeFrequency": "undamped.ModeFrequency",
        "ModeGap": "undamped.ModeGap",
        "ModeRatio": "undamped.ModeRatio",
        "Modulus": "modulus.Modulus",
        "Monomials": "monomials.Monomials",
        "Orbit": "orbit.Orbit",
        "PeakInRunUp": "peak_in_run_up.PeakInRunUp",
        "PeakInTime": "peak_in_time.PeakInTime",
        "PeakRubbing": "peak_rubbing.PeakRubbing",
        "PeakOverDurations": "any_duration.PeakOverDurations",
        "RootMeanSquare": "root_mean_square.RootMeanSquare",
        "Rubbing": "rubbing.Rubbing",
        "RubbingOfSeveral": "rubbing_of_several.RubbingOfSeveral",
        "StaticForce": "sags.StaticForce",
        "StaticLoad": "sags.StaticLoad",
        "StaticBending": "sags.StaticBending",
        "StaticMoment": "sags.StaticMoment",
        "StaticRow": "sags.StaticRow",
        "WhirlDamping": "whirling.WhirlDamping",
        "WhirlThreshold": "whirling.WhirlThreshold",
    },
)
"""By name; the file of a form is read when something is made of it."""

if TYPE_CHECKING:
    from vibopt.forms.added import Added
    from vibopt.forms.amplification import Amplification
    from vibopt.forms.any_duration import PeakOverDurations
    from vibopt.forms.damped import DecayRate, FreeMotion, LogDecrement, ModeDamping
    from vibopt.forms.modulus import Modulus
    from vibopt.forms.monomials import Monomials
    from vibopt.forms.orbit import Orbit
    from vibopt.forms.peak_in_run_up import PeakInRunUp
    from vibopt.forms.peak_in_time import PeakInTime
    from vibopt.forms.peak_rubbing import PeakRubbing
    from vibopt.forms.root_mean_square import RootMeanSquare
    from vibopt.forms.rubbing import Rubbing
    from vibopt.forms.rubbing_of_several import RubbingOfSeveral
    from vibopt.forms.sags import StaticBending, StaticForce, StaticLoad, StaticMoment, StaticRow
    from vibopt.forms.undamped import EnergyShare, ModeFrequency, ModeGap, ModeRatio
    from vibopt.forms.whirling import DampedCriticalSpeed, WhirlDamping, WhirlThreshold
else:

    def __getattr__(name: str) -> type[Form]:
        if name not in FORMS:
            raise AttributeError(f"vibopt.forms has no {name!r}")
        return FORMS[name]


__all__ = [
    "FORMS",
    "Added",
    "Amplification",
    "DampedCriticalSpeed",
    "DecayRate",
    "EnergyShare",
    "Form",
    "FreeMotion",
    "LogDecrement",
    "ModeDamping",
    "ModeFrequency",
    "ModeGap",
    "ModeRatio",
    "Modulus",
    "Monomials",
    "Orbit",
    "PeakInRunUp",
    "PeakInTime",
    "PeakOverDurations",
    "PeakRubbing",
    "RootMeanSquare",
    "Rubbing",
    "RubbingOfSeveral",
    "StaticBending",
    "StaticForce",
    "StaticLoad",
    "StaticMoment",
    "StaticRow",
    "WhirlDamping",
    "WhirlThreshold",
]
