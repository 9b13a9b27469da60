"""What vibopt says about wrong machines in space, word for word."""

import copy
from collections.abc import Callable
from typing import Any

import pytest

from refusals import refused
from vibopt.scene.read import from_dict

Edit = Callable[[dict[str, Any]], object]
GOOD: dict[str, Any] = {
    "title": "box",
    "bodies": {
        "box": {
            "mass": "1850 kg",
            "centre": ["0 m", "0 m", "0.45 m"],
            "inertia": ["310 kg m2", "620 kg m2", "590 kg m2"],
        }
    },
    "mounts": {
        "foot": {
            "between": ["box", "ground"],
            "at": [[f"{x} m", f"{y} m", "0 m"] for x in (0.85, -0.85) for y in (0.4, -0.4)],
            "stiffness": "1 MN/m",
            "shear_ratio": 0.55,
            "damping": "3 kN s/m",
        }
    },
    "excitations": {
        "shaker": {"kind": "force", "on": "box", "direction": "z", "amplitude": "2 kN", "speed": "1500 rpm"}
    },
    "measures": {"mode": {"response": "natural_frequency"}},
}


def box(**words: Any) -> Edit:
    """Change the body."""
    return lambda document: document["bodies"]["box"].update(words)


def foot(**words: Any) -> Edit:
    """Change the mounts."""
    return lambda document: document["mounts"]["foot"].update(words)


def asks(**words: Any) -> Edit:
    """Ask something else."""
    return lambda document: document["measures"].update(asked=words)


def shaken(**words: Any) -> Edit:
    """Shake in another way."""
    return lambda document: document["excitations"].update(shaker=words)


def slides(
    measure: dict[str, Any] | None = None, force: dict[str, Any] | None = None, link: str = "", plane: bool = False,
    **words: Any,
) -> Edit:  # fmt: skip
    """Put an absorber on the body, beside a floor, a disc and a point; a key that is None is left out."""

    def edit(document: dict[str, Any]) -> None:
        table = {"on": "box", "direction": "z", "mass": "1 kg", "frequency": "10 Hz", **words}
        document["absorbers"] = {"tmd": {key: value for key, value in table.items() if value is not None}}
        document["points"] = {"lid": {"on": "box", "at": ["0 m", "0 m", "1 m"]}}
        document["bodies"] |= {"floor": {"mass": "2 t"}, "disc": {"inertia": "2 kg m2"}}
        shaft = {"between": ["disc", "ground"], "torsional_stiffness": "1 kN m/rad"}
        document["links"] = {"slab": {"between": ["floor", "ground"], "stiffness": "1 MN/m"}, "shaft": shaft}
        if plane:
            box(motion="plane", inertia="620 kg m2")(document)
        if link == "links":
            document["links"]["arm"] = {"between": ["tmd", "ground"], "stiffness": "1 MN/m"}
        elif link:
            stands = {"at": ["0 m", "0 m", "1 m"], "direction": "z"}
            document[link] = {"arm": {"between": ["tmd", "ground"], "inertance": "3 kg", **stands}}
        document["excitations"]["shaker"] = force or document["excitations"]["shaker"]
        document["measures"] |= {"asked": {**measure, **HEARD.get(measure["response"], {})}} if measure else {}

    return edit


HEARD = {key: {"at": "1500 rpm"} for key in ("twist", "transmitted_force", "displacement")}
"""How a vibration is asked for."""
CASES: list[tuple[Edit, str]] = [
    (
        box(inertia=["310 kg m2", "620 kg m2", "990 kg m2"]),
        'box.toml: bodies.box.inertia = ["310 kg m2", "620 kg m2", "990 kg m2"] is no inertia of a '
        "body: the greatest principal moment, 990 kg m² about the axis z, is more than the other two "
        "together, 310 and 620 kg m². Check the three values and their units.",
    ),
    (
        box(inertia={"xx": "300 kg m2", "yy": "600 kg m2", "zz": "590 kg m2", "xy": "500 kg m2"}),
        'box.toml: bodies.box.inertia = { xx = "300 kg m2", yy = "600 kg m2", zz = "590 kg m2", xy = '
        '"500 kg m2" } is no inertia of a body: about the axis (0.802, 0.597, 0) it would be -72.02 '
        "kg m². Check the products of inertia and their signs: xy is the integral of x y dm.",
    ),
    (
        box(inertia=["0 kg m2", "620 kg m2", "620 kg m2"]),
        'box.toml: bodies.box.inertia = ["0 kg m2", "620 kg m2", "620 kg m2"] is zero about the axis '
        'x, but a body in space turns there as well. Write its real inertia, or motion = "plane".',
    ),
    (
        box(inertia=["310 kg m2", "620 kg m2"]),
        'box.toml: bodies.box.inertia = ["310 kg m2", "620 kg m2"] is no list of three moments of '
        'inertia. Write those about x, y, z: ["310 kg m2", "620 kg m2", "590 kg m2"].',
    ),
    (
        box(inertia={"xx": "300 kg m2", "yy": "600 kg m2"}),
        'box.toml: bodies.box.inertia = { xx = "300 kg m2", yy = "600 kg m2" } has no zz. Write xx, '
        "yy and zz; products xy, yz, zx are zero where left out.",
    ),
    (
        box(inertia={"Izz": "590 kg m2", "Ixx": "310 kg m2", "Iyy": "620 kg m2"}),
        'box.toml: bodies.box.inertia = { Izz = "590 kg m2", Ixx = "310 kg m2", Iyy = "620 kg m2" } is no choice, nor '
        'a tensor by its components. Write the moments about x, y, z, ["310 kg m2", "620 kg m2", "590 kg m2"], or '
        '{ xx = "...", yy = "...", zz = "..." } with products xy, yz, zx.',
    ),
    (
        box(inertia={"z": "59 kg m2"}),
        'box.toml: bodies.box.inertia = { z = "59 kg m2" } is no choice, nor a tensor by its components. Write the '
        'moments about x, y, z, ["310 kg m2", "620 kg m2", "590 kg m2"], or { xx = "...", yy = "...", zz = "..." } '
        "with products xy, yz, zx.",
    ),
    (
        box(inertia=["-310 kg m2", "620 kg m2", "590 kg m2"]),
        'box.toml: bodies.box.inertia = ["-310 kg m2", "620 kg m2", "590 kg m2"] has a negative '
        "moment of inertia about x. Write a positive value.",
    ),
    (
        box(inertia=["310 kg", "620 kg m2", "590 kg m2"]),
        'box.toml: bodies.box.inertia = ["310 kg", "620 kg m2", "590 kg m2"] has a wrong x: "310 kg" '
        "is a mass, but a moment of inertia is needed here. Write a moment of inertia, for example "
        '"0.8 kg m²".',
    ),
    (
        box(inertia=None, motion="space"),
        "box.toml: bodies.box moves in a way that needs one of inertia and shape. Write inertia = "
        '["310 kg m2", "620 kg m2", "590 kg m2"].',
    ),
    (
        box(inertia="310 kg m2", motion="space"),
        "box.toml: bodies.box moves in space, but its inertia is one value. Write those about x, y, "
        'z: inertia = ["310 kg m2", "620 kg m2", "590 kg m2"].',
    ),
    (
        box(centre=["0 m", "0 m"]),
        'box.toml: bodies.box.centre = ["0 m", "0 m"] is no place. Write its three coordinates, for '
        'example ["0.8 m", "0.4 m", "0 m"].',
    ),
    (
        box(centre=["0 m", "0 m", "3 kg"]),
        'box.toml: bodies.box.centre = ["0 m", "0 m", "3 kg"] has a wrong z: "3 kg" is a mass, but a '
        'length is needed here. Write a length, for example "20 mm".',
    ),
    (
        box(inertia=["310 kg m2", {"to": "620 kg m2"}, "590 kg m2"]),
        'box.toml: bodies.box.inertia = ["310 kg m2", { to = "620 kg m2" }, "590 kg m2"] has a wrong y: { to = '
        '"620 kg m2" } is no value with a unit, but a moment of inertia is needed here. Write a moment of inertia, '
        'for example "0.8 kg m²".',
    ),
    (
        box(motion="3d"),
        'box.toml: bodies.box.motion = "3d" is no motion that vibopt knows. Write "space", "plane" '
        '(x, z and the turn about y) or "line".',
    ),
    (
        box(centre=["1.2 m", "0 m", "0.45 m"]),
        "box.toml: the centre of mass of bodies.box lies outside its mounts: foot.3 is lifted with "
        "1.868 kN. Place a mount beyond it; or, for a mount that may pull, ask for response = "
        '"static_load" of foot.',
    ),
    (
        foot(at=[["0.85 m", "0 m", "0 m"], ["-0.85 m", "0 m", "0 m"]]),
        "box.toml: nothing holds bodies.box against turning about x: its mounts stand in one line. "
        'Place a mount beside, or write motion = "plane" or "line" where it cannot move that way.',
    ),
    (
        foot(at=["0.85 m", "0 m", "0 m"]),
        "box.toml: nothing holds bodies.box against turning about (0.989, 0, -0.149): it has one "
        'mount only. Place a mount beside, or write motion = "plane" or "line" where it cannot move '
        "that way.",
    ),
    (
        foot(shear_ratio=None),
        "box.toml: mounts.foot has one stiffness, that along its axis: how stiff is it across? Add "
        "shear_ratio = 0.5 (across over along), or write three values: stiffness = [x, y, z].",
    ),
    (
        foot(rating="-500..3000 N"),
        'box.toml: mounts.foot.rating = "-500..3000 N" is negative: a mount is rated for loads that '
        'press on it. Write "500..3500 N".',
    ),
    (
        foot(rating="3000 N"),
        'box.toml: mounts.foot.rating = "3000 N" is no range of loads. Write "500..3500 N".',
    ),
    (
        foot(damping_ratio=0.1),
        "box.toml: mounts.foot has a damping_ratio, but a machine in space has a mass and three "
        'inertias: relative to what? Write damping = "2 kN s/m", or loss_factor = 0.1.',
    ),
    (
        foot(at=[{"from": "1 m", "to": "0.1 m"}, "0 m", "0 m"]),
        'box.toml: mounts.foot.at = [{ from = "1 m", to = "0.1 m" }, "0 m", "0 m"] has a reversed range for its x: '
        "from is greater than to. Exchange the two.",
    ),
    (
        foot(at=[["0.85 m", "0 m", "0 m"], ["0.85 m", "0 m", "0 m"]]),
        'box.toml: mounts.foot.at = [["0.85 m", "0 m", "0 m"], ["0.85 m", "0 m", "0 m"]] names a '
        "place twice. Give each mount a place of its own.",
    ),
    (
        foot(between=["bocks", "ground"]),
        'box.toml: mounts.foot.between = "bocks" names no body, base or ground of this scene. Known: box, ground.',
    ),
    (
        foot(direction=["z", "z"]),
        "box.toml: mounts.foot has 4 places but 2 values of direction. Give one for all, or one for each.",
    ),
    (
        shaken(kind="force", on="box", amplitude="2 kN", speed="25 Hz"),
        'box.toml: excitations.shaker acts on box, which moves in space, but in no direction. Add direction = "z".',
    ),
    (
        shaken(kind="force", on="box", amplitude="2 kN", speed="25 Hz", direction="up"),
        'box.toml: excitations.shaker.direction = "up" is no direction. Write "x", "y", "z" or three '
        "numbers, for example [0.5, 0, 0.866].",
    ),
    (
        shaken(kind="force", on="box", amplitude="2 kN", speed="25 Hz", direction=[0, 0, 0]),
        'box.toml: excitations.shaker.direction = [0, 0, 0] points nowhere. Write "x", "y", "z" or '
        "three numbers, for example [0.5, 0, 0.866].",
    ),
    (
        shaken(kind="unbalance", on="box", unbalance="2 g m", speed="25 Hz"),
        "box.toml: excitations.shaker acts on box, which moves in space, but in no direction. Add "
        'direction = "z", or axis = "x" where it rotates about it.',
    ),
    *(
        (
            shaken(kind=kind, on="box", **shake, speed="25 Hz", **way),
            f'box.toml: excitations.shaker.{where} = "{given}" is a {what}. For {what}s write kind = "{instead}".',
        )
        for kind, what, given, instead, way in (
            ("force", "moment", "3 N m", "moment", {"direction": "z"}),
            ("moment", "force", "2 kN", "force", {"axis": "z"}),
            ("harmonics", "moment", "3 N m", "moment_harmonics", {"direction": "z"}),
            ("moment_harmonics", "force", "2 kN", "harmonics", {"axis": "z"}),
        )
        for where, shake in (
            [("harmonics[1].amplitude", {"harmonics": [{"order": 2, "amplitude": given}], "varies": "constant"})]
            if "harmonics" in kind
            else [("amplitude", {"amplitude": given})]
        )
    ),
    (
        shaken(kind="moment", on="box", amplitude="3 N m", speed="10 Hz"),
        'box.toml: excitations.shaker is a moment about no axis. Add axis = "x", or "y" or "z".',
    ),
    (
        shaken(kind="force", on="flange", amplitude="2 kN", speed="25 Hz", direction="z"),
        'box.toml: excitations.shaker.on = "flange" names no body of this scene. Known: box.',
    ),
    (
        shaken(kind="white_noise", on="box", density="1 N²/Hz"),
        'box.toml: excitations.shaker acts on box, which moves in space, but in no direction. Add direction = "z".',
    ),
    (
        lambda document: document.update(
            points={"eye": {"on": "box", "at": ["0 m", "0 m", "0.1 m"]}},
            excitations={"shaker": {"kind": "release", "on": "eye", "velocity": "1 m/s", "direction": "z"}},
        ),
        'box.toml: excitations.shaker releases a place. Release the body: on = "box".',
    ),
    (
        shaken(
            kind="unbalance",
            on="box",
            axis="y",
            unbalance="2 g m",
            speed="25 Hz",
            run_up={"from": "0 Hz", "to": "25 Hz", "acceleration": "1 Hz/s"},
        ),
        "box.toml: excitations.shaker goes round an axis and runs up, but in space a run-up is answered of a force "
        'along one direction, at a known rate. Write direction = "z" instead of axis.',
    ),
    (
        lambda document: document.update(points={"eye": {"on": "bix", "at": ["0 m", "0 m", "0 m"]}}),
        'box.toml: points.eye.on = "bix" names no body in space of this scene. Did you mean "box"?',
    ),
    (
        lambda document: document.update(links={"arm": {"between": ["box", "ground"], "stiffness": "1 MN/m"}}),
        "box.toml: links.arm ends at box, which moves in space, but it works along one line only. "
        "Write [mounts.NAME] with a place.",
    ),
    (
        lambda document: document.update(absorbers={"tmd": {"on": "box", "mass": "1 kg", "frequency": "10 Hz"}}),
        "box.toml: absorbers.tmd ends at box, which moves in space, but it works along one line only."
        ' Say which way it slides: direction = "z".',
    ),
    (
        slides(on="bix"),
        'box.toml: absorbers.tmd.on = "bix" names no body, absorber or point of a structure of this scene. Did you '
        'mean "box"?',
    ),
    (
        slides(direction=None, at=["0 m", "0 m", "1 m"]),
        'box.toml: absorbers.tmd has at, but no direction. Say which way it slides: direction = "z".',
    ),
    (
        slides(on="box", mass="2 t", at=["2 m", "0 m", "1 m"]),
        "box.toml: the centre of mass of bodies.box with its absorbers lies outside its mounts: foot.3 is lifted with "
        '2.098 kN. Place a mount beyond it; or, for a mount that may pull, ask for response = "static_load" of foot.',
    ),
    (
        slides(on="lid", at=["0 m", "0 m", "1 m"]),
        "box.toml: absorbers.tmd has at, but lid is a place already. Remove at, or name the body.",
    ),
    (
        slides(on="floor"),
        "box.toml: absorbers.tmd has a direction, but floor knows one line only. Remove direction.",
    ),
    (
        slides(on="disc"),
        'box.toml: absorbers.tmd.mass is along a line, but disc turns. Write inertia = "0.8 kg m2".\n'
        "box.toml: absorbers.tmd has a direction, but disc knows one axis only. Remove direction.",
    ),
    (
        slides(on={"one_of": ["lid", "floor"]}),
        "box.toml: absorbers.tmd.on is to be chosen, but there is no [goal] that says which place is best. Add [goal] "
        'with minimise = "displacement" and of = "BODY", for example.\n'
        "box.toml: absorbers.tmd has a direction, but floor knows one line only. Remove direction.",
    ),
    (
        slides(frequency=None, damping="1 kN s/m"),
        "box.toml: absorbers.tmd slides along a direction in space without a spring, so that nothing says where it "
        'rests. Give it a spring: frequency = "12 Hz", or a stiffness.',
    ),
    (
        slides(frequency=None, length="1 m"),
        "box.toml: absorbers.tmd has a direction, along which it slides, and length, which is of a pendulum. Write its "
        'frequency instead: frequency = "2 Hz".',
    ),
    (
        slides(mass=None, inertia="1 kg m2"),
        "box.toml: absorbers.tmd has a direction, along which it slides, and inertia, which is about an axis. Write "
        'mass = "20 kg".',
    ),
    (
        slides(frequency=None, tuning=1.0),
        "box.toml: absorbers.tmd.tuning = 1.0 has no frequency to refer to: without absorbers there are 8 natural "
        'frequencies. Add mode = 1, which is the lowest. Write tuning_to = "25 Hz", or the frequency of the absorber.',
    ),
    (
        slides(measure={"response": "tuning", "of": "tmd"}),
        "box.toml: measures.asked asks for the tuning of tmd, but it has no frequency to refer to: without absorbers "
        "there are 8 natural frequencies. Add mode = 1, which is the lowest. Ask for its own_frequency.",
    ),
    (
        slides(direction="y", plane=True),
        "box.toml: absorbers.tmd slides along y, but bodies.box moves in a plane: along x and z, and about y. Write "
        'direction = "x", or "z".',
    ),
    (
        slides(link="links"),
        "box.toml: links.arm ends at tmd, an absorber in space, on which only another absorber may sit. End it at box.",
    ),
    (
        slides(link="inerters"),
        "box.toml: inerters.arm ends at tmd, an absorber in space, on which only another absorber may sit. End it at "
        "box.",
    ),
    (
        slides(force={"kind": "force", "on": "tmd", "direction": "z", "amplitude": "2 kN", "speed": "1500 rpm"}),
        "box.toml: excitations.shaker acts on tmd, an absorber in space, which only its host moves. Act on box.",
    ),
    (
        slides(measure={"response": "transmitted_force", "into": "tmd", "direction": "z"}),
        'box.toml: measures.asked asks for the transmitted_force into tmd, an absorber. Write through = "tmd".',
    ),
    (
        slides(on="lid", measure={"response": "transmitted_force", "into": "box", "direction": "z"}),
        "box.toml: measures.asked asks for the transmitted_force into box, on which absorbers.tmd slides: its guide "
        'pushes beside the springs. Ask into what carries it, for example into = "ground", or through a mount.',
    ),
    (
        slides(measure={"response": "transmitted_force", "through": "tmd", "direction": "z"}),
        "box.toml: measures.asked has a direction, but tmd slides along its own. Remove direction.",
    ),
    (
        slides(measure={"response": "static_deflection", "of": "tmd", "direction": "z"}),
        "box.toml: measures.asked has a direction, but tmd slides along its own. Remove direction.",
    ),
    (
        slides(measure={"response": "displacement", "of": "tmd"}),
        'box.toml: measures.asked asks for the displacement of tmd in no direction. Add direction = "z", or "x" or '
        '"y".',
    ),
    (
        slides(measure={"response": "tilt", "of": "tmd", "axis": "x"}),
        "box.toml: measures.asked asks for the tilt of tmd, which is an absorber. Name a body in space.",
    ),
    (
        slides(measure={"response": "twist", "across": "tmd"}),
        "box.toml: measures.asked asks for the twist of tmd, which moves along a line. Write response = "
        '"relative_displacement".',
    ),
    (
        slides(measure={"response": "loss_factor", "of": "tmd"}),
        "box.toml: measures.asked asks for the loss_factor of tmd, but absorbers.tmd has no loss_factor. Add it, or "
        "ask for something else.",
    ),
    (
        asks(response="displacement", of="box"),
        "box.toml: measures.asked asks for the displacement of box in no direction. Add direction = "
        '"z", or "x" or "y".',
    ),
    (
        asks(response="displacement", of="flange", direction="z"),
        'box.toml: measures.asked.of = "flange" names no body of this scene. Known: box.',
    ),
    (
        asks(response="rotation", of="box"),
        'box.toml: measures.asked asks for the rotation of box about no axis. Add axis = "x", or "y" or "z".',
    ),
    (
        asks(response="transmitted_force", into="ground"),
        "box.toml: measures.asked asks for the transmitted_force into ground in no direction. Add "
        'direction = "z", or "x" or "y".',
    ),
    (
        asks(response="transmitted_force", through="foot"),
        'box.toml: measures.asked asks for the force through foot in no direction. Add direction = "z", or "x" or "y".',
    ),
    (
        asks(response="relative_displacement", across="foot"),
        "box.toml: measures.asked asks for the relative_displacement across foot. Write response = "
        '"travel" with of = "foot".',
    ),
    (
        asks(response="static_load", of="box"),
        'box.toml: measures.asked.of = "box" names no mount of this scene. Known: foot, foot.1, '
        "foot.2, foot.3, foot.4.",
    ),
    (
        asks(response="energy_share", of="box"),
        'box.toml: measures.asked needs either direction or axis: which motion of the body? Write direction = "z".',
    ),
    (
        asks(response="loss_factor", of="foot"),
        "box.toml: measures.asked asks for the loss_factor of foot, but mounts.foot has no loss_factor. Add it.",
    ),
    (
        asks(response="isolation", into="ground"),
        'box.toml: measures.asked: isolation has no direction. Write response = "transmitted_force" with a direction.',
    ),
    (
        asks(response="stiffness", of="foot.1"),
        "box.toml: measures.asked asks for the stiffness of one mount, but all of a group are alike. "
        'Write of = "foot".',
    ),
]


@pytest.mark.parametrize(("edit", "words"), CASES, ids=[words[:60] for _, words in CASES])
def test_message(edit: Edit, words: str) -> None:
    document = copy.deepcopy(GOOD)
    edit(document)
    for family in ("bodies", "mounts"):
        for table in document[family].values():
            for key in [key for key, value in table.items() if value is None]:
                del table[key]
    assert str(refused(from_dict, document, name="box.toml")) == words


@pytest.mark.parametrize(
    "shaker",
    [
        {"kind": "base_motion", "displacement": "1 mm", "speed": "5 Hz"},
        {"kind": "pulse", "shape": "half sine", "acceleration": "10 m/s2", "duration": "20 ms"},
        {"kind": "drop", "height": "5 mm"},
        {"kind": "white_noise", "density": "0.1 (m/s2)²/Hz"},
    ],
    ids=lambda shaker: shaker["kind"],
)
def test_a_base_below_what_moves_along_a_line_has_no_direction(shaker: dict[str, Any]) -> None:
    """It moved across that line, and every answer was nothing."""
    document: dict[str, Any] = {
        "bases": {"deck": {}},
        "bodies": {"floor": {"mass": "900 kg"}},
        "links": {"slab": {"between": ["floor", "deck"], "stiffness": "2 MN/m", "damping": "9 kN s/m"}},
        "excitations": {"shaker": {**shaker, "on": "deck", "direction": "x"}},
        "measures": {"own": {"response": "natural_frequency"}},
    }
    said = "excitations.shaker has a direction, but what stands on deck moves along one line only."
    assert str(refused(from_dict, document, name="hall.toml")) == f"hall.toml: {said} Remove direction."
    document["bodies"]["box"] = GOOD["bodies"]["box"]
    document["mounts"] = {name: {**table, "between": ["box", "floor"]} for name, table in GOOD["mounts"].items()}
    assert str(refused(from_dict, document, name="hall.toml")) == f'hall.toml: {said} Write direction = "z".'
    document["excitations"]["shaker"]["direction"] = "z"
    from_dict(document)
