"""The same machine in other units, or larger by a factor, gives the same answer."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
from vibopt.solve import solve

few = settings(derandomize=True, database=None, deadline=None, max_examples=12)

KILOGRAM = {"kg": 1.0, "g": 1e3, "t": 1e-3, "lb": 1 / 0.45359237}
STIFFNESS = {"N/m": 1.0, "N/mm": 1e-3, "kN/m": 1e-3, "lbf/in": 0.0254 / 4.4482216152605}
DAMPING = {"N s/m": 1.0, "N s/mm": 1e-3, "kN s/m": 1e-3, "lbf s/in": 0.0254 / 4.4482216152605}
FORCE = {"N": 1.0, "kN": 1e-3, "lbf": 1 / 4.4482216152605, "N pp": 2.0, "N rms": 0.5**0.5}
SPEED = {"rad/s": 1.0, "Hz": 0.15915494309189535, "rpm": 9.549296585513721}
LENGTH = {"m": 1.0, "mm": 1e3, "in": 1 / 0.0254, "mm pp": 2e3, "um rms": 1e6 * 0.5**0.5}


def press(units: dict[str, tuple[str, float]], *, size: float = 1.0, pace: float = 1.0) -> Design:
    """The stiffest mount of a press; masses and forces `size` times as large, times `pace` times as fast."""

    def text(kind: str, value: float) -> str:
        unit, per = units.get(kind, ("", 1.0))
        return f"{value * per!r} {unit}"

    stiff, damp = size * pace**2, size * pace
    document: dict[str, Any] = {
        "title": "press",
        "bodies": {"press": {"mass": text("mass", 300.0 * size)}},
        "links": {
            "mount": {
                "between": ["press", "ground"],
                "stiffness": {"from": text("stiffness", 1e4 * stiff), "to": text("stiffness", 1e9 * stiff)},
                "damping": {"from": text("damping", 10.0 * damp), "to": text("damping", 1e6 * damp)},
            }
        },
        "excitations": {
            "press": {
                "kind": "force", "on": "press", "amplitude": text("force", 3e4 * size * pace**2),
                "speed": text("speed", 314.0 * pace), "varies": "constant",
            }
        },
        "limits": {
            "floor": {
                "response": "transmitted_force", "into": "ground", "at_most": text("force", 1e4 * size * pace**2),
            },
            "start": {"response": "displacement", "of": "press", "over": "start-up", "at_most": text("length", 0.02)},
        },
        "goal": {"maximise": "stiffness", "of": "mount"},
    }  # fmt: skip
    return solve(from_dict(document), explain=False)


def values(design: Design) -> list[float]:
    return [one.value.value for one in design.variables.values()]


TABLES = {
    "mass": KILOGRAM, "stiffness": STIFFNESS, "damping": DAMPING, "force": FORCE, "speed": SPEED, "length": LENGTH,
}  # fmt: skip
SI = {kind: next(iter(table.items())) for kind, table in TABLES.items()}


@given(chosen=st.fixed_dictionaries({kind: st.sampled_from(sorted(table.items())) for kind, table in TABLES.items()}))
@few
def test_other_units_give_the_same_si_answer(chosen: dict[str, tuple[str, float]]) -> None:
    plain, other = press(SI), press(chosen)
    assert (other.status, values(other)) == (plain.status, pytest.approx(values(plain), rel=1e-9))
    worst = [[one.value.value for one in design.limits.values()] for design in (plain, other)]
    assert worst[1] == pytest.approx(worst[0], rel=1e-9)


@given(size=st.floats(-6, 6).map(lambda e: 10.0**e), pace=st.floats(-3, 3).map(lambda e: 10.0**e))
@few
def test_a_larger_and_faster_machine_scales_as_its_parts(size: float, pace: float) -> None:
    plain, other = press(SI), press(SI, size=size, pace=pace)
    stiffness, damping = values(plain)
    assert other.status == plain.status == "optimal"
    assert values(other) == pytest.approx([stiffness * size * pace**2, damping * size * pace], rel=1e-8)
