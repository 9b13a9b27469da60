"""Machines with absorbers said in every way, and the same machines written out as bodies and links by plain numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import strategies as st

G = 9.80665
Table = dict[str, Any]


@dataclass
class Drawn:
    """A document with absorbers, the values chosen in it by path, and its twin of bodies and links alone."""

    document: Table
    twin: Table
    chosen: dict[str, float] = field(default_factory=dict)
    numbers: dict[str, tuple[float, float, float, float]] = field(default_factory=dict)
    hosts: dict[str, str] = field(default_factory=dict)
    references: dict[str, float] = field(default_factory=dict)
    bases: dict[str, float] = field(default_factory=dict)


def natural(masses: dict[str, float], links: list[tuple[str, str, float]]) -> np.ndarray[Any, Any]:
    """Natural frequencies of masses on springs [rad/s]."""
    names = list(masses)
    stiff = np.zeros((len(names), len(names)))
    for a, b, k in links:
        row = np.array([float(one == b) - float(one == a) for one in names])
        stiff += k * np.outer(row, row)
    root = np.diag(1.0 / np.sqrt(list(masses.values())))
    return np.asarray(np.sqrt(np.abs(np.linalg.eigvalsh(root @ stiff @ root))))


class Pen:
    """Writes values, as facts or as choices."""

    def __init__(self, draw: Callable[..., Any], drawn: Drawn) -> None:
        self.draw, self.drawn = draw, drawn

    def number(self, low: float, high: float) -> float:
        size = self.draw(st.floats(np.log(low), np.log(high)))
        return float(f"{np.exp(size):.6g}")

    def say(self, path: str, value: float, unit: str) -> Any:
        """The value as it stands in the file: a fact, or a range that holds it."""

        def text(one: float) -> Any:
            return f"{one!r} {unit}" if unit else one

        if not self.draw(st.booleans()):
            return text(value)
        self.drawn.chosen[path] = value
        return {"from": text(0.5 * value), "to": text(2.0 * value)}


@st.composite
def machines(draw: Callable[..., Any]) -> Drawn:
    """Bodies on springs with up to three absorbers: in parallel, in series, pendulums, Lanchester dampers."""
    drawn = Drawn({}, {})
    pen = Pen(draw, drawn)
    names = ["a", "b"][: draw(st.integers(1, 2))]
    masses = {name: pen.number(10.0, 1000.0) for name in names}
    springs = [("ground" if i == 0 else names[i - 1], name, pen.number(1e4, 1e6)) for i, name in enumerate(names)]
    damping = pen.number(1.0, 1e3)
    bodies = {name: {"mass": f"{mass!r} kg"} for name, mass in masses.items()}
    links = {
        f"s{i}": {"between": [a, b], "stiffness": f"{k!r} N/m", "damping": f"{damping!r} N s/m"}
        for i, (a, b, k) in enumerate(springs)
    }
    frame = {"title": "drawn", "excitations": {"shaker": _shaker(draw(st.sampled_from(names)))}}
    drawn.document = {**frame, "bodies": bodies, "links": links, "absorbers": {}}
    drawn.twin = {**frame, "bodies": dict(bodies), "links": dict(links)}
    omega = natural(masses, springs)
    for name in ["t1", "t2", "t3"][: draw(st.integers(1, 3))]:
        host = draw(st.sampled_from(list(masses)))
        table = {"on": host}
        numbers = _absorber(pen, name, table, masses, omega)
        drawn.document["absorbers"][name] = table
        drawn.hosts[name] = host
        masses = {**masses, name: numbers[0]}
        _write_out(drawn, name, host, numbers)
    return drawn


def _shaker(on: str) -> Table:
    return {"kind": "force", "on": on, "amplitude": "100 N", "speed": "1..40 Hz", "varies": "constant"}


def _absorber(
    pen: Pen, name: str, table: Table, masses: dict[str, float], omega: np.ndarray[Any, Any]
) -> tuple[float, float, float, float]:
    """Writes the table, and gives m, k, c and loss factor."""
    path = f"absorbers.{name}"
    base = masses[table["on"]]
    if pen.draw(st.booleans()):
        mass = pen.number(0.01, 0.5) * base
        mass = float(f"{mass:.6g}")
        table["mass"] = pen.say(f"{path}.mass", mass, "kg")
    else:
        if pen.draw(st.booleans()):
            table["relative_to"] = pen.draw(st.sampled_from(list(masses)))
            base = masses[table["relative_to"]]
        ratio = pen.number(0.01, 0.5)
        table["mass_ratio"] = pen.say(f"{path}.mass_ratio", ratio, "")
        mass = ratio * base
    pen.drawn.bases[name] = base
    stiffness = _spring(pen, name, table, mass, omega)
    damper = pen.draw(st.sampled_from(["damping", "damping_ratio", "loss_factor"] if stiffness else ["damping"]))
    size = pen.number(0.01, 1.0)
    critical = 2.0 * np.sqrt(stiffness * mass)
    if damper == "damping":
        value = float(f"{size * (critical or mass * omega[0]):.6g}")
        table["damping"] = pen.say(f"{path}.damping", value, "N s/m")
        return mass, stiffness, value, 0.0
    if damper:
        table[damper] = pen.say(f"{path}.{damper}", size, "")
    return mass, stiffness, size * critical * (damper == "damping_ratio"), size * (damper == "loss_factor")


def _spring(pen: Pen, name: str, table: Table, mass: float, omega: np.ndarray[Any, Any]) -> float:
    path = f"absorbers.{name}"
    kind = pen.draw(st.sampled_from(["stiffness", "frequency", "tuning", "tuning_to", "mode", "length", "none"]))
    factor = pen.number(0.5, 2.0)
    reference = float(omega[0])
    if kind == "stiffness":
        value = float(f"{mass * (factor * reference) ** 2:.6g}")
        table["stiffness"] = pen.say(f"{path}.stiffness", value, "N/m")
        return value
    if kind == "length":
        value = float(f"{G / (factor * reference) ** 2:.6g}")
        table["length"] = pen.say(f"{path}.length", value, "m")
        return mass * G / value
    if kind == "frequency":
        value = float(f"{factor * reference:.6g}")
        table["frequency"] = pen.say(f"{path}.frequency", value, "rad/s")
        return mass * value**2
    if kind == "none":
        return 0.0
    if kind == "tuning_to":
        reference = float(f"{1.3 * reference:.6g}")
        table["tuning_to"] = f"{reference!r} rad/s"
    if kind == "mode":
        table["mode"] = pen.draw(st.integers(1, len(omega)))
        reference = float(omega[table["mode"] - 1])
    pen.drawn.references[name] = reference
    table["tuning"] = pen.say(f"{path}.tuning", factor, "")
    return mass * (factor * reference) ** 2


def _write_out(drawn: Drawn, name: str, host: str, numbers: tuple[float, float, float, float]) -> None:
    mass, stiffness, damping, loss = numbers
    drawn.numbers[name] = numbers
    drawn.twin["bodies"][name] = {"mass": f"{mass!r} kg"}
    link: Table = {"between": [host, name]}
    if stiffness:
        link["stiffness"] = f"{float(stiffness)!r} N/m"
    if damping:
        link["damping"] = f"{float(damping)!r} N s/m"
    if loss:
        link["loss_factor"] = float(loss)
    drawn.twin["links"][f"{name}_link"] = link
