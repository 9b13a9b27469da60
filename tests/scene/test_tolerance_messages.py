"""What is said of tolerances that cannot be, word for word."""

from __future__ import annotations

from pathlib import Path

import pytest

from refusals import refused
from vibopt.jobs import answer, is_scene, open_job
from vibopt.scene.read import from_text
from vibopt.scene.uncertain import uncertain
from vibopt.study.saved import saved_text

SCENE = """\
[bodies.press]
mass = { value = "300 kg", tolerance = "5 %" }
[links.mount]
between = ["press", "ground"]
stiffness = { value = "2 MN/m", tolerance = 0.2 }
damping = "9 kN s/m"
[excitations.press]
kind = "force"
on = "press"
amplitude = "30 kN"
speed = "3000 rpm"
varies = "constant"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "10 kN"
"""
MASS = '{ value = "300 kg", tolerance = "5 %" }'
WRONG = [
    (
        '"5 %"',
        '"100 %"',
        'line 2: bodies.press.mass = { value = "300 kg", tolerance = "100 %" } has a tolerance that may leave nothing '
        'of it. Write less than 100 %, for example tolerance = "5 %".',
    ),
    (
        '"5 %"',
        '"-5 %"',
        'line 2: bodies.press.mass = { value = "300 kg", tolerance = "-5 %" } has a negative tolerance, but a '
        "tolerance goes both ways. Write it without the sign.",
    ),
    (
        '"5 %"',
        '"15 kg"',
        'line 2: bodies.press.mass = { value = "300 kg", tolerance = "15 kg" } has a tolerance that is no ratio. Write '
        'tolerance = "5 %".',
    ),
    (
        '"5 %"',
        '"15 mm"',
        'line 2: bodies.press.mass = { value = "300 kg", tolerance = "15 mm" } has a tolerance that is no ratio. Write '
        'less than 100 %, for example tolerance = "5 %".',
    ),
    (
        '"5 %"',
        "true",
        'line 2: bodies.press.mass = { value = "300 kg", tolerance = true } has a tolerance that is no number. Write '
        'less than 100 %, for example tolerance = "5 %".',
    ),
    (
        '"5 %"',
        '"-20 dB"',
        'line 2: bodies.press.mass = { value = "300 kg", tolerance = "-20 dB" } has a tolerance in dB. Write less '
        'than 100 %, for example tolerance = "5 %".',
    ),
    (
        MASS,
        '{ value = "300 kg" }',
        'line 2: bodies.press.mass = { value = "300 kg" } has a value without a tolerance. Add tolerance = "5 %", or '
        "write the value alone.",
    ),
    (
        MASS,
        '{ tolerance = "5 %" }',
        'line 2: bodies.press.mass = { tolerance = "5 %" } needs one value, or from and to. Write { value = "...", '
        'tolerance = "5 %" }.',
    ),
    (
        MASS,
        '{ value = { from = "1 kg", to = "2 kg" }, tolerance = "5 %" }',
        'line 2: bodies.press.mass = { value = { from = "1 kg", to = "2 kg" }, tolerance = "5 %" } has a table as its '
        'value. Write { value = "...", tolerance = "5 %" }.',
    ),
    (
        "between",
        'count = { value = 4, tolerance = "5 %" }\nbetween',
        'line 4: links.mount.count = { value = 4, tolerance = "5 %" } has a tolerance, but a count is built as it is '
        "said. Remove the tolerance.",
    ),
    (
        "between",
        'dynamic_to_static = { value = 1.4, tolerance = "5 %" }\nbetween',
        'line 4: links.mount.dynamic_to_static = { value = 1.4, tolerance = "5 %" } has a tolerance, but is taken '
        "as it is said: of a machine only masses, moments of inertia, stiffnesses, dampings and diameters may have "
        "one. Write the value alone; vibopt sweep FILE --vary of this value with --keep-design tells what it does when "
        "it is off.",
    ),
    (
        "between",
        "tolerance = 15\nbetween",
        'line 4: links.mount.tolerance = 15 has a tolerance of 15, which is 1500 %. Write "15 %".',
    ),
    (
        "between",
        "tolerance = { normal = 5 }\nbetween",
        'line 4: links.mount.tolerance = { normal = 5 } has a tolerance of 5, which is 500 %. Write "5 %".',
    ),
    (
        "between",
        'tolerance = "120 %"\nbetween',
        'line 4: links.mount.tolerance = "120 %" has a tolerance that may leave nothing of it. Write less than 100 %, '
        'for example tolerance = "5 %".',
    ),
    (
        'amplitude = "30 kN"',
        'amplitude = { value = "30 kN", tolerance = "5 %" }',
        'line 10: excitations.press.amplitude = { value = "30 kN", tolerance = "5 %" } has a tolerance, but is taken '
        "as it is said: of a machine only masses, moments of inertia, stiffnesses, dampings and diameters may have "
        "one. Write the value alone; vibopt sweep FILE --vary of this value with --keep-design tells what it does when "
        "it is off.",
    ),
    (
        'speed = "3000 rpm"',
        'speed = { value = "3000 rpm", tolerance = "5 %" }',
        'line 11: excitations.press.speed = { value = "3000 rpm", tolerance = "5 %" } has a tolerance, but a speed has '
        'none. Write every speed: "2900..3100 rpm".',
    ),
    (
        'at_most = "10 kN"',
        'at_most = { value = "10 kN", tolerance = "5 %" }',
        'line 16: limits.floor.at_most = { value = "10 kN", tolerance = "5 %" } has a tolerance, but a limit has none. '
        "Write the value alone.",
    ),
    (
        '["press", "ground"]',
        '{ value = ["press", "ground"], tolerance = "5 %" }',
        'line 4: links.mount.between = { value = ["press", "ground"], tolerance = "5 %" } is not a pair of names. '
        'Write between = ["machine", "ground"].',
    ),
]


@pytest.mark.parametrize(("old", "new", "said"), WRONG, ids=[new for _, new, _ in WRONG])
def test_a_tolerance_that_cannot_be_is_refused_in_a_sentence(old: str, new: str, said: str) -> None:
    assert old in SCENE
    assert str(refused(from_text, SCENE.replace(old, new, 1), name="press.toml")) == f"press.toml {said}"


def test_find_all_wants_a_machine_without_tolerances() -> None:
    speeds = '{ from = "0 rpm", to = "9000 rpm" }'
    text = SCENE.replace('"3000 rpm"', speeds) + '[goal]\nfind_all = "press.speed"\n'
    assert str(refused(from_text, text, name="press.toml")) == (
        "press.toml line 18: goal.find_all looks for speeds of a given machine, but bodies.press.mass has a tolerance. "
        "Remove it, or ask with limits over a range of speeds."
    )


def test_a_tolerance_of_a_table_is_that_of_each_of_its_numbers() -> None:
    text = SCENE.replace("between", 'tolerance = "10 %"\nbetween')
    assert {one.path: one.tolerance for one in uncertain(from_text(text))} == {
        "bodies.press.mass": 0.05,
        "links.mount.stiffness": 0.2,
        "links.mount.damping": 0.1,
    }


SPACE = """
[bodies.box]
mass = "400 kg"
centre = ["0 m", "0 m", "0.5 m"]
shape = { box = ["1 m", "0.8 m", "0.6 m"] }
[mounts.foot]
between = ["box", "ground"]
at = [["0.5 m", "0.4 m", "0 m"], ["0.5 m", "-0.4 m", "0 m"], ["-0.5 m", "0 m", "0 m"]]
stiffness = "300 kN/m"
shear_ratio = 0.6
"""


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            'tolerance_of = "mount"',
            "box.toml line 10: mounts.foot has tolerance_of, but nothing of it has a tolerance. Add "
            'tolerance = "20 %", or remove tolerance_of.',
        ),
        (
            'tolerance = "20 %"\ntolerance_of = "each"',
            'box.toml line 11: mounts.foot.tolerance_of = "each" is not "group" (all mounts of the group are off '
            'alike, as one batch) or "mount" (each by itself).',
        ),
        (
            'tolerance = "120 %"',
            'box.toml line 10: mounts.foot.tolerance = "120 %" has a tolerance that may leave nothing of it. Write '
            'less than 100 %, for example tolerance = "5 %".',
        ),
        (
            '[bodies.line]\nmass = "3 kg"\ncentre_tolerance = "2 mm"',
            'box.toml line 10: bodies.line has a centre_tolerance, but no motion that needs it. Add motion = "space", '
            "or remove centre_tolerance.",
        ),
    ],
)
def test_tolerances_in_space_that_make_no_sense_are_refused(line: str, said: str) -> None:
    assert said in str(refused(from_text, SPACE.lstrip() + line, name="box.toml"))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ('"-2 mm"', "is negative, but a tolerance goes both ways. Write it without the sign."),
        ('["1 mm", "2 mm"]', 'is neither a length nor three. Write "20 mm", or ["20 mm", "10 mm", "0 m"].'),
    ],
)
def test_a_centre_of_mass_is_off_by_a_length(given: str, said: str) -> None:
    text = SPACE.lstrip().replace("shape =", f"centre_tolerance = {given}\nshape =")
    assert said in str(refused(from_text, text, name="box.toml"))


@pytest.mark.parametrize(
    ("cells", "same"),
    [
        ("deviation [%]\n-6\n+1.5\n4\n", ["-6 %", "1.5 %", "4 %"]),
        ("-6 %\n+1,5 %\n4 %\n", ["-6 %", "1.5 %", "4 %"]),
        ("part;deviation (%)\nA;-6\nB;1,5\nC;4\n", ["-6 %", "1.5 %", "4 %"]),
        ("0.02\n-0.01\n", ["2 %", "-1 %"]),
    ],
)
def test_deviations_stand_in_a_file_as_in_a_list(tmp_path: Path, cells: str, same: list[str]) -> None:
    (tmp_path / "measured.csv").write_text(cells, encoding="utf-8")
    file = tmp_path / "press.toml"
    file.write_text(SCENE.replace('"5 %"', '{ data = "measured.csv" }'), encoding="utf-8")
    listed = from_text(SCENE.replace('"5 %"', f"{{ data = {same} }}".replace("'", '"')))
    job = open_job(file)
    assert is_scene(job)
    assert uncertain(job) == uncertain(listed)
    saved = saved_text(job, answer(job), tmp_path / "below" / "design.toml")
    assert 'data = "../measured.csv"' in saved


def test_a_tolerance_with_an_escape_in_its_key_has_its_data_beside_the_file(tmp_path: Path) -> None:
    """What the text does not spell out may still be said."""
    (tmp_path / "measured.csv").write_text("-6 %\n4 %\n", encoding="utf-8")
    file = tmp_path / "press.toml"
    text = SCENE.replace('"5 %"', '{ data = "measured.csv" }').replace("tolerance", '"tol\\u0065rance"')
    file.write_text(text, encoding="utf-8")
    job = open_job(file)
    assert is_scene(job)
    assert uncertain(job) == uncertain(from_text(SCENE.replace('"5 %"', '{ data = ["-6 %", "4 %"] }')))


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        (None, "data that cannot be read: FOLDER/measured.csv is not there. Name the CSV file, relative to the problem "
               "file."),
        ("deviation [%]\n1\nabout 2\n",
         'data, and "about 2" in row 3 of measured.csv is no deviation. Write "+1 %", or 1 below "deviation [%]".'),
        ("part;off\nA;-6\n",
         "measured.csv with 2 columns, of which none is called deviation. Name the one that is meant "
         '"deviation [%]", or leave the others out.'),
        ("deviation [%]\n3\n",
         'data without a list of deviations. Write { normal = "2 %" } for a standard deviation, { uniform = "5 %" } '
         'or { data = ["+1 %", "-0.5 %"] }.'),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_file_of_deviations_is_said(tmp_path: Path, cells: str | None, words: str) -> None:
    if cells is not None:
        (tmp_path / "measured.csv").write_text(cells, encoding="utf-8")
    file = tmp_path / "press.toml"
    file.write_text(SCENE.replace('"5 %"', '{ data = "measured.csv" }'), encoding="utf-8")
    said = str(refused(open_job, file)).replace(str(tmp_path), "FOLDER")
    begin = 'press.toml line 2: bodies.press.mass = { value = "300 kg", tolerance = { data = "measured.csv" } } has a '
    assert said == f"{begin}tolerance from {words}"
