"""Values as a problem file writes them: a fact, a choice, a span of speeds."""

from vibopt.values.fields import Choice, Fact, Table, Tolerance, Value, number, rule_of, word
from vibopt.values.speeds import SpeedRange, read_speeds

__all__ = ["Choice", "Fact", "SpeedRange", "Table", "Tolerance", "Value", "number", "read_speeds", "rule_of", "word"]
