"""Answers a scene: chooses a method, solves, and has the result certified."""

from vibopt.solve.solve import solve

__all__ = ["solve"]
