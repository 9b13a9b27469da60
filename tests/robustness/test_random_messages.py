"""White noise and decay rates said wrongly: every message word for word."""

from __future__ import annotations

from typing import Any

import pytest

import vibopt as vo

BOTH = (
    'Write "100 N²/Hz" for a force, or "0.01 (m/s²)²/Hz" for the acceleration or "0.01 mm²/Hz" for the displacement of '
    "a base."
)
DRIFT = (
    "is infinite whatever the design: a base whose acceleration is white noise (excitations.w) drifts away, and m with "
    "it. Ask for rms_relative_displacement across a link, or for rms_acceleration."
)
STEADY = {"kind": "force", "on": "m", "amplitude": "3 N", "speed": "5 Hz"}
SHAKEN = {"kind": "white_noise", "on": "b", "density": "1 (m/s²)²/Hz"}
LOSSY = "but links.l has a loss_factor, which speaks of steady harmonic motion only. Give it damping or damping_ratio"

WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no density": ({"excitations.w.density": None}, 'excitations.w has no density. Add it: density = "100 N²/Hz".'),
    "no unit": ({"excitations.w.density": "3"}, 'excitations.w.density = "3" has no unit. Write "3 N²/Hz".'),
    "a mass": (
        {"excitations.w.density": "3 kg"},
        f'excitations.w.density = "3 kg" is a mass, but a spectral density of force is needed here. {BOTH}',
    ),
    "an unknown unit": (
        {"excitations.w.density": "3 (m/s2)2/Hx"},
        'excitations.w.density = "3 (m/s2)2/Hx" has the unknown unit "(m/s2)2/Hx". Units of a spectral density of '
        "force: N²/Hz, kN²/Hz, lbf²/Hz; on a base of acceleration: (m/s²)²/Hz, (mm/s²)²/Hz, g²/Hz; or of displacement: "
        "mm²/Hz, µm²/Hz, m²/Hz.",
    ),
    "negative": (
        {"excitations.w.density": "-3 N²/Hz"},
        'excitations.w.density = "-3 N²/Hz" is not greater than zero. Write a positive value, for example "100 N²/Hz".',
    ),
    "a choice": (
        {"excitations.w.density": {"from": "1 N²/Hz", "to": "2 N²/Hz"}},
        'excitations.w.density = { from = "1 N²/Hz", to = "2 N²/Hz" } is a choice, but this value must be a fact. '
        "Write one value.",
    ),
    "a speed": (
        {"excitations.w.speed": "300 rpm"},
        'excitations.w.speed = "300 rpm" is a speed, but white noise shakes at every frequency at once. Leave it out.',
    ),
    "acceleration of a body": (
        {"excitations.w.density": "1 g²/Hz"},
        'excitations.w.density = "1 g²/Hz" is a density of acceleration, but m is no base. Write one of force, for '
        'example "100 N²/Hz".',
    ),
    "force on a base": (
        {"excitations.w.on": "b"},
        'excitations.w.density = "1 N²/Hz" is a density of force, but b is a base. Write one of acceleration, for '
        'example "0.01 (m/s²)²/Hz", or of displacement, "0.01 mm²/Hz".',
    ),
    "displacement of a body": (
        {"excitations.w.density": "1 mm²/Hz"},
        'excitations.w.density = "1 mm²/Hz" is a density of displacement, but m is no base. Write one of force, for '
        'example "100 N²/Hz".',
    ),
    "velocity of a body on the damper of a base that is displaced": (
        {
            "links.l.between": ["b", "m"],
            "excitations.w": {"kind": "white_noise", "on": "b", "density": "1 mm²/Hz"},
            "measures.x.response": "rms_velocity",
        },
        "measures.x is infinite whatever the design: a base whose displacement is white noise (excitations.w) moves "
        "alike at every frequency, and of this response too much is left at high ones. Ask for rms_displacement of a "
        "body that the base reaches through a spring or a damper, or give a density of acceleration.",
    ),
    "nowhere": ({"excitations.w.on": "x"}, 'excitations.w.on = "x" names no body of this scene. Known: m, t.'),
    "steady response to noise": (
        {"measures.x.response": "displacement"},
        "measures.x: displacement is of a steady vibration, but excitations.w is white noise, which has no amplitude. "
        'Write response = "rms_displacement".',
    ),
    "ratio under noise": (
        {"measures.x": {"response": "transmissibility", "into": "ground"}},
        "measures.x: transmissibility is of a steady vibration, but excitations.w is white noise, which has no "
        "amplitude. Name a steady excitation in due_to.",
    ),
    "random response to a steady force": (
        {"excitations.f": STEADY, "measures.x.due_to": ["f"]},
        "measures.x: rms_displacement is a root mean square under white noise, but excitations.f is a steady "
        'vibration. Write response = "displacement", or name a white noise in due_to.',
    ),
    "nothing shakes": (
        {"excitations": None},
        "measures.x is a response to white noise, but nothing shakes the machine. Add [excitations.NAME] with kind = "
        '"white_noise".',
    ),
    "unknown noise": (
        {"measures.x.due_to": ["v"]},
        'measures.x.due_to = "v" names no excitation of this scene. Known: w.',
    ),
    "empty list": (
        {"measures.x.due_to": []},
        "measures.x.due_to is an empty list. Name an excitation, or leave it out.",
    ),
    "acceleration at once": (
        {"measures.x.response": "rms_acceleration"},
        "measures.x is infinite whatever the design: white noise holds every frequency, and the force of "
        "excitations.w accelerates m at once. Ask for rms_velocity or rms_displacement.",
    ),
    "drift": ({"links.l.between": ["b", "m"], "excitations.w": SHAKEN}, f"measures.x {DRIFT}"),
    "peak": (
        {"measures.x.unit": "mm pp"},
        'measures.x.unit = "mm pp" says "pp", but random vibration has no peak. Write the rms value.',
    ),
    "loss factor": (
        {"links.l.damping": None, "links.l.loss_factor": 0.1},
        f"measures.x asks for the response to white noise, {LOSSY} instead.",
    ),
    "loss factor and decay": (
        {
            "links.l.damping": None,
            "links.l.loss_factor": 0.1,
            "excitations": None,
            "measures.x": {"response": "decay_rate"},
        },
        f"measures.x asks for the decay rate of free vibration, {LOSSY} instead.",
    ),
    "not reached": (
        {"links.a.between": ["t", "ground"], "measures.x.of": "t"},
        "measures.x looks at t, which w cannot move: no link leads there. Add a link, or name another place.",
    ),
    "speeds of noise": (
        {"measures.x.over": "3 Hz"},
        'unknown key "over" in measures.x. Known: response, at_most, at_least, unit, soft, with_probability, worst, '
        "due_to, of, direction.",
    ),
    "find all": (
        {"goal": {"find_all": "w.speed"}, "excitations.f": STEADY},
        'goal.find_all = "w.speed" names no speed of this scene. Did you mean "f.speed"?',
    ),
}


def scene(changes: dict[str, Any]) -> vo.Scene:
    document: dict[str, Any] = {
        "bodies": {"m": {"mass": "100 kg"}, "t": {"mass": "5 kg"}},
        "bases": {"b": {}},
        "links": {
            "l": {"between": ["m", "ground"], "stiffness": "1 MN/m", "damping": "10 N s/m"},
            "a": {"between": ["t", "m"], "stiffness": "45 kN/m", "damping": "200 N s/m"},
        },
        "excitations": {"w": {"kind": "white_noise", "on": "m", "density": "1 N²/Hz"}},
        "measures": {"x": {"response": "rms_displacement", "of": "m"}},
    }
    for path, value in changes.items():
        *steps, last = path.split(".")
        here = document
        for step in steps:
            here = here[step]
        if value is None:
            here.pop(last)
        else:
            here[last] = value
    return vo.from_dict(document)


@pytest.mark.parametrize("case", WRONG)
def test_a_mistake_is_said_with_its_way_out(case: str) -> None:
    changes, text = WRONG[case]
    with pytest.raises(vo.InputError) as caught:
        scene(changes)
    assert str(caught.value) == f"scene: {text}"


def test_steady_and_random_responses_stand_side_by_side() -> None:
    both = scene({"excitations.f": STEADY, "measures.y": {"response": "displacement", "of": "t"}})
    design = vo.solve(both)
    assert design.measures["x"].value.shown == "0.01636 mm"
    assert design.measures["y"].value.si == "m"


def test_a_bound_may_say_rms_and_means_the_same_without() -> None:
    words = {"response": "rms_displacement", "of": "m"}
    limits = {"a": {**words, "at_most": "20 µm rms"}, "b": {**words, "at_most": "20 µm"}}
    design = vo.solve(scene({"limits": limits}))
    assert design.status == "met"
    assert design.limits["a"].margin == design.limits["b"].margin


def test_the_python_words_make_the_same_scene() -> None:
    machine = vo.Machine("Cabinet")
    machine.body("m", mass="100 kg")
    machine.link("l", between=("m", "ground"), stiffness="1 MN/m", damping="10 N s/m")
    machine.white_noise("w", on="m", density="1 N²/Hz")
    made = machine.scene(
        limits={"x": machine.rms_displacement(of="m") <= "1 mm rms", "d": machine.decay_rate() >= "0.01 1/s"},
        measures=[
            machine.rms_velocity(of="m"),
            machine.rms_force(into="ground"),
            machine.rms_relative_displacement(across="l"),
        ],
    )
    assert vo.from_text(vo.to_toml(made)).document == made.document
    assert vo.solve(made).status == "met"
