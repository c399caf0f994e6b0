"""Lines of the cost summary: unknowns, terms of the equations, bytes of files, and requests to a scene."""

from __future__ import annotations

from pathlib import Path
from types import UnionType
from typing import Any, NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.preparation import prepare, responses_of
from toolkit.components.bodies.body import CENTRE, Body
from toolkit.components.bodies.model_body import DEPENDENCE, FRAME, ModelBody
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.rigid_joint import Tie
from toolkit.description.design import BodyPoint
from toolkit.foundation.errors import NoDerivativeError
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.reduced_model.file import PARTS, stored_bytes
from toolkit.reduced_model.frozen_basis import RICHER_PARTS
from toolkit.reduced_model.questions import mesh_record
from toolkit.responses.local_stress import LocalStress
from toolkit.responses.shape_error import ShapeResponse
from toolkit.responses.stress import StressResponse, model_parameter
from toolkit.scene.scene import Scene
from toolkit.scene.space import SPACES
from toolkit.solvers.start.initial_conditions import closed
from toolkit.system.quantities import pressures_of
from toolkit.system.solution import deforming
from toolkit.system.system import System


class CostLine(NamedTuple):
    """A line of the summary: how much of something is kept and dropped, in the unit of its section, and why."""

    what: str
    kept: int
    dropped: int = 0
    why: str = ""


def terms(system: System) -> list[CostLine]:
    """Lines for mass, stiffness, damping, terms of a rotating frame, weight, and loads."""
    numbers = {name: number for number, name in enumerate(system.scene.all_bodies())}
    flexible = {name: numbers[name] for name in deforming(system.scene)}
    rigid = [numbers[name] for name in rigid_bodies(system)]
    lines = [line for name, number in flexible.items() for line in _flexible(system, number, name)]
    if rigid:
        lines += _rigid(system, rigid)
    falls = bool(np.any(system.scene.gravity != 0))
    lines.append(CostLine("weight", system.n_q) if falls else CostLine("weight", 0, 0, "no gravity: zeros, one product each"))
    return [*lines, *(CostLine(f"load {name}", 1) for name, load in system.scene.loads.items() if load.kind != "gravity")]


def rigid_bodies(system: System) -> list[str]:
    """Names of the bodies that do not deform."""
    return [name for name, body in system.scene.bodies.items() if not isinstance(body, ModelBody)]


def _rigid(system: System, numbers: list[int]) -> list[CostLine]:
    """Lines for the mass and quadratic velocity of all rigid bodies.

    In the plane their mass is constant, in space only that of those that do not turn.
    """
    lines = [CostLine("mass of rigid bodies", sum(_filled(system.values.constant[number].mass) for number in numbers))]
    if system.scene.space.constant_rigid_mass:
        return [*lines, CostLine("quadratic velocity of rigid bodies", 0, 2 * len(numbers), "frame at the centre of mass")]
    turning = [system.values.floating[number] for number in numbers if number in system.values.floating]
    return [*lines, CostLine("mass and quadratic velocity of rigid bodies, turning", sum(part.entries for part in turning))]


def _flexible(system: System, number: int, name: str) -> list[CostLine]:
    part, body = system.values.constant[number], system.scene.body(name)
    damped = _filled(part.damping)
    zero = "" if damped else "zero damping: zeros next to the stiffness, one product each"
    elastic = [CostLine(f"stiffness of {name}", _filled(part.stiffness)), CostLine(f"damping of {name}", damped, 0, zero)]
    turning = f"mass and quadratic velocity of {name}, turning"
    if number in system.values.floating:
        return [*elastic, CostLine(turning, frame_entries(system, body))]
    dropped = frame_entries(system, body.model_copy(update={"frame": "moving"}))
    mass = CostLine(f"mass of {name}, constant", _filled(part.mass))
    return [
        mass,
        *elastic,
        CostLine(turning, 0, dropped, f"{frame_of(body)} frame, no rotation: the mass matrix is constant, no velocity enters"),
    ]


def frame_of(body: Body) -> str:
    """Word for what the frame of a flexible body does, as the scene writes it; empty for other bodies."""
    return str(getattr(body, "frame", ""))


def frame_entries(system: System, body: Body) -> int:
    """Entries of the invariants of a body with a moving frame."""
    part = body.floating(system.scene)
    return 0 if part is None else part.entries


def _filled(values: np.ndarray) -> int:
    return int(np.count_nonzero(values))


def grounded_bodies(scene: Scene) -> dict[str, ModelBody]:
    """Flexible bodies whose frame has no coordinates."""
    bodies = {name: body for name, body in scene.bodies.items() if isinstance(body, ModelBody)}
    return {name: body for name, body in bodies.items() if not body.has_frame and not body.parted}


def with_frames(scene: Scene) -> Scene:
    """Scene with the frames of its grounded bodies: they may move, and a rigid joint to the ground holds each where it was.

    Frames in space that only turn, or only move, stay what they are.
    """
    grounded = {f"frame of {name}": name for name in grounded_bodies(scene)}
    moving = {name: scene.bodies[name].model_copy(update={"frame": "moving"}) for name in grounded.values()}
    points = {point: BodyPoint(body=name, interface=FRAME) for point, name in grounded.items()}
    rigid = scene.space.kinds["joints"]["rigid"]
    joints = {point: rigid.model_validate({"bodies": (name, "ground"), "point": point}) for point, name in grounded.items()}
    return scene.model_copy(
        update={
            "points": {**scene.points, **points},
            "bodies": {**scene.bodies, **moving},
            "joints": {**scene.joints, **joints},
        }
    )


def prepare_everything(scene: Scene) -> System:
    """Compile a scene with all frames, all groups of its files, and the derivative blocks of all its numbers.

    Of these the joints exclude some: axes of a universal joint that have to stay at right angles, points of joints that repeat each other.
    By them the motion has no derivative, so that no program could keep it.
    """
    for body in scene.bodies.values():
        if isinstance(body, ModelBody):
            scene.model(body.model, *PARTS)
    whole, paths = with_frames(scene), scene.available_paths()
    while True:
        try:
            system = prepare(whole, paths)
            closed(system, *system.start()[::2], 0.0)
        except NoDerivativeError as error:
            paths = [path for path in paths if path not in error.variables]
        else:
            return system


IDLE = {
    "grounded": "it neither moves nor turns",
    "translating": "it does not turn",
    "turning": "it turns about one axis and does not move",
}
"""Reasons why frames of fewer coordinates lack the others: what they do not do."""


def coordinates(system: System) -> list[CostLine]:
    """Lines for the coordinates of each flexible body, and of all rigid ones."""
    scene, rigid = system.scene, rigid_bodies(system)
    bodies = deforming(scene)
    lines = [CostLine(name, len(body.coordinate_names(scene)), *_missing(body)) for name, body in bodies.items()]
    own = [scene.bodies[name] for name in rigid]
    kept, most = sum(body.frame_size for body in own), scene.space.frame_size * len(own)
    why = "frames that do not move, or do not turn about every axis" if kept < most else ""
    lines += [CostLine(f"{len(rigid)} rigid", kept, most - kept, why)] if rigid else []
    states = len(system.numbering.states)
    return [*lines, CostLine(f"{states} states of loads", states)] if states else lines


def _missing(body: Body) -> tuple[int, str]:
    """Number of coordinates that a flexible body's frame does not have, and why."""
    missing = SPACES[body.dimension].frame_size - body.frame_size
    return (missing, f"{frame_of(body)} frame: {IDLE[frame_of(body)]}") if missing else (0, "")


def rows(system: System) -> list[CostLine]:
    """Lines for the constraint rows of the joints by kind, and for those that would hold a grounded frame if it could move."""
    joints = list(system.scene.joints.values())
    kinds = {
        kind: [len(joint.row_names) for joint in joints if _kind(joint) == kind] for kind in dict.fromkeys(map(_kind, joints))
    }
    whole = system.scene.space.frame_size  # rows that hold a frame, a quaternion's length among them
    held = [
        CostLine(f"frame of {name}", 0, whole, "grounded frame: nothing has to hold it") for name in grounded_bodies(system.scene)
    ]
    lengths = len(system.numbering.length)
    quaternions = [CostLine(f"{lengths} lengths of quaternions", lengths)] if lengths else []
    return [*(CostLine(f"{len(sizes)} {kind}", sum(sizes)) for kind, sizes in kinds.items()), *quaternions, *held]


def _kind(joint: Joint) -> str:
    return "between parts of bodies" if isinstance(joint, Tie) else joint.kind


def matrix(system: System) -> list[CostLine]:
    """Lines for the entries of the Jacobian and of its factors."""
    entries, stored, n = len(system.plan.indices), int(system.lu_plan.row_start[-1]), system.n
    return [
        CostLine("Jacobian", entries, n * n - entries, "entries that no part of the scene fills"),
        CostLine("its factors", stored, n * n - stored, "entries that elimination in this order leaves zero"),
    ]


def multiplications(plan: LUPlan) -> tuple[int, int]:
    """Number of multiplications of one factorization, and of one solution of the factored equations.

        factorization: sum_k u_k^2 + u_k
        solution:      sum_k 2 u_k + 1

    with u_k entries of U in row k beside the diagonal.
    """
    upper = plan.row_start[1:] - plan.diagonal - 1
    return int(np.sum(upper**2 + upper)), int(np.sum(2 * upper + 1))


MOST_NAMES = 12
"""More variables than this are counted together."""


def derivative_blocks(system: System, scene: Scene) -> list[CostLine]:
    """Rows of the residual that each variable moves, and how many numbers of the scene, as it was written, have no block."""
    moved = np.bincount(system.plan.touched_variable, minlength=system.n_x)
    blocks = [CostLine(each.name, int(count)) for each, count in zip(system.design, moved, strict=True)]
    if len(blocks) > MOST_NAMES:
        blocks = [CostLine(f"{len(blocks)} variables", int(moved.sum()))]
    paths = {path for each in system.design for path in each.paths}
    others = len([path for path in scene.available_paths() if path not in paths])
    return [*blocks, CostLine("other numbers of the scene", 0, others, "no derivative by them was asked for")]


def fields(system: System) -> list[CostLine]:
    """Points of every flexible body where stress and distance to a target are computed."""
    found = []
    for name, body in system.scene.bodies.items():
        if isinstance(body, ModelBody):
            points = len(system.scene.model(body.model).invariants.stress_operator)
            stress, shape = asking(system.scene, StressResponse | LocalStress, name), asking(system.scene, ShapeResponse, name)
            found.append(_field(f"stress of {name}", points, stress))
            if shape:
                target = system.scene.model(body.model, "shape").shape
                found.append(_field(f"distance of {name} to its target", 0 if target is None else len(target.target), shape))
            else:
                found.append(CostLine(f"distance of {name} to its target", 0, 0, "no response asks for it"))
    return found


def markers(system: System) -> list[CostLine]:
    """Points that a joint, a load or a response looks at, and interface points that none does."""
    found, rigid = [], rigid_bodies(system)
    for name, body in system.scene.all_bodies().items():
        used = {point for owner, point, *_ in system.numbering.markers if owner == name}
        known = (
            (system.scene.model(body.model).interfaces or {})
            if name in system.scene.bodies and isinstance(body, ModelBody)
            else {}
        )
        idle = set(known) - {getattr(system.scene.interface(point), "interface", "") for point in used if point != CENTRE}
        if name not in rigid:
            found.append(CostLine(name, len(used), len(idle), f"nothing looks at {', '.join(sorted(idle))}" if idle else ""))
    count = len([1 for owner, *_ in system.numbering.markers if owner in rigid])
    return [*found, CostLine(f"{len(rigid)} rigid", count)] if rigid else found


def asking(scene: Scene, kind: type | UnionType, body: str) -> list[str]:
    """Responses of a kind, or made of one, that look at a body."""
    parts = {name: (each, getattr(each, "of", None)) for name, each in responses_of(scene).items()}
    return [
        name
        for name, both in parts.items()
        if any(isinstance(each, kind) and getattr(each, "body", None) == body for each in both)
    ]


def _field(what: str, points: int, asked: list[str]) -> CostLine:
    return CostLine(what, points, 0, f"for {', '.join(asked)}") if asked else CostLine(what, 0, points, "no response asks for it")


UNREAD = {
    "affine": "every parameter has its nominal value, no variable changes one",
    "derivatives": "every parameter has its nominal value, no variable changes one",
    "interfaces": "nothing grips the body",
    "shape": "no response asks for the distance to a target",
    "stress": "places of the stress points, for results files and pictures",
    "outline": "for pictures",
    "interior": "for pictures",
    "elements": "no body of this model has several frames",
    "element_derivatives": "no body of this model has several frames and a parameter that changes",
    "element_affine": "no body of this model has several frames and a parameter that changes",
    "pieces": "for pictures",
    "surface": "for pictures",
    "surface_loads": "no load presses on a surface of the body",
    "piece_loads": "no load presses on a surface of a body with several frames",
    "left_out_shapes": "after a run that asks for stress or strain energy",
    **dict.fromkeys(("sections", "section_derivatives", "section_affine"), "after a run for the checks of beams"),
    "mesh": "for pictures, and after a run for the small-deformation meter",
    **dict.fromkeys(RICHER_PARTS, "no frozen body is off its design, no variable turns its shapes"),
}


def files(system: System) -> dict[str, list[CostLine]]:
    """Bytes of every group of every file; those that were read are what the program has read of it so far."""
    return {path: groups(system, path) for path in model_paths(system)}


def model_paths(system: System) -> list[str]:
    """Files of the scene's flexible bodies."""
    return list(dict.fromkeys(body.model for body in system.scene.bodies.values() if isinstance(body, ModelBody)))


def groups(system: System, path: str) -> list[CostLine]:
    """Bytes of every group of one file, and of what surrounds the groups."""
    read, full = system.scene.model(path).bytes_read, system.scene.directory / path
    stored = stored_bytes(full)
    lines = [
        CostLine(name, size, 0, _reason(system, path, name)) if name in read else CostLine(name, 0, size, UNREAD.get(name, ""))
        for name, size in stored.items()
    ]
    return [*lines, CostLine("names, attributes, tables of HDF5", 0, _size(full) - sum(stored.values()), "not counted as read")]


def meshes(system: System) -> dict[str, Any]:
    """File -> stress error of its mesh, for files of which it was estimated."""
    records = {path: mesh_record(system.scene.model(path)) for path in model_paths(system)}
    return {path: record for path, record in records.items() if record}


def bytes_read(system: System) -> int:
    """Bytes of arrays that the program has read of all files of the scene so far."""
    return sum(sum(system.scene.model(path).bytes_read.values()) for path in model_paths(system))


def _reason(system: System, path: str, group: str) -> str:
    scene = system.scene
    bodies = {name: body for name, body in scene.bodies.items() if isinstance(body, ModelBody) and body.model == path}
    if group in DEPENDENCE:
        nominal = scene.model(path).nominal
        asked = [
            each.name
            for each in system.design
            if any(model_parameter(scene, name, path) in nominal for name in bodies for path in each.paths)
        ]
        return f"for {', '.join(asked)}" if asked else "a parameter is off its nominal value"
    if group in RICHER_PARTS:
        return "to judge what frozen shapes lack"
    if group == "shape":
        return f"for {', '.join(name for body in bodies for name in asking(scene, ShapeResponse, body))}"
    if group in ("surface_loads", "piece_loads"):
        return f"for {', '.join(name for name, load in pressures_of(scene).items() if load.body in bodies)}"
    return "equations of motion"


def _size(path: Path) -> int:
    return path.stat().st_size
