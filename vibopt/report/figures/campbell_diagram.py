"""A Campbell diagram: spin across, frequency of free whirl up, forward and backward, orders one and two."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.report.campbell import Campbell
from vibopt.report.figures.paper import (
    BLUE,
    FAINT,
    FREE,
    RED,
    SIZE,
    WIDTH,
    dress,
    label,
    laid_out,
    legend,
    place,
    sheet,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RPM, _HZ = 30.0 / np.pi, 0.5 / np.pi
_TOGETHER = 0.03
"""Part of the width within which critical speeds share a label."""


def campbell_figure(campbell: Campbell, title: str) -> Figure:
    """Lines of whirl, of one and two times the spin, dots at critical speeds, running speeds shaded."""
    figure = sheet(WIDTH, 4.8)
    axes: Any = figure.subplots()
    dress(
        axes,
        f"{title}: Campbell diagram" if title else "Campbell diagram",
        "spin [rpm]",
        "frequency of free whirl [Hz]",
    )
    rpm, top = campbell.spins * _RPM, campbell.top * _HZ
    for low, high in campbell.running:
        if high > low:
            axes.axvspan(low * _RPM, high * _RPM, color=FREE, lw=0.0, zorder=1, label="running speeds")
        else:
            axes.axvline(low * _RPM, color=FREE, lw=5.0, zorder=1, label="running speed")
    kinds = (("forward", campbell.forward, BLUE, "-"), ("backward", campbell.backward, RED, "--"))
    for way, table, colour, style in kinds:
        for line in table.T:
            if np.nanmin(line) * _HZ <= top:
                shown = {"marker": ".", "ms": 3.0, "lw": 0.0} if campbell.damped else {"ls": style, "lw": 1.5}
                axes.plot(rpm, line * _HZ, color=colour, zorder=3, label=f"{way} whirl", **shown)
    for order, style in ((1, "-"), (2, ":")):
        axes.plot(rpm, order * rpm / 60.0, style, color=FAINT, lw=1.0, zorder=2)
        at = min(rpm[-1], 60.0 * top / order)
        axes.annotate(f"{order}x", (at, order * at / 60.0), xytext=(-4, 3), textcoords="offset points", ha="right",
                      fontsize=SIZE - 1, color=FAINT)  # fmt: skip
    marks = []
    for speeds, colour, way in ((campbell.critical, BLUE, "forward"), (campbell.against, RED, "backward")):
        for speed in speeds.tolist():
            axes.plot(speed * _RPM, speed * _HZ, "o", ms=6, mfc="white", mec=colour, mew=1.5, zorder=6,
                      label=f"critical speed, {way}")  # fmt: skip
    speeds, together = np.sort(np.concatenate([campbell.critical, campbell.against])), _TOGETHER * campbell.spins[-1]
    for some in np.split(speeds, np.flatnonzero(np.diff(speeds) > together) + 1) if len(speeds) else ():
        words, middle = ", ".join(f"{round(float(f'{speed * _RPM:.4g}')):d}" for speed in some), float(some.mean())
        marks.append(label(axes, f"{words} rpm", middle * _RPM, middle * _HZ))
    axes.set_xlim(0.0, float(rpm[-1]))
    axes.set_ylim(0.0, top)
    legend(figure, axes)
    laid_out(figure)
    every = [np.column_stack([rpm, line * _HZ]) for table in (campbell.forward, campbell.backward) for line in table.T]
    points = np.concatenate([*every, np.column_stack([rpm, rpm / 60.0])])
    place(marks, axes.transData.transform(points[np.isfinite(points).all(axis=1)]))
    return figure
