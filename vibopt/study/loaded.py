"""What an answer needs, loaded once: a process that has imported this file is what others are forked from."""

from importlib import import_module

for _name in ("balancing.engine", "balancing.known", "balancing.solve_rotor", "solve", "study.archive", "study.prices"):
    import_module(f"vibopt.{_name}")
