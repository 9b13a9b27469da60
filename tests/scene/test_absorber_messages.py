"""Wrong absorbers and wrong torsion: every message word for word."""

from __future__ import annotations

import pytest

from refusals import refused
from vibopt.scene.read import from_text

GOOD = """\
title = "Fan with an absorber"

[bodies.fan]
mass = "100 kg"

[links.mount]
between = ["fan", "ground"]
stiffness = "1 MN/m"
damping = "100 N s/m"

[absorbers.tmd]
on = "fan"
mass = "5 kg"
frequency = "15 Hz"
damping = "20 N s/m"

[excitations.fan]
kind = "force"
on = "fan"
amplitude = "100 N"
speed = "900 rpm"

[measures.motion]
response = "displacement"
of = "fan"
"""
ON, MASS, SPRING = 'on = "fan"\nmass', 'mass = "5 kg"', 'frequency = "15 Hz"'

WRONG = {
    "on ground": (
        {ON: 'on = "ground"\nmass'},
        'line 12: absorbers.tmd.on = "ground" is a support that does not give way: an absorber on it does nothing. '
        "Name a body.",
    ),
    "on nothing": (
        {ON: 'on = "fam"\nmass'},
        'line 12: absorbers.tmd.on = "fam" names no body, absorber or point of a structure of this scene. '
        'Did you mean "fan"?',
    ),
    "on itself": (
        {ON: 'on = "tmd"\nmass'},
        'line 12: absorbers.tmd.on = "tmd" is the absorber itself. Name what it sits on.',
    ),
    "in a ring": (
        {ON: 'on = "other"\nmass', "[excitations.fan]": '[absorbers.other]\non = "tmd"\nmass = "1 kg"\n'
         'stiffness = "1 kN/m"\n\n[excitations.fan]'},
        "line 12: absorbers.tmd sits on itself by way of other. Put one of them on a body.",
    ),
    "a damping ratio beside other bodies": (
        {"[absorbers.tmd]": '[bodies.floor]\nmass = "2 t"\n\n[links.slab]\nbetween = ["ground", "floor"]\n'
         'stiffness = "20 MN/m"\ndamping_ratio = 0.02\n\n[absorbers.tmd]'},
        "line 14: links.slab gives a damping ratio, but several bodies move: relative to which mass? Add "
        'relative_to = "floor".',
    ),
    "two masses": (
        {MASS: 'mass = "5 kg"\nmass_ratio = 0.05'},
        "line 11: absorbers.tmd gives mass and mass_ratio. Keep one: they are ways to say the mass of one absorber.",
    ),
    "two springs": (
        {SPRING: 'frequency = "15 Hz"\ntuning = 1.0'},
        "line 11: absorbers.tmd gives frequency and tuning. Keep one: they are ways to say the stiffness of one "
        "absorber.",
    ),
    "two dampers": (
        {'damping = "20 N s/m"': 'damping = "20 N s/m"\ndamping_ratio = 0.1'},
        "line 11: absorbers.tmd gives damping and damping_ratio. Keep one: they are ways to say the damping of one "
        "absorber.",
    ),
    "no mass": (
        {MASS + "\n": ""},
        'line 11: absorbers.tmd has no mass. Write mass = "20 kg", or mass_ratio = 0.05 (of what it sits on).',
    ),
    "negative": (
        {MASS: "mass_ratio = -0.05"},
        "line 13: absorbers.tmd.mass_ratio = -0.05 is not greater than zero. Write a positive value, for example "
        '"20 %".',
    ),
    "unknown key": (
        {SPRING: 'frequncy = "15 Hz"'},
        'line 14: unknown key "frequncy" in absorbers.tmd. Did you mean "frequency"?',
    ),
    "line on an axis": (
        {"[bodies.fan]\nmass = \"100 kg\"": '[bodies.fan]\nmass = "100 kg"\n\n[bodies.disc]\ninertia = "1 kg m2"',
         ON: 'on = "disc"\nmass'},
        'line 16: absorbers.tmd.mass is along a line, but disc turns. Write inertia = "0.8 kg m2".',
    ),
    "tuning to what is chosen": (
        {SPRING: "tuning = 1.0", 'stiffness = "1 MN/m"': 'stiffness = { from = "1 kN/m", to = "1 MN/m" }',
         "[measures.motion]": '[links.second]\nbetween = ["fan", "ground"]\nstiffness = "1 kN/m"\n\n'
         '[goal]\nmaximise = "stiffness"\nof = "mount"\n\n[measures.motion]'},
        "line 14: absorbers.tmd.tuning = 1.0 has no frequency to refer to: what it would refer to is to be chosen too. "
        'Write tuning_to = "25 Hz", or the frequency of the absorber.',
    ),
    "places without a goal": (
        {ON: 'on = { one_of = ["fan"] }\nmass'},
        "line 12: absorbers.tmd.on is to be chosen, but there is no [goal] that says which place is best. Add [goal] "
        'with minimise = "displacement" and of = "BODY", for example.',
    ),
    "band without excitation": (
        {GOOD[GOOD.index("[excitations"):GOOD.index("[measures")]: "",
         'of = "fan"\n': 'of = "fan"\nover = "0..20 Hz"\n'},
        "line 17: measures.motion is a response to vibration, but nothing shakes the machine. Add [excitations.NAME].",
    ),
    "rotation of what moves along a line": (
        {'response = "displacement"': 'response = "rotation"'},
        "line 23: measures.motion asks for the rotation of fan, which moves along a line. Write response = "
        '"displacement".',
    ),
    "moment on what moves along a line": (
        {'kind = "force"': 'kind = "moment"', '"100 N"': '"100 N m"'},
        "line 17: excitations.fan is a moment, but fan moves along a line. Write kind = \"force\" with amplitude = "
        '"6 kN".',
    ),
    "two kinds of mass": (
        {'mass = "100 kg"': 'mass = "100 kg"\ninertia = "1 kg m2"'},
        "line 3: bodies.fan gives mass and inertia. Keep one: mass for a body that moves along a line, inertia or disc "
        "for one that turns.",
    ),
    "torsion on a line": (
        {'stiffness = "1 MN/m"\ndamping = "100 N s/m"': 'torsional_stiffness = "1 kN m/rad"'},
        "line 8: links.mount.torsional_stiffness is about an axis, but fan moves along a line. Write stiffness = "
        '"200 kN/m".',
    ),
    "hollow shaft of any size": (
        {'stiffness = "1 MN/m"\ndamping = "100 N s/m"': 'shaft = { length = "1 m", diameter = { from = "1 cm", to = '
         '"9 cm" }, inner_diameter = "5 mm", shear_modulus = "80 GPa" }'},
        "line 8: links.mount.shaft has an inner_diameter while its diameter is to be chosen. Write inner_ratio = 0.5 "
        "(inner over outer diameter) instead.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), WRONG.values(), ids=WRONG)
def test_one_mistake_gives_one_message(changes: dict[str, str], message: str) -> None:
    text = GOOD
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    assert refused(from_text, text, name="fan.toml").messages == (f"fan.toml {message}",)


def test_the_good_file_is_good_and_says_what_its_tuning_refers_to() -> None:
    assert from_text(GOOD).absorbers["tmd"].host == "fan"
    tuned = from_text(GOOD.replace(SPRING, "tuning = 0.95"))
    assert tuned.notes == ("absorbers.tmd: tuning refers to the first natural frequency without absorbers, 15.92 Hz",)
