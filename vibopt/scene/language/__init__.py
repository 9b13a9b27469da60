"""The Python twin of the problem file: the same words, read by the same door."""

from vibopt.scene.language.limit import Limit, Measure
from vibopt.scene.language.machine import Machine
from vibopt.scene.language.words import choose, find_all, maximise, minimise, one_of

__all__ = ["Limit", "Machine", "Measure", "choose", "find_all", "maximise", "minimise", "one_of"]
