"""Words found in sections: the rare ones, those of headings, and those that follow one another first."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable
from itertools import pairwise

from vibopt.manual.topic import Section

IDLE = frozenset(
    re.findall(
        r"\w+",
        """a an and are as at be been by can could do does for from get give given has have how i if in is it its let
        make my me of on one or say should so some tell that the their them then there this to use want was we what
        used using when where which who why will with would write written you your""",
    )
)
"""Words that say nothing of what is meant."""
_HEADING, _HINT = 6, 4
"""What a word counts in a heading or among the words that serve the search, against once in the text."""
_REFUSED, _ASIDE = 0.4, {"changelog": 0.3, "contributing": 0.75}
"""What a word counts in a list of refusals, and in topics that are not for those who ask, against anywhere else."""
_FLAT, _LONG = 1.5, 0.6
"""Constants of Okapi's weighting (BM25): how soon more of a word counts no more, and how much length counts."""


class Index:
    """Sections by their words; Okapi's BM25."""

    def __init__(self, sections: Iterable[Section]) -> None:
        self.sections = tuple(sections)
        self.counts = [_counted(section) for section in self.sections]
        self.lengths = [sum(count.values()) for count in self.counts]
        self.mean = sum(self.lengths) / max(1, len(self.lengths))
        self.spread = Counter(word for count in self.counts for word in count)
        self.pairs = [_pairs(section.text) for section in self.sections]
        self.pair_spread = Counter(pair for one in self.pairs for pair in one)

    def hits(self, asked: str) -> tuple[Section, ...]:
        """Sections with any of the words, the best first."""
        words = dict.fromkeys(words_of(asked))
        pairs = _pairs(asked)
        scores = [
            sum(self._score(k, word) for word in words)
            + sum(self._rare(self.pair_spread[one]) for one in pairs & there)
            for k, there in enumerate(self.pairs)
        ]
        scores = [_ASIDE.get(section.topic, 1.0) * score for section, score in zip(self.sections, scores, strict=True)]
        order = sorted(range(len(scores)), key=lambda k: (-scores[k], k))
        return tuple(self.sections[k] for k in order if scores[k] > 0.0)

    def _score(self, k: int, word: str) -> float:
        count = self.counts[k][word]
        if not count:
            return 0.0
        rare = self._rare(self.spread[word])
        longer = 1.0 - _LONG + _LONG * self.lengths[k] / self.mean
        rare *= _REFUSED if self.sections[k].heading.startswith("Refused") else 1.0
        return rare * count * (_FLAT + 1.0) / (count + _FLAT * longer)

    def _rare(self, spread: int) -> float:
        """What a word counts that stands in so many sections."""
        return math.log(1.0 + (len(self.sections) - spread + 0.5) / (spread + 0.5))


def words_of(text: str) -> list[str]:
    """The words of a text that say something, without their endings; a name in one piece and in its parts."""
    found = []
    for word in re.findall(r"[^\W_]+(?:[_-][^\W_]+)*", text.lower()):
        parts = re.split(r"[_-]", word)
        found += [_stem(fromkey) for fromkey in dict.fromkeys([word.replace("-", "_"), *parts]) if fromkey not in IDLE]
    return found


def _stem(word: str) -> str:
    if len(word) > 4 and word.endswith("ies"):
        return f"{word[:-3]}y"
    return word[:-1] if len(word) > 3 and word.endswith("s") and word[-2] not in "su" else word


def _pairs(text: str) -> set[tuple[str, str]]:
    """Words that follow one another, idle ones too: what is asked in the words of a message is found by them."""
    return {pair for pair in pairwise(re.findall(r"[^\W_]+", text.lower())) if not IDLE.issuperset(pair)}


def _counted(section: Section) -> Counter[str]:
    counts = Counter(words_of(section.text))
    for text, weight in ((section.heading, _HEADING), (section.topic, _HEADING // 2), (section.words, _HINT)):
        for word in words_of(text):
            counts[word] += weight
    return counts
