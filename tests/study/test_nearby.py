"""A damper that was chosen by a ratio and rounded is the part that is bought."""

from __future__ import annotations

from pathlib import Path

import pytest

import vibopt as vo
from vibopt.study.rounded_plan import drawn
from vibopt.study.saved import saved_text

PRESS = """
[bodies.press]
mass = "300 kg"
[links.mount]
between = ["press", "ground"]
stiffness = "2 MN/m"
damping_ratio = { from = 0.05, to = 0.3 }
[excitations.e]
kind = "force"
on = "press"
amplitude = "1 kN"
speed = "0..3000 rpm"
varies = "constant"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "4 kN"
[goal]
minimise = "damping"
of = "mount"
"""


def test_a_ratio_is_rounded_and_the_damper_that_it_is_stays(tmp_path: Path) -> None:
    """With --round, kept and saved, and on a heavier press."""
    job = vo.from_text(PRESS, "press.toml")
    answer = vo.solve(job)
    done = drawn(job, answer, ("2",))
    ratio = done.values["links.mount.damping_ratio"].rounded.value
    damper = f"{2.0 * ratio * (2e6 * 300.0) ** 0.5!r} N s/m"
    built = PRESS.partition("[goal]")[0].replace("300 kg", "360 kg")
    built = built.replace("damping_ratio = { from = 0.05, to = 0.3 }", f'damping = "{damper}"')
    force = vo.solve(vo.from_text(built, "built.toml")).limits["floor"].value.value
    kept = vo.whatif(job, {"bodies.press.mass": "360 kg"}, keep_design=True, rounding=("2",))
    assert kept.after.limits["floor"].value.value == pytest.approx(force, rel=1e-9)
    target = tmp_path / "saved.toml"
    target.write_text(saved_text(job, done.design, target, fixed=done.kept), encoding="utf-8")
    saved = vo.with_changes(vo.read(target), {"bodies.press.mass": "360 kg"})
    assert vo.solve(saved).limits["floor"].value.value == pytest.approx(force, rel=1e-9)
