"""What happens in one instant: a velocity or a place is changed, and nothing acts behind it."""

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Transient
from vibopt.excitations.segments import AFTER


class AtOnce(Transient):
    """An excitation that is over as soon as it has come."""

    @property
    def length(self) -> float:
        return AFTER

    @property
    def joints(self) -> tuple[float, ...]:
        return (0.0, AFTER)

    def signal(self, time: FloatArray) -> FloatArray:
        return np.zeros(time.shape)
