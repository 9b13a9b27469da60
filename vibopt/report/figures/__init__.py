"""Figures: responses against speed, the plane of two design variables, strokes and modes of absorbers, a sweep.

Drawn for paper as well as for the screen: forbidden zones are hatched and lines differ by style, so that
nothing is lost in grey.  Matplotlib is loaded when something is drawn, and none of its global state is touched.
"""

from vibopt.report.figures.absorber_modes import below
from vibopt.report.figures.contours import plane_figure
from vibopt.report.figures.paper import saved
from vibopt.report.figures.response_curves import response_figure
from vibopt.report.figures.sweep_map import map_figure
from vibopt.report.figures.sweep_strips import strips_figure
from vibopt.report.figures.tradeoff_curve import tradeoff_figure

__all__ = ["below", "map_figure", "plane_figure", "response_figure", "saved", "strips_figure", "tradeoff_figure"]
