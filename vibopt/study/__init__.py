"""Studies on top of single answers: what-if, sweeps, prices, charts, records."""

from vibopt.study.sweep import sweep
from vibopt.study.whatif import whatif

__all__ = ["sweep", "whatif"]
