"""Every question that a file can ask about one machine of everything: each response at each place, each way."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from vibopt.errors import InputError
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene

WAYS: tuple[dict[str, Any], ...] = (
    {},
    {"direction": "z"},
    {"direction": "y"},
    {"direction": [0.6, 0, 0.8]},
    {"axis": "y"},
    {"axis": "x"},
    {"bearing": "right"},
)


def machine(motion: str, *, opened: bool) -> dict[str, Any]:
    """A body of some motion with an absorber, on two groups of mounts over a floor on a line, beside a shaft."""
    stiff = {"from": "0.2 MN/m", "to": "5 MN/m"} if opened else "0.9 MN/m"
    inertia: Any = {"space": ["31 kg m2", "62 kg m2", "59 kg m2"], "plane": "62 kg m2"}.get(motion)
    body: dict[str, Any] = {"mass": "180 kg", "centre": ["0.05 m", "0 m", "0.4 m"], "motion": motion}
    tmd = {"on": "eye", "direction": [0.6, 0, 0.8]} if inertia else {"on": "pump"}
    corners = [(0.6, 0.4), (0.6, -0.4), (-0.6, 0.4), (-0.6, -0.4)]
    return {
        "title": "everything",
        "bodies": {
            "pump": {**body, **({"inertia": inertia} if inertia else {})},
            "floor": {"mass": "900 kg"},
            "disc": {"inertia": "2 kg m2"},
        },
        "points": {"eye": {"on": "pump", "at": ["0.3 m", "0.1 m", "0.9 m"]}} if inertia else {},
        "absorbers": {"tmd": {**tmd, "mass": "9 kg", "frequency": "14 Hz", "damping_ratio": 0.1}},
        "links": {
            "girder": {
                "between": ["floor", "ground"],
                "beam": {"kind": "simply_supported", "length": "1 m", "modulus": "207 GPa", "diameter": "53.5 mm"},
                "damping": "5 kN s/m",
            },
            "shaft": {
                "between": ["disc", "ground"],
                "shaft": {"length": "1 m", "diameter": "32.7 mm", "shear_modulus": "80 GPa"},
                "torsional_damping": "3 N m s/rad",
            },
        },
        "mounts": {
            "foot": {
                "between": ["pump", "floor"],
                "at": [[f"{x} m", f"{y} m", "0 m"] for x, y in corners],
                "stiffness": stiff,
                "shear_ratio": 0.5,
                "damping": "2 kN s/m",
            },
            "stay": {
                "between": ["pump", "ground"],
                "at": [["0 m", "0 m", "0.8 m"]],
                "stiffness": "0.2 MN/m",
                "shear_ratio": 0.7,
                "damping": "1 kN s/m",
            },
        },
        "excitations": {
            "shaker": {
                "kind": "force",
                "on": "pump",
                **({"direction": [0.6, 0, 0.8]} if inertia else {}),
                "amplitude": "90 N",
                "speed": "20 Hz",
                "varies": "constant",
            },
            "torque": {"kind": "moment", "on": "disc", "amplitude": "9 N m", "speed": "20 Hz", "varies": "constant"},
        },
    }


def questions(kinds: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Tables of a measure without its name: kind, place and way."""
    names = ["pump", "floor", "disc", "eye", "girder", "shaft", "foot", "foot.2", "stay", "tmd", "ground"]
    for kind, cls in kinds.items():
        for key in ("of", "into", "through", "across"):
            if key in cls.model_fields:
                for name in names:
                    for way in WAYS:
                        if set(way) <= set(cls.model_fields):
                            yield {"response": kind, key: name, **way}
        yield {"response": kind}


def answerable(document: dict[str, Any]) -> Scene:
    """The document without the measures that a message names; each message names some."""
    while True:
        try:
            return from_dict(document)
        except InputError as error:  # a file tells of so many mistakes at once
            told = [message for message in error.messages if "only the first" not in message]
            named = [re.findall(r"measures\.(q\d+)", message) for message in told]
            if not all(named):
                raise
            gone = {name for one in named for name in one}
            document = {**document, "measures": {k: one for k, one in document["measures"].items() if k not in gone}}
