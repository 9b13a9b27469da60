"""Absorbers in the charts."""
