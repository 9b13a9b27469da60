"""The loss factor of a bought mount can be asked for whatever its static stiffness."""

from __future__ import annotations

from pathlib import Path

import pytest

import vibopt as vo

PARTS = "part,stiffness [N/mm],rated load max [N],loss factor,dynamic to static\nA,50,2000,0.1,1.2\nB,80,2000,0.2,1.5\n"
FILE = """
[bodies.m]
mass = "100 kg"

[links.l]
between = ["m", "ground"]
part = { catalogue = "parts.csv" }

[goal]
SENSE = "loss_factor"
of = "l"
"""


@pytest.mark.parametrize(("sense", "best"), [("minimise", 0.1), ("maximise", 0.2)])
def test_the_loss_factor_of_a_part_with_a_static_stiffness_of_its_own(sense: str, best: float, tmp_path: Path) -> None:
    (tmp_path / "parts.csv").write_text(PARTS, encoding="utf-8")
    (tmp_path / "scene.toml").write_text(FILE.replace("SENSE", sense), encoding="utf-8")
    job = vo.read(tmp_path / "scene.toml")
    design = vo.solve(job)
    assert (design.status, design.goal and design.goal[1].value) == ("optimal", best)
