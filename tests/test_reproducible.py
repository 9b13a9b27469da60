"""One answer: in one process or another, with any number of workers, idle or on a machine a hundred times slower."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from vibopt.jobs import answer, open_job
from vibopt.study.archive import kept_answer
from vibopt.study.workers import Lost, Processes, each

PROBLEMS = Path(__file__).parents[1] / "problems"
SAMPLE = (
    "isolation/rao_9_34",  # stiffness and damping of one mount, in closed form
    "isolation/rao_9_35",  # every speed at which the limits hold
    "isolation/rao_9_39",
    "absorbers/rao_9_53",  # several speeds
    "absorbers/assignment_4a",  # an analysis
    "absorbers/rao_9_66_best_half",  # discs
    "mounts/generator_set",  # in space, local search with exact peaks
    "mounts/compressor_on_bought_mounts",  # parts over tolerances
    "balancing/rao_9_13",  # influence coefficients
    "balancing/rao_9_13_holes",
    "balancing/rao_9_12_holes",
    "balancing/foiles_min_max_capped",  # second-order cones
    "balancing/shaft_three_planes",
    "balancing/engine_share_capped",
    "balancing/engine_phasing_five",
)
SPEED_UP = 100.0
CLOCKS = ("perf_counter", "monotonic", "time", "process_time")


def solved(name: str) -> str:
    """The answer to a problem file, as it is kept."""
    file = PROBLEMS / f"{name}.toml"
    job = open_job(file)
    return json.dumps(kept_answer(file, job, answer(job)))


def solved_in_haste(name: str) -> str:
    """The same where every clock runs a hundred times too fast, so that all seems to take a hundred times longer."""
    modules = [module for module in list(sys.modules.values()) if module.__name__.startswith("vibopt")]
    for clock in CLOCKS:
        true = getattr(time, clock)

        def hasty(true: Callable[[], float] = true) -> float:
            return SPEED_UP * true()

        for module in (time, *modules):
            for key, value in list(vars(module).items()):
                if value is true:
                    setattr(module, key, hasty)
    assert time.perf_counter() > 50.0 * time.clock_gettime(time.CLOCK_MONOTONIC) or sys.platform != "linux"
    return solved(name)


def solved_there_and_back(names: Sequence[str]) -> list[str]:
    """All in one process, then once more in the opposite order."""
    there = [solved(one) for one in names]
    back = [solved(one) for one in reversed(names)]
    return [*there, *reversed(back)]


@pytest.fixture(scope="module")
def fresh() -> dict[str, str | Lost]:
    """Each file in a process of its own, two at a time."""
    return dict(zip(SAMPLE, each(solved, SAMPLE, Processes(2)), strict=True))


def differing(fresh: dict[str, str | Lost], others: Sequence[str | Lost]) -> list[str]:
    return [name for name, other in zip(SAMPLE, others, strict=True) if other != fresh[name]]


def test_every_answer_of_the_sample_is_there(fresh: dict[str, str | Lost]) -> None:
    assert [one for one in fresh.values() if isinstance(one, Lost)] == []


def test_one_worker_gives_the_answers_of_two(fresh: dict[str, str | Lost]) -> None:
    assert differing(fresh, each(solved, SAMPLE, Processes(1))) == []


def test_no_clock_decides_an_answer(fresh: dict[str, str | Lost]) -> None:
    assert differing(fresh, each(solved_in_haste, SAMPLE, Processes(2))) == []


def test_what_was_solved_before_changes_no_answer(fresh: dict[str, str | Lost]) -> None:
    (found,) = each(solved_there_and_back, [SAMPLE], Processes(1))
    assert not isinstance(found, Lost)
    assert differing(fresh, found[: len(SAMPLE)]) == []
    assert differing(fresh, found[len(SAMPLE) :]) == []


TOWER = """
from vibopt.jobs import answer
from vibopt.answer.jsonable import json_text
from vibopt.scene.read import from_dict

names = ["pump", "deck", "frame", "raft", "anvil", "skid"]
document = {
    "bodies": {name: {"mass": f"{37 + 11 * i} kg"} for i, name in enumerate(names)},
    "links": {
        f"{a} on {b}": {"between": [a, b], "stiffness": f"{171 + 7 * len(b)} kN/m", "damping": "83 N s/m"}
        for a, b in zip(names, [*names[1:], "ground"])
    },
    "excitations": {"fan": {"kind": "force", "on": "pump", "amplitude": "70 N", "speed": "7 Hz", "varies": "constant"}},
    "measures": {
        "floor": {"response": "transmitted_force", "into": "ground"},
        "raft": {"response": "transmitted_force", "into": "raft", "over": "3..9 Hz"},
        "top": {"response": "velocity", "of": "pump", "over": "start-up"},
    },
}
found = {key: one for key, one in answer(from_dict(document)).to_json().items() if key != "timings"}
print(json_text(found))
"""


def test_no_order_of_names_in_memory_decides_a_digit() -> None:
    """Sets of names have another order under another seed of Python's hashes."""
    said = {
        subprocess.run(
            [sys.executable, "-c", TOWER],
            capture_output=True,
            check=True,
            env={**os.environ, "PYTHONHASHSEED": str(seed), "PYTHONPATH": str(PROBLEMS.parent)},
        ).stdout
        for seed in range(5)
    }
    assert len(said) == 1
