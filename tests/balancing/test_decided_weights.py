"""Weights that are decided: a plan as a file of its own measures what the plan promised."""

from __future__ import annotations

import re
from math import isclose
from pathlib import Path

import pytest

from refusals import refused
from rotor_jobs import FAN
from vibopt.document.toml_writing import document_toml
from vibopt.errors import InputError
from vibopt.jobs import answer, from_text, is_scene, kept_plan, open_job, with_changes
from vibopt.study.prices import priced

FILES = sorted((Path(__file__).parents[2] / "problems" / "balancing").glob("*.toml"))
MEASURED = ("planes.", "sensors.", "residual.", "as_found.", "orders.", "all_orders.", "cylinders.")
HALF = FAN.replace(
    '[planes.left]\nradius = "150 mm"',
    '[planes.left]\nradius = "150 mm"\nholes = 24\nweight = ["10 g in hole 7", "4 g in hole 9"]',
).replace(
    '[planes.right]\nradius = "150 mm"', '[planes.right]\nradius = "150 mm"\nweight = { from = "0 g", to = "60 g" }'
)
"""The left plane is decided, the right one is to be chosen."""


@pytest.mark.parametrize("file", FILES, ids=lambda one: one.stem)
def test_a_plan_as_a_file_of_its_own_measures_what_the_plan_promised(file: Path) -> None:
    job = open_job(file)
    assert not is_scene(job)
    found = answer(job, explain=False)
    saved = from_text(document_toml(kept_plan(job, found).document), "saved")
    assert not is_scene(saved)
    assert not saved.choices
    again = answer(saved, explain=False)
    assert again.status == "met"
    said, measured = found.entries(), again.entries()
    for path, one in said.items():
        if not path.startswith(MEASURED):
            continue
        other = measured[path].value
        if isinstance(one.value, str) or isinstance(other, str):
            assert other == one.value, path
        elif not path.endswith("angle"):
            assert isclose(other, one.value, rel_tol=1e-9, abs_tol=1e-12), path


def test_a_run_is_predicted_by_its_own_weights() -> None:
    """The rotor with the weights of a trial decided must show the readings of that trial."""
    text = HALF.replace('weight = { from = "0 g", to = "60 g" }', "weight = []")
    text = text.replace('["10 g in hole 7", "4 g in hole 9"]', '"10 g @ 270 deg"')
    found = answer(from_text(text))
    assert (found.status, found.goal is not None) == ("met", True)
    shown = {name: float(found.find(f"sensors.{name}.residual").value) for name in "ab"}
    assert shown == pytest.approx({"a": 0.5 * 5.9 * 25.4e-6, "b": 0.5 * 4.5 * 25.4e-6}, rel=1e-9)


def test_with_one_plane_decided_the_other_is_chosen_for_it() -> None:
    """The free plane does what least squares say with the decided weights on the rotor."""
    import numpy as np

    found = answer(from_text(HALF))
    wholly = answer(from_text(HALF.replace('holes = 24\nweight = ["10 g in hole 7", "4 g in hole 9"]', "")))
    assert found.status == "optimal"
    turn = {"left": [(0.010, 90.0), (0.004, 120.0)]}
    u = sum(m * 0.150 * np.exp(-1j * np.radians(angle)) for m, angle in turn["left"])

    def phasor(amplitude: float, angle: float) -> complex:
        return complex(0.5 * amplitude * 25.4e-6 * np.exp(-1j * np.radians(angle)))

    y0 = np.array([phasor(8.6, 63), phasor(6.5, 206)])
    left = np.array([phasor(5.9, 123), phasor(4.5, 228)]) - y0
    right = np.array([phasor(6.2, 36), phasor(10.4, 162)]) - y0
    H = np.stack([left / (0.010 * 0.150 * np.exp(-1j * np.radians(270))),
                  right / (0.012 * 0.150 * np.exp(-1j * np.radians(180)))], axis=1)  # fmt: skip
    start = y0 + H[:, 0] * u
    best = -np.vdot(H[:, 1], start) / np.vdot(H[:, 1], H[:, 1])
    residual = np.abs(start + H[:, 1] * best)
    assert float(found.find("planes.right.mass").value) == pytest.approx(abs(best) / 0.150, rel=1e-6)
    assert [float(found.find(f"sensors.{one}.residual").value) for one in "ab"] == pytest.approx(residual, rel=1e-6)
    assert found.goal is not None
    assert wholly.goal is not None
    assert float(found.goal[1].value) > float(wholly.goal[1].value)


def test_decided_weights_that_break_a_limit_are_violated() -> None:
    text = HALF.replace('weight = { from = "0 g", to = "60 g" }', "weight = []")
    found = answer(from_text(f'{text}[limits.running]\nresponse = "residual"\nat_most = "0.2 mil"\n'))
    assert (found.status, found.claim) == ("violated", "limits that do not hold: running; "
        "put back into a simulated rotor, which shows the same up to rounding")  # fmt: skip
    assert found.exit_code == 7


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "holes = 24\n",
            'holes = 24\nshelf = ["5 g"]\n',
            "fan line 12: planes.left has shelf, which is for a weight that is chosen, but its weight is decided. "
            "Leave shelf out, or write weight as a range { from, to }.",
        ),
        (
            '"4 g in hole 9"',
            '"4 g in hole 99"',
            'fan line 12: planes.left.weight[2] = "4 g in hole 99" names a hole that is not there: planes.left has '
            "holes 1 to 24.",
        ),
        (
            '"4 g in hole 9"',
            '"4 g"',
            'fan line 12: planes.left.weight[2] = "4 g" has no angle. Write "10 g @ 270 deg".',
        ),
        (
            'weight = { from = "0 g", to = "60 g" }',
            'remove = true\nweight = "40 g @ 20 deg"\n'
            'drill = { diameter = "10 mm", density = "7850 kg/m³", deepest = "20 mm" }',
            'fan line 16: planes.right.weight = "40 g @ 20 deg" takes a hole 64.88 mm deep, but the deepest that may '
            "be drilled is 20 mm.",
        ),
    ],
)
def test_wrong_decided_weights_are_told(old: str, new: str, message: str) -> None:
    error = refused(from_text, HALF.replace(old, new, 1), "fan")
    assert re.sub(r"fan line \d+", "", "\n".join(error.messages)) == re.sub(r"fan line \d+", "", message)


def test_decided_weights_have_no_prices_and_nothing_is_said_of_them() -> None:
    text = HALF.replace('weight = { from = "0 g", to = "60 g" }', "weight = []")
    text = f'{text}[limits.running]\nresponse = "residual"\nat_most = "20 mil"\n'
    for explain in (True, False):
        found = answer(from_text(text), explain=explain)
        assert (found.status, priced(found).limits["running"].price) == ("met", None)
        assert not [one for one in found.notes if "price" in one]


def test_where_nothing_was_found_there_is_nothing_to_keep() -> None:
    job = from_text(f'{HALF}[limits.running]\nresponse = "residual"\nat_most = "0.001 mil"\n', "fan")
    assert not is_scene(job)
    with pytest.raises(InputError, match=r"fan: there is no design to keep: infeasible\. Solve the file first\."):
        kept_plan(job, answer(job))


def test_a_decided_weight_is_a_number_of_the_file_like_any_other() -> None:
    job = with_changes(from_text(HALF), {"planes.left.weight.2": "6 g in hole 9"})
    found = answer(job)
    assert float(found.find("planes.left.mass").value) != 0.0
