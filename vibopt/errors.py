"""What can go wrong, in the user's words.

Each text says where, what was given, what is wrong and the way out. Messages about a value are
sentences in two halves: the reader of the file knows the place, the reader of the value knows the complaint.
"""

import re
from collections.abc import Iterable
from difflib import get_close_matches

LONGEST = 399
"""Most letters of one message, whatever was given."""
_PIECE = re.compile(r"\S{61,}")
_CONTROL = re.compile("[\\x00-\\x1f\\x7f-\\x9f\\ud800-\\udfff]")
_LISTED = 240
"""Most letters of a list of known names."""


class VibOptError(Exception):
    """Root of everything vibopt raises on purpose; `exit_code` is the code of the command line."""

    exit_code: int = 1


class InputError(VibOptError):
    """Mistakes in what the user wrote, all of them at once.

    Parameters
    ----------
    messages
        One finished sentence per mistake, in the order of the file; a single text counts as one.
    """

    exit_code = 2

    def __init__(self, messages: Iterable[str] | str) -> None:
        said = (messages,) if isinstance(messages, str) else messages
        self.messages: tuple[str, ...] = tuple(brief(one) for one in said)
        super().__init__(self.messages)

    def __str__(self) -> str:
        return "\n".join(self.messages)


class QuantityError(VibOptError, ValueError):
    """A value that cannot be read.

    Parameters
    ----------
    complaint
        Continues the sentence "<file> line N: <path> = <given> ", as in 'has no unit. Write "480 kg".'
    """

    exit_code = 2

    def __init__(self, complaint: str) -> None:
        self.complaint = complaint
        super().__init__(complaint)


class UnknownName(VibOptError):  # noqa: N818 - reads better in "except UnknownName"
    """A name that nothing in the scene carries."""

    exit_code = 2

    @classmethod
    def among(cls, what: str, name: str, known: Iterable[str]) -> "UnknownName":
        """The error for `name`, where `what` is the kind of thing ("link") and `known` its names."""
        return cls(f'unknown {what} "{name}".{way_out(name, known)}')


class NotProven(VibOptError):  # noqa: N818 - public name; a finding rather than an error
    """Raised by `Design.require_proof()`: the answer may be good, but nothing proves it."""

    exit_code = 5


def way_out(name: str, known: Iterable[str]) -> str:
    """The sentence behind an unknown `name`: the nearest of `known`, else all of them; starts with a space."""
    names = list(known)
    near = get_close_matches(name[:LONGEST], names, n=1)
    if near:
        return f' Did you mean "{shortened(near[0], 60)}"?'
    if names:
        return f" Known: {_listed(names)}."
    return ""


def _listed(names: list[str]) -> str:
    """Names in a row; of many the first ones and how many more there are."""
    text = ", ".join(names)
    if len(text) <= _LISTED:
        return text
    kept: list[str] = []
    for one in names:
        kept.append(shortened(one, 60))
        if sum(map(len, kept)) + 2 * len(kept) > _LISTED - 20:
            break
    return f"{', '.join(kept)} and {len(names) - len(kept)} more" if len(kept) < len(names) else ", ".join(kept)


def shortened(text: str, most: int) -> str:
    """A text of at most `most` letters: a longer one has dots in its middle."""
    if len(text) <= most:
        return text
    head = (most - 3) * 2 // 3
    return f"{text[:head]}...{text[len(text) - (most - 3 - head) :]}"


def brief(message: str) -> str:
    """A message in one line of bounded length: a monstrous name is cut, the place and the way out stay."""
    plain = _CONTROL.sub("?", message)
    if len(plain) <= LONGEST:
        return plain
    return shortened(_PIECE.sub(lambda found: shortened(found[0], 60), plain), LONGEST)
