"""A topic of the manual, in Markdown, and its sections."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from vibopt.records import cached_property, dataclass

_HEADING = re.compile(r"^(#{1,4}) (.+)$")
_WORDS = re.compile(r"<!-- words: (.*?) -->\n?", re.S)


@dataclass(frozen=True)
class Section:
    """What stands under one heading, down to the next of any level; `words` are found but not shown."""

    topic: str
    heading: str
    level: int
    text: str
    words: str


@dataclass(frozen=True)
class Topic:
    """One page: `name` as it is asked for, `group` of the contents, and its Markdown or what makes it when read.

    about
        What it is about, where that is known without making the page; else "".
    """

    name: str
    group: str
    source: str | Callable[[], str]
    about: str = ""

    @cached_property
    def text(self) -> str:
        """Markdown that begins with the title."""
        return self.source if isinstance(self.source, str) else self.source()

    @property
    def title(self) -> str:
        return self.sections[0].heading

    @cached_property
    def shown(self) -> str:
        """The text without the words that only serve the search."""
        return _WORDS.sub("", self.text)

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        return tuple(self._cut())

    @property
    def line(self) -> str:
        """What it is about, for lists: its title, or its first sentence where the title is its name."""
        title = self.about or self.title
        if title != self.name:
            return title
        body = next(
            (
                part
                for part in self.sections[0].text.split("\n\n")
                if part and part[0] not in "#|<-" and part[:3] != "```"
            ),
            "",
        )
        return re.split(r"(?<=[.:;])\s", plain(" ".join(body.split())))[0].rstrip(".:;")

    def _cut(self) -> Iterator[Section]:
        start, heading, level, fenced = 0, self.name, 1, False
        lines = self.text.splitlines()
        for k, line in enumerate([*lines, "# end"]):
            fenced ^= line.startswith("```")
            match = _HEADING.match(line)
            if not match or fenced:
                continue
            if k:
                whole = "\n".join(lines[start:k])
                yield Section(
                    self.name, plain(heading), level, _WORDS.sub("", whole).strip(), " ".join(_WORDS.findall(whole))
                )
            start, heading, level = k, match[2], len(match[1])


def plain(text: str) -> str:
    """Markdown of one line without its marks."""
    return re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", text).replace("`", "").replace("**", "")


def slug(heading: str) -> str:
    """A heading as part of an address."""
    return "-".join(re.findall(r"[a-z0-9_]+", plain(heading).lower()))
