"""Whole cold `vibopt solve` against the bare imports that any such tool pays for, in one run.

    python tests/bench/startup.py

Byte code is kept for all of them, as it is for installed packages.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
FILE = ROOT / "problems" / "isolation" / "rao_9_34.toml"
REPEATS = 15
LIMIT = 1.3
COMMANDS = {
    "vibopt solve rao_9_34.toml": ["-m", "vibopt", "solve", str(FILE)],
    "import casadi": ["-c", "import casadi"],
    "import pint, pydantic, click, rich": ["-c", "import pint, pydantic, click, rich"],
}


def timed(environment: dict[str, str]) -> dict[str, float]:
    """Least time of each command [s], run in turns."""
    best = dict.fromkeys(COMMANDS, float("inf"))
    for _ in range(REPEATS):
        for name, words in COMMANDS.items():
            begin = time.perf_counter()
            subprocess.run([sys.executable, *words], check=True, capture_output=True, cwd=ROOT, env=environment)
            best[name] = min(best[name], time.perf_counter() - begin)
    return best


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        best = timed({**kept, "PYTHONPYCACHEPREFIX": folder})
    for name, seconds in best.items():
        print(f"{name:36}{1e3 * seconds:7.0f} ms")
    whole, *parts = best.values()
    print(f"ratio {whole / sum(parts):.2f} (at most {LIMIT})")


if __name__ == "__main__":
    main()
