"""Verbs, messages, exit codes: what a user or a script relies on."""

import gc
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from texts import floor, shaken_fan
from vibopt.cli.main import main

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2]
HEAVY = ("casadi", "cvxpy", "clarabel", "scipy.optimize", "scipy.linalg", "matplotlib", "jinja2", "rich")
FAN = 'title = "fan"\n' + shaken_fan(
    {"stiffness": "100 kN/m"}, floor("1 N", "force"), kind="unbalance", unbalance="1 kg mm", speed="1500 rpm"
)


def shell(*words: str, **environment: str) -> "subprocess.CompletedProcess[bytes]":
    """The command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "vibopt", *words],
        capture_output=True,
        cwd=ROOT,
        env={**os.environ, **environment},
        timeout=120,
        check=False,
    )


def test_help_lists_every_verb_and_loads_nothing_heavy() -> None:
    program = (
        "import sys\nfrom vibopt.cli.main import main\ncode = main(['--help'])\n"
        "heavy = [name for name in ('numpy', 'pydantic', 'pint', 'rich', 'matplotlib', 'scipy', 'casadi') "
        "if name in sys.modules]\nassert (code, heavy) == (0, []), heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=True)
    for verb in ("check", "solve", "explain", "whatif", "sweep", "plot", "report", "verify", "schema"):
        assert f"  {verb} " in done.stdout


AREAS = ("vibopt.balancing.", "vibopt.charts", "vibopt.manual", "vibopt.posed", "vibopt.answer.answer_page")
ROTORS = (
    "vibopt.mechanics.rotating",
    "vibopt.mechanics.whirl",
    "vibopt.mechanics.shaft_waves",
    "vibopt.mechanics.host",
)
SEARCHES = ("vibopt.solve.sqp", "vibopt.solve.relaxed", "vibopt.solve.passive", "vibopt.solve.loosen")
ABSORBERS = ("vibopt.devices.absorber", "vibopt.devices.inertia")
SLOW = ("scipy", "numpy.typing", "numpy.random", "multiprocessing", "concurrent", *HEAVY)
STARTS = {
    ("check",): ("vibopt.solve", "vibopt.study", "vibopt.verify", *ABSORBERS, *AREAS, *SLOW),
    ("solve",): (
        "vibopt.solve.plane", "vibopt.solve.catalogue", "vibopt.responses.damping",
        *SEARCHES, *ABSORBERS, *ROTORS, *AREAS, *SLOW, "json",
    ),
    ("--version",): ("numpy", "pydantic", "tomli", "vibopt.answer.answer", "vibopt.answer.entry", *AREAS, *SLOW),
    ("help",): ("vibopt.study", "vibopt.cli.solve_command", "vibopt.solve.plane", *SLOW),
}  # fmt: skip
"""What a command must not load before it has said its word, a trailing dot standing for all that lies inside."""


@pytest.mark.parametrize("words", STARTS, ids=" ".join)
def test_a_command_loads_only_what_it_needs(words: tuple[str, ...], press: str) -> None:
    given = [*words, *([press] if words[0] in ("check", "solve") else [])]
    program = (
        f"import sys\nfrom vibopt.cli.main import main\ncode = main({given!r})\n"
        f"found = [name for name in {STARTS[words]!r} if any(f'{{one}}.'.startswith(f'{{name.rstrip(chr(46))}}.') "
        "and (name[-1] != '.' or one != name[:-1]) for one in sys.modules)]\nassert (code, found) == (0, []), found\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr


def test_dry_friction_under_a_steady_force_is_answered_without_scipy() -> None:
    program = (
        "import sys\nfrom vibopt.cli.main import main\ncode = main(['solve', 'problems/friction/rao_9_41.toml'])\n"
        "assert (code, 'scipy' in sys.modules) == (0, False)\n"
    )
    environment = {**os.environ, "VIBOPT_CACHE": "off"}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, env=environment)
    assert done.returncode == 0, done.stderr


def test_a_process_of_its_own_ends_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    at_the_end: list[Any] = []
    monkeypatch.setattr("atexit.register", at_the_end.append)
    monkeypatch.setenv("PYDANTIC_DISABLE_PLUGINS", "as the user has it")
    monkeypatch.setattr(sys, "argv", ["vibopt", "--version"])
    assert main(["--version"]) == 0
    assert at_the_end == []
    assert main() == 0
    assert at_the_end == [gc.freeze]
    assert os.environ["PYDANTIC_DISABLE_PLUGINS"] == "as the user has it"


def test_check_tells_what_a_file_asks(run: Run, press: str) -> None:
    done = run("check", press)
    assert (done.code, done.err) == (0, "")
    assert done.out == (
        f"{press}: no mistakes. 1 body, 1 link, 1 excitation, 3 limits, 1 measure, 2 variables, 7 records; "
        "goal: maximise stiffness of mount.\n"
        "  links.mount.stiffness: 10 kN/m to 1 GN/m\n"
        "  links.mount.damping: 10 N s/m to 1 MN s/m\n"
        "  An amplitude is peak (pk, zero to peak) unless pp or rms is written behind its unit.\n"
        "  press: the force keeps its amplitude at every speed.\n"
    )


def test_check_calls_a_part_to_be_bought_one_choice(run: Run, file: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "feet.csv").write_text(
        "part,rated load max [N],stiffness [N/mm],loss factor,price [EUR]\nA,700,80,0.08,12\nB,1100,150,0.1,14\n"
    )
    bought = file(
        '[bodies.comp]\nmass = { from = "200 kg", to = "300 kg" }\n[links.feet]\nbetween = ["comp", "ground"]\n'
        'part = { catalogue = "feet.csv" }\ncount = 4\n[goal]\nminimise = "price"\n'
    )
    assert run("check", bought).out == (
        f"{bought}: no mistakes. 1 body, 1 link, 1 variable, 1 choice; goal: minimise price.\n"
        "  links.feet.part: one of 2 parts of feet.csv\n"
        "  bodies.comp.mass: 200 kg to 300 kg\n"
    )
    plain = run("check", "--json", bought).data["files"][0]
    assert (plain["variables"], len(plain["choices"])) == (5, 5)


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        (
            'mass = "100 kg"',
            'mass = "260 kgf"',
            'bodies.fan.mass = "260 kgf" is a force, but a mass is needed here. Write weight = "260 kgf".',
        ),
        (
            'unbalance = "',
            'varies = "constant"\nunbalance = "',
            'excitations.fan.varies = "constant" is for kind = "force"; the force of an unbalance grows with the '
            'square of the speed by its nature. Leave it out, or write kind = "force" with an amplitude.',
        ),
        (
            'unbalance = "',
            'amplitude = "',
            'excitations.fan.amplitude = "1 kg mm" is for kind = "force"; an unbalance gives its mass times its '
            'distance from the axis. Write unbalance = "20 kg mm", or kind = "force".',
        ),
        (
            FAN,
            FAN.replace("response = ", 'combine = "sum"\nresponse = ')
            + '[excitations.belt]\nkind = "force"\non = "fan"\namplitude = "1 N"\nspeed = "600 rpm"\n'
            'varies = "constant"\n[limits.up]\nresponse = "displacement"\nof = "fan"\nover = "start-up"\n'
            'combine = "sum"\nat_most = "90 mm"\n',
            "limits.up.over speaks of one start-up, but 2 excitations act here: whose? Write over = { "
            'fan = "start-up", belt = "start-up" }, or name one in due_to.',
        ),
    ],
)
def test_a_key_or_unit_of_another_quantity_is_refused_with_the_way_out(
    run: Run, file: Callable[..., str], was: str, now: str, said: str
) -> None:
    lines = run("check", file(FAN.replace(was, now))).err.splitlines()
    assert [line.split(": ", 1)[1] for line in lines] == [said]


def test_check_goes_on_after_a_bad_file_and_tells_all_mistakes(run: Run, press: str, file: Callable[..., str]) -> None:
    bad = file(FAN.replace('mass = "100 kg"', "mass = 100").replace("stiffness", "stifness"))
    done = run("check", bad, press)
    assert done.code == 2
    assert "no mistakes" in done.out
    assert 'mine.toml line 3: bodies.fan.mass = 100 has no unit. Write "100 kg".' in done.err
    assert 'mine.toml line 6: unknown key "stifness" in links.mount. Did you mean "stiffness"?' in done.err
    data = run("check", "--json", bad, press).data
    assert data["status"] == "input_error"
    assert [one["status"] for one in data["files"]] == ["input_error", "ok"]
    assert data["messages"] == data["files"][0]["messages"]


def test_check_tells_a_record_that_verify_could_not_compare(run: Run, file: Callable[..., str]) -> None:
    done = run("check", file(FAN + '[[expected]]\nwhat = "k"\npath = "status"\nvaleu = "optimal"\n'))
    assert done.code == 2
    said = 'expected[1]: unknown key "valeu" in the record. Did you mean "value"?'
    assert done.err.strip().split(": ", 1)[1] == said


@pytest.mark.parametrize("verb", ["solve", "check", "explain", "verify"])
def test_a_missing_file_is_an_input_error_everywhere(run: Run, verb: str) -> None:
    done = run(verb, "nowhere.toml")
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith("nowhere.toml is not there.")
    assert run(verb, "nowhere.toml", "--json").data["status"] == "input_error"


@pytest.mark.parametrize(
    ("name", "code", "status"),
    [("rao_9_34", 0, "optimal"), ("rao_9_34_printed_design", 7, "violated"), ("rao_9_35", 0, "met")],
)
def test_the_exit_code_is_that_of_the_status(run: Run, name: str, code: int, status: str) -> None:
    done = run("solve", f"{ROOT}/problems/isolation/{name}.toml", "--json")
    assert (done.code, done.data["status"]) == (code, status)


def test_infeasible_is_three_and_names_the_limits(run: Run, press: str) -> None:
    done = run("solve", press, "--set", "limits.start_up.at_most=8 mm")
    assert done.code == 3
    assert 'These cannot hold together: "floor_force", "start_up".' in done.out
    assert "Smallest loosening of one:" in done.out


def test_prices_are_told_and_can_be_left_out(run: Run, press: str) -> None:
    assert run("solve", press, "--json").data["limits"]["floor_force"]["price"]["words"]
    assert run("solve", press, "--json", "--no-prices").data["limits"]["floor_force"]["price"] is None


@pytest.mark.parametrize("value", ['"21 mm"', "21 mm"])
def test_set_takes_values_with_and_without_quotation_marks(run: Run, press: str, value: str) -> None:
    data = run("solve", press, "--no-prices", "--json", "--set", f"limits.start_up.at_most={value}").data
    assert data["limits"]["start_up"]["limit"] == pytest.approx(0.021)


def test_set_takes_numbers_and_tables(run: Run) -> None:
    file = f"{ROOT}/problems/isolation/rao_9_36.toml"
    one = run("solve", file, "--json", "--no-prices", "--set", "links.mount.damping_ratio=0.1").data
    two = run("solve", file, "--json", "--no-prices", "--set", "links.mount.damping_ratio=10 %").data
    assert one["goal"]["value"] == two["goal"]["value"]
    narrow = 'links.mount.stiffness={ from = "10 kN/m", to = "20 kN/m" }'
    three = run("solve", file, "--json", "--no-prices", "--set", narrow).data
    assert three["variables"]["links.mount.stiffness"]["at_bound"] == "to"


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("nothing", '--set nothing: is no PATH=VALUE. Write --set limits.start_up.at_most="8 mm".'),
        ("limits.start_upp.at_most=8 mm", 'there is no "start_upp" in this file. Did you mean "start_up"?'),
        ("limits.start_up.at_most=8 kg", 'limits.start_up.at_most = "8 kg" is a mass, but displacement is a length.'),
        ("limits.start_up.at_most=nan", "is not a finite number"),
    ],
)
def test_a_wrong_change_is_an_input_error(run: Run, press: str, change: str, text: str) -> None:
    done = run("solve", press, "--set", change)
    assert done.code == 2
    assert text in done.err


def test_an_unproven_answer_fails_when_proof_is_required(run: Run, press: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    import vibopt.cli.solve_command as verb
    from vibopt.scene.read import read
    from vibopt.solve import solve

    design = replace(solve(read(press)), status="feasible")
    monkeypatch.setattr(verb, "_answer", lambda asked: design)
    assert run("solve", press, "--no-prices").code == 0
    done = run("solve", press, "--no-prices", "--require-proof")
    assert (done.code, done.err) == (5, "feasible is not proven, and --require-proof was asked for.\n")


def test_a_fault_of_ours_is_one_sentence(run: Run, press: str, monkeypatch: pytest.MonkeyPatch) -> None:
    import vibopt.cli.solve_command as verb

    def broken(asked: object) -> None:
        raise ZeroDivisionError("division\nby zero.")

    monkeypatch.setattr(verb, "_answer", broken)
    text = "vibopt failed inside: ZeroDivisionError: division by zero. This is a fault of vibopt, not of your file."
    done = run("solve", press)
    assert (done.code, done.out, done.err) == (1, "", f"{text}\n")
    assert run("solve", press, "--json").data == {"status": "internal_error", "messages": [text]}
    monkeypatch.setenv("VIBOPT_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        run("solve", press)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("slove", "x"), 'there is no verb "slove". Did you mean "solve"?'),
        (("chart", "stabilty"), 'there is no chart "stabilty". Did you mean "stability"?'),
        (
            ("chart", "nothing"),
            'there is no chart "nothing". Known: cost, fidelity, profiles, speed-accuracy, stability.',
        ),
        (("solve", "x.toml", "--jsno"), "--json"),
        (("solve",), "Missing argument 'FILE'"),
        (("sweep", "x.toml"), "Missing option '--vary'"),
    ],
)
def test_a_wrong_command_line_is_an_input_error(run: Run, words: tuple[str, ...], text: str) -> None:
    done = run(*words)
    assert (done.code, done.out) == (2, "")
    assert text in done.err


def test_a_wrong_command_line_is_json_where_json_is_asked(run: Run) -> None:
    data = run("slove", "--json").data
    assert data == {"status": "input_error", "messages": ['there is no verb "slove". Did you mean "solve"?']}


def test_no_verb_shows_the_help(run: Run) -> None:
    done = run()
    assert done.code == 2
    assert "check" in done.out + done.err


def test_a_reader_who_leaves_is_no_error() -> None:
    command = f"{sys.executable} -m vibopt schema | head -n 1"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", command], capture_output=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_full_disk_is_told() -> None:
    command = f"{sys.executable} -m vibopt schema > /dev/full"
    done = subprocess.run(["bash", "-c", command], capture_output=True, cwd=ROOT, check=False)
    assert done.returncode == 1
    assert done.stderr == b"The answer cannot be written to standard output: No space left on device.\n"


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_every_terminal_gets_text_that_it_can_show(encoding: str) -> None:
    file = "problems/isolation/rao_9_40.toml"
    done = shell("solve", file, "--no-prices", "--set", "measures.other_end.unit=m/s²", PYTHONIOENCODING=encoding)
    assert done.returncode == 0
    assert "m/s" in done.stdout.decode(encoding)
    import json

    assert json.loads(shell("solve", file, "--no-prices", "--json", PYTHONIOENCODING=encoding).stdout.decode(encoding))


def test_a_pipe_gets_no_escape_codes_and_no_bar() -> None:
    done = shell("solve", "problems/isolation/rao_9_34.toml", FORCE_COLOR="1")
    assert b"\x1b" not in done.stdout + done.stderr
    assert done.stderr == b""


def test_schema_speaks_of_every_table_and_fits_every_problem(run: Run) -> None:
    import tomllib

    data = run("schema").data
    assert data["additionalProperties"] is False
    for path in [*(ROOT / "problems" / "isolation").glob("*.toml"), *(ROOT / "problems" / "absorbers").glob("*.toml")]:
        assert set(tomllib.loads(path.read_text(encoding="utf-8"))) <= set(data["properties"])
    limits = data["properties"]["limits"]["additionalProperties"]["oneOf"]
    assert "transmitted_force" in [one["properties"]["response"]["const"] for one in limits]
    measures = data["properties"]["measures"]["additionalProperties"]["oneOf"]
    assert not any({"at_most", "at_least", "outside"} & set(one["properties"]) for one in measures)
