"""Bodies that are geared to others: a tree of what turns, and torques of teeth where they can be told."""

from __future__ import annotations

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene import places
from vibopt.scene.scene import Scene
from vibopt.scene.space import is_spatial


def check_gears(scene: Scene, mistakes: Mistakes) -> None:
    """Add what is wrong with bodies that are geared to others."""
    geared = {name: body.geared_to for name, body in scene.bodies.items() if body.geared_to is not None}
    for name, to in geared.items():
        path, known = ("bodies", name, "geared_to"), [one for one in places.raw(scene, "bodies") if one != name]
        if to == name:
            mistakes.value(path, to, "is the body itself. Name the one whose teeth turn it.")
        elif to not in known:
            mistakes.unknown_name(path, to, "other body", known)
        elif to in scene.bodies and not scene.bodies[to].turns:
            mistakes.value(path, to, "does not turn about its axis. Give it an inertia instead of its mass.")
        elif name in _above(scene, name):
            mistakes.value(
                path, to, f"is geared to {name} in turn. One body of a train of gears is geared to no other."
            )
    for link, ends in places.ends(scene).items():
        if ends[0] != ends[1] and places.gear_root(scene, ends[0]) == places.gear_root(scene, ends[1]):
            family = next(kind for kind, one, _ in places.devices(scene) if one == link)
            mistakes.value(
                (family, link, "between" if family != "absorbers" else "on"),
                list(ends),
                "joins two bodies of one train of gears, which turn as one already. Leave it out, or one of the gears.",
            )
    beside = next((name for name in places.raw(scene, "structures")), "a machine in space" * is_spatial(scene))
    if beside:
        mistakes.add(
            ("bodies", next(iter(geared)), "geared_to"),
            f"bodies.{next(iter(geared))} is geared beside {beside}. Gears are answered among bodies that turn about "
            "one axis. Leave the other out.",
        )


def gear_fault(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a response asks of gears what they have no number for; adds it."""
    geared = [name for name, body in scene.bodies.items() if body.geared_to is not None]
    if isinstance(response, HarmonicResponse) and response.rigid_link and geared:
        mistakes.add(
            path,
            f"{dotted(path)} asks for the {response.response}, which joins two bodies into one, beside "
            f"bodies.{geared[0]}, which is geared. Ask for the transmitted_moment with and without the link.",
        )
        return True
    of = vars(response)["of"] if response.response == "gear_torque" else ""
    if of not in geared:
        return False
    behind = {name for name in geared if of in (*_above(scene, name), name)}
    due = vars(response)["due_to"] or tuple(scene.excitations)
    shaker = next((name for name in due if name in scene.excitations and scene.excitations[name].on in behind), "")
    if not shaker:
        return False
    on, to = scene.excitations[shaker].on, scene.bodies[of].geared_to
    mistakes.add(
        path,
        f"{dotted(path)} asks for the gear_torque of {of}, which would have to balance excitations.{shaker} on {on} "
        f"as well. Write the gears the other way round, {to} geared to {of}, and ask of {to}; or put the excitation on "
        f"a body of its own that a shaft joins to {on}.",
    )
    return True


def _above(scene: Scene, name: str) -> list[str]:
    """The bodies that a body is geared to, one by one."""
    found: list[str] = []
    while (body := scene.bodies.get(name)) is not None and body.geared_to not in (None, *found):
        name = str(body.geared_to)
        found.append(name)
    return found
