"""An answer as JSON from which it can be made again, bit for bit: the classes it is built of and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cache, partial
from importlib import import_module
from math import isnan
from typing import Any

import numpy as np

_HOMES = ("vibopt.answer.answer", "vibopt.answer.entry", "vibopt.answer.plan")
"""Modules whose classes an answer is built of."""
_KIND, _JOB = "is", "job"


class NotStoredError(TypeError):
    """Something in the answer is none of what is stored."""


@cache
def _classes() -> Mapping[str, type[Any]]:
    """Classes that may be made of what was stored, by name."""
    found = {}
    for home in _HOMES:
        module = import_module(home)
        for name, var in vars(module).items():
            if isinstance(var, type) and var.__module__ == home and hasattr(var, "__dataclass_params__"):
                found[name] = var
    return found


def packed(data: Any, job: Callable[[Any], Any]) -> Any:
    """Plain data for `json.dumps`; `job` says what stands for the job of an answer.

    Raises
    ------
    NotStoredError
        It holds what is none of numbers, words, arrays, lists, tables and the classes of an answer.
    """
    if data is None or isinstance(data, (bool, str)):
        return data
    if isinstance(data, (float, int)):
        return float(data) if isinstance(data, float) else int(data)
    if isinstance(data, complex):
        return {_KIND: "complex", "of": [data.real, data.imag]}
    if isinstance(data, np.ndarray):
        flat = data.ravel().tolist()
        return {_KIND: "array", "of": packed(flat, job), "type": data.dtype.str, "shape": list(data.shape)}
    kind = type(data)
    if _classes().get(kind.__name__) is kind:
        held = {
            field.name: job(data.job) if field.name == _JOB else packed(getattr(data, field.name), job)
            for field in fields(data)
        }
        return {_KIND: kind.__name__, "of": held}
    if isinstance(data, Mapping):
        return {_KIND: "table", "of": [[packed(key, job), packed(one, job)] for key, one in data.items()]}
    if isinstance(data, Sequence):
        inner = [packed(one, job) for one in data]
        return inner if isinstance(data, list) else {_KIND: "tuple", "of": inner}
    if callable(data):  # words that are made when they are looked at
        return {_KIND: "said", "of": packed(data(), job)}
    raise NotStoredError(f"{kind.__name__} is not stored")


def unpacked(data: Any, job: Callable[[Any], Any]) -> Any:
    """What `packed` was given; `job` makes the job of an answer from what stands for it.

    Raises
    ------
    ValueError, KeyError, TypeError
        It is nothing that `packed` makes.
    """
    if isinstance(data, list):
        return [unpacked(one, job) for one in data]
    if not isinstance(data, dict):
        return data
    kind, of = data[_KIND], data["of"]
    if kind == "complex":
        return complex(*of)
    if kind == "array":
        values: Any = np.array(unpacked(of, job), dtype=np.dtype(data["type"]))
        return values.reshape(data["shape"])
    if kind == "said":
        return partial(str, unpacked(of, job))
    if kind == "table":
        return {unpacked(key, job): unpacked(one, job) for key, one in of}
    if kind == "tuple":
        return tuple(unpacked(one, job) for one in of)
    made = _classes()[kind]
    held = {name: job(one) if name == _JOB else unpacked(one, job) for name, one in of.items()}
    return made(**held)


def alike(one: Any, other: Any) -> bool:
    """Whether two stored forms are the same, a number that is none like another that is none."""
    if isinstance(one, float) and isinstance(other, float):
        return one == other or (isnan(one) and isnan(other))
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    return bool(one == other)
