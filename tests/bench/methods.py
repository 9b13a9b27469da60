"""Time of every method over that of the default, and its true error, on scenes whose answer is known.

    python tests/bench/methods.py [--quick]

The same as `vibopt chart speed-accuracy`, as one line per scene and method: ratio of times in this run, true error,
and what is wrong with the claim.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from vibopt.charts.runner import speed_accuracy


def main(quick: bool) -> None:
    """Print the table."""
    result = speed_accuracy(quick=quick)
    for case in result.cases:
        for one in result.of(case.name):
            ratio, error = result.ratio(one), one.error
            print(f"{case.name:32} {one.method:20} {ratio:10.3g} {error:10.1e}  {one.fault or one.status}")


if __name__ == "__main__":
    main("--quick" in sys.argv)
