"""What can go wrong, in the user's words.

Each text says where, what was given, what is wrong and the way out. Messages about a value are
sentences in two halves: the reader of the file knows the place, the reader of the value knows the complaint.
"""

from collections.abc import Iterable
from difflib import get_close_matches


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
        self.messages: tuple[str, ...] = (messages,) if isinstance(messages, str) else tuple(messages)
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
    near = get_close_matches(name, names, n=1)
    if near:
        return f' Did you mean "{near[0]}"?'
    if names:
        return f" Known: {', '.join(names)}."
    return ""
