"""Chains that float or ride on a base, in fifty and more digits with mpmath; shares no code with vibopt."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
from mpmath import mp

DIGITS = 90
REST = mpmath.mpf(10) ** -12
"""A frequency [rad/s] as good as none."""
GROWS = {"constant": 0, "speed": 1, "speed^2": 2}
SAID = {"displacement": 0, "velocity": 1, "acceleration": 2}
TURNED = {"relative_displacement": "twist", "transmitted_force": "transmitted_moment", "displacement": "rotation"}
TOP = 25.0
"""Highest speed [rad/s]."""


@dataclass
class Floating:
    """Bodies on one line or axis, joined in a row, here and there by a damper alone; the first may ride on a base.

    masses [kg] or [kg m^2], links (first, second, k, c) by name.
    """

    masses: dict[str, float]
    links: dict[str, tuple[str, str, float, float]]
    turns: bool
    on: str
    said: str
    varies: str | list[list[Any]]

    @classmethod
    def of(cls, seed: int) -> Floating:
        rng = np.random.default_rng(seed)
        names = [f"m{i}" for i in range(int(rng.integers(1, 5)))]
        rides = bool(rng.random() < 0.5) or len(names) == 1
        turns = not rides and bool(rng.random() < 0.5)
        row = [*(["base"] if rides else []), *names]
        links = {}
        for i, (a, b) in enumerate(pairwise(row)):
            damper_alone = rng.random() < 0.12
            k = 0.0 if damper_alone else float(10 ** rng.uniform(2, 4.5))
            c = float(10 ** rng.uniform(0, 2.5)) if damper_alone or rng.random() < 0.8 else 0.0
            links[f"l{i}"] = (a, b, k, c)
        if len(names) > 2 and rng.random() < 0.3:
            links["across"] = (names[0], names[2], float(10 ** rng.uniform(2, 4)), 3.0)
        said = str(rng.choice(list(SAID))) if rides else "force"
        varies: Any = str(rng.choice(list(GROWS)))
        if rng.random() < 0.2:
            varies = [["0 rad/s", float(rng.choice([0.0, 0.5]))], ["7 rad/s", 1.3], [f"{TOP} rad/s", 0.8]]
        masses = {name: float(rng.uniform(1.0, 20.0)) for name in names}
        return cls(masses, links, turns, "base" if rides else str(rng.choice(names)), said, varies)

    def readings(self) -> dict[str, tuple[str, str]]:
        """Response and place by name."""
        found = {}
        for name in self.masses:
            for kind in SAID:
                if kind == "displacement" or not self.turns:
                    found[f"{kind}_{name}"] = (kind, name)
            found[f"into_{name}"] = ("transmitted_force", name)
        for name in self.links:
            found[f"rel_{name}"] = ("relative_displacement", name)
            found[f"through_{name}"] = ("transmitted_force", name)
        if self.on == "base":
            found["into_base"] = ("transmitted_force", "base")
        last = list(self.masses)[-1]
        if self.on == "base":
            found["ratio"] = ("transmissibility", last)
        return found

    def document(self, over: str) -> dict[str, Any]:
        """The problem file, every reading a measure; with `over` the speeds to look at."""
        heavy, stiff, dash = (
            ("inertia", "torsional_stiffness", "torsional_damping") if self.turns else ("mass", "stiffness", "damping")
        )
        units = ("kg m2", "N m/rad", "N m s/rad") if self.turns else ("kg", "N/m", "N s/m")
        links = {}
        for name, (a, b, k, c) in self.links.items():
            links[name] = {"between": [a, b]}
            links[name] |= {stiff: f"{k!r} {units[1]}"} if k else {}
            links[name] |= {dash: f"{c!r} {units[2]}"} if c else {}
        shaker: dict[str, Any] = {"kind": "moment" if self.turns else "force", "on": self.on, "amplitude": "3 N"}
        if self.turns:
            shaker["amplitude"] = "3 N m"
        if self.on == "base":
            unit = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2"}[self.said]
            shaker = {"kind": "base_motion", "on": "base", self.said: f"3 {unit}"}
        shaker |= {"speed": f"{TOP} rad/s", "varies": self.varies}
        measures = {}
        for name, (kind, place) in self.readings().items():
            word = TURNED.get(kind, kind) if self.turns else kind
            key = {"relative_displacement": "across"}.get(kind, "of")
            if kind == "transmitted_force":
                key = "into" if name.startswith("into") else "through"
            measures[name] = {"response": word, key: place, ("at" if ".." not in over else "over"): over}
        return {
            "title": "floating",
            "bodies": {name: {heavy: f"{m!r} {units[0]}"} for name, m in self.masses.items()},
            **({"bases": {"base": {}}} if self.on == "base" else {}),
            "links": links,
            "excitations": {"shaker": shaker},
            "measures": measures,
        }

    def amplitude(self, w: Any) -> Any:
        """Peak of what the file says, at w."""
        if isinstance(self.varies, str):
            return 3 * (w / TOP) ** GROWS[self.varies]
        (_, a), (_, b), (_, c) = self.varies
        return 3 * (a + (mpmath.mpf(b) - a) * w / 7 if w <= 7 else b + (mpmath.mpf(c) - b) * (w - 7) / (TOP - 7))

    def values(self, w: Any) -> dict[str, Any]:
        """Every reading at one frequency [rad/s] above zero."""
        with mp.workdps(DIGITS):
            w = mpmath.mpf(w)
            names, i = list(self.masses), mpmath.mpc(0, 1)
            whole, load = mpmath.matrix(len(names)), mpmath.matrix(len(names), 1)
            for n, name in enumerate(names):
                whole[n, n] -= mpmath.mpf(self.masses[name]) * w**2
            size = self.amplitude(w)
            moved = {"base": size / w ** SAID[self.said]} if self.on == "base" else {}
            z = {name: mpmath.mpf(k) + i * w * mpmath.mpf(c) for name, (_, _, k, c) in self.links.items()}
            for name, (a, b, _, _) in self.links.items():
                for here, there in ((a, b), (b, a)):
                    if here in names:
                        whole[names.index(here), names.index(here)] += z[name]
                        if there in names:
                            whole[names.index(here), names.index(there)] -= z[name]
                        else:
                            load[names.index(here)] += z[name] * moved[there]
            if self.on in names:
                load[names.index(self.on)] += size
            u = mpmath.lu_solve(whole, load)
            moved |= {name: u[n] for n, name in enumerate(names)}
            force = {name: z[name] * (moved[a] - moved[b]) for name, (a, b, _, _) in self.links.items()}
            return {
                name: abs(self._reading(name, kind, place, w, moved, force))
                for name, (kind, place) in self.readings().items()
            }

    def _reading(self, name: str, kind: str, place: str, w: Any, moved: dict[str, Any], force: dict[str, Any]) -> Any:
        if kind in SAID:
            return moved[place] * w ** SAID[kind]
        if kind == "relative_displacement":
            a, b, _, _ = self.links[place]
            return moved[a] - moved[b]
        if kind == "transmissibility":
            return moved[place] / moved["base"]
        if name.startswith("through"):
            return force[place]
        ends = ((link, a, b) for link, (a, b, _, _) in self.links.items())
        return sum(force[link] * ((b == place) - (a == place)) for link, a, b in ends)

    def at_rest(self) -> dict[str, float]:
        """The limit of every reading towards standstill; infinite where it has none."""
        here, nearer = self.values(REST), self.values(REST / 100)
        return {name: float("inf") if nearer[name] > 5 * value else float(nearer[name]) for name, value in here.items()}

    def as_design(self, seed: int) -> dict[str, Any]:
        """The problem file with one or two links open: limits about as the chain stands, and a response as the goal."""
        rng = np.random.default_rng(seed)
        document = self.document(f"0..{TOP} rad/s")
        finite = [name for name, value in self.at_rest().items() if np.isfinite(value)]
        springs = [name for name, one in self.links.items() if one[2] and one[3]]
        if not finite or not springs:
            return {}
        for name in springs[: int(rng.integers(1, 3))]:
            table = document["links"][name]
            for key in [key for key in table if key != "between"][: int(rng.integers(1, 3))]:
                number, unit = table[key].split(" ", 1)
                table[key] = {"from": f"{float(number) / 3.0!r} {unit}", "to": f"{float(number) * 3.0!r} {unit}"}
        picks = [str(one) for one in rng.choice(finite, size=3)]
        measures = document.pop("measures")
        sizes = [self.values(w) for w in np.linspace(0.01, TOP, 12)]
        unit = {"velocity": "m/s", "acceleration": "m/s2", "transmitted_force": "N", "transmissibility": ""}
        limits = {}
        for name in picks[:2]:
            kind = self.readings()[name][0]
            word = ("rad" if self.turns else "m") if kind in ("displacement", "relative_displacement") else unit[kind]
            word = "N m" if self.turns and word == "N" else word
            most = 2.0 * max(float(one[name]) for one in sizes)
            limits[name] = {**measures[name], "at_most": f"{most!r} {word}" if word else most}
        goal = dict(measures[picks[2]])
        goal["minimise"] = goal.pop("response")
        return {**document, "limits": limits, "goal": goal}
