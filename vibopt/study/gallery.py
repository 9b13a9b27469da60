"""A page about verified problem files: each with what was asked, what was printed, what is right, and the proof."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from urllib.parse import quote

from vibopt.document.expected import VERDICTS
from vibopt.errors import counted
from vibopt.files.marks import with_markdown_check
from vibopt.records import dataclass
from vibopt.study.recorded import Row
from vibopt.study.verify import About, FileResult

AT_FAULT = ("wrong", "misprint")
MEANINGS = {
    "right": "right, as far as it is printed",
    "rounded": "right but for rounding, on the way or at the end",
    "wrong": "what was asked has another answer",
    "misprint": "worked out rightly, printed wrongly",
    "incomplete": "true, but not all that was asked, or not the best",
}
_SPECIAL = re.compile(r"[\\`*\[\]<>|~]|(?<!\w)_|_(?!\w)")
"""What Markdown would take for its own."""
_HEAD = """\
# Problems and their answers

Made by `vibopt verify FOLDER --report`: every file is solved anew and compared with the answers that it records.
"""
_READING = """\
A problem that can be read in several ways has a file for each, and a printed answer is judged under each of them.
"""
_ONE_NUMBER = """\
One number stands for ours and the right one where they are written alike; they agree to 1e-6, or the file says
why not.
"""


@dataclass(frozen=True, slots=True)
class _Problem:
    """One file: its place seen from the page, what is known of it, and its records, each with its own reason."""

    place: str
    about: About
    records: tuple[tuple[Row, str], ...]

    @property
    def title(self) -> str:
        return self.about.title or self.place.rpartition("/")[2]

    @property
    def folder(self) -> str:
        return self.place.rpartition("/")[0]


def gallery(results: Sequence[FileResult], folder: Path) -> str:
    """The page in Markdown, the same for the same answers: no clock, no path of this machine, files in natural order.

    Parameters
    ----------
    results
        What became of each file.
    folder
        Where the page will lie; links start from there.
    """
    problems = sorted((_problem(result, folder) for result in results), key=lambda problem: _natural(problem.place))
    parts = [_HEAD, _summary(problems), _faults(problems), _ONE_NUMBER]
    parts += [_folder(name, list(inside)) for name, inside in groupby(problems, key=lambda problem: problem.folder)]
    return with_markdown_check("\n".join(filter(None, parts)))


def _problem(result: FileResult, folder: Path) -> _Problem:
    file, reasons = result.about.file, result.about.reasons
    try:
        place = os.path.relpath(file, folder.resolve()).replace(os.sep, "/")
    except ValueError:  # on another drive
        place = file.as_posix()
    spare = ("",) * (len(result.rows) - len(reasons))  # a row that is no record
    return _Problem(place, result.about, tuple(zip(result.rows, (*reasons, *spare), strict=True)))


def _natural(text: str) -> list[tuple[str, int]]:
    """9.2 before 9.10."""
    return [(words, int(number or 0)) for words, number in re.findall(r"(\D*)(\d*)", text)]


def _summary(problems: Sequence[_Problem]) -> str:
    rows = [row for problem in problems for row, _ in problem.records]
    wrong = sum(not row.ok for row in rows)
    agreed = "all as recorded" if not wrong else f"{len(rows) - wrong} as recorded and **{wrong} not**"
    proven = sum(problem.about.proven for problem in problems)
    lines = [
        f"{counted(len(problems), 'files')}, {counted(len(rows), 'records')}, {agreed}. "
        f"{counted(proven, 'answers')} proven, or measured on a machine as given; "
        f"{len(problems) - proven} not proven.\n"
    ]
    judged = Counter(row.verdict for row in rows if row.verdict)
    if judged:
        counts = [(word, str(judged[word]), MEANINGS[word]) for word in VERDICTS]
        lines += [f"{counted(judged.total(), 'printed answers')}:\n", _table(("Verdict", "Answers", "Means"), counts)]
        lines += [_READING]
    return "\n".join(lines)


def _faults(problems: Sequence[_Problem]) -> str:
    """All printed answers that are wrong, by their source, named once for each file; "" where there is none."""
    rows: list[tuple[str, ...]] = []
    for problem in sorted(problems, key=lambda one: (_natural(one.about.source or one.title), _natural(one.place))):
        where = _link(problem, problem.about.source or problem.title)
        for asked, row, why in _asked(problem):
            if row.verdict in AT_FAULT:
                rows.append((where, asked, _plain(row.printed), _plain(row.right), row.verdict, _plain(why)))
                where = ""
    heads = ("Where", "Asked", "Printed", "Right", "Verdict", "Why")
    return f"## Printed wrongly\n\n{_table(heads, rows)}" if rows else ""


def _asked(problem: _Problem) -> Iterator[tuple[str, Row, str]]:
    """What each record asks, also where it stands alone: "its angle (mass in plane 2)"."""
    whose = ""
    for row, why in problem.records:
        of_another = bool(whose) and row.what.startswith("its ")
        whose = whose if of_another else row.what
        yield _plain(f"{row.what} ({whose})" if of_another else row.what), row, why


def _folder(name: str, problems: Iterable[_Problem]) -> str:
    lines = [
        (
            _link(problem, problem.title),
            _plain(problem.about.source),
            "<br>".join(_records(problem)),
            _proof(problem.about),
        )
        for problem in problems
    ]
    table = _table(("Problem", "Source", "Answers", "Proof"), lines)
    return f"## {_plain(name) or 'Problems'}\n\n{table}"


def _records(problem: _Problem) -> Iterator[str]:
    """What was asked, ours and the right value, and what was printed with its verdict and the reason."""
    for row, why in problem.records:
        ours = f"**{_plain(row.ours)}**" if row.ours else ""
        right = "" if row.right == row.ours else f", right {_plain(row.right)}"
        printed = f"; printed {_plain(row.printed)}" if row.printed else ""
        loud = "**" if row.verdict in AT_FAULT else ""
        verdict = f": {loud}{row.verdict}{loud}" if row.verdict else ""
        reason = f" ({_plain(why)})" if why else ""
        fault = "" if row.ok else f"; **not as recorded**: {_plain(row.why)}"
        yield f"{_plain(row.what)}: {ours}{right}{printed}{verdict}{reason}{fault}"


def _proof(about: About) -> str:
    """Status, whether it is proven, and by which method."""
    proven = {"optimal": ", proven", "feasible": ", not proven to be the best"}.get(about.status, "")
    open_ = "; not every tolerance is proven" if about.status in ("optimal", "met") and not about.proven else ""
    method = f": {_plain(about.method)}" if about.method not in ("", "none") else ""
    return f"{about.status}{proven}{open_}{method}"


def _link(problem: _Problem, words: str) -> str:
    return f"[{_plain(words)}]({quote(problem.place)})"


def _plain(text: str) -> str:
    """A text on one line that Markdown shows as it stands."""
    return _SPECIAL.sub(r"\\\g<0>", " ".join(text.split()))


def _table(heads: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (heads, tuple("---" for _ in heads), *rows))
