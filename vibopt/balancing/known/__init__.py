"""Known masses on a shaft: static and couple unbalance, reactions of the bearings, and corrections in given planes."""

from vibopt.balancing.known.answer import solve_known
from vibopt.balancing.known.job import KnownJob, read_known

__all__ = ["KnownJob", "read_known", "solve_known"]
