"""An answer with the prices of what holds it back, both ways and over their ranges."""

from __future__ import annotations

from typing import Any

from vibopt.answer.answer import Answer
from vibopt.study.prices import prices_of_limits, with_prices


def ranged(found: Answer[Any]) -> Answer[Any]:
    every = prices_of_limits(found)
    assert every is not None
    return with_prices(found, every)
