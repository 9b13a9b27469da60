"""Prices from one allowance of work: what it ends is named, and others who answer change nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from vibopt.errors import PoolError
from vibopt.jobs import facts, open_job, with_changes
from vibopt.study import purse
from vibopt.study.prices import prices
from vibopt.study.workers import Lost
from vibopt.work import SpentError, done, metered, worked

PROBLEMS = Path(__file__).parent.parent.parent / "problems"
FILE = "isolation/rao_9_34.toml"


@dataclass
class _Task:
    index: int
    made: Any

    def result(self) -> Any:
        return self.made

    def end(self) -> None:
        self.made = None


@dataclass
class _Backwards:
    """A pool of this very process in which the last that is begun is ready first."""

    most: int = 3
    advice: str = "Take fewer."
    lost: bool = False

    def begin(self, work: Callable[[Any], Any], index: int, item: Any) -> _Task:
        return _Task(index, Lost("it is gone") if self.lost else work(item))

    def ready(self, running: Sequence[_Task]) -> list[_Task]:
        return [running[-1]]


@pytest.mark.parametrize("most", [0.0, 60.0, 1_000.0])
def test_others_who_answer_find_what_one_finds_whatever_work_is_allowed(most: float) -> None:
    job = open_job(PROBLEMS / FILE)
    some = {"limits.floor_force.at_most", "bodies.press.mass", "excitations.press.amplitude"}
    alone, together = (prices(job, only=some, most=most, pool=pool) for pool in (None, _Backwards()))
    assert together.rows == alone.rows
    assert together.notes == alone.notes


def test_an_answer_that_is_lost_is_an_error() -> None:
    with pytest.raises(PoolError, match=r"^An answer was lost: it is gone\. Take fewer\.$"):
        prices(open_job(PROBLEMS / FILE), pool=_Backwards(lost=True))


def test_a_number_of_which_one_answer_takes_too_much_is_named_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    job = open_job(PROBLEMS / FILE)
    looked = purse._looked
    cheap = {"limits.floor_force.at_most", "limits.start_up.at_most"}

    def dear(errand: Any, job: Any) -> Any:
        return looked(errand if errand.fact.path in cheap else replace(errand, each=0.0), job)

    monkeypatch.setattr(purse, "_looked", dear)
    found = prices(job)
    assert {row.path for row in found.rows if row.ways} == cheap
    [note] = (
        note for note in found.notes if note.startswith("No price was computed for ") and "bodies.press.mass" in note
    )
    assert note.endswith("each takes answers of its own. `vibopt whatif FILE --thorough` computes all.")


def test_work_beyond_what_is_allowed_ends_what_does_it_and_is_counted_outside() -> None:
    with metered() as outer:
        with metered(10.0), metered(100.0):
            worked(6.0)
            with pytest.raises(SpentError):
                worked(6.0)
        worked(1.0)
        assert done() == outer.done == 13.0


def test_up_to_which_speed_whirls_count_is_a_speed() -> None:
    job = open_job(PROBLEMS / "shafts/compressor_on_tilting_pads.toml")
    at = next(one for one in facts(job) if one.path == "limits.fades.up_to")
    assert at.read("7000 rpm") == at.value


def test_of_an_angle_that_is_the_rounding_of_zero_nothing_buys_anything() -> None:
    path = "bodies.compressor.mass"
    found = prices(open_job(PROBLEMS / "mounts/compressor_on_sliding_feet.toml"), only={path}, most=800.0)
    assert [way.change for way in found.find(path).ways] == [0.0, 0.0]
    assert found.first == "No sensible step of any number that was looked at improves the tilt."


def test_a_number_below_zero_is_worth_what_its_mirror_image_is() -> None:
    scene, path = open_job(PROBLEMS / "shock/trolley_on_buffer.toml"), "excitations.arrival.velocity"
    wide, ways = {"links.buffer.damping": "9 kN s/m", "limits.travel.at_most": "300 mm"}, []
    for sign in (1.0, -1.0):
        mirrored = with_changes(scene, {**wide, path: f"{sign * 1.4} m/s"})
        rows = prices(mirrored, only={path}).table()
        told = ("goal", "goal_until", "then", "beyond")
        ways.append([(*(sign * row[one] for one in ("now", "step")), *(row[one] for one in told)) for row in rows])
    assert len(ways[0]) == 2
    assert ways[0] == ways[1]
