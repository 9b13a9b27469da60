"""Questions of a new user: one `vibopt help` with his own words shows the place that answers."""

from __future__ import annotations

import pytest

from vibopt.cli.main import main

QUESTIONS = {
    "how do I say 7 mm/s rms": '`at_most = "7 mm/s rms"`',
    "which limit is start-up": '`over = "start-up"`',
    "where do I say that force grows with speed squared": '`varies = "speed^2"`',
    "my mount list is in kg/mm": "`stiffness [kgf/mm]`",
    "each spring or all four": "ONE single mount",
    "unproven so what": "no answer to build by",
    "what is the natural frequency": 'response = "natural_frequency"',
    "how do I call vibopt after installing": ". .venv/bin/activate",
    "choose from a list of values": "{ one_of = [",
    "choose a mount bought from a catalogue": 'part = { catalogue = "mounts.csv" }',
    "rubber stiffness scatters by 20 %": "tolerance",
    "several machines on one floor, how do they add up": '"rss"',
    "two plane balancing of a fan": "[planes.left]",
    "balance without phase": "three different angles",
    "how large is the first trial weight": "trial_force",
    "holes in a balancing plane": "holes = 24",
    "v twin counterweight": "counterweight_share",
    "pendulum absorber": 'length = "62 mm"',
    "best place for an absorber": "one_of",
    "floor given by modes": "modal_mass",
    "matrices from finite elements": "stiffness.mtx",
    "engine mounts at their places in space": "[mounts.foot]",
    "centre of mass not known exactly": "centre_tolerance",
    "what does a limit cost": "vibopt explain",
    "round values for the drawing": "--round 3",
    "print a page to sign": "--sheet",
    "exit code of infeasible": "`infeasible`",
    "add my own constraint in cvxpy": "cvxpy.Problem",
    "random vibration wind": "white_noise",
    "avoid engine orders": "orders = [",
    "find all permitted speeds": "find_all",
    "which solver is used": "closed_form",
    "what do I do when no design exists": "cannot hold together",
    "stop a long search": "--time-limit",
    "overwrite a file": "--force",
    "how do I check a file for mistakes": "vibopt check",
    "inclined mounts": "direction = [0, 0.5, 0.866]",
    "decimal comma in csv": "decimal comma",
    "static deflection under weight": "static_deflection",
    "is a response to vibration, but nothing shakes the machine": "Add [excitations.NAME].",
    "machine at two speeds": 'speed = ["1450 rpm", "2900 rpm"]',
    "runs at several speeds": 'speed = ["1450 rpm", "2900 rpm"]',
    "no correction plane": 'there is no correction plane. Write [planes.NAME] with radius = "150 mm".',
    "a box is dropped from half a metre": "peak_",
    "same answer on another computer": "--against",
}


@pytest.mark.parametrize("asked", QUESTIONS)
def test_a_question_is_answered_by_one_call(asked: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help", asked]) == 0
    shown = capsys.readouterr().out.partition("\nAlso: ")[0]
    assert QUESTIONS[asked] in " ".join(shown.split())
