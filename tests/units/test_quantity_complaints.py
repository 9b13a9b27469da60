"""Every complaint about a value, word for word."""

import re
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibopt.errors import QuantityError
from vibopt.units import DIMENSIONS, read_quantity, read_range

_OFF = 'Write "12 kg" alone, or { value = "12 kg", tolerance = "5 %" } where a number may be off.'

COMPLAINTS: list[tuple[object, str, str]] = [
    *(
        (text, "mass", f"is a value and a tolerance at once. {_OFF}")
        for text in (
            "12 kg +- 5 %",
            "12 kg ± 5 %",
            "12kg+/-5%",
            "12 kg (±5 %)",
            "12 ± 0.6 kg",
            "12 kg ± 0.6 kg",
        )
    ),
    (
        "20 ± 10 %",
        "length",
        (
            'is a value and a tolerance at once. Write "20 mm" alone, '
            'or { value = "20 mm", tolerance = "10 %" } where a number may be off.'
        ),
    ),
    (
        "3000 rpm ± 50 rpm",
        "angular_rate",
        'is a value and a tolerance at once. Write "3000 rpm" alone, or "2950..3050 rpm" for each.',
    ),
    (480, "mass", 'has no unit. Write "480 kg".'),
    ("480", "mass", 'has no unit. Write "480 kg".'),
    (20.5, "length", 'has no unit. Write "20.5 mm".'),
    (3000, "angular_rate", 'has no unit. Write "3000 rpm".'),
    (0.8, "length", 'has no unit. Write "0.8 m".'),
    (4, "length", 'has no unit. Write "4 mm" or "4 m".'),
    (1500, "stiffness", 'has no unit. Write "1500 N/m" or "1500 kN/m".'),
    (50, "stiffness", 'has no unit. Write "50 kN/m".'),
    (1.5e6, "stiffness", 'has no unit. Write "1500000.0 N/m".'),
    (50, "angular_rate", 'has no unit. Write "50 Hz".'),
    (0.09, "unbalance", 'has no unit. Write "0.09 kg m".'),
    ("6 mm", "force", 'is a length, but a force is needed here. Write a force, for example "6 kN".'),
    ("6 kN", "length", 'is a force, but a length is needed here. Write a length, for example "20 mm".'),
    (
        "6 s",
        "angular_rate",
        (
            "is a time, but a speed of rotation or a frequency is needed here. "
            'Write a speed of rotation or a frequency, for example "3000 rpm".'
        ),
    ),
    (
        "1480 1/min",
        "angular_rate",
        'is a decay rate, but a speed of rotation or a frequency is needed here. Did you mean "rpm"?',
    ),
    ("8 mil", "angle", 'is a length, but an angle is needed here. Write an angle, for example "30 deg".'),
    ("5 rad", "ratio", 'is an angle, but a ratio is needed here. Write a ratio, for example "20 %".'),
    (
        "20 %",
        "level",
        'is a ratio, but a level in decibel is needed here. Write a level in decibel, for example "14 dB".',
    ),
    ("5 N m", "force", 'is a couple, but a force is needed here. Write a force, for example "6 kN".'),
    ("4 %", "count", 'is a ratio, but a whole number is needed here. Write a whole number, for example "4".'),
    ("4.5", "count", 'is not a whole number. Write a whole number, for example "4".'),
    ("20 kn", "force", 'has the unknown unit "kn". Did you mean "kN"?'),
    ("20 mn", "force", 'has the unknown unit "mn". Did you mean "MN" or "mN"?'),
    ("20 RPM", "angular_rate", 'has the unknown unit "RPM". Did you mean "rpm"?'),
    (
        "5 Ns/m",
        "stiffness",
        'is a damping coefficient, but a stiffness is needed here. Write a stiffness, for example "2 MN/m".',
    ),
    ("5 lbs/in", "stiffness", 'has the unknown unit "lbs/in". Did you mean "lb/in"?'),
    ("5 furlong", "mass", 'has the unknown unit "furlong". Units of a mass: kg, g, mg, t, lb, oz.'),
    ("5 mounts", "count", 'has the unknown unit "mounts". Write a whole number, for example "4".'),
    ("nan kg", "mass", "is not a finite number."),
    ("-inf N", "force", "is not a finite number."),
    (float("nan"), "ratio", "is not a finite number."),
    (float("inf"), "ratio", "is not a finite number."),
    ("1e31 N", "force", "is beyond what any machine has (|value| > 1e30 in SI)."),
    ("1e400 N", "force", "is beyond what any machine has (|value| > 1e30 in SI)."),
    ("1e5 dB", "ratio", "is beyond what any machine has (|value| > 1e30 in SI)."),
    (10**400, "ratio", "is beyond what any machine has (|value| > 1e30 in SI)."),
    (True, "count", 'is true or false, but a whole number is needed here. Write a whole number, for example "4".'),
    ([1], "mass", 'is no value with a unit, but a mass is needed here. Write a mass, for example "300 kg".'),
    (None, "mass", 'is no value with a unit, but a mass is needed here. Write a mass, for example "300 kg".'),
    ("1,5 mm", "length", 'has a decimal comma; write a point for the decimals: "1.5 mm".'),
    ("0,125 mm", "length", 'has a decimal comma; write a point for the decimals: "0.125 mm".'),
    ("1,500 rpm", "angular_rate", 'has a comma that can be read in two ways. Write "1500 rpm" or "1.500 rpm".'),
    ("1 000 N", "force", 'has a separator inside its number. Write "1000 N".'),
    ("1,200.5 N", "force", 'has a separator inside its number. Write "1200.5 N".'),
    ("", "mass", 'is empty. Write a mass, for example "300 kg".'),
    ("  ", "mass", 'is empty. Write a mass, for example "300 kg".'),
    ("heavy", "mass", 'does not start with one number. Write a mass, for example "300 kg".'),
    ("3..5 kg", "mass", 'is a range, but one value is needed here. Write a mass, for example "300 kg".'),
    ("3-5 kg", "mass", 'looks like a range. Write it with two points: "3..5 kg".'),
    ("3 to 5 kg", "mass", 'looks like a range. Write it with two points: "3..5 kg".'),
    (
        "20 mm pp",
        "length",
        'says "pp", but only an amplitude can be peak, peak-to-peak or rms. Write "20 mm".',
    ),
]


@pytest.mark.parametrize(("given", "dimension", "complaint"), COMPLAINTS)
def test_each_complaint_says_what_is_wrong_and_the_way_out(given: object, dimension: str, complaint: str) -> None:
    with pytest.raises(QuantityError) as caught:
        read_quantity(given, dimension)
    assert caught.value.complaint == complaint
    assert str(caught.value) == complaint


@pytest.mark.parametrize("dimension", [one for one in DIMENSIONS if DIMENSIONS[one].usual])
@pytest.mark.parametrize("power", range(-6, 8))
def test_what_a_bare_number_is_offered_can_be_read(dimension: str, power: int) -> None:
    """At least one text, at most two, each the number with a unit of the dimension."""
    number = f"{3 * 10.0**power:.10g}"
    for amplitude in (False, True):
        try:
            read_quantity(number, dimension, amplitude=amplitude)
        except QuantityError as error:
            offered = re.findall(r'"([^"]*)"', error.complaint)
            assert 1 <= len(offered) <= 2
            for text in offered:
                assert text.startswith(f"{number} ")
                assert read_quantity(text, dimension).value > 0.0
        else:
            assert dimension == "ratio"


def test_a_bound_and_an_amplitude_are_small() -> None:
    for words in ({"amplitude": True}, {"place": "static_deflection"}):
        with pytest.raises(QuantityError, match=r'^has no unit\. Write "0\.8 mm"\.$'):
            read_quantity("0.8", "length", **words)


def test_a_forgotten_unit_keeps_the_detector() -> None:
    with pytest.raises(QuantityError) as caught:
        read_quantity("20 pp", "length", amplitude=True)
    assert caught.value.complaint == 'has no unit. Write "20 mm pp".'


def test_the_place_is_named_where_it_is_known() -> None:
    with pytest.raises(QuantityError) as caught:
        read_quantity("6 mm", "force", place="transmitted_force")
    wanted = 'is a length, but transmitted_force is a force. Write a force, for example "6 kN".'
    assert caught.value.complaint == wanted


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("2000..800 rpm", 'runs downwards: its lower end is above its upper end. Write "800 rpm..2000 rpm".'),
        ("5 rpm..5 rpm", 'is empty: both ends are the same. Write the one value, "5 rpm", or a wider range.'),
        ("800..2000", 'has no unit. Write "800..2000 rpm".'),
        ("..3 rpm", 'has no lower end. Write a range, for example "0..3000 rpm".'),
        ("3 rpm..", 'has no upper end. Write a range, for example "0..3000 rpm".'),
        ("1...2 rpm", 'is no range with two points between its ends. Write a range, for example "0..3000 rpm".'),
        ("1..2..3 rpm", 'is no range with two points between its ends. Write a range, for example "0..3000 rpm".'),
        ("800..2000 rp", 'has the unknown unit "rp". Did you mean "rpm"?'),
        ("800 rpm..2000", 'has the upper end "2000", which has no unit. Write "2000 rpm".'),
        (
            "3 mm..5 rpm",
            (
                'has the lower end "3 mm", which is a length, but a speed of rotation or a frequency is needed here. '
                'Write a speed of rotation or a frequency, for example "3000 rpm".'
            ),
        ),
        (
            "1,5..2 rpm",
            'has the lower end "1,5", which has a decimal comma; write a point for the decimals: "1.5".',
        ),
    ],
)
def test_each_complaint_about_a_range(text: str, complaint: str) -> None:
    with pytest.raises(QuantityError) as caught:
        read_range(text, "angular_rate")
    assert caught.value.complaint == complaint


@pytest.mark.parametrize(
    "unit", ["kg//m", "kg*", "*kg", "(kg", "kg)", "s-1", "N 3", "m s-2", "kg m 1", "()", "kgs", "ukg"]
)
def test_a_unit_that_is_no_product_of_units_is_unknown(unit: str) -> None:
    with pytest.raises(QuantityError, match="has the unknown unit"):
        read_quantity(f"1 {unit}", "stiffness")


@given(st.text() | st.text("0123456789.,eE+- kNmsrp/^*()%°²", min_size=1), st.sampled_from(sorted(DIMENSIONS)))
def test_any_text_is_read_or_refused(text: str, dimension: str) -> None:
    for read in (read_quantity, read_range):
        with suppress(QuantityError):
            read(text, dimension, amplitude=True)
