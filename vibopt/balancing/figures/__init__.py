"""Figures of a balancing answer: dials of planes and readings, bars of what is left, forces of an engine.

On every dial the rotor turns counter-clockwise and zero is on top; what stands for what differs in shape as well as in
colour, so that nothing is lost in grey.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.balancing import is_known, is_rotor

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure_of(answer: Answer[Any], *, compact: bool = False) -> Figure | None:
    """Picture of a balancing answer, `compact` for a page that holds more; None where there is nothing to draw."""
    if is_rotor(answer.job):
        from vibopt.balancing.figures.rotor_figure import plan_figure

        return plan_figure(answer, compact=compact)
    if is_known(answer.job):
        from vibopt.balancing.figures.known_figure import known_figure

        return known_figure(answer, compact=compact)
    from vibopt.balancing.figures.engine_figure import engine_figure

    return engine_figure(answer, compact=compact)


__all__ = ["figure_of"]
