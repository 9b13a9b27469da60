"""Values as a problem file writes them: a fact, a choice, a span of speeds."""

from vibopt.values.fields import Choice, Fact, Table, Value, number, rule_of, word
from vibopt.values.speeds import SpeedRange, read_speeds
from vibopt.values.tolerance import Tolerance

__all__ = ["Choice", "Fact", "SpeedRange", "Table", "Tolerance", "Value", "number", "read_speeds", "rule_of", "word"]
