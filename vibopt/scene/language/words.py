"""The words around a machine: what may be chosen, and what is wanted."""

from __future__ import annotations

from vibopt.errors import InputError
from vibopt.scene.language.limit import Limit, Measure
from vibopt.scene.language.values import Bound
from vibopt.scene.scene import MAXIMISE, MINIMISE


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


def one_of(*values: Bound) -> dict[str, object]:
    """A design variable, `{ one_of = [...] }` in the file: one of the listed values, as from a catalogue."""
    return {"one_of": list(values)}


def maximise(response: Measure) -> dict[str, object]:
    """The goal: as much of a response as the limits allow."""
    return _goal(MAXIMISE, response)


def minimise(response: Measure) -> dict[str, object]:
    """The goal: as little of a response as the limits allow."""
    return _goal(MINIMISE, response)


def find_all(speed: str) -> dict[str, object]:
    """The goal: all speeds at which the limits hold; `speed` is "EXCITATION.speed", written as a choice there."""
    return {"find_all": speed}


def _goal(sense: str, response: object) -> dict[str, object]:
    if not isinstance(response, (Measure, Limit)):
        raise InputError(
            f'{sense}({response!r}): this is no response. Write {sense}(machine.stiffness(of="mount")), for example.'
        )
    words = dict(response.words)
    return {sense: words.pop("response"), **words}
