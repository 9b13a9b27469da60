"""Values at the door: what they mean, and that notation does not change it."""

import math
import subprocess
import sys
from math import pi, sqrt

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibopt.units import DIMENSIONS, is_range, read_quantity, read_range
from vibopt.units.spelling import DEFINITIONS, expression, factor_and_dimensionality, symbols

numbers = st.floats(min_value=-1e6, max_value=1e6).filter(lambda number: number == 0 or abs(number) > 1e-6)


@pytest.mark.parametrize(
    ("text", "dimension", "si"),
    [
        ("300 kg", "mass", 300.0),
        ("5 g", "mass", 0.005),
        ("5 mg", "mass", 5e-6),
        ("2 t", "mass", 2000.0),
        ("1 lb", "mass", 0.45359237),
        ("16 oz", "mass", 0.45359237),
        ("20 mm", "length", 0.02),
        ("10 µm", "length", 1e-5),
        ("10 μm", "length", 1e-5),
        ("10 um", "length", 1e-5),
        ("8 mil", "length", 2.032e-4),
        ("1 ft", "length", 0.3048),
        ("2.8 mm/s", "velocity", 0.0028),
        ("36 km/h", "velocity", 10.0),
        ("1 mph", "velocity", 0.44704),
        ("0.1 in/s", "velocity", 0.00254),
        ("1 g", "acceleration", 9.80665),
        ("1 mg", "acceleration", 9.80665e-3),
        ("1 gn", "acceleration", 9.80665),
        ("-9.8 m/s²", "acceleration", -9.8),
        ("6 kN", "force", 6000.0),
        ("1 lbf", "force", 4.4482216152605),
        ("1 lb", "force", 4.4482216152605),
        ("1 kgf", "force", 9.80665),
        ("2 MN/m", "stiffness", 2e6),
        ("5 N/mm", "stiffness", 5000.0),
        ("100 lb/in", "stiffness", 100 * 4.4482216152605 / 0.0254),
        ("5 kN s/m", "damping", 5000.0),
        ("5 N/(mm/s)", "damping", 5000.0),
        ("1 lb s/in", "damping", 4.4482216152605 / 0.0254),
        ("60 rpm", "angular_rate", 2 * pi),
        ("60 cpm", "angular_rate", 2 * pi),
        ("1 kHz", "angular_rate", 2000 * pi),
        ("125.5 rad/s", "angular_rate", 125.5),
        ("1 rev/s", "angular_rate", 2 * pi),
        ("200 g mm", "unbalance", 2e-4),
        ("0.2 kg-m", "unbalance", 0.2),
        ("1 oz in", "unbalance", 0.028349523125 * 0.0254),
        ("0.2", "ratio", 0.2),
        (0.2, "ratio", 0.2),
        (2, "ratio", 2.0),
        ("20 %", "ratio", 0.2),
        ("-20 dB", "ratio", 0.1),
        ("−20 dB", "ratio", 0.1),
        ("14 dB", "level", 14.0),
        ("180 deg", "angle", pi),
        ("90°", "angle", pi / 2),
        ("0.6 rad/m", "wavenumber", 0.6),
        ("4", "count", 4.0),
        (4, "count", 4.0),
        (4.0, "count", 4.0),
        ("50 ms", "time", 0.05),
    ],
)
def test_a_value_means_what_the_field_means(text: object, dimension: str, si: float) -> None:
    assert read_quantity(text, dimension).value == pytest.approx(si, rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "5 kN s/m",
        "5 kN*s/m",
        "5 kN·s/m",
        "5 kN-s/m",
        "5kN s/m",
        "5e3 N s / m",
        "+5. kN s m^-1",
        "5 kN s m⁻¹",
        "5 kNs/m",
    ],
)
def test_products_may_be_written_in_any_way(text: str) -> None:
    assert read_quantity(text, "damping").value == 5000.0


@pytest.mark.parametrize("unit", ["m/s²", "m/s^2", "m/s**2", "m/s2", "m / s ^ 2", "m/s/s", "m s⁻²", "m/(s s)"])
def test_powers_may_be_written_in_any_way(unit: str) -> None:
    assert read_quantity(f"3 {unit}", "acceleration").value == 3.0


@pytest.mark.parametrize("unit", ["(m/s²)²/Hz", "(m/s2)2/Hz", "(m/s^2)^2/Hz", "m2/s4/Hz"])
def test_powers_of_brackets_may_be_written_in_any_way(unit: str) -> None:
    assert read_quantity(f"3 {unit}", "acceleration_density").value == pytest.approx(3.0 / math.tau, rel=1e-15)


def test_1200_rpm_is_20_hertz_to_the_last_bit() -> None:
    assert read_quantity("1200 rpm", "angular_rate").value == read_quantity("20 Hz", "angular_rate").value
    assert read_quantity("1200 rpm", "angular_rate").value == pytest.approx(125.66370614359172, rel=1e-15)


@given(st.integers(min_value=0, max_value=10**6))
def test_sixty_rpm_are_one_hertz(hertz: int) -> None:
    rpm = read_quantity(f"{60 * hertz} rpm", "angular_rate")
    assert rpm.value == read_quantity(f"{hertz} Hz", "angular_rate").value


@given(numbers)
def test_every_dimension_reads_its_own_units_linearly(number: float) -> None:
    for name, dimension in DIMENSIONS.items():
        for unit in dimension.units:
            if unit == "dB" or name == "count":
                continue
            one = read_quantity(f"1 {unit}", name).value
            assert read_quantity(f"{number!r} {unit}", name).value == pytest.approx(number * one, rel=1e-13)


@given(st.floats(min_value=1e-6, max_value=1e6))
def test_an_amplitude_is_peak(number: float) -> None:
    peak = read_quantity(f"{number!r} mm", "length", amplitude=True)
    assert peak.detector is None
    for word in ("pk", "peak", "0-p", "Peak", "(pk)"):
        assert read_quantity(f"{number!r} mm {word}", "length", amplitude=True).value == peak.value
    for word in ("pp", "p-p", "pk-pk", "peak-to-peak", "PP", "(p-p)"):
        assert read_quantity(f"{number!r} mm {word}", "length", amplitude=True).value == pytest.approx(peak.value / 2)
    rms = read_quantity(f"{number!r} mm rms", "length", amplitude=True)
    assert rms.value == pytest.approx(peak.value * sqrt(2))


@pytest.mark.parametrize("text", ["5 grms", "5 g rms", "5 g RMS", "5 g-rms", "5 g_rms", "5 g (rms)"])
def test_the_detector_may_be_glued_to_the_unit(text: str) -> None:
    quantity = read_quantity(text, "acceleration", amplitude=True)
    assert quantity.detector == "rms"
    assert quantity.value == pytest.approx(5 * 9.80665 * sqrt(2))
    assert quantity.unit == text[1:].strip()


@pytest.mark.parametrize(
    ("text", "dimension", "echo"),
    [
        ("100 lb/in", "stiffness", '"100 lb/in" read as 100 lbf/in'),
        ("2.5 lb s/in", "damping", '"2.5 lb s/in" read as 2.5 lbf s/in'),
        ("800 lb", "force", '"800 lb" read as 800 lbf'),
        ("0.5 g rms", "acceleration", '"0.5 g rms" read as 0.5 gn rms (gravity, 9.80665 m/s²)'),
        ("800 lb", "mass", None),
        ("800 lbf", "force", None),
        ("5 g mm", "unbalance", None),
        ("5 m/s²", "acceleration", None),
    ],
)
def test_a_reading_by_place_is_echoed(text: str, dimension: str, echo: str | None) -> None:
    assert read_quantity(text, dimension, amplitude=True).echo == echo


@pytest.mark.parametrize(
    ("text", "low", "high", "units"),
    [
        ("800..2000 rpm", "800 rpm", "2000 rpm", ("rpm", "rpm")),
        ("800 rpm..2000 rpm", "800 rpm", "2000 rpm", ("rpm", "rpm")),
        ("0 .. 3000 rpm", "0 rpm", "3000 rpm", ("rpm", "rpm")),
        ("13.3 Hz..2000 rpm", "13.3 Hz", "2000 rpm", ("Hz", "rpm")),
        ("0.5..1.5 Hz", "0.5 Hz", "1.5 Hz", ("Hz", "Hz")),
    ],
)
def test_a_range_has_two_ends(text: str, low: str, high: str, units: tuple[str, str]) -> None:
    ends = read_range(text, "angular_rate")
    assert [end.value for end in ends] == [read_quantity(end, "angular_rate").value for end in (low, high)]
    assert tuple(end.unit for end in ends) == units


def test_a_range_of_ratios_needs_no_unit() -> None:
    assert [end.value for end in read_range("0.1..0.5", "ratio")] == [0.1, 0.5]
    assert [end.value for end in read_range("10..50 %", "ratio")] == [0.1, 0.5]


def test_a_range_of_amplitudes_shares_the_detector() -> None:
    assert [end.value for end in read_range("10..20 mm pp", "length", amplitude=True)] == [0.005, 0.01]


def test_a_range_is_known_by_its_points() -> None:
    assert is_range("800..2000 rpm")
    assert not is_range("800 rpm")
    assert not is_range(800)


@pytest.fixture(scope="module")
def pints() -> pint.UnitRegistry[float]:
    """Pint with the field's units and no others."""
    return pint.UnitRegistry(str(DEFINITIONS))


def like_pint(pints: pint.UnitRegistry[float], text: str) -> bool:
    """Whether factor and dimensions of a product of units are those that pint finds."""
    unit = pints.parse_units(text)
    factor, powers = factor_and_dimensionality(text)
    exact = pints.Quantity(1.0, unit).to_root_units().magnitude
    return factor == pytest.approx(exact, rel=4e-15, abs=0.0) and dict(powers) == dict(unit.dimensionality)


@pytest.mark.parametrize("symbol", sorted(symbols()))
def test_every_unit_is_the_one_that_pint_reads(pints: pint.UnitRegistry[float], symbol: str) -> None:
    assert like_pint(pints, symbol)


def test_every_proposed_unit_is_the_one_that_pint_reads(pints: pint.UnitRegistry[float]) -> None:
    texts = {text for one in DIMENSIONS.values() for text in (one.si, *one.units)} - {""}
    for text in sorted(texts):
        written = expression(text)
        assert written is not None
        assert like_pint(pints, written), text


@st.composite
def products(draw: st.DrawFn, depth: int = 2) -> str:
    """Units multiplied and divided, with powers, brackets and brackets within brackets."""
    parts = []
    for index in range(draw(st.integers(1, 3))):
        inner = draw(st.booleans()) if depth else False
        unit = f"({draw(products(depth=depth - 1))})" if inner else draw(st.sampled_from(sorted(symbols() - {"dB"})))
        power = draw(st.sampled_from(["", "", "**2", "**3"] if inner else ["", "", "**2", "**-1", "**-3"]))
        parts.append((draw(st.sampled_from("*/")) if index else "") + unit + power)
    return "".join(parts)


@given(products())
def test_every_product_of_units_is_the_one_that_pint_reads(pints: pint.UnitRegistry[float], text: str) -> None:
    assert like_pint(pints, text)


def test_importing_units_loads_no_heavy_library() -> None:
    heavy = "{'pint', 'numpy', 'scipy', 'matplotlib'}"
    program = f"import sys, vibopt.units; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
