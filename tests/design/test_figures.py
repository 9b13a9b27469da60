"""Figures as files: readable by others, the same every time, without touching matplotlib's state."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from pictures import covered

from vibopt.report.curves import panels
from vibopt.report.design_plane import plane
from vibopt.report.figures import plane_figure, response_figure, saved, strips_figure
from vibopt.report.series import Line, Strip, Strips
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
from vibopt.solve import solve

Solved = Callable[[str], Design]


@pytest.mark.parametrize(("form", "magic"), [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_files_have_their_format_and_do_not_change(solved: Solved, form: str, magic: bytes) -> None:
    one, two = (saved(response_figure(panels(solved("rao_9_34")), "title"), form) for _ in range(2))
    assert one.startswith(magic)
    assert one == two


@pytest.mark.parametrize("name", ["rao_9_1", "rao_9_27", "rao_9_34", "rao_9_35", "rao_9_39", "rao_9_65"])
def test_labels_stay_on_the_paper_and_off_each_other(solved: Solved, name: str) -> None:
    from matplotlib.text import Annotation, Text

    figure = response_figure(panels(solved(name)))
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    found = [one for one in figure.findobj(Annotation) if one.get_text()]
    boxes = [Text.get_window_extent(one, renderer) for one in found]
    for index, box in enumerate(boxes):
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.width
        assert not any(box.overlaps(other) for other in boxes[:index])


@pytest.mark.parametrize("name", ["fan", "second_compressor_of_the_cold_store"])
@pytest.mark.parametrize("response", ["displacement", "isolation"])
def test_a_title_and_the_notes_on_its_panel_do_not_cover_each_other(name: str, response: str) -> None:
    """Short and long titles, one note to three."""
    place = {"into": "ground"} if response == "isolation" else {"of": "machine"}
    design = solve(from_dict({
        "title": "A machine with two loads",
        "bodies": {"machine": {"mass": "2 t"}, "floor": {"mass": "9 t"}},
        "links": {
            "feet": {"between": ["machine", "floor"], "stiffness": "2 MN/m", "damping": "4 kN s/m"},
            "slab": {"between": ["floor", "ground"], "stiffness": "40 MN/m", "damping": "60 kN s/m"},
        },
        "excitations": {
            "rotor": {"kind": "unbalance", "on": "machine", "unbalance": "0.1 kg m", "speed": "1470 rpm"},
            name: {"kind": "force", "on": "machine", "amplitude": "1 kN", "speed": "100 Hz"},
        },
        "measures": {"most": {"response": response, **place, **COUNTED[response]}},
    }))  # fmt: skip
    assert covered(response_figure(panels(design))) == []


COUNTED = {"displacement": {"combine": "sum"}, "isolation": {"due_to": ["rotor"]}}


def test_the_map_is_drawn(solved: Solved) -> None:
    drawn = plane(solved("rao_9_34"))
    assert drawn is not None
    ElementTree.fromstring(saved(plane_figure(drawn), "svg"))


def test_a_sweep_is_drawn_with_gaps_and_shaded_parts() -> None:
    x = np.array([1.0, 2.0, 3.0])
    strip = Strip("y [N]", (Line("y", np.array([np.nan, 1.0, 2.0])),))
    strips = Strips("t", "x [mm]", x, False, (strip,), ((1, 1.5, "no"),))
    text = saved(strips_figure(strips), "svg")
    ElementTree.fromstring(text)


def test_drawing_leaves_no_trace_in_matplotlib() -> None:
    program = (
        "import matplotlib\nbefore = matplotlib.rcParams.copy()\n"
        "from pathlib import Path\n"
        "from vibopt.scene.read import read\nfrom vibopt.solve import solve\n"
        "from vibopt.report.curves import panels\nfrom vibopt.report.figures import response_figure, saved\n"
        "design = solve(read(Path('problems/isolation/rao_9_36.toml')))\n"
        "saved(response_figure(panels(design)), 'svg')\n"
        "import sys\nassert 'matplotlib.pyplot' not in sys.modules\nassert matplotlib.rcParams.copy() == before\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True, cwd=Path(__file__).parents[2], timeout=120)
