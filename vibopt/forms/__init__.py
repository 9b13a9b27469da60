"""What a limit is made of once the words are gone.

A response lowers itself to one of the forms below.  Each is data, and says beside it what the methods ask of a form:
its value, slope, bounds and rows, or in words why there are none (`vibopt.forms.form`).
"""

from __future__ import annotations

from vibopt.forms.damped import DecayRate, FreeMotion, ModeDamping
from vibopt.forms.form import Form
from vibopt.forms.modulus import Modulus
from vibopt.forms.monomials import Monomials
from vibopt.forms.peak_in_run_up import PeakInRunUp
from vibopt.forms.peak_in_time import PeakInTime
from vibopt.forms.root_mean_square import RootMeanSquare
from vibopt.forms.sags import StaticForce, StaticLoad, StaticRow
from vibopt.forms.undamped import EnergyShare, ModeFrequency, ModeGap, ModeRatio

FORMS: tuple[type[Form], ...] = (
    DecayRate,
    EnergyShare,
    FreeMotion,
    ModeDamping,
    ModeFrequency,
    ModeGap,
    ModeRatio,
    Modulus,
    Monomials,
    PeakInRunUp,
    PeakInTime,
    RootMeanSquare,
    StaticForce,
    StaticLoad,
    StaticRow,
)

__all__ = [
    "FORMS",
    "DecayRate",
    "EnergyShare",
    "Form",
    "FreeMotion",
    "ModeDamping",
    "ModeFrequency",
    "ModeGap",
    "ModeRatio",
    "Modulus",
    "Monomials",
    "PeakInRunUp",
    "PeakInTime",
    "RootMeanSquare",
    "StaticForce",
    "StaticLoad",
    "StaticRow",
]
