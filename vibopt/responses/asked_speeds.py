"""Speeds at which a response is asked for, as a file says them: single ones, ranges, or all from rest on."""

import re
from typing import Annotated, Any

from vibopt.errors import QuantityError
from vibopt.values import SpeedRange, read_speeds
from vibopt.values.fields import ReadBy, complaint

START_UP = "start-up"
_OTHER_WORDS = ("runup", "rundown", "coastdown", "shutdown", "startstop", "acceleration", "all", "start")


def _one(given: object) -> SpeedRange | str:
    word = re.sub(r"[\s_-]", "", given).lower() if isinstance(given, str) else ""
    if word == "startup":
        return START_UP
    if word in _OTHER_WORDS:
        raise QuantityError(f'is no speed. Did you mean "{START_UP}", every speed from rest to the highest own speed?')
    return read_speeds(given)


def _over(given: object) -> object:
    try:
        if isinstance(given, dict):
            return {name: _one(one) for name, one in given.items()}
        return _one(given)
    except QuantityError as error:
        raise complaint(str(error)) from None


def _at(given: object) -> object:
    speeds = _over(given)
    parts = list(speeds.values()) if isinstance(speeds, dict) else [speeds]
    for part in parts:
        if not isinstance(part, SpeedRange) or not all(band.is_point for band in part.bands):
            raise complaint('is a range, but `at` names single speeds. Write over = "..." for every speed in a range.')
    return speeds


_SPEEDS = {"type": ["string", "array", "object"], "description": 'speeds, for example "0..3000 rpm"'}
Over = Annotated[Any, ReadBy(_over, _SPEEDS)]
At = Annotated[Any, ReadBy(_at, _SPEEDS)]
