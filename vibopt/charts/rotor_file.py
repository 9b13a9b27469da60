"""A question as the file of a measured rotor: readings as found, ready coefficients, caps, holes, limits, goal."""

from __future__ import annotations

from math import degrees
from typing import Any

import numpy as np

from vibopt.balancing.question import Question
from vibopt.balancing.read_rotor import read_rotor
from vibopt.balancing.rotor_job import RotorJob
from vibopt.document.mistakes import Mistakes

_SPEED = "3000 rpm"


HOLES, WEIGHTS = 24, (0.1, 0.2, 0.3, 0.4, 0.5)
"""Holes of a plane and masses of the shelf [kg], of all questions with lists; at a radius of 1 m."""


def job_of(question: Question, name: str) -> RotorJob:
    """The job as read, every number of the question in its text."""
    return read_rotor(document(question), Mistakes(name, None))


def document(question: Question) -> dict[str, Any]:
    """The problem file as a dictionary."""
    sensors = [f"s{i}" for i in range(question.n_readings)]
    planes = [f"p{i}" for i in range(question.n_planes)]
    found = {sensor: _phasor(y, "m") for sensor, y in zip(sensors, question.y0.tolist(), strict=True)}
    shelf = {"holes": HOLES, "shelf": [f"{value!r} kg" for value in WEIGHTS]} if question.is_discrete else {}
    tables = {
        "conventions": {
            "phase": "lead", "readings": "phase", "angles": "with rotation", "detector": "pk", "zero": "mark",
        },
        "planes": {
            plane: {"radius": "1 m", **shelf, **_cap(cap)}
            for plane, cap in zip(planes, question.caps.tolist(), strict=True)
        },
        "sensors": {
            sensor: {"unit": "m", "importance": weight}
            for sensor, weight in zip(sensors, question.importance.tolist(), strict=True)
        },
        "runs": [{"name": "as found", "speed": _SPEED, "readings": found}],
        "influence": [
            {"sensor": sensor, "plane": plane, "value": _phasor(h, "m/kg")}
            for sensor, row in zip(sensors, question.H.tolist(), strict=True)
            for plane, h in zip(planes, row, strict=True)
        ],
        "limits": {
            f"at_{sensor}": {"response": "residual", "at": sensor, "at_most": f"{limit!r} m"}
            for sensor, limit in zip(sensors, question.limits.tolist(), strict=True)
            if np.isfinite(limit)
        },
        "goal": _goal(question),
    }  # fmt: skip
    return {key: table for key, table in tables.items() if table}


def _cap(cap: float) -> dict[str, Any]:
    return {"weight": {"from": "0 kg", "to": f"{cap!r} kg"}} if np.isfinite(cap) else {}


def _goal(question: Question) -> dict[str, Any]:
    if question.goal == "correction":
        return {"minimise": "correction"}
    threshold = {"huber_at": f"{question.huber!r} m"} if question.goal == "huber" else {}
    return {"minimise": "residual", "combine": question.goal, **threshold}


def _phasor(z: complex, unit: str) -> str:
    return f"{abs(z)!r} {unit} @ {degrees(np.angle(z))!r} deg"
