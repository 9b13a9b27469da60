"""All topics in the order of the contents, and how one is found."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache, partial
from pathlib import Path

from vibopt.errors import InputError, way_out
from vibopt.manual import reference
from vibopt.manual.search import Index
from vibopt.manual.topic import Section, Topic, plain
from vibopt.records import cached_property

GROUPS = {
    "Begin": ("start", "questions", "problem_file", "limits", "statuses", "commands"),
    "Guides": (
        "isolators", "absorbers", "space", "catalogues", "structures", "noise", "shock", "run_up", "friction",
        "shafts", "rotors", "drive_lines", "tolerances", "studies", "balancing", "known_masses", "engines", "methods",
        "verification", "charts", "python", "formats",
    ),
    "Reference": ("excitations", "responses", "units", "refusals"),
    "About": ("contributing", "changelog"),
}  # fmt: skip
"""Guides by group of the contents, in its order."""
_FOLDER = Path(__file__).with_name("guides")
_CONTRIBUTING = Path(__file__).parents[1] / "CONTRIBUTING.md"
_TABLE = re.compile(r"<!-- table: (.+?) -->")
_MOST = 8
"""Most places that are named beside the best one."""


class Book:
    """The topics.

    Parameters
    ----------
    topics
        In the order of the contents.
    """

    def __init__(self, topics: Iterable[Topic]) -> None:
        self.topics = {topic.name: topic for topic in topics}

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        return tuple(section for topic in self.topics.values() for section in topic.sections)

    @cached_property
    def index(self) -> Index:
        return Index(self.sections)

    @property
    def groups(self) -> dict[str, list[Topic]]:
        """Topics by group."""
        found: dict[str, list[Topic]] = {}
        for topic in self.topics.values():
            found.setdefault(topic.group, []).append(topic)
        return found

    def find(self, asked: str) -> tuple[Topic | Section, tuple[Section, ...]]:
        """What answers best; and where it was searched for, other places.

        Parameters
        ----------
        asked
            The name of a topic or of a table, or any words.

        Raises
        ------
        InputError
            Nothing has any of these words.
        """
        name = "_".join(re.findall(r"\w+", asked.lower().removesuffix(".name")))
        topic = self.topics.get(name) or self.topics.get(f"{name}s")
        if topic is not None:
            return topic, ()
        hits = self.index.hits(asked)
        if not hits:
            raise InputError(f'the manual has nothing on "{asked}".{way_out(name, self.topics)} vibopt help lists all.')
        return hits[0], hits[1 : _MOST + 1]


@cache
def the_book() -> Book:
    """The manual, but for the pages of the commands, which the command line adds."""
    written = {
        name: Topic(name, group, partial(_guide_text, name), _title(name))
        for group, names in GROUPS.items()
        for name in names
    }
    made = [*reference.kinds(), *reference.balancing()]
    for one in [topic for topic in made if topic.name in written]:
        guide = written[one.name]
        written[one.name] = Topic(guide.name, guide.group, partial(_with_keys, guide, one), guide.about)
        made.remove(one)
    groups = list(GROUPS)
    first = [topic for topic in written.values() if topic.group in groups[:2]]
    last = [topic for topic in written.values() if topic.group not in groups[:2]]
    return Book([*first, *made, *last])


def _with_keys(guide: Topic, table: Topic) -> str:
    """A guide and below it the keys of the table of the same name."""
    keys = table.text.split("\n", 1)[1].strip().replace("\n## Refused", "\n### Refused")
    return f"{guide.text.rstrip()}\n\n## Keys\n\n{keys}\n"


def _guide_text(name: str) -> str:
    tables = reference.tables()
    return _TABLE.sub(lambda match: tables[match[1]](), _file(name).read_text(encoding="utf-8"))


def _title(name: str) -> str:
    """The heading above a guide, in its first line."""
    with _file(name).open(encoding="utf-8") as lines:
        return plain(next(lines).removeprefix("# ").strip())


def _file(name: str) -> Path:
    return _CONTRIBUTING if name == "contributing" else _FOLDER / f"{name}.md"
