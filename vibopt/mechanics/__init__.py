"""Mechanical models at a given design: matrices, motion, modes, exact peaks."""
