"""Rotors with slips: each is told once, in words, and a speed far below all critical ones is no slip."""

from __future__ import annotations

import math

import pytest

import vibopt as vo
from refusals import refused

TEXT = """
[rotors.sh]
modulus = "207 GPa"
density = "7850 kg/m3"
sections = [{ length = "800 mm", diameter = "50 mm" }]
stations = { left = "0 mm", right = "800 mm" }
discs = [{ name = "d", at = "300 mm", mass = "30 kg", diametral = "0.3 kg m2", polar = "0.5 kg m2" }]
[links.a]
between = ["left", "ground"]
stiffness = "20 MN/m"
damping = "5 kN s/m"
[links.b]
between = ["right", "ground"]
stiffness = "20 MN/m"
damping = "5 kN s/m"
[excitations.u]
kind = "unbalance"
on = "d"
unbalance = "300 g mm"
speed = "1500..2600 rpm"
[limits.cs]
response = "critical_speed"
outside = { orders = [1], of = "u", margin = "15 %" }
[limits.cd]
response = "combined_displacement"
of = "d"
at_most = "0.2 mm"
""".lstrip()


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        (
            'right = "800 mm"',
            'right = "900 mm"',
            "t line 5: rotors.sh has right at 0.9 m, beyond the end of its shaft at 0.8 m. Write a place on the shaft, "
            "or longer sections.",
        ),
        (
            "modulus =",
            "youngs_modulus =",
            't line 2: unknown key "youngs_modulus" in rotors.sh. Did you mean "modulus"?',
        ),
        ('"50 mm"', '"nan mm"', 't line 4: rotors.sh.sections[1].diameter = "nan mm" is not a finite number.'),
        ("1500..2600 rpm", "inf rpm", 't line 19: excitations.u.speed = "inf rpm" is not a finite number.'),
        (
            '"50 mm"',
            '"1e9 mm"',
            "t line 4: rotors.sh.sections[1] is 1000000 m wide on a shaft of 0.8 m: no shaft is more than 100 times as "
            "thick as it is long. Check the units.",
        ),
        (
            '"50 mm"',
            '"1e-6 mm"',
            "t line 4: rotors.sh is so slender that more than 100 half waves stand on one of its spans at 4478 rpm. "
            "Check the units, write a thicker shaft, or ask for lower speeds.",
        ),
    ],
)
def test_one_slip_is_told_once(right: str, wrong: str, said: str) -> None:
    assert str(refused(vo.from_text, TEXT.replace(right, wrong), name="t")) == said


@pytest.mark.parametrize("speed", ["0 rpm", "1 rpm", "0..50 rpm"])
def test_slow_speeds_are_outside_all_critical_ones(speed: str) -> None:
    """The nearest is the lowest, as it is told by itself; of a band at rest there is no part."""
    lowest = '[measures.lowest]\nresponse = "critical_speed"\n'
    found = vo.solve(vo.from_text(TEXT.replace("1500..2600 rpm", speed) + lowest))
    assert found.status == "met", found.claim
    row = found.limits["cs"]
    assert row.value.value == pytest.approx(found.measures["lowest"].value.value, rel=1e-9)
    assert (row.margin == math.inf) == (speed == "0 rpm")
