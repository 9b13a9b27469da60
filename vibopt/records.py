"""`dataclass` as in the standard library; what a class never uses of it is never made, which most of a start was."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Sequence
from dataclasses import MISSING, Field, FrozenInstanceError
from functools import cache
from operator import attrgetter
from types import MemberDescriptorType, SimpleNamespace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
    from dataclasses import replace as replace
    from functools import cached_property as cached_property
else:

    class cached_property(functools.cached_property):  # noqa: N801
        """As in the standard library, without the lock that it takes before Python 3.12: two threads may both work."""

        def __get__(self, instance, owner=None):
            if instance is None:
                return self
            found = instance.__dict__[self.attrname] = self.func(instance)
            return found

    def dataclass(cls=None, /, *, frozen=False, eq=True, slots=False, kw_only=False):
        """As `dataclasses.dataclass`: one class text is compiled, `__init__`, and only with its first object.

        Fields, defaults, `replace`, equality, hashes, frozen attributes and copies are those of the standard library.
        """

        def made(given):
            return _made(given, frozen=frozen, eq=eq, slots=slots, kw_only=kw_only)

        return made if cls is None else made(cls)

    def replace(given, /, **changes):
        """As `dataclasses.replace`: a new object with the values of another one but for changes; read all at once."""
        names, values = _told(given.__class__)
        return given.__class__(**{**dict(zip(names, values(given))), **changes})  # noqa: B905  # as many as names


_NO_FIELD = ("ClassVar", "typing.ClassVar")
_FEW = 12
"""Objects of a class from which on compiling an `__init__` for it pays."""


def _made(given: type, *, frozen: bool, eq: bool, slots: bool, kw_only: bool) -> Any:
    text = dict(vars(given))
    said = {name: kind for name, kind in text.get("__annotations__", {}).items() if not str(kind).startswith(_NO_FIELD)}
    for parent in given.__mro__[1:]:
        if getattr(vars(parent).get("__dataclass_params__"), "frozen", frozen) is not frozen:
            words = "frozen dataclass from a non-frozen" if frozen else "non-frozen dataclass from a frozen"
            raise TypeError(f"cannot inherit {words} one")
    made: Any = _with_slots(given, text, said) if slots else _with_defaults(given, text, said)
    made.__doc__ = given.__doc__ or f"{given.__name__}(...)"  # the library would work out a signature
    made.__dataclass_params__ = SimpleNamespace(frozen=frozen, repr=False)  # `pprint` asks for both
    methods: dict[str, Any] = {"__init__": _first_init(made, frozen), "__repr__": _repr}
    if eq:
        methods |= {"__eq__": _eq, "__hash__": _hash if frozen else None}
    methods = {name: method for name, method in methods.items() if text.get(name) is None}
    if frozen:
        methods |= {"__setattr__": _set, "__delattr__": _delete}
    if frozen and slots:
        methods |= {"__getstate__": _state, "__setstate__": _restore}
    methods["__dataclass_fields__"] = _Later(made, "__dataclass_fields__", lambda: _fields(made, text, said, kw_only))
    methods["__match_args__"] = _Later(made, "__match_args__", lambda: tuple(_words(made, named=False)))
    for name, method in methods.items():
        setattr(made, name, method)
    return made


class _Later:
    """An attribute of a class that is made when it is first asked for: most never are."""

    def __init__(self, home: type, name: str, make: Callable[[], Any]) -> None:
        self.home, self.name, self.make = home, name, make

    def __get__(self, _: object, kind: type) -> Any:
        value = self.make()
        setattr(self.home, self.name, value)
        return value


def _with_slots(given: Any, text: dict[str, Any], said: dict[str, Any]) -> Any:
    """The class again, with places for its fields in the stead of a dictionary."""
    taken = {name for parent in given.__mro__[1:] for name in vars(parent).get("__slots__", ())}
    kept = {name: one for name, one in text.items() if name not in said and name not in ("__dict__", "__weakref__")}
    kept |= {"__slots__": tuple(name for name in said if name not in taken), "__qualname__": given.__qualname__}
    return type(given)(given.__name__, given.__bases__, kept)


def _with_defaults(given: Any, text: dict[str, Any], said: dict[str, Any]) -> Any:
    """The class with the defaults themselves where it has words about them."""
    for name in said:
        if isinstance(one := text.get(name), Field):
            delattr(given, name) if one.default is MISSING else setattr(given, name, one.default)
    return given


def _fields(made: type, text: dict[str, Any], said: dict[str, Any], kw_only: bool) -> dict[str, Field[Any]]:
    """The fields of a class: those of its parents, and its own."""
    found: dict[str, Field[Any]] = {}
    for parent in reversed(made.__mro__[1:]):
        found |= getattr(parent, "__dataclass_fields__", {})
    for name, kind in said.items():
        default = text.get(name, MISSING)
        if type(default).__hash__ is None:
            raise ValueError(f"{made.__name__}.{name} has a default that may change. Use field(default_factory=...).")
        one: Any = default if isinstance(default, Field) else dataclasses.field(default=default)
        one.name, one.type, one._field_type = name, kind, dataclasses._FIELD  # type: ignore[attr-defined]
        one.kw_only = kw_only if one.kw_only is MISSING else one.kw_only
        found[name] = one
    return found


def _words(kind: Any, *, named: bool) -> dict[str, str]:
    """Parameters of the `__init__` by field, those that are given by name only or the others."""
    return {field.name: _word(field) for field in dataclasses.fields(kind) if field.init and field.kw_only is named}


def _first_init(kind: type, frozen: bool) -> Callable[..., None]:
    """The `__init__` of the first objects of a class; one that has many gets a faster one, compiled for it."""
    left = _FEW
    filled: Callable[..., bool] | None = None

    def first(self: Any, *given: Any, **named: Any) -> None:
        nonlocal left, filled
        left -= 1
        filled = filled or _filler(kind)
        if left < 0 or not filled(self, given, named):
            made = _init(kind, frozen)
            kind.__init__ = made  # type: ignore[misc]
            made(self, *given, **named)

    return first


def _filler(kind: Any) -> Callable[[Any, tuple[Any, ...], dict[str, Any]], bool]:
    """What sets the fields of a new object by position and name; it says False where these do not fit."""
    fields = dataclasses.fields(kind)
    words: Any = kind.__match_args__
    factories: list[tuple[str, Any]] = [(field.name, field.default_factory) for field in fields if _is_made(field)]
    known = frozenset(field.name for field in fields if field.init)
    needed = frozenset(
        field.name for field in fields if field.init and field.default is MISSING and not _is_made(field)
    )
    begun = {
        field.name: field.default for field in fields if field.init or field.default is not MISSING or _is_made(field)
    }
    places = [(name, _place(kind, name)) for name in begun]
    slots = [(name, place.__set__) for name, place in places if place is not None]
    loose = [name for name, place in places if place is None]
    ends = hasattr(kind, "__post_init__")

    def filled(new: Any, given: tuple[Any, ...], named: dict[str, Any]) -> bool:
        said = dict(zip(words, given)) | named if given else named  # noqa: B905  # too many are found out below
        if len(said) != len(given) + len(named) or not needed <= said.keys() <= known:
            return False
        for name, make in factories:
            if name not in said:
                said[name] = make()
        values = begun | said
        for name, put in slots:
            put(new, values[name])
        if loose:
            new.__dict__.update({name: values[name] for name in loose} if slots else values)
        if ends:
            new.__post_init__()
        return True

    return filled


def _is_made(field: Field[Any]) -> bool:
    return field.default_factory is not MISSING


def _place(kind: type, name: str) -> MemberDescriptorType | None:
    """The place of a field with slots; None of one in the dictionary."""
    place = getattr(kind, name, None)
    return place if isinstance(place, MemberDescriptorType) else None


def _init(kind: type, frozen: bool) -> Callable[..., None]:
    """The `__init__` of a class; a frozen one sets its fields past its own refusal."""
    fields = dataclasses.fields(kind)
    plain, named = _words(kind, named=False).values(), _words(kind, named=True).values()
    words = ["self", *plain, *(["*", *named] if named else [])]
    known: dict[str, Any] = {"_missing": MISSING}
    for one in fields:
        known[f"_{one.name}"] = one.default if one.default_factory is MISSING else one.default_factory
    values = [(field.name, _value(field)) for field in fields if field.init or known[f"_{field.name}"] is not MISSING]
    lines = [_setting(kind, name, value, known) if frozen else f"self.{name} = {value}" for name, value in values]
    if any(line.startswith("__own[") for line in lines):
        lines.insert(0, "__own = self.__dict__")
    if hasattr(kind, "__post_init__"):
        lines.append("self.__post_init__()")
    exec(f"def __init__({', '.join(words)}):\n " + "\n ".join(lines or ["pass"]), known)
    made: Callable[..., None] = known["__init__"]
    made.__qualname__ = f"{kind.__qualname__}.__init__"
    return made


def _setting(kind: type, name: str, value: str, known: dict[str, Any]) -> str:
    """Sets a field of a frozen class where it lies, its own place or the dictionary, past the refusal to set it."""
    place = _place(kind, name)
    if place is None:
        return f"__own[{name!r}] = {value}"
    known[f"__set_{name}"] = place.__set__
    return f"__set_{name}(self, {value})"


def _word(field: Field[Any]) -> str:
    """The parameter of a field."""
    if field.default_factory is not MISSING:
        return f"{field.name}=_missing"
    return field.name if field.default is MISSING else f"{field.name}=_{field.name}"


def _value(field: Field[Any]) -> str:
    """What a field is set to: what is given, its default, or what its factory makes."""
    if field.default_factory is MISSING:
        return field.name if field.init else f"_{field.name}"
    return f"_{field.name}() if {field.name} is _missing else {field.name}" if field.init else f"_{field.name}()"


@cache
def _compared(kind: Any) -> Callable[[Any], Any]:
    """What of an object is compared, as one tuple."""
    return _tuple_of([field.name for field in dataclasses.fields(kind) if field.compare])


@cache
def _told(kind: Any) -> tuple[list[str], Callable[[Any], Any]]:
    """Names of what an object of a kind is made of, and their values as one tuple."""
    names = [field.name for field in dataclasses.fields(kind) if field.init]
    return names, _tuple_of(names)


def _tuple_of(names: Sequence[str]) -> Callable[[Any], Any]:
    """Attributes of an object as one tuple."""
    if len(names) == 1:
        return lambda given: (getattr(given, names[0]),)
    return attrgetter(*names) if names else lambda given: ()


def _eq(self: Any, other: Any) -> Any:
    if other.__class__ is not self.__class__:
        return NotImplemented
    compared = _compared(self.__class__)
    return compared(self) == compared(other)


def _hash(self: Any) -> int:
    return hash(_compared(self.__class__)(self))


def _repr(self: Any) -> str:
    said = (f"{field.name}={getattr(self, field.name)!r}" for field in dataclasses.fields(self) if field.repr)
    return f"{self.__class__.__qualname__}({', '.join(said)})"


def _set(self: Any, name: str, value: object) -> None:
    raise FrozenInstanceError(f"cannot assign to field {name!r}")


def _delete(self: Any, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _state(self: Any) -> list[Any]:
    return [getattr(self, field.name) for field in dataclasses.fields(self)]


def _restore(self: Any, state: list[Any]) -> None:
    for field, value in zip(dataclasses.fields(self), state, strict=True):
        object.__setattr__(self, field.name, value)
