"""Reciprocating engines: shaking forces and couples, counterweights, balance shafts, crank phasing and firing order."""

from vibopt.balancing.engine.engine_answer import solve_engine
from vibopt.balancing.engine.engine_job import EngineJob, read_engine

__all__ = ["EngineJob", "read_engine", "solve_engine"]
