"""A limit is a comparison: a response with its place on one side, a value with its unit on the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import NoReturn, TypeAlias

from vibopt.document.mistakes import toml_text
from vibopt.errors import InputError
from vibopt.scene.scene import MAXIMISE, MINIMISE

Bound: TypeAlias = str | float
"""A value with its unit, "6 kN"; pure ratios may be numbers."""

Given: TypeAlias = str | float | Mapping[str, object]
"""A fact as Bound, or a choice made by `choose` or `one_of`."""

Way: TypeAlias = str | Sequence[float]
"""A direction or an axis in space: "x", "y", "z" or three numbers."""

Speeds: TypeAlias = str | Sequence[str] | Mapping[str, object]
"""A speed, "800..2000 rpm", or a list of those; a choice; per excitation as a mapping."""


def plain_table(words: Mapping[str, object]) -> dict[str, object]:
    """The words as a table of a problem file; what is None is not said."""
    return {key: plain(value) for key, value in words.items() if value is not None}


def plain(value: object) -> object:
    """A value as TOML knows it, in new lists and tables; what TOML does not know is left to the reader to refuse."""
    if isinstance(value, (str, bool)):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value)
    if isinstance(value, Mapping):
        return plain_table(value)
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return value


BOUNDS = ("at_least", "at_most", "outside")


class Limit:
    """A response with its bound, as `[limits.NAME]`; true or false only once a scene is solved.

    Parameters
    ----------
    words
        Keys and values as in the file, `response` among them.
    """

    def __init__(self, words: Mapping[str, object]) -> None:
        if not isinstance(words, Mapping):
            raise InputError(f'Limit({words!r}): this is no table. Write machine.displacement(of="press") <= "2 mm".')
        self.words = plain_table(words)

    def __bool__(self) -> NoReturn:
        raise InputError(
            f"{self!r} is a limit, and neither true nor false before the scene is solved. "
            'For a value between two bounds write .limit(at_least="...", at_most="..."); '
            "for several limits write a list of them."
        )

    def __repr__(self) -> str:
        given = {key: value for key, value in self.words.items() if key in BOUNDS}
        place = _place({key: value for key, value in self.words.items() if key not in BOUNDS})
        for key, sign in (("at_least", ">="), ("at_most", "<=")):
            if list(given) == [key]:
                return f"{place} {sign} {_side(given[key])}"
        return f"{place}.limit({_listed(given)})"


class Measure:
    """A response with its place, as `[measures.NAME]`; compared with a value it becomes a Limit.

    Parameters
    ----------
    response
        A response of the problem file, such as "transmitted_force".
    words
        Its other keys as in the file; those that are None are left out.

    Notes
    -----
    `measure <= "6 kN"` and `measure >= "6 kN"` make limits; `<`, `>`, `==` and `!=` raise, as a limit includes
    its bound and no machine meets a value exactly.
    """

    __array_ufunc__ = None
    """So that numpy's numbers, too, leave `0.1 >= measure` to the measure."""

    def __init__(self, response: str, **words: object) -> None:
        self.words = plain_table({"response": response, **words})
        for key in BOUNDS:
            if key in self.words:
                raise InputError(f"{self!r} has a bound ({key}). Write a bound as a comparison, as .limit({key}=...).")

    def limit(self, *, at_most: Bound | None = None, at_least: Bound | None = None, outside: object = None) -> Limit:
        """The limit with the bounds of the file; `outside` belongs to natural frequencies, as "20..30 Hz"."""
        return Limit({**self.words, "at_most": at_most, "at_least": at_least, "outside": outside})

    def __le__(self, bound: Bound) -> Limit:
        self._no_response("<=", bound)
        return self.limit(at_most=bound)

    def __ge__(self, bound: Bound) -> Limit:
        self._no_response(">=", bound)
        return self.limit(at_least=bound)

    def __lt__(self, bound: Bound) -> NoReturn:
        self._no_response("<", bound)
        self._strict("<", bound)

    def __gt__(self, bound: Bound) -> NoReturn:
        self._no_response(">", bound)
        self._strict(">", bound)

    def __eq__(self, bound: object) -> NoReturn:
        self._no_response("==", bound)
        raise InputError(
            f"{self!r} == {_side(bound)} is no limit: no machine meets a value exactly. "
            'Write <= or >=, or both as .limit(at_least="...", at_most="...").'
        )

    def __repr__(self) -> str:
        return _place(self.words)

    def _strict(self, sign: str, bound: object) -> NoReturn:
        side = _side(bound)
        raise InputError(
            f"{self!r} {sign} {side} is no limit: a limit includes its bound. Write {self!r} {sign}= {side}."
        )

    def _no_response(self, sign: str, bound: object) -> None:
        if isinstance(bound, (Measure, Limit)):
            raise InputError(
                f"{self!r} {sign} {bound!r} compares two responses. "
                'Compare a response with a value and its unit, for example "6 kN".'
            )


def _place(words: Mapping[str, object]) -> str:
    """A response as the user called it: displacement(of="press")."""
    return f"{words['response']}({_listed({key: value for key, value in words.items() if key != 'response'})})"


def _listed(words: Mapping[str, object]) -> str:
    return ", ".join(f"{key}={_side(value)}" for key, value in words.items())


def _side(value: object) -> str:
    """A value as text in messages; text and numbers as in the file."""
    return toml_text(value) if isinstance(value, (str, int, float)) else repr(value)


def choose(from_: Bound | None = None, to: Bound | None = None, *, whole: bool | None = None) -> dict[str, object]:
    """A design variable, `{ from, to }` in the file: any one value of the range, its ends included.

    Parameters
    ----------
    from_, to
        Ends of the range with their units; without one of them the range is open on that side.
    whole
        Whether only whole numbers may be chosen, as for a count.
    """
    words = {"from": from_, "to": to, "whole": whole}
    return {key: value for key, value in words.items() if value is not None}


def one_of(*values: Bound | Sequence[object]) -> dict[str, object]:
    """A choice, `{ one_of = [...] }` in the file: one of the listed values, as from a catalogue, or pairs of ends."""
    return {"one_of": list(values)}


def maximise(response: Measure) -> dict[str, object]:
    """The goal: as much of a response as the limits allow."""
    return _goal(MAXIMISE, response)


def minimise(response: Measure) -> dict[str, object]:
    """The goal: as little of a response as the limits allow."""
    return _goal(MINIMISE, response)


def find_all(path: str) -> dict[str, object]:
    """The goal: all speeds ("EXCITATION.speed", a choice there) or values of the one variable at which limits hold."""
    return {"find_all": path}


def _goal(sense: str, response: object) -> dict[str, object]:
    if not isinstance(response, (Measure, Limit)):
        raise InputError(
            f'{sense}({response!r}): this is no response. Write {sense}(machine.stiffness(of="mount")), for example.'
        )
    words = dict(response.words)
    return {sense: words.pop("response"), **words}
