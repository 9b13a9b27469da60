"""Lines of keys: the writer of each text knows where it put them."""

import tomllib
from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibopt.document.locate import DEEPEST, Locator, Path, may_be_too_deep

PRESS = '''\
# [not.a.table]
title = "a # [b]"
[bodies.press]   # mass = 1
mass = "300 kg"

[links."my mount"]
between = [
  "press", # ] "
  "ground",
]
statement = """
[fake]
x = 1 """""
stiffness = { from = "1 N/m", to = [1,
  2] }
a.b."c\\u0020d" = 1
[[expected]]
what = 'x'
[[expected]]
what = \'\'\'
[[expected]]
\'\'\'
  [expected.sub]
  day = 1979-05-27 07:32:00
  [[expected.sub.list]]
  [[expected.sub.list]]
  k = [[1, 2], [
    3]]
[bodies]
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("title",), 2),
        (("bodies",), 29),
        (("bodies", "press"), 3),
        (("bodies", "press", "mass"), 4),
        (("links",), 6),
        (("links", "my mount", "between"), 7),
        (("links", "my mount", "between", 0), 8),
        (("links", "my mount", "between", 1), 9),
        (("links", "my mount", "statement"), 11),
        (("links", "my mount", "stiffness", "from"), 14),
        (("links", "my mount", "stiffness", "to"), 14),
        (("links", "my mount", "stiffness", "to", 1), 15),
        (("links", "my mount", "a", "b", "c d"), 16),
        (("expected",), 17),
        (("expected", 0), 17),
        (("expected", 0, "what"), 18),
        (("expected", 1), 19),
        (("expected", 1, "what"), 20),
        (("expected", 1, "sub", "day"), 24),
        (("expected", 1, "sub", "list", 1), 26),
        (("expected", 1, "sub", "list", 1, "k", 1, 0), 28),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_every_key_is_found(path: Path, line: int, newline: str) -> None:
    text = PRESS.replace("\n", newline)
    tomllib.loads(text)
    assert Locator(text).line_of(path) == line


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("bodies", "press", "stiffness"), 3),
        (("bodies", "fan", "mass"), 29),
        (("links", "my mount", "stiffness", "by", 3), 14),
        (("expected", 7, "what"), 17),
        (("goal", "maximise"), None),
        ((), None),
    ],
)
def test_what_is_not_there_is_at_its_nearest_parent(path: Path, line: int | None) -> None:
    assert Locator(PRESS).line_of(path) == line


# A small writer of TOML that remembers the line of every path.

Tree = Mapping[str, object]
_KEYS = st.text("abZ_-09", min_size=1, max_size=4) | st.text(st.characters(codec="utf-8"), max_size=4)
_LEAVES = st.integers() | st.booleans() | st.text(st.characters(codec="utf-8"), max_size=8)
_LEAVES |= st.sampled_from(["a#b", "[x]", "}\n]", '"', "'", "\n\n", "k = 1", '"""', "'''"])


def _tables(inner: st.SearchStrategy[object]) -> st.SearchStrategy[dict[str, object]]:
    return st.dictionaries(_KEYS, inner, max_size=3)


_VALUES = st.recursive(_LEAVES, lambda inner: st.lists(inner, max_size=3) | _tables(inner), max_leaves=12)


class Writer:
    """Writes nested dictionaries in one of several styles and records (path, line) pairs."""

    def __init__(self, draw: st.DrawFn) -> None:
        self.draw = draw
        self.text = ""
        self.lines: dict[Path, int] = {}

    def choose(self, *styles: str) -> str:
        return self.draw(st.sampled_from(styles))

    def note(self, path: Path) -> None:
        self.lines.setdefault(path, self.text.count("\n") + 1)

    def key(self, key: str) -> str:
        if key and set(key) <= set("abZ_-09") and self.choose("bare", "quoted") == "bare":
            return key
        if "'" not in key and key.isprintable() and self.choose("basic", "literal") == "literal":
            return f"'{key}'"
        return self.basic(key)

    def basic(self, text: str) -> str:
        plain = {'"': '\\"', "\\": "\\\\"}
        return '"' + "".join(plain.get(c, c if c.isprintable() else f"\\U{ord(c):08x}") for c in text) + '"'

    def value(self, value: object, path: Path) -> None:
        if isinstance(value, dict):
            self.inline(value, path)
        elif isinstance(value, list):
            self.array(value, path)
        elif isinstance(value, bool | int):
            self.text += str(value).lower()
        else:
            self.string(str(value))

    def string(self, text: str) -> None:
        printable = all(c.isprintable() or c == "\n" for c in text)
        style = self.choose("basic", "multi", "literal")
        if style == "multi" and printable and not set(text) & set('"\\'):
            self.text += '"""\n' + text + '"""' + self.draw(st.sampled_from(["", '"', '""']))
        elif style == "literal" and printable and "'" not in text:
            self.text += "'''" + text + "'''"
        else:
            self.text += self.basic(text)

    def array(self, values: list[object], path: Path) -> None:
        self.text += "["
        for index, value in enumerate(values):
            self.text += self.draw(st.sampled_from(["", "\n  ", " # ], [x\n"]))
            self.note((*path, index))
            self.value(value, (*path, index))
            self.text += self.draw(st.sampled_from([",", " , ", " # '\n,"]))
        self.text += self.draw(st.sampled_from(["", "\n"])) + "]"

    def inline(self, table: Tree, path: Path) -> None:
        self.text += "{"
        for number, (key, value) in enumerate(table.items()):
            self.text += ", " if number else " "
            self.pair(key, value, path)
        self.text += " }"

    def pair(self, key: str, value: object, path: Path) -> None:
        self.note((*path, key))
        self.text += self.key(key) + self.draw(st.sampled_from(["=", " = "]))
        self.value(value, (*path, key))

    def dotted(self, keys: list[str], value: object, path: Path) -> None:
        for depth in range(1, len(keys) + 1):
            self.note((*path, *keys[:depth]))
        self.text += " . ".join(self.key(key) for key in keys) + " = "
        self.value(value, (*path, *keys))
        self.text += "\n"

    def table(self, table: Tree, path: Path, header: list[str]) -> None:
        """Plain keys first, then tables under their own headers."""
        later: list[tuple[str, object]] = []
        for key, value in table.items():
            style = self.choose("plain", "header", "dotted")
            if style == "header" and (isinstance(value, dict) or self.is_tables(value)):
                later.append((key, value))
            elif style == "dotted" and isinstance(value, dict) and value:
                for inner, leaf in value.items():
                    self.dotted([key, inner], leaf, path)
            else:
                self.pair(key, value, path)
                self.text += self.draw(st.sampled_from(["\n", " # \" ' [\n", "\n\n"]))
        for key, value in later:
            for index, member in enumerate(value if isinstance(value, list) else [value]):
                self.header(member, (*path, key), [*header, key], index if isinstance(value, list) else None)

    def header(self, table: Tree, path: Path, header: list[str], index: int | None) -> None:
        self.note(path)
        place = path if index is None else (*path, index)
        self.note(place)
        name = ".".join(self.key(key) for key in header)
        self.text += f"  [{name}]\n" if index is None else f"[[ {name} ]] # [[\n"
        self.table(table, place, header)

    @staticmethod
    def is_tables(value: object) -> bool:
        return isinstance(value, list) and bool(value) and all(isinstance(member, dict) for member in value)


@st.composite
def documents(draw: st.DrawFn) -> Writer:
    writer = Writer(draw)
    writer.table(draw(st.dictionaries(_KEYS, _VALUES, max_size=4)), (), [])
    return writer


@given(documents())
def test_every_key_of_any_document_is_on_its_line(document: Writer) -> None:
    tomllib.loads(document.text)
    locator = Locator(document.text)
    assert {path: locator.line_of(path) for path in document.lines} == document.lines


@given(st.text() | st.text("ab.=[]{}\"'#,\n \\1", max_size=40))
def test_no_text_makes_it_raise(text: str) -> None:
    Locator(text).line_of(("a", "b", 0))


@pytest.mark.parametrize("deep", ["a = " + "[" * 10_000, "a = " + "{b=" * 10_000, "a." * 100 + "b = 1", "a = [1 2"])
def test_no_depth_makes_it_raise(deep: str) -> None:
    assert Locator(deep).line_of(("a",)) == 1


PARTS = st.one_of(
    st.text("ab_-", min_size=1, max_size=3),
    st.text("ab.=@ µé", max_size=4).map(lambda one: f'"{one}"'),
    st.text("ab.=@ µé", max_size=4).map(lambda one: f"'{one}'"),
)


@given(st.lists(st.tuples(PARTS, st.sampled_from((".", " . ", "\t."))), min_size=DEEPEST + 1, max_size=DEEPEST + 9))
def test_a_key_that_goes_too_deep_is_never_overlooked(parts: list[tuple[str, str]]) -> None:
    text = f"x = 1\n{''.join(name + point for name, point in parts)}end = 2\n"
    assert Locator(text).too_deep
    assert may_be_too_deep(text)


def test_readings_are_not_taken_for_a_deep_key() -> None:
    cells = ", ".join(f's{k} = "{k}.5 µm pp @ {k}.25 deg"' for k in range(500))
    assert not may_be_too_deep(f"[[runs]]\nreadings = {{ {cells} }}\n")
