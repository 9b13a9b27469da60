"""Values on the way out: plain digits in the user's unit."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibopt.units import DIMENSIONS, best_unit, plain, read_quantity, show, si_unit, to_unit

sizes = st.floats(min_value=1e-6, max_value=1e9)
places = st.sampled_from([(name, unit) for name, kind in DIMENSIONS.items() for unit in kind.units])


@pytest.mark.parametrize(
    ("value", "unit", "dimension", "text"),
    [
        (6.95712e6, "MN/m", "stiffness", "6.957 MN/m"),
        (0.02, "mm", "length", "20 mm"),
        (12345.6, "N", "force", "12346 N"),
        (1e6, "N", "force", "1000000 N"),
        (0.2, "", "ratio", "0.2"),
        (0.2, "%", "ratio", "20 %"),
        (0.999, "%", "ratio", "99.9 %"),
        (0.999999, "%", "ratio", "99.9999 %"),
        (1.0 - 1e-12, "%", "ratio", "100 %"),
        (1.00001, "%", "ratio", "100 %"),
        (0.1, "dB", "ratio", "-20 dB"),
        (-0.1, "dB", "ratio", "-10 %"),
        (0.0, "dB", "ratio", "0 %"),
        (4.0, "", "count", "4"),
        (0.0, "", "force", "0 N"),
        (inf, "mm", "length", "infinite"),
        (-inf, "mm", "length", "minus infinite"),
        (nan, "mm", "length", "not a number"),
        (17512.683524647637, "lb/in", "stiffness", "100 lb/in"),
        (950.0, "", "force", "950 N"),
        (3e6, "", "stiffness", "3 MN/m"),
        (5000.0, "", "damping", "5 kN s/m"),
        (0.02, "", "length", "20 mm"),
        (314.1592653589793, "", "angular_rate", "3000 rpm"),
        (-2500.0, "", "force", "-2.5 kN"),
    ],
)
def test_a_value_is_shown_as_its_user_would_write_it(value: float, unit: str, dimension: str, text: str) -> None:
    assert show(value, unit, dimension) == text


@pytest.mark.parametrize(
    ("unit", "text"),
    [
        ("mm", "10 mm pk"),
        ("mm pk", "10 mm pk"),
        ("mm peak", "10 mm peak"),
        ("mm pp", "20 mm pp"),
        ("mm p-p", "20 mm p-p"),
        ("mm rms", "7.071 mm rms"),
        ("", "10 mm pk"),
    ],
)
def test_an_amplitude_says_its_detector(unit: str, text: str) -> None:
    assert show(0.01, unit, "length", amplitude=True) == text


@given(places, sizes, st.sampled_from(["", "pk", "pp", "rms"]))
def test_what_is_shown_reads_back(place: tuple[str, str], number: float, word: str) -> None:
    dimension, unit = place
    if unit == "dB":
        number = min(number, 100.0)
    value = read_quantity(f"{number!r} {unit} {word}".strip(), dimension, amplitude=True).value
    shown = show(value, f"{unit} {word}".strip(), dimension, digits=15, amplitude=True)
    assert read_quantity(shown, dimension, amplitude=True).value == pytest.approx(value, rel=1e-11)


@given(places, sizes)
def test_to_unit_undoes_reading(place: tuple[str, str], number: float) -> None:
    dimension, unit = place
    if unit == "dB":
        number = min(number, 100.0)
    value = read_quantity(f"{number!r} {unit}", dimension).value
    assert to_unit(value, unit, dimension) == pytest.approx(number, rel=1e-13, abs=1e-13)


@given(st.sampled_from(sorted(DIMENSIONS)), st.floats(min_value=-1e12, max_value=1e12))
def test_the_best_unit_belongs_to_the_dimension(dimension: str, value: float) -> None:
    shown = show(value, best_unit(value, dimension), dimension, digits=12)
    if dimension != "count":
        assert read_quantity(shown, dimension).value == pytest.approx(value, rel=1e-10, abs=1e-300)


@pytest.mark.parametrize("dimension", sorted(DIMENSIONS))
def test_the_si_unit_is_one(dimension: str) -> None:
    assert read_quantity(f"1 {si_unit(dimension)}", dimension).value == 1.0


@pytest.mark.parametrize("dimension", sorted(DIMENSIONS))
def test_the_example_of_a_dimension_can_be_read(dimension: str) -> None:
    assert read_quantity(DIMENSIONS[dimension].example, dimension).value > 0


@given(st.floats(min_value=1e-6, max_value=1e14), st.integers(min_value=1, max_value=15))
def test_plain_digits_keep_the_number(number: float, digits: int) -> None:
    text = plain(number, digits)
    assert "e" not in text
    assert float(text) == pytest.approx(number, rel=0.51 * 10.0 ** (1 - digits))


@pytest.mark.parametrize(
    ("number", "text"),
    [(9.99996, "10"), (0.000123456, "0.0001235"), (-0.0, "0"), (1000.0, "1000"), (1.5e-9, "1.5e-9"), (2e20, "2e20")],
)
def test_plain_digits(number: float, text: str) -> None:
    assert plain(number) == text


def test_decibels_of_a_negative_ratio_do_not_exist() -> None:
    with pytest.raises(ValueError, match="domain"):
        to_unit(-0.2, "dB", "ratio")
