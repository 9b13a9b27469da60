"""What is measured: one line per kind of quantity, with its words for messages and its usual units."""

from __future__ import annotations

from typing import Literal, TypeAlias

from vibopt.records import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Dimension:
    """A kind of quantity.

    Attributes
    ----------
    name
        As in code: "angular_rate".
    noun
        With its article, for messages: "a speed of rotation or a frequency".
    si
        SI unit text; "" for a plain number.
    usual
        The unit a forgotten unit most likely was.
    example
        A value as a user writes it.
    units
        Unit texts to propose, the usual ones of the field.
    ladder
        (from this SI value on, unit to show), rising; the first also serves below it.
    """

    name: str
    noun: str
    si: str
    usual: str
    example: str
    units: tuple[str, ...]
    ladder: tuple[tuple[float, str], ...]

    @property
    def way_out(self) -> str:
        """The last sentence of a complaint: 'Write a force, for example "6 kN".'"""
        return f'Write {self.noun}, for example "{self.example}".'


def _dimension(
    name: str, noun: str, si: str, example: str, units: str, ladder: tuple[tuple[float, str], ...] = ()
) -> Dimension:
    """One line of the table; `units` is separated by commas and its first is the usual one."""
    texts = tuple(text.strip() for text in units.split(",")) if units else ()
    usual = texts[0] if texts else ""
    steps = ladder or ((0.0, usual),)
    return Dimension(name=name, noun=noun, si=si, usual=usual, example=example, units=texts, ladder=steps)


_ALL = (
    _dimension("viscosity", "a viscosity", "Pa s", "0.012 Pa s", "Pa s, N s/m2"),
    _dimension(
        "mass",
        "a mass",
        "kg",
        "300 kg",
        "kg, g, mg, t, lb, oz",
        ((0.0, "g"), (1.0, "kg"), (1e5, "t")),
    ),
    _dimension(
        "length",
        "a length",
        "m",
        "20 mm",
        "mm, µm, um, nm, cm, m, km, mil, in, ft",
        ((0.0, "µm"), (1e-5, "mm"), (10.0, "m"), (1e4, "km")),
    ),
    _dimension(
        "velocity",
        "a velocity",
        "m/s",
        "2.8 mm/s",
        "mm/s, m/s, in/s, km/h, mph",
        ((0.0, "mm/s"), (1.0, "m/s")),
    ),
    _dimension("acceleration", "an acceleration", "m/s²", "5 m/s²", "m/s², m/s^2, mm/s², in/s², g, gn, mg"),
    _dimension("jerk", "a jerk", "m/s³", "20 m/s³", "m/s³, m/s^3, mm/s³, in/s³, ft/s³"),
    _dimension("angular_jerk", "an angular jerk", "rad/s³", "20 rad/s³", "rad/s³, rad/s^3, deg/s³"),
    _dimension(
        "force",
        "a force",
        "N",
        "6 kN",
        "N, kN, MN, mN, daN, lbf, lb, kgf",
        ((0.0, "N"), (1e3, "kN"), (1e6, "MN")),
    ),
    _dimension(
        "stiffness",
        "a stiffness",
        "N/m",
        "2 MN/m",
        "N/m, N/mm, kN/m, kN/mm, MN/m, GN/m, lb/in, lbf/in, kgf/mm",
        ((0.0, "N/m"), (1e3, "kN/m"), (1e6, "MN/m"), (1e9, "GN/m")),
    ),
    _dimension(
        "damping",
        "a damping coefficient",
        "N s/m",
        "5 kN s/m",
        "N s/m, N s/mm, kN s/m, kN s/mm, MN s/m, lb s/in, lbf s/in, kg/s",
        ((0.0, "N s/m"), (1e3, "kN s/m"), (1e6, "MN s/m")),
    ),
    _dimension(
        "angular_rate",
        "a speed of rotation or a frequency",
        "rad/s",
        "3000 rpm",
        "rpm, Hz, kHz, cpm, rad/s, deg/s, rev/min, rev/s",
    ),
    _dimension(
        "angular_acceleration",
        "an angular acceleration",
        "rad/s²",
        "50 rpm/s",
        "rpm/s, Hz/s, rad/s², rad/s^2, rpm/min, deg/s²",
    ),
    _dimension(
        "unbalance",
        "an unbalance",
        "kg m",
        "200 g mm",
        "g mm, g cm, kg mm, kg cm, kg m, oz in, lb in",
        ((0.0, "g mm"), (1e-2, "kg mm"), (1e-1, "kg m")),
    ),
    _dimension(
        "moment", "a couple", "N m", "300 N m", "N m, N mm, kN m, lbf in, lbf ft", ((0.0, "N m"), (1e3, "kN m"))
    ),
    _dimension(
        "couple_unbalance",
        "a couple unbalance",
        "kg m²",
        "500 g mm²",
        "g mm², kg mm², kg m², kg cm²",
        ((0.0, "g mm²"), (1e-3, "kg mm²"), (1e-1, "kg m²")),
    ),
    _dimension(
        "inertia",
        "a moment of inertia",
        "kg m²",
        "0.8 kg m²",
        "kg m², g m², kg cm², kg mm², t m², lb ft², lb in²",
        ((0.0, "kg mm²"), (1e-3, "kg m²")),
    ),
    _dimension(
        "torsional_stiffness",
        "a torsional stiffness",
        "N m/rad",
        "40 kN m/rad",
        "N m/rad, kN m/rad, MN m/rad, N mm/rad, N m/deg, lb in/rad, lb ft/rad",
        ((0.0, "N m/rad"), (1e3, "kN m/rad"), (1e6, "MN m/rad")),
    ),
    _dimension(
        "torsional_damping",
        "a torsional damping coefficient",
        "N m s/rad",
        "20 N m s/rad",
        "N m s/rad, kN m s/rad, N mm s/rad, lb in s/rad",
        ((0.0, "N m s/rad"), (1e3, "kN m s/rad")),
    ),
    _dimension(
        "stress",
        "a stress",
        "Pa",
        "80 MPa",
        "MPa, N/mm², GPa, kPa, Pa, psi",
        ((0.0, "Pa"), (1e3, "kPa"), (1e6, "MPa"), (1e9, "GPa")),
    ),
    _dimension("modulus", "a modulus of elasticity", "Pa", "207 GPa", "GPa, MPa, Pa, N/mm², psi"),
    _dimension("second_moment", "a second moment of area", "m⁴", "80 cm⁴", "cm⁴, mm⁴, m⁴, in⁴"),
    _dimension("density", "a density", "kg/m³", "7850 kg/m³", "kg/m³, g/cm³"),
    _dimension("force_density", "a spectral density of force", "N² s/rad", "100 N²/Hz", "N²/Hz, kN²/Hz, lbf²/Hz"),
    _dimension(
        "acceleration_density",
        "a spectral density of acceleration",
        "m²/(s³ rad)",
        "0.01 (m/s²)²/Hz",
        "(m/s²)²/Hz, (mm/s²)²/Hz, g²/Hz",
    ),
    _dimension(
        "displacement_density", "a spectral density of displacement", "m² s/rad", "0.01 mm²/Hz", "mm²/Hz, µm²/Hz, m²/Hz"
    ),
    _dimension("decay_rate", "a decay rate", "1/s", "2 1/s", "1/s"),
    _dimension("ratio", "a ratio", "", "20 %", "%, dB", ((0.0, ""),)),
    _dimension("angle", "an angle", "rad", "30 deg", "deg, rad, mrad, rev"),
    _dimension("wavenumber", "a wavenumber", "rad/m", "0.6 rad/m", "rad/m, rad/mm"),
    _dimension("count", "a whole number", "", "4", ""),
    _dimension(
        "price",
        "a price",
        "money",
        "45 EUR",
        "EUR, USD, GBP, CHF, SEK, NOK, DKK, PLN, CZK, CNY, JPY, INR, KRW, BRL, CAD, AUD",
    ),
    _dimension("level", "a level in decibel", "dB", "14 dB", "dB"),
    _dimension("time", "a time", "s", "0.2 s", "s, ms, min, h", ((0.0, "ms"), (1.0, "s"))),
)

DIMENSIONS: dict[str, Dimension] = {dimension.name: dimension for dimension in _ALL}


def si_unit(dimension: str) -> str:
    """SI unit text of a dimension by name; "" for ratios and counts."""
    return DIMENSIONS[dimension].si


Detector: TypeAlias = Literal["pk", "pp", "rms"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number in SI with the words it was written in.

    Attributes
    ----------
    value
        In SI; speeds of rotation and frequencies in rad/s, ratios as a number, levels in dB.
        An amplitude is peak: pp has been halved, rms multiplied by the root of two (the peak of one sine of that rms).
    unit
        The user's own unit text, with the detector word if there was one ("mm pp"); "" for a bare number.
    detector
        How an amplitude was written; None if no word said so, and then an amplitude is peak.
    echo
        A sentence to show back where the unit was read as the place expects, as in
        '"100 lb/in" read as 100 lbf/in'; else None.
    """

    value: float
    unit: str
    detector: Detector | None = None
    echo: str | None = None
