"""Lines of keys in a TOML text, for messages; the TOML readers themselves forget them."""

import re
import tomllib
from bisect import bisect_right
from contextlib import suppress

Path = tuple[str | int, ...]

_BLANK = re.compile(r"(?:\s|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_KEY = re.compile(r"""[^\s.=\[\]{}"'#,]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*'""")
_STRING = re.compile(
    r""""{3}(?:\\.|[^\\])*?"{3,5}|'{3}.*?'{3,5}|"(?:[^"\\\n]|\\.)*"|'[^'\n]*\'""",
    re.DOTALL,
)
_BARE = re.compile(r"[^,\]}\n#]*")


class Locator:
    """Finds the line of a key, a table or an element of an array in the text of a problem file.

    Parameters
    ----------
    text
        The whole file. Text that is no TOML does not raise: what cannot be followed is left out.
    """

    def __init__(self, text: str) -> None:
        self._lines = _Scan(text).lines

    def line_of(self, path: Path) -> int | None:
        """Line (from 1) of `path`, else of its nearest parent in the file, else None.

        Parameters
        ----------
        path
            Keys and indices from the top, as ("links", "mount", "stiffness") or ("expected", 0, "value").
        """
        for length in range(len(path), 0, -1):
            line = self._lines.get(path[:length])
            if line is not None:
                return line
        return None


class _Scan:
    """One pass over the text; `lines` maps the path of everything met to its line."""

    def __init__(self, text: str) -> None:
        self.lines: dict[Path, int] = {}
        self._text = text
        self._position = 0
        self._breaks = [found.start() for found in re.finditer("\n", text)]
        self._sizes: dict[Path, int] = {}
        with suppress(RecursionError):
            self._document()

    def _document(self) -> None:
        table: Path = ()
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

    def _header(self, *, repeated: bool) -> Path:
        """Path of the table that starts here; names of arrays of tables on the way stand for their last table."""
        line = self._line()
        keys = self._keys()
        path: Path = ()
        for depth, key in enumerate(keys, start=1):
            path = (*path, key)
            last = depth == len(keys)
            self.lines.setdefault(path, line)
            if repeated and last:
                self._sizes[path] = self._sizes.get(path, 0) + 1
            elif last:
                self.lines[path] = line
            if path in self._sizes:
                path = (*path, self._sizes[path] - 1)
                self.lines.setdefault(path, line)
        self._take(_SPACE)
        self._skip("]]" if repeated else "]")
        return path

    def _pair(self, table: Path) -> None:
        """A key, dotted or not, and its value."""
        line = self._line()
        path = table
        for key in self._keys():
            path = (*path, key)
            self.lines.setdefault(path, line)
        self._take(_SPACE)
        if self._skip("="):
            self._take(_SPACE)
            self._value(path)

    def _value(self, path: Path) -> None:
        if self._skip("["):
            self._array(path)
        elif self._skip("{"):
            self._inline_table(path)
        elif not self._take(_STRING):
            self._take(_BARE)

    def _array(self, path: Path) -> None:
        index = 0
        self._take(_BLANK)
        while self._position < len(self._text) and not self._skip("]"):
            start = self._position
            self.lines.setdefault((*path, index), self._line())
            self._value((*path, index))
            self._take(_BLANK)
            index += self._skip(",")
            self._take(_BLANK)
            if self._position == start:
                return

    def _inline_table(self, path: Path) -> None:
        self._take(_BLANK)
        while self._position < len(self._text) and not self._skip("}"):
            start = self._position
            self._pair(path)
            self._take(_BLANK)
            self._skip(",")
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
            self._take(_SPACE)
            if not self._skip("."):
                return keys

    def _take(self, pattern: re.Pattern[str]) -> str:
        """Text of `pattern` at this position, which moves behind it; "" if it is not here."""
        found = pattern.match(self._text, self._position)
        if not found:
            return ""
        self._position = found.end()
        return found[0]

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
        return str(tomllib.loads(f"key = {key}")["key"])
    except tomllib.TOMLDecodeError:
        return key
