"""Chains and trees of two or three bodies with matrices written by hand; shares no code with vibopt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from lone_mass import GRAVITY, MOTIONS, UNITS, Array, Pick

Complex = NDArray[np.complex128]
Path = tuple[str, str, str]


@dataclass
class Joint:
    """Whole group: stiffness, damping, structural stiffness, and number of mounts."""

    ends: tuple[str, str]
    stiffness: float
    damping: float
    lossy: float
    count: float


@dataclass
class Chain:
    """A scene: masses, links in the words of the file, ranges by path, and one shaker over one band."""

    masses: dict[str, float]
    links: dict[str, dict[str, Any]]
    ranges: dict[Path, tuple[float, float]]
    on: str
    amplitude: float
    power: int
    band: tuple[float, float]
    document: dict[str, Any] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        return list(self.masses)

    def design(self, rng: np.random.Generator) -> dict[Path, float]:
        return {path: float(np.exp(rng.uniform(*np.log(ends)))) for path, ends in self.ranges.items()}

    def built(self, x: dict[Path, float]) -> tuple[dict[str, float], dict[str, Joint]]:
        masses = {name: x.get(("bodies", name, "mass"), mass) for name, mass in self.masses.items()}
        joints = {}
        for name, words in self.links.items():
            value = {key: x.get(("links", name, key), words[key]) for key in words if key in UNITS}
            count = float(words.get("count", 1))
            stiffness = count * value["stiffness"]
            damping = count * value.get("damping", 0.0)
            if "damping_ratio" in value:
                damping = 2.0 * value["damping_ratio"] * np.sqrt(stiffness * masses[words["relative_to"]])
            lossy = stiffness * value.get("loss_factor", 0.0)
            joints[name] = Joint(tuple(words["between"]), stiffness, damping, lossy, count)
        return masses, joints

    def matrix(self, x: dict[Path, float], speed: Array) -> tuple[Complex, Complex, dict[str, Joint]]:
        """Dynamic stiffness (n, bodies, bodies) and the pull of a base that moves by one (n, bodies)."""
        masses, joints = self.built(x)
        place = {name: i for i, name in enumerate(self.names)}
        whole = np.zeros((len(speed), len(place), len(place)), dtype=complex)
        pull = np.zeros((len(speed), len(place)), dtype=complex)
        for name, i in place.items():
            whole[:, i, i] -= masses[name] * speed**2
        for joint in joints.values():
            z = joint.stiffness + 1j * (joint.lossy + joint.damping * speed)
            for here, there in (joint.ends, joint.ends[::-1]):
                if here in place:
                    whole[:, place[here], place[here]] += z
                    if there in place:
                        whole[:, place[here], place[there]] -= z
                    elif there == "base":
                        pull[:, place[here]] += z
        return whole, pull, joints

    def response(self, x: dict[Path, float], speed: Array, kind: str, place: str) -> Array:
        """Amplitude at each speed."""
        whole, pull, joints = self.matrix(x, speed)
        shaking = self.amplitude * speed**self.power if kind != "transmissibility" else np.ones_like(speed)
        load = np.zeros_like(pull)
        if self.on == "base":
            load = pull * shaking[:, None]
        else:
            load[:, self.names.index(self.on)] = shaking
        moved = np.linalg.solve(whole, load[..., None])[..., 0]
        points = {name: moved[:, i] for i, name in enumerate(self.names)}
        points |= {"ground": np.zeros_like(speed), "base": shaking if self.on == "base" else np.zeros_like(speed)}
        forces = {}
        for name, joint in joints.items():
            z = joint.stiffness + 1j * (joint.lossy + joint.damping * speed)
            forces[name] = z * (points[joint.ends[0]] - points[joint.ends[1]])
        if kind in MOTIONS:
            return np.abs(points[place]) * speed ** MOTIONS.index(kind)
        if kind == "relative_displacement":
            first, second = joints[place].ends
            return np.abs(points[first] - points[second])
        if kind == "through":
            return np.abs(forces[place]) / joints[place].count
        if kind == "transmissibility" and self.on == "base":
            return np.abs(points[place])
        total = np.zeros(len(speed), dtype=complex)
        for name, joint in joints.items():
            total += forces[name] * ((joint.ends[1] == place) * 1.0 - (joint.ends[0] == place) * 1.0)
        return np.abs(total)

    def poles(self, x: dict[Path, float]) -> Complex:
        masses, _ = self.built(x)
        n = len(masses)
        inverse = np.diag(1.0 / np.array(list(masses.values())))
        at_rest, _, joints = self.matrix(x, np.zeros(1))
        damping = np.zeros((n, n))
        for joint in joints.values():
            row = np.array([(name == joint.ends[0]) * 1.0 - (name == joint.ends[1]) * 1.0 for name in masses])
            damping += np.outer(row, row) * joint.damping
        size = np.sqrt(np.abs(inverse @ at_rest[0]).max())
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ at_rest[0] / size**2, -inverse @ damping / size]])
        found: Complex = -1j * np.linalg.eigvals(state) * size
        return found

    def static(self, x: dict[Path, float], place: str) -> float:
        masses, joints = self.built(x)
        whole, _, _ = self.matrix(x, np.zeros(1))
        down = np.linalg.solve(whole[0].real, GRAVITY * np.array(list(masses.values())))
        points = {**dict(zip(masses, down, strict=True)), "ground": 0.0, "base": 0.0}
        if place in joints:
            first, second = joints[place].ends
            return float(abs(points[first] - points[second]))
        return float(abs(points[place]))

    def natural(self, x: dict[Path, float], mode: int) -> float:
        masses, _ = self.built(x)
        whole, _, _ = self.matrix(x, np.zeros(1))
        squares = np.linalg.eigvals(whole[0].real / np.array(list(masses.values()))[:, None]).real
        return float(np.sqrt(np.sort(squares)[mode - 1]))

    def greatest(self, x: dict[Path, float], kind: str, place: str) -> float:
        """The greatest value over the band: dense around every pole, then refined."""
        low, high = self.band
        side = np.logspace(-2, 2, 25)
        speeds = [np.linspace(low, high, 400)]
        for pole in self.poles(x):
            around = pole.real + np.concatenate([[0.0], side, -side]) * max(pole.imag, 1e-13 * abs(pole))
            speeds.append(np.clip(around, low, high))
        grid = np.unique(np.concatenate(speeds))
        values = self.response(x, grid, kind, place)
        best = float(values.max())
        for i in np.argsort(-values)[:6]:
            left, right = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
            for _ in range(7):
                finer = np.linspace(left, right, 13)
                values_here = self.response(x, finer, kind, place)
                j = int(values_here.argmax())
                best = max(best, float(values_here[j]))
                left, right = finer[max(j - 1, 0)], finer[min(j + 1, 12)]
        return best


@st.composite
def chains(draw: Callable[..., Any]) -> Chain:
    """Two or three bodies, each on the one before or on the support, all links damped."""
    pick = Pick(draw)
    names = pick.one(["a", "b"], ["a", "b", "c"])
    support = pick.one("ground", "base")
    mass, speed = pick.size(1e-2, 1e3), pick.size(1.0, 1e3)
    masses = {name: float(f"{mass * pick.size(0.1, 10.0):.6g}") for name in names}
    links: dict[str, dict[str, Any]] = {}
    for i, name in enumerate(names):
        under = support if i == 0 else pick.one(names[i - 1], support)
        links[f"l{i}"] = _link(pick, name, under, mass, speed)
    if pick.often(0.4):
        links["extra"] = _link(pick, names[-1], pick.one("ground", names[0]), mass, speed)
    keys: list[Path] = [("links", name, key) for name, words in links.items() for key in words if key in UNITS]
    keys = [path for path in keys if path[2] != "count"] + [("bodies", names[0], "mass")]
    chosen = draw(st.lists(st.sampled_from(keys), min_size=1, max_size=3, unique=True))
    ranges = {}
    for family, name, key in chosen:
        value = masses[name] if key == "mass" else links[name][key]
        reach = pick.one(1.5, 4.0, 20.0)
        low, high = float(f"{value / reach:.6g}"), float(f"{value * reach:.6g}")
        ranges[family, name, key] = (low, min(high, 9.0) if not UNITS[key] else high)
    low = float(f"{speed * pick.size(0.1, 2.0):.6g}")
    band = (low, float(f"{low * pick.size(1.2, 10.0):.6g}"))
    on = pick.one("base", names[-1]) if support == "base" else pick.one(*names)
    chain = Chain(masses, links, ranges, on, pick.size(1e-3, 1e3), 0, band)
    shaker: dict[str, Any] = {"on": on, "speed": f"{band[0]!r}..{band[1]!r} rad/s"}
    if on == "base":
        shaker |= {"kind": "base_motion", "displacement": f"{chain.amplitude!r} m"}
    elif pick.often(0.5):
        chain.power = 2
        shaker |= {"kind": "unbalance", "unbalance": f"{chain.amplitude!r} kg m"}
    else:
        shaker |= {"kind": "force", "amplitude": f"{chain.amplitude!r} N"}
    chain.document = _document(chain, shaker)
    if support == "base":
        chain.document["bases"] = {"base": {}}
    return chain


def _link(pick: Pick, first: str, second: str, mass: float, speed: float) -> dict[str, Any]:
    ends = pick.one([first, second], [second, first])
    if first == second:
        ends = [first, "ground"]
    words: dict[str, Any] = {"between": ends, "stiffness": float(f"{mass * speed**2 * pick.size(0.1, 10.0):.6g}")}
    damper = pick.one("damping", "damping", "damping_ratio", "loss_factor")
    words[damper] = float(f"{mass * speed * pick.size(1e-3, 1.0):.6g}") if damper == "damping" else pick.size(1e-3, 0.5)
    if damper == "damping_ratio":
        words["relative_to"] = first
    if pick.often(0.2):
        words["count"] = 4
    return words


def _document(chain: Chain, shaker: dict[str, Any]) -> dict[str, Any]:
    def text(path: Path, value: float) -> Any:
        unit = f" {UNITS[path[2]]}" if UNITS[path[2]] else ""
        said = [f"{one!r}{unit}" if unit else one for one in chain.ranges.get(path, (value,))]
        return {"from": said[0], "to": said[1]} if path in chain.ranges else said[0]

    links = {
        name: {k: text(("links", name, k), v) if k in UNITS and k != "count" else v for k, v in words.items()}
        for name, words in chain.links.items()
    }
    bodies = {name: {"mass": text(("bodies", name, "mass"), mass)} for name, mass in chain.masses.items()}
    return {"title": "drawn", "bodies": bodies, "links": links, "excitations": {"shaker": shaker}}
