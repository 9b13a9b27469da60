"""Lines of keys in a TOML text, for messages; the TOML readers themselves forget them."""

from functools import lru_cache
from typing import TYPE_CHECKING

from vibopt.records import cached_property

if TYPE_CHECKING:
    from vibopt.document.toml_scanning import Scan

Path = tuple[str | int, ...]

DEEPEST = 30
"""Most steps of a key, and of brackets within brackets: twice as many as any job has."""

_ENDS = bytes.maketrans(b"=@", b"\n\n")
_BESIDE_POINTS = bytes(set(range(256)) - set(b".=@\n"))
_QUOTES = bytes.maketrans(b"'", b'"')


class Locator:
    """Finds the line of a key, a table or an element of an array in the text of a problem file.

    Parameters
    ----------
    text
        The whole file. Text that is no TOML does not raise: what cannot be followed is left out, and nothing is
        followed beyond a place that lies deeper than `DEEPEST`.  It is looked through when the first place is asked
        for.
    """

    def __init__(self, text: str) -> None:
        self._text = text

    @cached_property
    def _scan(self) -> "Scan":
        from vibopt.document.toml_scanning import Scan

        return Scan(self._text, DEEPEST)

    @property
    def too_deep(self) -> bool:
        """Whether keys or brackets go deeper than `DEEPEST`."""
        return self._scan.too_deep

    def line_of(self, path: Path) -> int | None:
        """Line (from 1) of `path`, else of its nearest parent in the file, else None.

        Parameters
        ----------
        path
            Keys and indices from the top, as ("links", "mount", "stiffness") or ("expected", 0, "value").
        """
        here, line = self._scan.top, None
        for step in path:
            found = here.inner.get(step)
            if found is None:
                break
            here, line = found, found.line
        return line


def may_be_too_deep(text: str) -> bool:
    """Whether a key may have more than `DEEPEST` parts; told by its points, without following the text.

    No other key has so many between signs of equality, or one behind a quotation mark.
    """
    plain = text.encode("ascii", "replace")
    many = b"." * DEEPEST in plain.translate(_ENDS, _BESIDE_POINTS)
    return many or b'".' in plain.translate(_QUOTES, b" \t")


@lru_cache(maxsize=4)
def located(text: str) -> Locator:
    """The locator of a text; the same for the same text."""
    return Locator(text)
