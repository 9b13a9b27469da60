"""One pass over a TOML text that notes the line of every key."""

import re
from bisect import bisect_right
from contextlib import suppress
from dataclasses import field

import tomli

from vibopt.records import dataclass

_BLANK = re.compile(r"(?:\s|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_KEY = re.compile(r"""[^\s.=\[\]{}"'#,]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*'""")
_STRING = re.compile(
    r""""{3}(?:\\.|[^\\])*?"{3,5}|'{3}.*?'{3,5}|"(?:[^"\\\n]|\\.)*"|'[^'\n]*\'""",
    re.DOTALL,
)
_BARE = re.compile(r"[^,\]}\n#]*")


@dataclass(slots=True)
class Node:
    """What is met at one path: its line, its tables where it is an array of tables, and what lies in it."""

    line: int
    tables: int = 0
    inner: "dict[str | int, Node]" = field(default_factory=dict)

    def step(self, key: str | int, line: int) -> "Node":
        """What lies at a key of it; new ones stand at `line`."""
        return self.inner.setdefault(key, Node(line))


class Scan:
    """One pass over the text; `top` holds everything met, `too_deep` says that the pass ended at too deep a place.

    `deepest`: most steps of a key, and of brackets within brackets.
    """

    def __init__(self, text: str, deepest: int) -> None:
        self._deepest = deepest
        self.top = Node(0)
        self.too_deep = False
        self._depth = 0
        self._text = text
        self._position = 0
        self._breaks = [match.start() for match in re.finditer("\n", text)]
        with suppress(RecursionError):
            self._document()

    def _document(self) -> None:
        table = self.top
        self._take(_BLANK)
        while self._position < len(self._text):
            start = self._position
            if self._skip("[["):
                table = self._header(repeated=True)
            elif self._skip("["):
                table = self._header(repeated=False)
            else:
                self._pair(table)
            self._take(_BLANK)
            if self._position == start:
                self._to_next_line()

    def _header(self, *, repeated: bool) -> Node:
        """The table that starts here; names of arrays of tables on the way stand for their last table."""
        line, here = self._line(), self.top
        keys = self._keys()
        for depth, key in enumerate(keys, start=1):
            here = here.step(key, line)
            if depth == len(keys):
                here.tables += repeated
                here.line = here.line if repeated else line
            if here.tables:
                here = here.step(here.tables - 1, line)
        self._take(_SPACE)
        self._skip("]]" if repeated else "]")
        return here

    def _pair(self, table: Node) -> None:
        """A key, dotted or not, and its value."""
        line, here = self._line(), table
        for key in self._keys():
            here = here.step(key, line)
        self._take(_SPACE)
        if self._skip("="):
            self._take(_SPACE)
            self._value(here)

    def _value(self, here: Node) -> None:
        if self._text.startswith(("[", "{"), self._position):
            if self._depth == self._deepest:
                self.too_deep = True
                raise RecursionError
            self._depth += 1
            if self._skip("["):
                self._listed(here, "]")
            elif self._skip("{"):
                self._listed(here, "}")
            self._depth -= 1
        elif not self._take(_STRING):
            self._take(_BARE)

    def _listed(self, here: Node, closing: str) -> None:
        """Values of an array, or pairs of an inline table, up to the bracket that closes it."""
        index = 0
        self._take(_BLANK)
        while self._position < len(self._text) and not self._skip(closing):
            start = self._position
            if closing == "]":
                self._value(here.step(index, self._line()))
            else:
                self._pair(here)
            self._take(_BLANK)
            index += self._skip(",")
            self._take(_BLANK)
            if self._position == start:
                return

    def _keys(self) -> list[str]:
        """The parts of a dotted key, without their quotes."""
        keys: list[str] = []
        while True:
            self._take(_SPACE)
            written = self._take(_KEY)
            if not written:
                return keys
            keys.append(_plain(written))
            if len(keys) > self._deepest:
                self.too_deep, self._position = True, len(self._text)
                return keys
            self._take(_SPACE)
            if not self._skip("."):
                return keys

    def _take(self, pattern: re.Pattern[str]) -> str:
        """Text of `pattern` at this position, which moves behind it; "" if it is not here."""
        match = pattern.match(self._text, self._position)
        if not match:
            return ""
        self._position = match.end()
        return match[0]

    def _skip(self, sign: str) -> bool:
        """Moves behind `sign` if it is here, and says so."""
        here = self._text.startswith(sign, self._position)
        self._position += len(sign) * here
        return here

    def _line(self) -> int:
        return bisect_right(self._breaks, self._position - 1) + 1

    def _to_next_line(self) -> None:
        end = self._text.find("\n", self._position)
        self._position = len(self._text) if end < 0 else end + 1


def _plain(key: str) -> str:
    """A key without its quotes and escapes; as written if these are no TOML."""
    if key[0] not in "\"'":
        return key
    try:
        return str(tomli.loads(f"key = {key}")["key"])
    except tomli.TOMLDecodeError:
        return key
