"""CasADi with IPOPT on sampled speeds: one run with exact second derivatives from a good start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vibopt.program.nlp import SampledProgram, Samples
from vibopt.program.program import Program
from vibopt.solve.method import Found, Progress
from vibopt.solve.rivals.claims import claimed, discrete
from vibopt.solve.rivals.sampled import SampledRows


@dataclass
class IpoptSampled:
    """One IPOPT run on the same smooth program as `nlp`, without measuring or adding speeds."""

    speeds: int = 200
    name: str = "ipopt_sampled"

    @property
    def summary(self) -> str:
        return f"CasADi with IPOPT, limits on {self.speeds} sampled speeds"

    def refuses(self, program: Program) -> str | None:
        """Discrete variables."""
        return discrete(self.name, program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Run it once, and pass on its flag."""
        rows = SampledRows(program, self.speeds)
        start = rows.start()
        samples = Samples(program).spread(self.speeds)
        nlp = SampledProgram(samples, np.exp(start), rows.low, rows.high)
        answer = nlp.solve(start, iterations=500)
        return claimed(self.name, program, answer.y, success=answer.claims, word=answer.word, speeds=self.speeds)
