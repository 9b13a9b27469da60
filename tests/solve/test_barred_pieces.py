"""Where limits that no excitation has a part in rule a design out, no response is followed."""

from __future__ import annotations

from typing import Any

import pytest

import vibopt as vo
from vibopt.forms.modulus import Modulus

TEXT = """
[bodies.g]
mass = "900 kg"
centre = ["0.05 m", "0.02 m", "0.4 m"]
inertia = ["120 kg m2", "210 kg m2", "220 kg m2"]
[mounts.foot]
between = ["g", "ground"]
at = [["0.7 m", "0.4 m", "0 m"], ["0.7 m", "-0.4 m", "0 m"], ["-0.7 m", "0.4 m", "0 m"], ["-0.7 m", "-0.4 m", "0 m"]]
stiffness = { from = "FROM", to = "TO" }
shear_ratio = 0.6
loss_factor = 0.1
[excitations.u]
kind = "unbalance"
on = "g"
at = ["0.3 m", "0 m", "0.6 m"]
axis = "x"
unbalance = "0.05 kg m"
speed = "1200..1500 rpm"
[limits.moves]
response = "displacement"
of = "g"
direction = "z"
over = "start-up"
at_most = "3 mm"
[goal]
minimise = "transmitted_force"
into = "ground"
direction = "z"
"""
SAG = '[limits.sag]\nresponse = "static_deflection"\nof = "g"\nat_most = "4 mm"\n'


def solved(low: str, high: str, more: str = SAG) -> Any:
    return vo.solve(
        vo.from_text(TEXT.replace("FROM", low).replace("TO", high) + more), method="one_range", explain=False
    )


def test_what_static_limits_rule_out_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    followed = []
    worst = Modulus.worst

    def counted(form: Modulus, *given: Any, **more: Any) -> Any:
        followed.append(form)
        return worst(form, *given, **more)

    monkeypatch.setattr(Modulus, "worst", counted)
    solved("20 kN/m", "3 MN/m", "")
    free = len(followed)
    followed.clear()
    assert solved("20 kN/m", "3 MN/m", SAG.replace("4 mm", "0.5 mm")).status == "infeasible"
    assert len(followed) < 0.1 * free


def test_a_wider_range_of_which_static_limits_rule_out_most_has_the_same_answer() -> None:
    wide, near = solved("20 kN/m", "3 MN/m"), solved("0.5 MN/m", "0.7 MN/m")
    assert wide.limits["sag"].active
    assert wide.x == pytest.approx(near.x, rel=1e-8)
