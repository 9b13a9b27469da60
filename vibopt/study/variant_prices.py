"""What the bought parts of variants cost, and which of the variants can be compared by it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from vibopt.answer.entry import Entry
from vibopt.devices.part import Part
from vibopt.report.machine_words import listed
from vibopt.responses.price import TotalPrice
from vibopt.scene.scene import Design, Scene
from vibopt.verify.certify import measure
from vibopt.verify.checked import shown_value, usual_unit


def bought(scene: Scene) -> dict[str, Part]:
    """Parts from catalogues, chosen or fixed, by the path of what they are bought for: "links.feet"."""
    parts = {f"links.{name}": one.part for name, one in scene.links.items()}
    parts |= {f"mounts.{name}": one.part for name, one in scene.mounts.items()}
    return {path: one for path, one in parts.items() if one is not None}


def price_of(design: Design, chosen: Mapping[str, float]) -> Entry | None:
    """What all bought parts cost together; None where nothing is bought, or a catalogue has no prices."""
    parts = bought(design.scene)
    if not parts or any(one.price is None for one in parts.values()):
        return None
    response = TotalPrice(response="price")
    return shown_value(response, measure(design.scene, chosen, response).value, usual_unit(design.scene, response))


def price_words(price: Entry, design: Design, designs: Sequence[Design]) -> str:
    """The price, and what of that which other variants buy it does not hold: "80 EUR without feet"."""
    missing = _not_bought(design, designs)
    return f"{price.shown} without {listed(missing)}" if missing else price.shown


def comparable(designs: Sequence[Design]) -> list[bool]:
    """Per variant whether its price is that of everything that any variant buys, all in one currency."""
    currencies = {one.price.unit for each in designs for one in bought(each.scene).values() if one.price is not None}
    return [len(currencies) == 1 and bool(bought(one.scene)) and not _not_bought(one, designs) for one in designs]


def _not_bought(design: Design, designs: Sequence[Design]) -> list[str]:
    """Names of what is made to order here and bought in another variant."""
    scene, mine = design.scene, bought(design.scene)
    own = [f"links.{name}" for name in scene.links] + [f"mounts.{name}" for name in scene.mounts]
    others = dict.fromkeys(path for one in designs for path in bought(one.scene))
    return [path.split(".", 1)[1] for path in others if path in own and path not in mine]


__all__ = ["bought", "comparable", "price_of", "price_words"]
