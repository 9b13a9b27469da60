"""Absorber scenes on hard ground, family by family; every answer is a closed form or stands in forty digits."""

from __future__ import annotations

import math

from vibopt.study.chart.absorbers.cases import absorbed, least_peak
from vibopt.study.chart.cases import FEASIBLE, INFEASIBLE, Case

_CLOSED = "closed form (Nishihara and Asami)"
_STATIC = 1e-5
_OWN = math.sqrt(1000.0)


def families() -> list[Case]:
    """All cases, those of a family next to each other."""
    return [*small_masses(), *out_of_reach(), *fixed_stroke(), *edges(), *like_modes()]


def small_masses() -> list[Case]:
    """Mass ratios down to 1e-6: two peaks that lie ever nearer together."""
    return [
        Case(f"mass ratio {mu:g}", absorbed([0], [mu], least_damping=1e-6), FEASIBLE, least_peak(mu) * _STATIC, _CLOSED,
             "small absorbers")
        for mu in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    ]  # fmt: skip


def _limited(parts: float) -> str:
    """Least damping of an absorber under a limit of so many times the least possible peak."""
    most = parts * least_peak(0.05) * _STATIC
    bound = f'[limits.amplitude]\nresponse = "displacement"\nof = "m0"\nat_most = "{most!r} m"'
    return absorbed([0], [0.05], extra=bound, goal='[goal]\nminimise = "damping_ratio"\nof = "a0"')


def out_of_reach() -> list[Case]:
    """A limit a hair below the least peak that any absorber of that mass can reach."""
    return [
        Case(
            f"limit {part:g} below the least peak", _limited(1.0 - part), INFEASIBLE, math.nan, _CLOSED, "out of reach"
        )
        for part in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
    ]


def fixed_stroke() -> list[Case]:
    """At the resonance of the locked machine the stroke is (1 + mu)/mu static deflections, whatever the absorber."""
    cases = []
    for mu in (0.2, 0.05, 0.01, 0.001):
        bound = 0.999 * (1.0 + mu) / mu * _STATIC
        extra = f'[limits.stroke]\nresponse = "stroke"\nof = "a0"\nat_most = "{bound!r} m"'
        text = absorbed([0], [mu], extra=extra)
        cases.append(
            Case(f"stroke at mass ratio {mu:g}", text, INFEASIBLE, math.nan, "closed form", "stroke out of reach")
        )
    return cases


def edges() -> list[Case]:
    """The band begins or ends on the resonance of the bare machine: no closed form, equal peaks in 40 digits."""
    above = absorbed([0], [0.05], speeds=(_OWN, 100.0), least_damping=0.0)
    below = absorbed([0], [0.05], speeds=(5.0, _OWN), least_damping=0.0)
    return [
        Case(
            "band from the resonance on", above, FEASIBLE, EDGES[0], "equal peaks in 40 digits", "edge on a resonance"
        ),
        Case("band up to the resonance", below, FEASIBLE, EDGES[1], "equal peaks in 40 digits", "edge on a resonance"),
    ]


EDGES = (3.6537468181360059676e-5, 5.3959542036293631977e-5)
"""Least greatest amplitude with the band above, and below, the resonance of the bare mass [m]."""


def like_modes() -> list[Case]:
    """A second machine with nearly the same frequency, hardly coupled: the answer of the first alone."""
    cases = []
    for apart in (1e-3, 1e-6, 1e-9):
        twin = (
            '[bodies.twin]\nmass = "100 kg"\n[links.feet]\nbetween = ["ground", "twin"]\n'
            f'stiffness = "{1e5 * (1 + apart)!r} N/m"\n'
            'damping_ratio = 0.05\nrelative_to = "twin"\n[links.pipe]\nbetween = ["m0", "twin"]\nstiffness = "1e-6 N/m"'
        )
        text = absorbed([0], [0.05], extra=twin).replace(
            "tuning = {", 'tuning_to = "31.622776601683793 rad/s"\ntuning = {'
        )
        cases.append(Case(f"twin {apart:g} apart", text, FEASIBLE, least_peak(0.05) * _STATIC, _CLOSED, "like modes"))
    return cases
