"""A measure over tolerances is told as the limit of the same question: worst machine, value, and what is proven."""

from __future__ import annotations

from functools import cache
from math import inf

import numpy as np
import pytest

from vibopt.program.worst_case import around
from vibopt.report.curves import panels
from vibopt.report.sheet.judgement import proof_of, verdict_of
from vibopt.scene.read import from_text
from vibopt.scene.scene import Design
from vibopt.solve import solve
from vibopt.solve.proof import searched, settled, worst_machines
from vibopt.study.window import window
from vibopt.work import metered

TURNS = 'kind = "unbalance"\nunbalance = "0.2 kg m"\nspeed = "1500 rpm"\n'
SHAKEN = 'kind = "force"\namplitude = "5 kN"\nspeed = "300..1500 rpm"\n'
PULSE = 'kind = "pulse"\nshape = "half sine"\namplitude = "5 kN"\n'
JOBS = {
    "a motor that sticks": (TURNS + 'run_up = { torque = "6 N m", inertia = "2 kg m2" }', "peak_displacement"),
    "a rate of the speed": (TURNS + 'run_up = { acceleration = "500 rpm/s" }', "peak_displacement"),
    "down": (TURNS + 'run_up = { from = "1500 rpm", to = "0 rpm", duration = "3 s" }', "peak_displacement"),
    "a release": ('kind = "release"\ndisplacement = "5 mm"', "peak_displacement"),
    "any duration": (PULSE + 'duration_up_to = "10 ms"', "peak_displacement"),
    "suddenly": (SHAKEN.replace("300..", "") + 'begins = "suddenly"', "peak_displacement"),
    "steady": (SHAKEN, "displacement"),
}
PROVEN = {"a motor that sticks", "steady"}


@cache
def _answered(job: str, family: str, bound: str = "") -> Design:
    excitation, response = JOBS[job]
    return solve(
        from_text(f"""
[bodies.fan]
mass = "200 kg"
[links.springs]
between = ["fan", "ground"]
stiffness = {{ value = "800 kN/m", tolerance = "3 %" }}
damping = {{ value = "1264.9 N s/m", tolerance = "40 %" }}
[excitations.e]
on = "fan"
{excitation}
[{family}.level]
response = "{response}"
of = "fan"
{bound}
""")
    )


@pytest.mark.parametrize(
    "job", [pytest.param(one, marks=pytest.mark.slow) if one == "any duration" else one for one in JOBS]
)
def test_a_measure_is_judged_as_the_limit_of_the_same_question(job: str) -> None:
    measured = _answered(job, "measures")
    row = measured.measures["level"]
    bound = row.value.value * 1.0005 if row.value.value < inf else 1.0
    limited = _answered(job, "limits", f'at_most = "{bound:.12g} m"')
    asked = limited.limits["level"]
    assert (row.value.value, row.off) == (asked.value.value, asked.off)
    assert (row.value.value == inf) is ("sticks" in job)
    if "sticks" in job:
        assert row.off == pytest.approx({"links.springs.damping": -0.4})
    assert measured.proven == limited.proven == (job in PROVEN)
    assert measured.to_json()["proven"] is measured.proven
    assert measured.tolerances is not None
    if measured.proven:
        assert measured.claim.endswith("for every machine within the tolerances, proven")
        assert measured.tolerances.open == ()
    else:
        assert measured.claim.endswith("machines found, not proven for measures.level")
        assert measured.tolerances.open == ("measures.level",)
        assert 'Not proven over the tolerances: "measures.level"' in " ".join(proof_of(measured))


@pytest.mark.parametrize("job", JOBS)
def test_a_figure_shows_the_worst_machine_beside_the_one_as_designed(job: str) -> None:
    design = _answered(job, "measures")
    row, [panel] = design.measures["level"], panels(design)
    if "sticks" in job:
        assert panel.title == "Torque of the run-up of e: the worst machine sticks"
        return
    [mark] = panel.marks
    first, *worst = [one for one in panel.curves if not one.before]
    assert len(worst) == bool(row.off)
    for one in worst:
        assert one.worst
        assert "as designed" in first.label
        assert "worst machine within the tolerances" in one.label
        assert np.abs(first.y).max() < abs(mark.y)
    shown = (worst or [first])[0]
    order = np.argsort(shown.x)  # a run-down falls
    assert abs(np.interp(mark.x, shown.x[order], shown.y[order])) == pytest.approx(abs(mark.y), rel=1e-3)
    assert np.abs(shown.y).max() == pytest.approx(abs(mark.y), rel=1e-3)
    assert panel.x_span[0] <= mark.x <= panel.x_span[1]


SPRINGS = """
[bodies.fan]
mass = { value = "200 kg", tolerance = "2 %" }
[links.springs]
between = ["fan", "ground"]
stiffness = { from = "100 kN/m", to = "9 MN/m" }
damping = { value = "1264.9 N s/m", tolerance = "10 %" }
[excitations.e]
kind = "force"
on = "fan"
amplitude = "5 kN"
speed = "1500 rpm"
begins = "suddenly"
varies = "constant"
[limits.steady]
response = "transmitted_force"
into = "ground"
at_most = "2 kN"
[measures.level]
response = "peak_displacement"
of = "fan"
[goal]
maximise = "stiffness"
of = "springs"
"""


def test_a_design_whose_limits_are_proven_says_what_is_not_proven_of_its_measure() -> None:
    design = solve(from_text(SPRINGS))
    assert design.status == "optimal"
    assert design.claim.endswith(
        "all of it proven (to 0.1 % of the bound where a limit is tight); "
        "the worst found, not proven, for measures.level"
    )
    assert not design.proven
    assert "for every machine within the tolerances" in verdict_of(design).lines[0] + verdict_of(design).head


def test_a_measure_takes_nothing_from_what_is_proven_of_a_window() -> None:
    text = SPRINGS.replace('{ value = "200 kg", tolerance = "2 %" }', '"200 kg"')
    text = text.replace('{ value = "1264.9 N s/m", tolerance = "10 %" }', '"1264.9 N s/m"')
    assert window(from_text(text)).proven


def test_what_no_machine_has_takes_little_work() -> None:
    """No bound on machines comes as near as zero to a load that no machine has: most of the work went there."""
    design = solve(
        from_text("""
[bodies.box]
mass = "600 kg"
inertia = ["60 kg m2", "90 kg m2", "99 kg m2"]
[mounts.left]
between = ["box", "ground"]
at = [["0.8 m", "0.5 m", "0 m"], ["0.8 m", "-0.5 m", "0 m"]]
stiffness = { value = "850 kN/m", tolerance = "5 %" }
shear_ratio = 0.45
damping = { value = "1420 N s/m", tolerance = "2 %" }
[mounts.right]
between = ["box", "ground"]
at = [["-0.79 m", "0.49 m", "0 m"], ["-0.8 m", "-0.5 m", "0 m"]]
stiffness = "660 kN/m"
shear_ratio = 0.45
[limits.aside]
response = "static_load"
of = "right"
direction = "x"
at_most = "1 N"
[measures.least]
response = "static_load"
of = "left"
direction = "x"
worst = "least"
""")
    )
    assert design.status == "met"
    assert [design.limits["aside"].value.value, design.measures["least"].value.value] == [0.0, 0.0]
    assert design.work < 1000.0


def test_worst_machines_are_the_same_where_nothing_is_to_be_proven_and_take_less_work() -> None:
    scene = from_text("""
[bodies.box]
mass = "2070 kg"
centre = ["0.1 m", "0.06 m", "0.2 m"]
shape = { box = ["1.6 m", "1 m", "0.8 m"] }
tolerance = "5 %"
[mounts.foot]
between = ["box", "ground"]
at = [["0.8 m", "0.5 m", "0 m"], ["0.8 m", "-0.5 m", "0 m"], ["-0.8 m", "0.5 m", "0 m"], ["-0.8 m", "-0.5 m", "0 m"]]
stiffness = { value = "850 kN/m", tolerance = "10 %" }
shear_ratio = 0.5
damping = "3 kN s/m"
[excitations.shake]
kind = "force"
on = "box"
amplitude = "3 kN"
speed = "300..1500 rpm"
direction = [0.5, 0, 0.866]
[limits.way]
response = "displacement"
of = "box"
direction = "x"
combine = "sum"
at_most = "20 mm"
[excitations.other]
kind = "force"
on = "box"
amplitude = "1 kN"
speed = "600 rpm"
direction = "x"
[limits.sag]
response = "static_deflection"
of = "box"
at_most = "6 mm"
""")
    program = around(scene, np.zeros(0))
    with metered() as quick:
        hits = searched(program)
    with metered() as whole:
        settled_ones, _ = settled(program, worst_machines(program, {}))
    assert {index: (one.value, one.factors.tolist()) for index, one in hits.items()} == {
        index: (one.value, one.factors.tolist()) for index, one in settled_ones.items()
    }
    assert quick.done < whole.done
