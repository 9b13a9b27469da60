"""Balance quality grades: the velocity that one stands for, and the unbalance that it permits."""

import re


def grade_velocity(given: object) -> object:
    """A grade by its name, "G6.3" or "G 2,5", as the velocity that it stands for; anything else as it is."""
    named = re.fullmatch(r"\s*[Gg]\s*-?\s*(\d+(?:[.,]\d+)?)(?:\s*mm/s)?\s*", given) if isinstance(given, str) else None
    return given if named is None else f"{named[1].replace(',', '.')} mm/s"


def permissible_unbalance(grade: float, mass: float, speed: float) -> float:
    """Of a whole rotor [kg m]: grade [m/s] times mass [kg] over its highest service speed [rad/s] (ISO 21940-11)."""
    return mass * grade / speed
