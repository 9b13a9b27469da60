"""How easily a limit may be loosened: `soft = 2` weighs it in what comes nearest where not all can hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.values.fields import ReadBy, complaint

_MOST = 1000.0


def _read(given: object) -> float:
    """A weight, greater than zero."""
    number = given if isinstance(given, (int, float)) and not isinstance(given, bool) else math.nan
    if not 1.0 / _MOST <= number <= _MOST:
        raise complaint(
            f"is no weight of a limit. Write a number from {1.0 / _MOST:g} to {_MOST:g}: with soft = 2 a loosening by "
            "20 % counts as one by 10 %."
        )
    return float(number)


Soft = Annotated[
    float | None,
    ReadBy(_read, {"type": "number", "exclusiveMinimum": 0, "description": "how easily the limit may be loosened"}),
]


def softness(limits: Mapping[str, object]) -> dict[str, float]:
    """The weights of the limits that have one, by name."""
    given = {name: getattr(limit, "soft", None) for name, limit in limits.items()}
    return {name: soft for name, soft in given.items() if soft is not None}


def widened(factor: float, soft: float) -> float:
    """By which factor a bound is widened where one without a weight is widened by `factor`: twice the part beyond 1."""
    return 1.0 + soft * (factor - 1.0) if factor > 1.0 else factor


def counted(missed: float, soft: float, *, at_least: bool = False) -> tuple[float, float, float]:
    """Log of one plus the weighed part of its bound by which a limit is missed, with its two derivatives.

    `missed` is the log of the factor by which it is: the part of the bound is exp(missed) - 1, of a limit that asks for
    `at_least` its bound 1 - exp(-missed).  Inverse of `widened` where the limit is missed; where it is met, less the
    log of one plus the weighed part that is left over: its margin.
    """
    sign, turned = (1.0 if missed > 0.0 else -1.0), (-1.0 if at_least else 1.0)
    whole = soft + abs(math.expm1(turned * missed))
    slope = math.exp(turned * missed) / whole
    return sign * math.log(whole / soft), slope, turned * slope - sign * slope**2


def bent(slope: FloatArray, bend: FloatArray | None, first: float, second: float) -> FloatArray | None:
    """Second derivative (n, n) of a function of a value with `slope` (n,) and `bend`; None where that is not known."""
    return None if bend is None else np.asarray(first * bend + second * np.outer(slope, slope))
