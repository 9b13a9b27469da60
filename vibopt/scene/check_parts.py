"""Mistakes about parts of catalogues that only show when the scene is seen as a whole."""

from __future__ import annotations

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import Response
from vibopt.scene import places
from vibopt.scene.scene import Scene


def check_price(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> None:
    """A price is asked for only where every part has one, all in one currency."""
    if not response.priced:
        return
    tables = {f"links.{name}": link.part for name, link in scene.links.items()}
    tables |= {f"mounts.{name}": mount.part for name, mount in scene.mounts.items()}
    bought = {path: part for path, part in tables.items() if part is not None}
    if not bought and any("part" in table for one in ("links", "mounts") for table in places.raw(scene, one).values()):
        return  # said where the part is
    if not bought:
        mistakes.add(
            path,
            f"{dotted(path)} asks for a price, but nothing is bought. Give a link its part = {{ catalogue = "
            '"mounts.csv" }.',
        )
        return
    units = {}
    for name, part in bought.items():
        if part.price is None:
            mistakes.add(
                path,
                f"{dotted(path)} asks for a price, but {part.catalogue.name}, from which {name} is bought, has "
                'none. Add a column "price [EUR]".',
            )
            return
        units[name] = part.price.unit
    for key in ("at_most", "at_least"):
        given = getattr(response, key)
        if given is not None:
            units[f"{dotted(path)}.{key}"] = given.unit
    _one_currency(path, units, mistakes)


def _one_currency(path: Path, units: dict[str, str], mistakes: Mistakes) -> None:
    (first, unit), *rest = units.items()
    for other, another in rest:
        if another != unit:
            mistakes.add(
                path,
                f"{other} is in {another}, but {first} is in {unit}. Nothing is exchanged: write all prices in one "
                "currency.",
            )
            return


__all__ = ["check_price"]
