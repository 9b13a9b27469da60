"""One mass on one link by the textbook, and scenes of it drawn at random; shares no code with vibopt.

Every function takes whole arrays of designs.  The worst over a band is searched on a grid that is dense around the
resonance and refined; good to about 1e-11.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

Array = NDArray[np.float64]
Designs = dict[str, Array]
Bands = list[tuple[float, float]] | None

GRAVITY = 9.80665
UNITS = {
    "mass": "kg", "stiffness": "N/m", "damping": "N s/m", "damping_ratio": "", "loss_factor": "", "count": "",
    "displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "relative_displacement": "m",
    "transmitted_force": "N", "through": "N", "transmissibility": "", "isolation": "", "static_deflection": "m",
    "natural_frequency": "rad/s",
}  # fmt: skip
MOTIONS = ("displacement", "velocity", "acceleration")
RATIOS = ("transmissibility", "isolation")
HARMONIC = (*MOTIONS, "relative_displacement", "transmitted_force", "through", *RATIOS)
PATHS = {"mass": "bodies.body.mass"}


class Pick:
    """Draws from hypothesis in the words of an engineer."""

    def __init__(self, draw: Callable[..., Any]) -> None:
        self.draw = draw

    def one(self, *items: Any) -> Any:
        return self.draw(st.sampled_from(items))

    def size(self, low: float, high: float) -> float:
        """A size, even in its logarithm, with six digits."""
        power = self.draw(st.floats(math.log10(low), math.log10(high), allow_nan=False))
        return float(f"{10.0**power:.6g}")

    def often(self, part: float) -> bool:
        return self.draw(st.integers(0, 99)) < 100 * part


@dataclass
class LoneMass:
    """A scene: `facts` by name, `ranges` (low, high, values or None) by name.

    limits
        (response, bands, side, bound).
    """

    damper: str
    on_base: bool
    amplitude: float
    power: int
    table: tuple[Array, Array] | None
    own: list[tuple[float, float]]
    facts: dict[str, float] = field(default_factory=dict)
    ranges: dict[str, tuple[float, float, Array | None]] = field(default_factory=dict)
    limits: list[tuple[str, Bands, str, float]] = field(default_factory=list)
    goal: tuple[str, str, Bands] = ("maximise", "stiffness", None)
    document: dict[str, Any] = field(default_factory=dict)

    def designs(self, rng: np.random.Generator, count: int) -> Designs:
        """Spread evenly in the logarithm, with some at the ends of the ranges."""
        found = {name: np.full(count, value) for name, value in self.facts.items()}
        for name, (low, high, values) in self.ranges.items():
            if values is not None:
                found[name] = rng.choice(values, count)
                continue
            x = np.exp(rng.uniform(np.log(max(low, 1e-9 * high)), np.log(high), count))
            edge = rng.random(count)
            found[name] = np.where(edge < 0.03, low, np.where(edge > 0.97, high, x))
        return found

    def near(self, rng: np.random.Generator, x: dict[str, float], count: int, reach: float) -> Designs:
        """Around one design, most of them far nearer than `reach` (a part of each value)."""
        found = {name: np.full(count, value) for name, value in self.facts.items()}
        for name, (low, high, values) in self.ranges.items():
            if values is not None:
                found[name] = np.where(rng.random(count) < 0.8, x[name], rng.choice(values, count))
                continue
            step = reach * 10.0 ** rng.uniform(-3, 0, count) * rng.standard_normal(count) * (rng.random(count) < 0.8)
            found[name] = np.clip(x[name] * np.exp(step), low, high)
        return found

    def mechanics(self, x: Designs) -> tuple[Array, Array, Array, Array, Array]:
        """Mass, and of the whole group stiffness, viscous damping, structural stiffness, and count."""
        one = np.ones_like(x["mass"])
        count, mass = x.get("count", one), x["mass"]
        stiffness, damping, lossy = count * x["stiffness"], 0.0 * one, 0.0 * one
        if self.damper == "damping":
            damping = count * x["damping"]
        if self.damper == "damping_ratio":
            damping = 2.0 * x["damping_ratio"] * np.sqrt(stiffness * mass)
        if self.damper == "loss_factor":
            lossy = x["loss_factor"] * stiffness
        return mass, stiffness, damping, lossy, count

    def shaking(self, speed: Array, response: str) -> Array:
        """Amplitude of the force, or of the motion of the base."""
        if response in RATIOS:
            return np.ones_like(speed)
        size = np.full_like(speed, self.amplitude)
        if self.table is not None:
            size = size * np.interp(speed, *self.table)
        with np.errstate(all="ignore"):
            return np.abs(size * speed**self.power) if self.power else np.abs(size)

    def size(self, parts: tuple[Array, ...], speed: Array, response: str) -> Array:
        """Amplitude of a response at each speed."""
        mass, stiffness, damping, lossy, count = parts
        with np.errstate(all="ignore"):
            natural = np.sqrt(stiffness / mass)
            inertia = mass * (natural - speed) * (natural + speed)
            below = np.hypot(inertia, damping * speed + lossy)
            link = np.hypot(stiffness, damping * speed + lossy)
            shaking = self.shaking(speed, response)
            moved = shaking * (link / below if self.on_base else 1.0 / below)
            if response in MOTIONS:
                value = moved * speed ** MOTIONS.index(response)
            elif response == "relative_displacement":
                value = shaking * mass * speed**2 / below if self.on_base else moved
            elif response in ("transmitted_force", "through"):
                value = shaking * mass * speed**2 / below * link if self.on_base else moved * link
                value = value / count if response == "through" else value
            else:
                value = moved if self.on_base else moved * link
        return np.where(np.isnan(value), np.inf, value)

    def worst(self, x: Designs, response: str, bands: Bands, side: str) -> Array:
        """The worst value over the bands, as the user counts it."""
        parts = self.mechanics(x)
        mass, stiffness, damping, _, _ = parts
        if response == "static_deflection":
            return mass * GRAVITY / stiffness
        if response == "natural_frequency":
            return np.sqrt(stiffness / mass)
        if response == "damping_ratio":
            return damping / (2.0 * np.sqrt(stiffness * mass))
        if bands is None:
            return x[response]
        sign = -1.0 if (side == "at_least") != (response == "isolation") else 1.0
        found = [self._over(parts, response, low, high, sign) for low, high in bands]
        value = sign * np.max(found, axis=0)
        return 1.0 - value if response == "isolation" else value

    def _over(self, parts: tuple[Array, ...], response: str, low: float, high: float, sign: float) -> Array:
        mass, stiffness, damping, lossy, _ = columns = tuple(one[:, None] for one in parts)
        natural = np.sqrt(stiffness / mass)
        width = np.maximum(damping / (2.0 * mass * natural) + lossy / (2.0 * stiffness), 1e-12)
        if low == high:
            return sign * self.size(columns, np.full_like(natural, low), response)[:, 0]
        side = np.logspace(-3, 3, 60)
        around = natural * (1.0 + np.concatenate([[0.0], side, -side]) * width)
        peak = natural * np.sqrt(np.maximum(1.0 - 2.0 * width**2, 0.0))
        even = np.broadcast_to(np.linspace(low, high, 257), (len(mass), 257))
        kinks = np.array([] if self.table is None else self.table[0])
        kinks = np.broadcast_to(kinks, (len(mass), len(kinks)))
        speeds = np.sort(np.clip(np.concatenate([even, around, peak, kinks], axis=1), low, high), axis=1)
        values = sign * self.size(columns, speeds, response)
        rows, column = np.arange(len(mass)), np.arange(speeds.shape[1])
        top = values.max(axis=1)
        for _ in range(3):
            best = values.argmax(axis=1)
            left = speeds[rows, np.maximum(best - 1, 0)]
            right = speeds[rows, np.minimum(best + 1, speeds.shape[1] - 1)]
            top = np.maximum(top, self._refined(columns, response, left, right, sign))
            values = np.where(np.abs(column - best[:, None]) <= 3, -np.inf, values)
        free = ((damping == 0.0) & (lossy == 0.0) & (natural >= low) & (natural <= high))[:, 0]
        shaken = self.shaking(natural[:, 0], response) > 0.0
        return np.where(free & shaken, np.inf, top) if sign > 0 else top

    def _refined(self, parts: tuple[Array, ...], response: str, left: Array, right: Array, sign: float) -> Array:
        """The greatest value between two speeds per design, by finer and finer grids."""
        rows = np.arange(len(left))
        top = np.full(len(left), -np.inf)
        for _ in range(4):
            finer = left[:, None] + (right - left)[:, None] * np.linspace(0.0, 1.0, 17)
            values = sign * self.size(parts, finer, response)
            best = values.argmax(axis=1)
            top = np.maximum(top, values[rows, best])
            left, right = finer[rows, np.maximum(best - 1, 0)], finer[rows, np.minimum(best + 1, 16)]
        return top

    def missed(self, x: Designs) -> Array:
        """Worst miss of any limit as a part of its bound; not positive where all hold."""
        found = np.full(len(x["mass"]), -np.inf)
        for response, bands, side, bound in self.limits:
            value = self.worst(x, response, bands, side)
            size = abs(bound) if response != "isolation" else abs(1.0 - bound)
            miss = (value - bound if side == "at_most" else bound - value) / size
            found = np.maximum(found, np.where(np.isnan(miss), np.inf, miss))
        return found

    def aim(self, x: Designs) -> Array:
        """Goal in the sense to be minimised."""
        sense, response, bands = self.goal
        value = self.worst(x, response, bands, "at_most" if sense == "minimise" else "at_least")
        return value if sense == "minimise" else -value

    def best(self, rng: np.random.Generator, claimed: dict[str, float] | None, count: int) -> tuple[float, float]:
        """(miss, goal) of the best design that sampling finds; the miss is positive where none holds every limit."""
        pools = [self.designs(rng, count)]
        if claimed is not None:
            pools += [self.near(rng, claimed, count // 2, reach) for reach in (1e-1, 1e-3, 1e-5)]
        miss, aim, at = np.inf, np.inf, None
        for reach in (0.0, *np.logspace(0, -6, 8)):
            pools = pools if reach == 0.0 else [self.near(rng, at, count // 4, reach)] if at else []
            for x in pools:
                missed, aims = self.missed(x), self.aim(x)
                score = np.where(missed <= 0.0, aims, np.inf)
                index = int(score.argmin() if (missed <= 0.0).any() else missed.argmin())
                better = aims[index] < aim if missed[index] <= 0.0 and miss <= 0.0 else missed[index] < miss
                if better:
                    miss, aim = float(max(missed[index], 0.0)), float(aims[index])
                    at = {name: float(values[index]) for name, values in x.items()}
        return miss, aim


def _text(value: float, name: str) -> Any:
    unit = UNITS[name]
    return f"{value!r} {unit}" if unit else value


@st.composite
def lone_masses(draw: Callable[..., Any], *, wide: bool = False) -> LoneMass:
    """Scenes of one mass; `wide` ranges span up to eight decades and begin at almost no damping."""
    pick = Pick(draw)
    mass, speed = pick.size(1e-3, 1e5), pick.size(1e-1, 1e4)
    damper = pick.one("damping", "damping_ratio", "loss_factor", "none")
    sizes = {"mass": mass, "stiffness": mass * speed**2 * pick.size(0.03, 30.0)}
    light = 1e-6 if wide else 1e-3
    if damper == "damping":
        sizes[damper] = mass * speed * pick.size(light, 3.0)
    elif damper != "none":
        sizes[damper] = pick.size(light, 1.0)
    if pick.often(0.25):
        sizes["count"] = 4.0
    free = {"stiffness"} | {name for name in sizes if pick.often({"mass": 0.2}.get(name, 0.6))}
    case, shaker = _shaken(pick, damper, mass, speed)
    words = _link_words(pick, case, sizes, free, wide)
    body = {"mass": words.pop("mass")}
    support = "base" if case.on_base else "ground"
    ends = pick.one([support, "body"], ["body", support])
    case.document = {
        "title": "drawn",
        "bodies": {"body": body},
        "links": {"link": {"between": ends, **words}},
        "excitations": {"shaker": shaker},
        "limits": {},
    }
    if case.on_base:
        case.document["bases"] = {"base": {}}
    _ask(pick, case, draw(st.integers(0, 2**32 - 1)))
    return case


def _shaken(pick: Pick, damper: str, mass: float, speed: float) -> tuple[LoneMass, dict[str, Any]]:
    low = speed * pick.size(0.2, 5.0)
    high = low * pick.size(1.1, 8.0)
    own, text = pick.one(
        ([(low, low)], f"{low!r} rad/s"),
        ([(low, low), (high, high)], [f"{low!r} rad/s", f"{high!r} rad/s"]),
        ([(low, high)], f"{low!r}..{high!r} rad/s"),
    )
    kind = pick.one("force", "unbalance", "base_motion")
    shaker: dict[str, Any] = {"kind": kind, "on": "base" if kind == "base_motion" else "body", "speed": text}
    case = LoneMass(damper, kind == "base_motion", 1.0, 0, None, own)
    if kind == "unbalance":
        case.amplitude, case.power = mass * pick.size(1e-5, 1e-1), 2
        shaker["unbalance"] = f"{case.amplitude!r} kg m"
        return case, shaker
    word, unit, case.power = (
        ("amplitude", "N", 0)
        if kind == "force"
        else pick.one(("displacement", "m", 0), ("velocity", "m/s", -1), ("acceleration", "m/s^2", -2))
    )
    case.amplitude = pick.size(1e-4, 1e4)
    shaker[word] = f"{case.amplitude!r} {unit}"
    how = pick.one("constant", "speed", "speed^2", "table")
    if how == "table":
        speeds = np.array([0.0, 0.5, 0.8, 3.0]) * case.own[-1][1]
        factors = np.array([pick.one(0.3, 0.5, 1.0, 2.0) for _ in speeds])
        case.table = (speeds, factors)
        shaker["varies"] = [[f"{float(a)!r} rad/s", float(b)] for a, b in zip(speeds, factors, strict=True)]
        return case, shaker
    shaker["varies"] = how
    grows = ("constant", "speed", "speed^2").index(how)
    if grows:
        shaker["amplitude_at"] = f"{low!r} rad/s"
        case.amplitude, case.power = case.amplitude / low**grows, case.power + grows
    return case, shaker


def _link_words(pick: Pick, case: LoneMass, sizes: dict[str, float], free: set[str], wide: bool) -> dict[str, Any]:
    words: dict[str, Any] = {}
    for name, value in sizes.items():
        if name not in free:
            case.facts[name] = value
            words[name] = _text(value, name) if name != "count" else int(value)
        elif name == "count":
            case.ranges[name] = (1.0, 8.0, np.arange(1.0, 9.0))
            words[name] = {"from": 1, "to": 8, "whole": True}
        elif pick.often(0.1):
            values = sorted({value, float(f"{value * pick.size(0.2, 0.9):.6g}")})
            case.ranges[name] = (values[0], values[-1], np.array(values))
            words[name] = {"one_of": [_text(one, name) for one in values]}
        else:
            reach = pick.one(2.0, 3.0) if name == "mass" else pick.one(3.0, 30.0, 1e4 if wide else 100.0)
            low, high = (float(f"{one:.6g}") for one in (value / reach, value * reach))
            high = min(high, 9.0) if not UNITS[name] else high
            case.ranges[name] = (low, high, None)
            words[name] = {"from": _text(low, name), "to": _text(high, name)}
    return words


def _ask(pick: Pick, case: LoneMass, seed: int) -> None:
    """Limits that a design drawn at random nearly meets, and a goal."""
    some = case.designs(np.random.default_rng(seed), 1)
    static = ["static_deflection", "natural_frequency"]
    for index in range(pick.one(1, 2, 3)):
        response = pick.one(*HARMONIC, *static)
        bands, words = _place(pick, case, response)
        side = pick.one("at_most", "at_most", "at_most", "at_least")
        value = float(case.worst(some, response, bands, side)[0])
        if not 1e-20 < value < 1e20:
            continue
        bound = float(f"{value * pick.size(0.7, 1.6):.5g}")
        if response == "isolation":
            bound = float(f"{1.0 - (1.0 - value) * pick.size(0.7, 1.6):.5g}")
        if bound <= 0.0:
            continue
        case.limits.append((response, bands, side, bound))
        case.document["limits"][f"limit_{index}"] = {**words, side: _text(bound, response)}
    own = [name for name in case.ranges if name != "mass"]
    response = pick.one(*own, *own, "displacement", "transmitted_force", "transmissibility", "static_deflection")
    sense = pick.one("maximise", "minimise")
    bands, words = _place(pick, case, response)
    words.pop("response")
    if response in case.ranges:
        words = {"of": "link"}
    case.goal = (sense, response, bands)
    case.document["goal"] = {sense: response, **words}


def _place(pick: Pick, case: LoneMass, response: str) -> tuple[Bands, dict[str, Any]]:
    support = "base" if case.on_base else "ground"
    words: dict[str, Any] = {"response": response}
    if response in MOTIONS:
        words["of"] = "body"
    elif response == "relative_displacement":
        words["across"] = "link"
    elif response == "through":
        words = {"response": "transmitted_force", "through": "link"}
    elif response == "transmitted_force":
        words["into"] = support
    elif response in RATIOS:
        words["of" if case.on_base else "into"] = "body" if case.on_base else "ground"
    elif response == "static_deflection":
        words["of"] = "link"
    if response not in HARMONIC:
        return None, words
    top = case.own[-1][1]
    how = pick.one("own", "at", "over", "start-up")
    if how == "at":
        speed = float(f"{top * 0.7:.6g}")
        words["at"] = f"{speed!r} rad/s"
        return [(speed, speed)], words
    if how == "over":
        low = float(f"{top * pick.size(0.05, 0.9):.6g}")
        high = float(f"{low * pick.size(1.2, 2.8):.6g}")
        words["over"] = f"{low!r}..{high!r} rad/s"
        return [(low, high)], words
    if how == "start-up" and not (case.on_base and case.power < 0):
        words["over"] = "start-up"
        return [(0.0, top)], words
    return list(case.own), words
