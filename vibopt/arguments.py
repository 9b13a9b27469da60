"""Arguments of public verbs: one of another kind than its annotation says is refused by its name, before it is used."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from functools import wraps
from numbers import Integral, Real
from os import PathLike
from types import FunctionType
from typing import Any

Holds = Callable[[object], bool]


def _job(value: object) -> bool:
    return hasattr(value, "document") and hasattr(value, "kind")


def _text(value: object) -> bool:
    return isinstance(value, str)


def _flag(value: object) -> bool:
    return isinstance(value, bool) or type(value).__module__ == "numpy"


def _number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _by(kind: Holds) -> Holds:
    return lambda value: isinstance(value, Mapping) and all(map(_text, value)) and all(map(kind, value.values()))


def _many(kind: Holds) -> Holds:
    """Of a list, a tuple, a set or an array."""

    def holds(value: object) -> bool:
        listed = hasattr(value, "__array__") or isinstance(value, (Sequence, Set))
        return listed and not isinstance(value, (str, bytes)) and all(map(kind, value))  # type: ignore[call-overload]

    return holds


_JOB = "no job. Take one from vibopt.read, or make a scene."
_CHANGES = 'no values by their paths. Write {"bodies.press.mass": "310 kg"}.'
_TEXTS = 'no list of texts. Write ["one", "other"].'
KINDS: dict[str, tuple[Holds, str]] = {
    "Job": (_job, _JOB),
    "J": (_job, _JOB),
    "Documented": (_job, _JOB),
    "Scene": (
        lambda value: getattr(value, "kind", "") == "scene",
        "no scene. Take one from vibopt.read of a machine, or make one with vibopt.Machine.",
    ),
    "Answer[Any]": (lambda value: _job(getattr(value, "job", None)), "no answer. Take one from vibopt.solve."),
    "Mapping[str, Job]": (_by(_job), 'no jobs by their names. Write {"A": vibopt.read("a.toml"), "B": other}.'),
    "Mapping[str, Any]": (_by(lambda _: True), _CHANGES),
    "str | Mapping[str, str]": (
        lambda value: _text(value) or _by(_text)(value),
        'no path, and no ranges by their paths. Write "bodies.press.mass", or {"bodies.press.mass": "290..310 kg"}.',
    ),
    "str | FilePath": (lambda value: isinstance(value, (str, PathLike)), 'no name of a file. Write "press.toml".'),
    "str": (_text, "no text."),
    "Sample": (_text, 'no text. Write "sobol" or "latin".'),
    "Sequence[str]": (_many(_text), _TEXTS),
    "Collection[str]": (_many(_text), _TEXTS),
    "Sequence[float]": (_many(_number), "no list of numbers. Write [1.0, 2.0]."),
    "bool": (_flag, "neither True nor False."),
    "int": (lambda value: isinstance(value, Integral) and _number(value), "no whole number."),
    "float": (_number, "no number."),
    "Progress": (callable, "no function. Give one that takes a stage and the part that is done."),
}
"""Annotation of a parameter: what holds of its values, and what is said of others."""
_KNOWN = ("method",)
"""Parameters of which a verb says itself what there is."""


def checked(name: str, verb: Callable[..., Any]) -> Callable[..., Any]:
    """A public verb, `vibopt.NAME`, that looks at the kinds of its arguments first.

    Raises
    ------
    TypeError
        Called with an argument of another kind.
    """
    parameters = verb.__code__.co_varnames[: verb.__code__.co_argcount]
    named_so = FunctionType(verb.__code__, verb.__globals__, name, verb.__defaults__, verb.__closure__)
    named_so.__kwdefaults__, named_so.__qualname__ = verb.__kwdefaults__, f"vibopt.{name}"

    @wraps(verb)
    def door(*given: Any, **named: Any) -> Any:
        for key, value in (*zip(parameters, given), *named.items()):  # noqa: B905 - too many are the verb's to refuse
            _check(name, key, value, verb.__annotations__.get(key, ""))
        return named_so(*given, **named)

    door.__module__, door.__name__, door.__qualname__ = "vibopt", name, name
    return door


def _check(name: str, key: str, value: object, annotation: str) -> None:
    kind = annotation.removesuffix(" | None")
    if kind not in KINDS or key in _KNOWN or (value is None and kind != annotation):
        return
    holds, words = KINDS[kind]
    if not holds(value):
        where = "" if words is _JOB else f"vibopt.{name}({key}=...): "
        raise TypeError(f"{where}{type(value).__name__} is {words}")
