"""The errors themselves."""

import pickle

import pytest

from vibopt.errors import InputError, NotProven, QuantityError, UnknownName, VibOptError, counted


def test_an_input_error_holds_all_mistakes() -> None:
    error = InputError(["one.", "two."])
    assert error.messages == ("one.", "two.")
    assert str(error) == "one.\ntwo."
    assert InputError("one.").messages == ("one.",)


@pytest.mark.parametrize(
    ("kind", "code"), [(VibOptError, 1), (InputError, 2), (QuantityError, 2), (UnknownName, 2), (NotProven, 5)]
)
def test_each_error_has_its_exit_code(kind: type[VibOptError], code: int) -> None:
    assert kind.exit_code == code


@pytest.mark.parametrize("error", [InputError(["one.", "two."]), QuantityError("has no unit."), NotProven("no gap.")])
def test_errors_survive_the_way_between_processes(error: VibOptError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)


@pytest.mark.parametrize(
    ("things", "alone"),
    [
        ("classes", "1 class"), ("convex programs", "1 convex program"), ("bodies", "1 body"), ("masses", "1 mass"),
        ("groups of mounts", "1 group of mounts"), ("bases", "1 base"), ("runs with weights", "1 run with weights"),
        ("counterweights and balance shafts", "1 counterweight or balance shaft"),
    ],
)  # fmt: skip
def test_one_of_a_thing_is_told_without_a_plural(things: str, alone: str) -> None:
    assert counted(1, things) == alone
    assert counted(2, things) == f"2 {things}"


def test_a_quantity_error_is_a_value_error() -> None:
    assert issubclass(QuantityError, ValueError)


@pytest.mark.parametrize(
    ("name", "known", "text"),
    [
        (
            "floor force",
            ["rms_force", "transmitted_force"],
            'unknown link "floor force". Did you mean "transmitted_force"?',
        ),
        ("number", ["between", "count", "stiffness"], 'unknown link "number". Did you mean "count"?'),
        ("number", ["between", "at", "stiffness"], 'unknown link "number". Did you mean "at"?'),
        ("number", ["at", "over"], 'unknown link "number". Known: at, over.'),
        ("on", ["between", "count"], 'unknown link "on". Did you mean "between"?'),
        ("height", ["weight", "centre"], 'unknown link "height". Did you mean "centre"?'),
        ("mont", ["mount", "press"], 'unknown link "mont". Did you mean "mount"?'),
        ("xyz", ["mount", "press"], 'unknown link "xyz". Known: mount, press.'),
        ("xyz", [], 'unknown link "xyz".'),
    ],
)
def test_an_unknown_name_shows_the_way_out(name: str, known: list[str], text: str) -> None:
    assert str(UnknownName.among("link", name, known)) == text
