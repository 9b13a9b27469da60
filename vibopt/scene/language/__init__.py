"""The Python twin of the problem file: the same words, read by the same door."""

from vibopt.scene.language.limit import Limit, Measure, choose, find_all, maximise, minimise, one_of
from vibopt.scene.language.python_machine import Machine

__all__ = ["Limit", "Machine", "Measure", "choose", "find_all", "maximise", "minimise", "one_of"]
