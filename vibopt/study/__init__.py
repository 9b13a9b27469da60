"""Studies on top of single answers: what-if, sweeps, prices, charts, records.

Each is imported from its own file, so that one verb does not load the others.
"""
