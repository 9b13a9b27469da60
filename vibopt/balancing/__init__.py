"""Balancing: measured rotors by influence coefficients, known masses on a shaft, and reciprocating engines."""
