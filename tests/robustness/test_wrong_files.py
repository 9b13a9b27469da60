"""Wrong problem files: every message word for word, with its line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from refusals import refused
from vibopt import jobs
from vibopt.scene.read import from_text, read

GOOD = """\
title = "Fan on its mount"

[bodies.fan]
mass = "100 kg"

[links.mount]
between = ["fan", "ground"]
stiffness = { from = "10 kN/m", to = "1 MN/m" }
damping = "100 N s/m"

[excitations.fan]
kind = "force"
on = "fan"
amplitude = "100 N"
speed = "3000 rpm"

[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "20 N"

[goal]
maximise = "stiffness"
of = "mount"
"""

RANGE = '{ from = "10 kN/m", to = "1 MN/m" }'
FAR = "is beyond what any machine has"

WRONG = {
    "zero mass": (
        {'"100 kg"': '"0 kg"'},
        'line 3: nothing has a mass, so that nothing vibrates. Give a body its mass: "300 kg".',
    ),
    "negative mass": (
        {'"100 kg"': '"-5 kg"'},
        'line 4: bodies.fan.mass = "-5 kg" is not greater than zero. Write a positive value, for example "300 kg".',
    ),
    "not a number": ({'"100 kg"': '"nan kg"'}, 'line 4: bodies.fan.mass = "nan kg" is not a finite number.'),
    "a bare nan": ({'"100 kg"': "nan"}, "line 4: bodies.fan.mass = nan is not a finite number."),
    "infinite": ({'"100 kg"': '"inf kg"'}, 'line 4: bodies.fan.mass = "inf kg" is not a finite number.'),
    "huge": ({'"100 kg"': '"1e300 kg"'}, f'line 4: bodies.fan.mass = "1e300 kg" {FAR} (|value| > 1e30 in SI).'),
    "tiny": ({'"100 kg"': '"1e-300 kg"'}, f'line 4: bodies.fan.mass = "1e-300 kg" {FAR} (|value| < 1e-30 in SI).'),
    "no unit": ({'"100 kg"': "100"}, 'line 4: bodies.fan.mass = 100 has no unit. Write "100 kg".'),
    "unknown unit": (
        {'"100 kg"': '"100 kilo"'},
        'line 4: bodies.fan.mass = "100 kilo" has the unknown unit "kilo". Units of a mass: kg, g, mg, t, lb, oz.',
    ),
    "empty range": (
        {'to = "1 MN/m"': 'to = "10 kN/m"'},
        'line 8: links.mount.stiffness = { from = "10 kN/m", to = "10 kN/m" } is an empty range: from equals to. '
        "Write the value alone, as a fact.",
    ),
    "reversed range": (
        {'to = "1 MN/m"': 'to = "1 N/m"'},
        'line 8: links.mount.stiffness = { from = "10 kN/m", to = "1 N/m" } is a reversed range: from is greater '
        "than to. Exchange the two.",
    ),
    "whole numbers of newtons": (
        {RANGE: '{ from = "1 N/m", to = "9 N/m", whole = true }'},
        'line 8: links.mount.stiffness = { from = "1 N/m", to = "9 N/m", whole = true } asks for whole numbers, but '
        'only a count is one. Write one_of = ["...", "..."] for a list of values.',
    ),
    "a range for an end": (
        {'to = "1 MN/m"': 'to = { from = true, to = "a" }'},
        'line 8: links.mount.stiffness = { from = "10 kN/m", to = { from = true, to = "a" } } has a wrong to: '
        '{ from = true, to = "a" } is no value with a unit, but a stiffness is needed here. Write a stiffness, for '
        'example "2 MN/m".',
    ),
    "too many mounts": (
        {'"100 N s/m"': '"100 N s/m"\ncount = { from = 1, to = 1e12 }'},
        "line 10: links.mount.count = { from = 1, to = 1000000000000.0 } holds more than 5000 whole numbers. "
        "Write a narrower range, or leave whole out.",
    ),
    "no whole number": (
        {'"100 N s/m"': '"100 N s/m"\ncount = { to = 1, whole = false }'},
        "line 10: links.mount.count = { to = 1, whole = false } has whole = false, but a count is a whole number. "
        "Leave whole out.",
    ),
    "half a mount": (
        {'"100 N s/m"': '"100 N s/m"\ncount = 2.5'},
        'line 10: links.mount.count = 2.5 is not a whole number. Write a whole number, for example "4".',
    ),
    "half a mode": (
        {'"transmitted_force"\ninto = "ground"\nat_most = "20 N"': '"damping_ratio"\nmode = 1.5\nat_least = 0.01'},
        "line 19: limits.floor.mode = 1.5 is not a whole number. Write one, for example mode = 1.",
    ),
    "no mount": (
        {'"100 N s/m"': '"100 N s/m"\ncount = 0'},
        'line 10: links.mount.count = 0 is not greater than zero. Write a positive value, for example "4".',
    ),
    "empty list of values": (
        {RANGE: "{ one_of = [] }"},
        'line 8: links.mount.stiffness = { one_of = [] } needs one_of = ["...", "..."] alone, with at least one '
        "value in it.",
    ),
    "unknown key": ({"damping =": "dampng ="}, 'line 9: unknown key "dampng" in links.mount. Did you mean "damping"?'),
    "unknown table": ({"[goal]": "[gaol]"}, 'line 22: unknown key "gaol" at the top level. Did you mean "goal"?'),
    "name taken twice": (
        {"[links.mount]": "[links.fan]", 'of = "mount"': 'of = "fan"'},
        "line 6: links.fan takes a name that bodies.fan has already. Choose another.",
    ),
    "missing body": (
        {'["fan", "ground"]': '["fam", "ground"]'},
        'line 7: links.mount.between = ["fam", "ground"] names "fam", which is no body, base or ground. '
        'Did you mean "fan"?',
    ),
    "a link from a point to itself": (
        {'["fan", "ground"]': '["fan", "fan"]'},
        'line 7: links.mount.between = ["fan", "fan"] joins a point with itself. Name two different ends.',
    ),
    "held by nothing": (
        {
            f"stiffness = {RANGE}\n": "", '"100 N s/m"': '{ from = "1 N s/m", to = "9 N s/m" }',
            'maximise = "stiffness"\nof = "mount"': 'minimise = "static_deflection"\nof = "fan"',
        },
        "line 21: goal asks for the static deflection of fan, but no spring holds it. Add a link with a stiffness "
        "from fan towards the ground.",
    ),
    "moved by nothing": (
        {
            "[excitations.fan]": '[bodies.desk]\nmass = "9 kg"\n[links.leg]\nbetween = ["desk", "ground"]\n'
            'stiffness = "1 kN/m"\n\n[excitations.fan]',
            'response = "transmitted_force"\ninto = "ground"\nat_most = "20 N"': 'response = "displacement"\n'
            'of = "desk"\nat_most = "1 mm"',
        },
        "line 23: limits.floor looks at desk, which fan cannot move: no link leads there. Add a link, or name "
        "another place.",
    ),
    "wrong dimension": (
        {'"20 N"': '"20 mm"'},
        'line 20: limits.floor.at_most = "20 mm" is a length, but transmitted_force is a force. Write a force, for '
        'example "6 kN".',
    ),
    "negative bound": (
        {'"20 N"': '"-20 N"'},
        'line 20: limits.floor.at_most = "-20 N" is negative. Write its size, a positive value.',
    ),
    "no bound": (
        {'at_most = "20 N"\n': ""},
        "line 17: limits.floor has no bound. Add at_most or at_least, or move it to [measures.floor].",
    ),
    "bounds exchanged": (
        {'"20 N"': '"20 N"\nat_least = "30 N"'},
        "line 17: limits.floor has an at_least above its at_most. Exchange the two.",
    ),
    "unit of another dimension": (
        {'"20 N"': '"20 N"\nunit = "mm"'},
        'line 21: limits.floor.unit = "mm" is a length, but a force is needed here. Write a force, for example '
        '"6 kN".',
    ),
    "at and over": (
        {'"20 N"': '"20 N"\nat = "3000 rpm"\nover = "0..3000 rpm"'},
        "line 17: limits.floor has both at and over. Keep one: at for single speeds, over for ranges.",
    ),
    "a place that is not said": (
        {"mount": "spring", 'response = "transmitted_force"\ninto = "ground"': 'response = "relative_displacement"',
         '"20 N"': '"20 mm"'},
        'line 17: limits.floor has no across. Add it: across = "spring".',
    ),
    "negative factor": (
        {'"3000 rpm"': '"3000 rpm"\nvaries = [["0 rpm", -1], ["5000 rpm", 2]]'},
        'line 16: excitations.fan.varies = [["0 rpm", -1], ["5000 rpm", 2]] has a factor below zero, and an amplitude '
        "is its size. Write factors of zero or more.",
    ),
    "missing varies": (
        {'"20 N"': '"20 N"\nover = "0..3000 rpm"'},
        "line 17: limits.floor looks at speeds other than those of excitations.fan: how does its amplitude vary? "
        'Add varies = "constant" or varies = "speed^2" to excitations.fan.',
    ),
    "growing from standstill": (
        {'"3000 rpm"': '"0 rpm"\nvaries = "speed^2"'},
        "line 11: excitations.fan has an amplitude that grows with the speed, but gives it at standstill, where it "
        'is zero. Write amplitude_at = "2000 rpm".',
    ),
    "amplitude at a speed with which it does not grow": (
        {'"3000 rpm"': '"3000 rpm"\nvaries = "constant"\namplitude_at = "1500 rpm"'},
        "line 17: excitations.fan has amplitude_at, but its amplitude does not grow with a power of the speed. Write "
        'varies = "speed^2", or leave amplitude_at out.',
    ),
    "steady, and begins suddenly": (
        {'"3000 rpm"': '"3000 rpm"\nbegins = "suddenly"'},
        "line 16: excitations.fan begins suddenly, but what is asked is steady, as if it had run for long. Ask for "
        'what is greatest in time, response = "peak_displacement" for example, or leave begins out.',
    ),
    "negative speed": (
        {'"3000 rpm"': '"-3000 rpm"'},
        'line 15: excitations.fan.speed = "-3000 rpm" is a negative speed. Write its size: what turns the '
        "other way has the other axis in space, and k_yz, k_zy, c_yz and c_zy of the other sign in bearings; to all "
        "else the sense of rotation does not matter.",
    ),
    "speeds downwards": (
        {'"3000 rpm"': '"3000..100 rpm"'},
        'line 15: excitations.fan.speed = "3000..100 rpm" runs downwards: its lower end is above its upper end. '
        'Write "100 rpm..3000 rpm".',
    ),
    "unknown response": (
        {'"transmitted_force"': '"transmited_force"'},
        'line 18: limits.floor.response = "transmited_force" is no response that vibopt knows. Did you mean '
        '"transmitted_force"?',
    ),
    "unknown kind": (
        {'kind = "force"': 'kind = "forse"'},
        'line 12: excitations.fan.kind = "forse" is no kind that vibopt knows. Did you mean "force"?',
    ),
    "too high a mode": (
        {'response = "transmitted_force"\ninto = "ground"\nat_most = "20 N"': 'response = "natural_frequency"\n'
         'mode = 2\nat_most = "9 Hz"'},
        "line 19: limits.floor.mode = 2 is more than the number of modes, 1.",
    ),
    "two dampers in one": (
        {'"100 N s/m"': '"100 N s/m"\nloss_factor = 0.1'},
        "line 6: links.mount gives damping and loss_factor. Keep one: they are three ways to say the damping of one "
        "link.",
    ),
    "two goals": (
        {'maximise = "stiffness"': 'maximise = "stiffness"\nminimise = "damping"'},
        "line 22: goal has maximise and minimise. Keep one of them.",
    ),
    "a goal of many": (
        {'maximise = "stiffness"': 'maximise = ["stiffness"]'},
        'line 23: goal.maximise = ["stiffness"] is no response that vibopt knows. Did you mean "stiffness"?',
    ),
    "a bound on the goal": (
        {'of = "mount"\n': 'of = "mount"\nat_most = "1 N/m"\n'},
        "line 25: goal has a bound (at_most). Say bounds in [limits.NAME].",
    ),
    "title of a number": ({'"Fan on its mount"': "3"}, "line 1: title = 3 is not a text. Write it in quotation marks."),
    "a goal of two mounts": (
        {'of = "mount"': 'of = ["mount", "other"]'}, 'line 24: goal.of = ["mount", "other"] is a list. Write one text.'
    ),
    "a place under another key": (
        {'on = "fan"': 'of = "fan"'}, 'line 13: excitations.fan has of = "fan" where on is needed. Write on = "fan".'
    ),
    "a place that no key takes": (
        {'into = "ground"': 'of = "ground"'}, 'line 19: unknown key "of" in limits.floor. Did you mean "into"?'
    ),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), WRONG.values(), ids=WRONG)
def test_one_mistake_gives_one_message(changes: dict[str, str], message: str) -> None:
    text = GOOD
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    assert refused(from_text, text, name="fan.toml").messages == (f"fan.toml {message}",)


def test_the_good_file_is_good() -> None:
    assert from_text(GOOD, name="fan.toml").title == "Fan on its mount"


FILES = {
    "empty": (b"", 'file.toml is empty. A problem file needs at least a [bodies.NAME] with mass = "300 kg".'),
    "comments only": (
        b"# later\n\n", 'file.toml is empty. A problem file needs at least a [bodies.NAME] with mass = "300 kg".'
    ),
    "binary": (bytes(range(256)) * 40, "file.toml is not a text in UTF-8. A problem file is a TOML text file."),
    "utf-16": (GOOD.encode("utf-16"), "file.toml is a text in UTF-16. Save it as UTF-8."),
    "latin-1": (
        GOOD.replace('"100 kg"', '"100 kg\u00e4"').encode("latin-1"),
        "file.toml line 4: holds a sign that is not written in UTF-8. Save the file as UTF-8.",
    ),
    "umlaut": (
        b"[bodies.gr\xc3\xb6\xc3\x9fe]\nmass = 1\n",
        "file.toml line 1: is no valid TOML: Expected ']' at the end of a table declaration. A name with other signs "
        'than letters without accents, digits, - and _ stands in quotation marks: [bodies."gr\u00f6\u00dfe"].',
    ),
    "10 MB": (b"#" * 10_000_000, "file.toml has 10.0 MB; a problem file has at most 2 MB."),
    "nested": (b"a = " + b"[" * 5000 + b"]" * 5000, "file.toml: is nested too deeply for a problem file."),
    "key twice": (
        GOOD.replace('mass = "100 kg"', 'mass = "100 kg"\nmass = "1 kg"').encode(),
        "file.toml line 5: mass is given a second time. Keep one, or take another name.",
    ),
    "open quote": (
        GOOD.replace('"100 kg"', '"100 kg').encode(),
        "file.toml line 4: is no valid TOML: Illegal character '\\n'. Close the quotation mark.",
    ),
    "table twice": (
        b'[bodies.fan]\nmass = "1 kg"\n[bodies.fan]\nmass = "2 kg"\n',
        "file.toml line 3: [bodies.fan] is given a second time. Keep one, or take another name.",
    ),
    "key twice in braces": (
        b'[links.a]\nstiffness = { from = "1 N/m", from = "2 N/m" }\n',
        "file.toml line 2: from is given a second time. Keep one, or take another name.",
    ),
    "no quotes": (
        GOOD.replace('"100 kg"', "100 kg").encode(),
        "file.toml line 4: is no valid TOML: Expected newline or end of document after a statement. "
        'A text stands in quotation marks: mass = "300 kg".',
    ),
    "cut short": (b"[goal]\nminimise =", 'file.toml line 2: is no valid TOML: Invalid value. '
                  'A text stands in quotation marks: mass = "300 kg".'),
}  # fmt: skip


@pytest.mark.parametrize(("content", "message"), FILES.values(), ids=FILES)
def test_a_file_that_is_no_problem_file(content: bytes, message: str, tmp_path: Path) -> None:
    file = tmp_path / "file.toml"
    file.write_bytes(content)
    assert refused(read, file).messages == (message,)


@pytest.mark.parametrize("content", [GOOD.replace("\n", "\r\n").encode(), b"\xef\xbb\xbf" + GOOD.encode()])
def test_files_of_other_systems_are_read(content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "fan.toml"
    file.write_bytes(content)
    assert read(file).title == "Fan on its mount"


def test_a_file_that_is_not_there_or_a_folder(tmp_path: Path) -> None:
    caught = refused(read, tmp_path / "no.toml")
    assert str(caught) == f"{tmp_path / 'no.toml'} is not there. Name an existing problem file (.toml)."
    assert str(refused(read, tmp_path)) == f"{tmp_path} is a folder. Name a problem file (.toml)."


def test_line_ends_that_toml_does_not_know_are_said() -> None:
    words = "scene.toml: its lines end with a bare carriage return, as TOML knows none. Save it with line feeds."
    assert str(refused(lambda: from_text(GOOD.replace("\n", "\r"), name="scene.toml"))) == words


NAMING = {
    "influence": 'influence = "{}"\nspeed = "9 Hz"\n[planes.p]\n[[runs]]\nreadings = {{ a = "1 mm" }}\n',
    "readings": 'readings = "{}"\n[planes.p]\n',
    "structures.s.mass": '[structures.s]\nmass = "{}"\nstiffness = "k.mtx"\n',
    "links.l.part.catalogue": '[links.l]\nbetween = ["a", "ground"]\npart = {{ catalogue = "{}" }}\n',
    "bearings.b.table": '[bodies.a]\nmass = "1 kg"\n[bearings.b]\nbetween = ["a", "ground"]\ntable = "{}"\n',
    "excitations.e.file": '[bodies.a]\nmass = "1 kg"\n[excitations.e]\nkind = "record"\non = "a"\nfile = "{}"\n',
    "data": '[bodies.a]\nmass = {{ value = "1 kg", tolerance = {{ data = "{}" }} }}\n',
}  # fmt: skip


@pytest.mark.parametrize("key", NAMING)
def test_a_blank_is_no_file_name_and_a_point_is_the_folder(key: str) -> None:
    for blank in ("", "  "):
        said = str(refused(jobs.from_text, NAMING[key].format(blank)))
        assert "no file name. Write " in said
        assert key.rpartition(".")[2] in said
    assert re.search(r"\S is a folder\. Name a ", str(refused(jobs.from_text, NAMING[key].format("."))))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("bodies.fan", 'bodies."f.1"', 'bodies: "f.1" has a point, which parts the steps of a path as '
         'bodies.press.mass. Write "f-1".'),
        ("limits.floor", 'limits." "', 'limits: " " is a blank name. Write one with letters, "press".'),
        ("links.mount", 'links."a\\tb"', 'links: "a?b" has a sign that cannot be shown. Write a name of letters and '
         "digits."),
    ],
)  # fmt: skip
def test_a_name_by_which_no_path_leads_is_refused(old: str, new: str, message: str) -> None:
    assert message in str(refused(jobs.from_text, GOOD.replace(old, new)))


def test_a_sensor_has_a_name_by_which_a_path_leads(tmp_path: Path) -> None:
    head = 'speed = "9 Hz"\n[planes.p]\n[conventions]\nphase = "lag"\nreadings = "phase"\n'
    head += 'angles = "with rotation"\ndetector = "pk"\nzero = "key"\n'
    said = '"a.1" has a point, which parts the steps of a path as bodies.press.mass. Write "a-1".'
    runs = f'{head}[[runs]]\nreadings = {{ "a.1" = "1 mm @ 3 deg" }}\n'
    assert said in str(refused(jobs.from_text, runs))
    (tmp_path / "runs.csv").write_text("p mass [g],p angle [deg],a.1 amplitude [mm],a.1 angle [deg]\n,,1,3\n2,0,2,9\n")
    (tmp_path / "job.toml").write_text(f'readings = "runs.csv"\n{head}')
    assert said in str(refused(jobs.open_job, tmp_path / "job.toml"))
