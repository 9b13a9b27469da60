"""The words that tables of a machine know in Python, each as its key in a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypedDict

from vibopt.scene.language.limit import Bound, Given, Way


class BodyWords(TypedDict, total=False):
    """Keys of `[bodies.NAME]`: mass [kg], or weight on earth [N]; inertia [kg m^2] or disc of one that turns.

    disc
        {"mass": ..., "diameter": ...}.
    rolling
        {"inertia": ..., "radius": ...} of a body that rolls as it moves.
    geared_to, speed_ratio
        Body whose teeth turn this one, and how many times as fast it turns, below zero the other way.
    motion, centre, shape, made_of
        In space: "space", "plane" or "line"; centre of mass; {"box": [a, b, c]} or {"cylinder": {...}}; pieces with
        mass, centre and inertia or shape.  Inertia is then a list of three, or a table of a tensor.
    centre_tolerance
        How far the centre of mass may be off [m]: one length, or three along x, y, z.
    """

    mass: Given
    weight: Bound
    inertia: Given | Sequence[Bound]
    disc: Mapping[str, Bound]
    rolling: Mapping[str, Bound]
    geared_to: str
    speed_ratio: float
    tolerance: Bound
    motion: str
    centre: Sequence[Bound]
    centre_tolerance: Bound | Sequence[Bound]
    shape: Mapping[str, object]
    made_of: Sequence[Mapping[str, object]]


class LinkWords(TypedDict, total=False):
    """Keys of `[links.NAME]`; values are those of one single mount, or of one single shaft.

    shaft
        {"length": ..., "diameter": ..., "shear_modulus": ...}, and inner_diameter or inner_ratio.
    beam
        {"kind": ..., "length": ..., "modulus": ...}, at, and second_moment, diameter, or width and height.
    part
        {"catalogue": "mounts.csv"}, and name or only.
    """

    stiffness: Given
    torsional_stiffness: Given
    shaft: Mapping[str, object]
    beam: Mapping[str, Bound]
    damping: Given
    torsional_damping: Given
    damping_ratio: Given
    relative_to: str
    loss_factor: Given
    rotating_damping: Given
    rotating_damping_ratio: Given
    friction_force: Given
    count: Given
    dynamic_to_static: Bound
    tolerance: Bound
    part: Mapping[str, object]


class BearingWords(TypedDict, total=False):
    """Keys of `[bearings.NAME]`: stiffness and damping along y and z, what couples both, or a table over the speed.

    k_yy, k_yz, k_zy, k_zz
        [N/m].
    c_yy, c_yz, c_zy, c_zz
        [N s/m].
    table, tolerance
        Rows by speed, or a CSV file of them; how far each number may be off as built.
    squeeze_film
        {"clearance": ..., "length": ..., "diameter": ..., "viscosity": ...}.
    """

    k_yy: Given
    k_yz: Bound
    k_zy: Bound
    k_zz: Given
    c_yy: Given
    c_yz: Bound
    c_zy: Bound
    c_zz: Given
    table: Sequence[Mapping[str, object]] | str
    squeeze_film: Mapping[str, object]
    tolerance: Bound


class InerterWords(TypedDict, total=False):
    """Keys of `[inerters.NAME]`: force over relative acceleration, in one of three ways.

    inertance, torsional_inertance, mass_ratio
        [kg]; about an axis [kg m^2]; or over the mass of the body `relative_to`.
    at, direction
        In space: where it stands, and which way it acts.
    """

    inertance: Given
    torsional_inertance: Given
    mass_ratio: Given
    relative_to: str
    at: Sequence[Bound]
    direction: Way
    tolerance: Bound


class MountWords(TypedDict, total=False):
    """Keys of `[mounts.NAME]`; values are those of one mount.

    stiffness, damping
        Three along the own x, y, z; or one along its axis z, with shear_ratio for those across.
    direction, across
        Own z and own x: a letter or three numbers, or a list of them, one a mount.
    rating, gap
        Least and greatest static load, "500..3500 N"; how far it may move.
    shift
        How far all places move along "x", "y" and "z": lengths, or choose(...).
    tolerance, tolerance_of
        Of stiffness and damping; of the "group" (all alike) or of each "mount" by itself.
    """

    shift: Mapping[str, Given]
    stiffness: Given | Sequence[Given]
    shear_ratio: Given
    damping: Given | Sequence[Given]
    loss_factor: Given
    direction: Way | Sequence[Way]
    across: Way | Sequence[Way]
    dynamic_to_static: Bound
    rating: str
    gap: Bound
    tolerance: Bound
    tolerance_of: str
    part: Mapping[str, object]


class StructureWords(TypedDict, total=False):
    """Keys of `[structures.NAME]`: modes, or the names of matrix files.

    modes
        Tables of frequency, damping_ratio, modal_mass and shape (a value per point).
    mass, stiffness, damping, file
        Files with one matrix each (.mtx, .npz), or one .npz with M, K and C.
    points
        Coordinate number of each point, from 0.
    loss_factor
        Of the whole stiffness.
    """

    modes: Sequence[Mapping[str, object]]
    mass: str
    stiffness: str
    damping: str
    file: str
    points: Mapping[str, int]
    loss_factor: Bound


class RotorWords(TypedDict, total=False):
    """Keys of `[rotors.NAME]`: a shaft of sections, or by its matrices, that spins, with discs.

    sections
        Tables of length, diameter, inner_diameter or inner_ratio, from left to right.
    matrices
        Files of mass, stiffness, gyroscopic and damping; units, order and nodes.
    discs
        Tables of name, at, and mass, diametral, polar, or outer_diameter, inner_diameter, width, density.
    stations
        Place of each from the left end.
    modulus, density, poisson_ratio, shear_modulus, shear_coefficient
        Of the shaft; a Poisson's ratio of 0.3 and Cowper's coefficient without the last three.
    material_damping
        Time by which the stress of its material leads the strain, in the frame that turns with it [s].
    """

    sections: Sequence[Mapping[str, object]]
    matrices: Mapping[str, object]
    discs: Sequence[Mapping[str, object]]
    stations: Mapping[str, Bound]
    modulus: Bound
    density: Bound
    poisson_ratio: float
    shear_modulus: Bound
    shear_coefficient: float
    material_damping: Bound


class AbsorberWords(TypedDict, total=False):
    """Keys of `[absorbers.NAME]`: one way each to say mass, spring and damper.

    mass, mass_ratio, inertia, disc
        Mass [kg]; its ratio to the mass of what it sits on (or of `relative_to`); or, about an axis, [kg m^2].
    stiffness, frequency, tuning, length, torsional_stiffness, shaft
        Spring [N/m]; own frequency; own frequency over `tuning_to` or over natural frequency number `mode`
        without absorbers; length of a pendulum [m]; [N m/rad]; a shaft.
    damping, damping_ratio, loss_factor, torsional_damping
        Damper [N s/m]; of critical of its own mass; structural; [N m s/rad].
    at, direction
        In space: where it stands, and which way it slides.
    """

    at: Sequence[Bound]
    direction: Way
    mass: Given
    mass_ratio: Given
    relative_to: str
    inertia: Given
    disc: Mapping[str, Bound]
    stiffness: Given
    frequency: Given
    tuning: Given
    tuning_to: Bound
    mode: int
    length: Given
    torsional_stiffness: Given
    shaft: Mapping[str, object]
    damping: Given
    damping_ratio: Given
    loss_factor: Given
    torsional_damping: Given
    tolerance: Bound


class Varied(TypedDict, total=False):
    """How an amplitude varies away from its own speed: "constant", "speed", "speed^2" or rows [speed, factor]."""

    varies: str | Sequence[Sequence[Bound]]
    amplitude_at: str


class Acting(Varied, total=False):
    """In space: the place `at` and the `direction` of a force."""

    at: Sequence[Bound]
    direction: Way


class MomentWords(Varied, total=False):
    """In space: the `axis` of a moment."""

    axis: Way


class ForceWords(Acting, total=False):
    """How the speed rises or falls: `run_up`, a table of from, to, and acceleration or duration; how it `begins`."""

    run_up: Mapping[str, Bound]
    begins: str


class UnbalanceWords(TypedDict, total=False):
    """Unbalance [kg m], or a rotating mass [kg] and its radius [m]; run_up; also; in space `at`, and axis.

    also
        Further ones that turn with it: {"on": ..., "unbalance": ..., "angle": ...}.
    angles
        "any" where nobody knows at which angles these stand: the worst of all.
    grade, rotor_mass, service_speed
        Of a rotor, instead of its unbalance: its balance quality grade [m/s], and the mass [kg] and the speed that it
        counts.
    or_on
        Further stations and discs of a rotor where it may be, in any parts.
    """

    run_up: Mapping[str, Bound]
    at: Sequence[Bound]
    axis: Way
    direction: Way

    unbalance: Bound
    rotating_mass: Bound
    radius: Bound
    also: Sequence[Mapping[str, Bound]]
    angles: str
    grade: Bound
    rotor_mass: Bound
    service_speed: Bound
    or_on: Sequence[str]


class BaseMotionWords(Varied, total=False):
    """One of displacement [m], velocity [m/s] and acceleration [m/s^2], peak; `begins`; under mounts a direction."""

    direction: Way
    begins: str

    displacement: Bound
    velocity: Bound
    acceleration: Bound


class Directed(TypedDict, total=False):
    """In space: the place `at` and the `direction` of what comes once, or of noise; a base has a direction alone."""

    at: Sequence[Bound]
    direction: Way


class PulseWords(Directed, total=False):
    """Words of a pulse."""

    amplitude: Bound
    acceleration: Bound
    displacement: Bound
    duration: Bound
    duration_up_to: Bound
    duration_from: Bound
    frequency: Bound
    damping_ratio: Bound
    times: int
    every: Bound


class DropWords(TypedDict, total=False):
    """Words of a drop; in space its direction."""

    direction: Way
    height: Bound
    velocity_change: Bound
    rebound: Bound


class ReleaseWords(TypedDict, total=False):
    """Words of a release; in space its direction."""

    direction: Way
    displacement: Bound
    velocity: Bound


class RecordWords(Directed, total=False):
    """Words of a record."""

    column: str
    interval: Bound
    factor: Bound


class RoadWords(TypedDict, total=False):
    """Wavelength [m] or wavenumber [rad/m]."""

    wavelength: Bound
    wavenumber: Bound
