"""Whole cold `vibopt solve` against the bare imports that any such tool pays for, in one run, in CPU time.

    python tests/bench/startup.py

Byte code is kept for both, as it is for installed packages.  A first model of pydantic belongs to its import: only
then does it look for plugins.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
FILE = ROOT / "problems" / "isolation" / "rao_9_34.toml"
REPEATS = 15
LIMIT = 1.3
IMPORTS = """
import click, numpy, tomllib
from pydantic import BaseModel
class Table(BaseModel):
    value: float
Table(value=1.0)
"""
COMMANDS = {
    "vibopt solve rao_9_34.toml": ["-m", "vibopt", "solve", str(FILE)],
    "numpy, pydantic, click": ["-c", IMPORTS],
}


def timed(environment: dict[str, str]) -> dict[str, float]:
    """Least time of each command [s], run in turns."""
    best = dict.fromkeys(COMMANDS, float("inf"))
    for _ in range(REPEATS):
        for name, words in COMMANDS.items():
            begin = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, *words], check=True, capture_output=True, cwd=ROOT, env=environment)
            end = resource.getrusage(resource.RUSAGE_CHILDREN)
            best[name] = min(best[name], end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)
    return best


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        best = timed({**kept, "PYTHONPYCACHEPREFIX": folder})
    for name, seconds in best.items():
        print(f"{name:36}{1e3 * seconds:7.0f} ms")
    whole, imports = best.values()
    print(f"ratio {whole / imports:.2f} (at most {LIMIT})")


if __name__ == "__main__":
    main()
