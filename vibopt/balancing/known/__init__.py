"""Known masses on a shaft: static and couple unbalance, reactions of the bearings, and corrections in given planes."""

from vibopt.balancing.known.known_answer import solve_known
from vibopt.balancing.known.known_job import KnownJob, read_known

__all__ = ["KnownJob", "read_known", "solve_known"]
