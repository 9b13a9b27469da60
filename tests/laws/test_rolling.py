"""What is said relative to a body that rolls refers to what moves, m + J/r²; its static deflection to its weight."""

from __future__ import annotations

import math

import pytest

import vibopt as vo
from vibopt.mechanics.constants import GRAVITY

TEXT = """
[bodies.r]
mass = "20 kg"
rolling = { inertia = "0.9 kg m2", radius = "0.3 m" }
[links.k]
between = ["r", "ground"]
stiffness = "50 kN/m"
damping_ratio = 0.08
"""
MOVES = 20.0 + 0.9 / 0.3**2
ABSORBER = '[absorbers.t]\non = "r"\nmass_ratio = 0.1\nstiffness = "5 kN/m"\n'
INERTER = '[inerters.i]\nbetween = ["r", "ground"]\nmass_ratio = 0.05\nrelative_to = "r"\n'


def measured(text: str, response: str, of: str) -> float:
    asked = f'[measures.m]\nresponse = "{response}"\n{of}\n'
    return float(vo.solve(vo.from_text(TEXT + text + asked)).measures["m"].value.value)


def test_a_ratio_of_a_body_that_rolls_is_of_what_moves() -> None:
    assert measured("", "damping", 'of = "k"') == pytest.approx(2.0 * 0.08 * math.sqrt(50e3 * MOVES))
    assert measured(ABSORBER, "mass", 'of = "t"') == pytest.approx(0.1 * MOVES)
    assert measured(INERTER, "natural_frequency", "mode = 1") == pytest.approx(math.sqrt(50e3 / (1.05 * MOVES)))


def test_what_rolls_sags_by_its_weight() -> None:
    assert measured("", "static_deflection", 'of = "k"') == pytest.approx(20.0 * GRAVITY / 50e3)
