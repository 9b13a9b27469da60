"""Records are what the standard library makes of the same class: fields, order of words, equality, hashes, copies."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import pprint
from dataclasses import FrozenInstanceError, field
from typing import Any

import pytest

from vibopt.records import cached_property, dataclass, replace

OPTIONS = [
    {"frozen": frozen, "eq": eq, "slots": slots, "kw_only": kw_only}
    for frozen in (False, True)
    for eq in (True, False)
    for slots in (False, True)
    for kw_only in (False, True)
]


def _class() -> type:
    class Sample:
        """A record with every sort of field."""

        mass: float
        name: str = "press"
        places: list[str] = field(default_factory=list)
        seen: int = field(default=3, compare=False, repr=False)
        inner: int = field(init=False, default=7)
        made: list[int] = field(init=False, default_factory=lambda: [1])

        def __post_init__(self) -> None:
            object.__setattr__(self, "places", [*self.places, "end"])

    return Sample


@pytest.mark.parametrize("before", [0, 100], ids=["first objects", "later objects"])
@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_a_record_is_that_of_the_standard_library(options: dict[str, bool], before: int) -> None:
    ours: Any = dataclass(**options)(_class())
    theirs: Any = dataclasses.dataclass(**options)(_class())
    words: dict[str, Any] = {"mass": 2.0, "places": ["floor"], "seen": 5}
    for _ in range(before):
        ours(**words)
    one, other = ours(**words), theirs(**words)
    assert dataclasses.asdict(one) == dataclasses.asdict(other)
    assert repr(one) == repr(other)
    assert hasattr(one, "__dict__") == hasattr(other, "__dict__")
    assert ours.__match_args__ == theirs.__match_args__
    for change in ({"mass": 2.0}, {"mass": 3.0}, {"seen": 9}, {"name": "fan"}):
        assert (one == dataclasses.replace(one, **change)) is (other == dataclasses.replace(other, **change))
        assert dataclasses.asdict(replace(one, **change)) == dataclasses.asdict(dataclasses.replace(other, **change))
    with pytest.raises(TypeError, match="argument"):
        replace(one, weight=1.0)
    assert (one == other) is False
    assert (ours.__hash__ is None) is (theirs.__hash__ is None)
    assert dataclasses.asdict(copy.copy(one)) == dataclasses.asdict(copy.copy(other))
    for wrong, named in (((), {}), ((1.0, "a", [], 3, 4), {}), ((), {**words, "inner": 1}), ((1.0,), words)):
        with pytest.raises(TypeError, match="argument"):
            ours(*wrong, **named)


@pytest.mark.parametrize("slots", [False, True])
def test_a_frozen_record_refuses_changes_and_hashes_by_what_it_compares(slots: bool) -> None:
    @dataclass(frozen=True, slots=slots)
    class Pair:
        """Two numbers and a remark."""

        low: float
        high: float
        said: str = field(default="", compare=False)

    pair = Pair(1.0, 2.0, "a")
    assert hash(pair) == hash(Pair(1.0, 2.0, "b")) == hash((1.0, 2.0))
    assert {pair: 1}[Pair(1.0, 2.0)] == 1
    for change in (lambda: setattr(pair, "low", 3.0), lambda: delattr(pair, "low"), lambda: setattr(pair, "new", 3.0)):
        with pytest.raises(FrozenInstanceError):
            change()


def test_records_pass_between_processes_before_one_was_made_there() -> None:
    """What comes out of a pickle compares, though no `__init__` has run."""
    from vibopt.values.fields import Fact

    sent = pickle.dumps(Fact(1.5, "mm"))
    assert pickle.loads(sent) == Fact(1.5, "mm")
    assert hash(pickle.loads(sent)) == hash(Fact(1.5, "mm"))
    assert repr(pickle.loads(sent)) == "Fact(value=1.5, unit='mm', echo=None, tolerance=0.0)"


def test_own_methods_stay_and_children_add_fields() -> None:
    @dataclass(frozen=True)
    class Parent:
        """Says itself in its own words."""

        mass: float

        def __repr__(self) -> str:
            return f"{self.mass} kg"

        def __hash__(self) -> int:
            return 11

    @dataclass(frozen=True)
    class Child(Parent):
        """One field more."""

        name: str = "press"

    assert repr(Parent(2.0)) == "2.0 kg"
    assert hash(Parent(2.0)) == 11
    assert repr(Child(2.0)).endswith("Child(mass=2.0, name='press')")
    assert Child(2.0) == Child(2.0, "press") != Child(2.0, "fan")
    assert Parent(2.0) != Child(2.0)


@pytest.mark.parametrize("parent", [dataclass, dataclasses.dataclass], ids=["ours", "theirs"])
@pytest.mark.parametrize("child", [dataclass, dataclasses.dataclass], ids=["ours", "theirs"])
@pytest.mark.parametrize("frozen", [(True, True), (False, False), (True, False), (False, True)], ids=str)
def test_records_and_those_of_the_library_inherit_from_each_other(parent: Any, child: Any, frozen: Any) -> None:
    """Both frozen or neither, with the same words where not."""

    def made() -> Any:
        @parent(frozen=frozen[0])
        class Parent:
            """One field."""

            mass: float

        @child(frozen=frozen[1])
        class Child(Parent):
            """One field more."""

            name: str = "press"

        return Child(2.0)

    if frozen[0] != frozen[1]:
        with pytest.raises(TypeError, match=r"cannot inherit (non-)?frozen dataclass from a (non-)?frozen one"):
            made()
    else:
        assert dataclasses.asdict(made()) == {"mass": 2.0, "name": "press"}


def test_a_property_is_worked_out_once_for_each_object_and_a_copy_with_other_fields_begins_anew() -> None:
    @dataclass(frozen=True)
    class Sample:
        mass: float
        asked: list[float] = field(default_factory=list, compare=False)

        @cached_property
        def weight(self) -> float:
            self.asked.append(self.mass)
            return 9.80665 * self.mass

    one = Sample(2.0)
    assert one.weight == one.weight == 2.0 * 9.80665
    assert one.asked == [2.0]
    other = dataclasses.replace(one, mass=3.0)
    assert other.weight == 3.0 * 9.80665
    assert one.asked == [2.0, 3.0]
    assert one == Sample(2.0)
    assert isinstance(vars(Sample)["weight"], type(Sample.weight))  # of the class it is the property itself


@pytest.mark.parametrize("options", OPTIONS)
def test_a_record_is_printed_prettily(options: dict[str, Any]) -> None:
    """`pprint` asks a class of fields for more than the library says in public."""
    made: Any = dataclass(**options)(_class())
    assert pprint.pformat([made(mass=1.0)]) == repr([made(mass=1.0)])
