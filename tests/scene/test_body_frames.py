"""A flexible body moves unless its frame is grounded, and whoever gets the frame wrong is told: in plane and in space."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from preprocessing import build
from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible, SpatialFlexible
from toolkit.components.bodies.rigid import Rigid, SpatialRigid
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver, SpatialAngleDriver
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.joints.rigid_joint import RigidJoint, SpatialRigidJoint
from toolkit.components.joints.spherical import Spherical
from toolkit.components.loads.point_force import PointForce, SpatialPointForce
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, InputError, SingularSystemError
from toolkit.reduced_model.file import save
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.scene_cautions import cautions_of_scene

E, T, B, FORCE = 2e11, 0.01, 0.02, 1.0
BENDING = E * B * T**3 / 12
FRAME = f"""units = "m-kg-s"
clamp = ["A"]
nodes = {{ A = [0.0, 0.0, 0.0], B = [1.0, 0.0, 0.0] }}
beams = [{{ from = "A", to = "B", section = "bar", elements = 2, orientation = [0.0, 0.0, 1.0] }}]
interface_points = {{ root = {{ node = "A" }}, tip = {{ node = "B" }} }}
sections = {{ bar = {{ kind = "rectangle", thickness = {T}, width = {B}, material = "steel" }} }}
materials = {{ steel = {{ youngs_modulus = {E}, poisson_ratio = 0.3, density = 7800.0 }} }}
"""


class Kinds(NamedTuple):
    """What a dimension calls its components."""

    dimension: int
    beam: Callable[..., Any]
    weld: type
    pin: Callable[..., Any]
    driver: Callable[..., Any]
    block: Callable[..., Any]
    push: type

    def point(self, x: float) -> Point:
        return Point(x=x, y=0.0) if self.dimension == 2 else Point(x=x, y=0.0, z=0.0)

    def across(self, size: float) -> tuple[float, ...]:
        return (0.0, size, 0.0)[: self.dimension]


Z = (0.0, 0.0, 1.0)
PLANE = Kinds(2, Flexible, RigidJoint, Revolute, AngleDriver, lambda **body: Rigid(mass=1.0, inertia=1.0, **body), PointForce)
SPACE = Kinds(
    3,
    SpatialFlexible,
    SpatialRigidJoint,
    lambda **joint: SpatialRevolute(axis=Z, **joint),
    lambda **joint: SpatialAngleDriver(axis=Z, **joint),
    lambda **body: SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), **body),
    SpatialPointForce,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("models")
    section = Section(youngs_modulus=E, density=7800.0, thickness=T, width=B)
    save_beam(directory / "2.h5", np.column_stack([np.linspace(0, 1, 3), np.zeros(3)]), section, {"root": 0.0, "tip": 1.0})
    (directory / "frame.toml").write_text(FRAME)
    save(build(directory / "frame.toml"), directory / "3.h5")
    return directory


@pytest.fixture(params=[PLANE, SPACE], ids=["plane", "space"])
def kinds(request) -> Kinds:
    return request.param


def scene(kinds: Kinds, folder: Path, bodies: dict[str, Any], joints: dict[str, Any], **parts: Any) -> Scene:
    """Beams of 1 m along x, each with the points NAMEroot and NAMEtip, and whatever else there is."""
    beams = [name for name, body in bodies.items() if isinstance(body, (Flexible, SpatialFlexible))]
    points = {name + end: BodyPoint(body=name, interface=end) for name in beams for end in ("root", "tip")}
    return Scene(
        units="m-kg-s",
        dimension=kinds.dimension,
        directory=folder,
        points={"O": kinds.point(0.0), "P": kinds.point(1.0), **points},
        bodies=bodies,
        joints=joints,
        **parts,
    )


def beam(kinds: Kinds, at: float = 0.0, **options: Any) -> Any:
    position = (at, 0.0, 0.0)[: kinds.dimension]
    return kinds.beam(model=f"{kinds.dimension}.h5", position=position, **options)


def two_beams(kinds: Kinds, folder: Path, **second: Any) -> Scene:
    """One that is clamped to the ground, another tied rigidly to its end, and a force at the far one."""
    bodies = {"one": beam(kinds, frame="grounded"), "two": beam(kinds, 1.0, **second)}
    joints = {"weld": kinds.weld(bodies=("two", "one"), point=("tworoot", "onetip"))}
    load = {"push": kinds.push(body="two", point="twotip", force=kinds.across(FORCE))}
    return scene(kinds, folder, bodies, joints, loads=load)


def deflection(of: Scene, kinds: Kinds) -> float:
    """Of the far end, across."""
    system = compile_scene(of, markers=(("two", "twotip"),))
    found = solve_statics(system, RunOptions(load_steps=1))
    two = of.bodies["two"]
    at = solution_part(found, "two")
    place, elastic = two.point(loaded(of), "twotip", "two")[0], at[two.frame_size :]
    if not two.has_frame:
        return float(place[1] @ [1, *elastic])
    turn = at[2] if kinds.dimension == 2 else 2 * at[6]  # small
    return float(at[1] + turn * 1.0 + place[1] @ [1, *elastic])


def solution_part(found, body: str) -> np.ndarray:
    return found.q[0, found.coordinates(body)]


# --- the default ----------------------------------------------------------------------------------------------------------------


def test_a_mechanism_of_two_beams_tied_rigidly_bends_as_one_beam_of_both_lengths(kinds, folder):
    """Clamped, each to the ground, the second bends alone: an eighth."""
    whole, half = (FORCE * length**3 / (3 * BENDING) for length in (2.0, 1.0))
    # small rotations: what is of second order in them, 1.5e-2 squared; beams are exact for forces at nodes
    assert deflection(two_beams(kinds, folder), kinds) == pytest.approx(whole, rel=1e-3)
    grounded = two_beams(kinds, folder, frame="grounded")
    assert deflection(grounded, kinds) == pytest.approx(half, rel=1e-9)
    assert half / whole == 1 / 8


def test_a_joint_that_ties_a_body_to_the_ground_through_a_grounded_one_is_a_doubt(kinds, folder):
    (caution,) = cautions_of_scene(two_beams(kinds, folder, frame="grounded"))
    assert (caution.code, caution.doubt) == ("joint-ties-to-the-ground", True)
    assert "joint 'weld' ties 'one' to the ground: 'two' cannot move there" in caution.text
    assert cautions_of_scene(two_beams(kinds, folder)) == []


def test_a_joint_of_two_grounded_bodies_ties_their_deformations_alone(kinds, folder):
    """Two beams from opposite walls, joined where they meet: legitimate, and said."""
    turned = {"angle": np.pi} if kinds.dimension == 2 else {"orientation": (0.0, 0.0, np.pi)}
    bodies = {"one": beam(kinds, frame="grounded"), "two": beam(kinds, 2.0, frame="grounded", **turned)}
    met = scene(kinds, folder, bodies, {"weld": kinds.weld(bodies=("two", "one"), point=("twotip", "onetip"))})
    (caution,) = cautions_of_scene(met)
    assert (caution.code, caution.doubt) == ("joint-of-grounded-bodies", False)
    compile_scene(met)


def test_a_joint_that_holds_nothing_is_a_doubt(kinds, folder):
    bodies = {"one": beam(kinds, frame="grounded"), "block": kinds.block(center="P")}
    joints = {
        "clamp": kinds.weld(bodies=("one", "ground"), point="oneroot"),
        "hinge": kinds.pin(bodies=("one", "block"), point="onetip"),
    }
    caution, *others = cautions_of_scene(scene(kinds, folder, bodies, joints))
    assert (caution.code, caution.doubt, others) == ("joint-holds-nothing", True, [])
    assert "joint 'clamp' holds nothing: 'one' and 'ground' cannot move there" in caution.text


def test_a_support_of_a_grounded_body_is_no_caution(kinds, folder):
    joints = {"support": kinds.pin(bodies=("one", "ground"), point="onetip")}
    assert cautions_of_scene(scene(kinds, folder, {"one": beam(kinds, frame="grounded")}, joints)) == []


def test_a_joint_that_lets_bodies_turn_that_cannot_is_told(folder):
    frames = {"one": SpatialRigid(mass=1.0, inertia=(1.0, 1.0, 1.0), center="P", frame="translating")}
    pinned = scene(SPACE, folder, frames, {"ball": Spherical(bodies=("one", "ground"), point="P")})
    (caution,) = cautions_of_scene(pinned)
    assert (caution.code, caution.doubt) == ("joint-cannot-turn", False)
    turning = {"one": frames["one"].model_copy(update={"frame": "moving"})}
    assert cautions_of_scene(pinned.model_copy(update={"bodies": turning})) == []


# --- bodies that nothing holds --------------------------------------------------------------------------------------------------


def test_a_flexible_body_that_nothing_holds_is_told_how_to_be(kinds, folder):
    """A caution before the run; an error of statics that names the frame."""
    load = {"push": kinds.push(body="one", point="onetip", force=kinds.across(FORCE))}
    free = scene(kinds, folder, {"one": beam(kinds)}, {}, loads=load)
    (caution,) = cautions_of_scene(free)
    assert (caution.code, caution.doubt) == ("held-by-nothing", False)
    assert "no joint holds 'one'" in caution.text
    words = "Body 'one' moves with the frame; frame = .grounded. fixes"
    with pytest.raises(ConvergenceError, match=rf"end nowhere, last moving y of body 'one'.*{words}"):
        solve_statics(compile_scene(free))
    with pytest.raises(SingularSystemError, match=rf"free to move there.*{words}"):
        solve_statics(compile_scene(free.model_copy(update={"loads": {}})))
    assert cautions_of_scene(free.model_copy(update={"bodies": {"one": beam(kinds, frame="grounded")}})) == []


# --- grounded by mistake --------------------------------------------------------------------------------------------------------


def rocker(kinds: Kinds, folder: Path, frame: str) -> Scene:
    """A driven crank that coincides with the root of a beam, whose tip slides: impossible if the beam's root is clamped."""
    bodies = {"crank": kinds.block(center="O"), "one": beam(kinds, frame=frame)}
    joints = {
        "hinge": kinds.pin(bodies=("crank", "ground"), point="O"),
        "weld": kinds.weld(bodies=("one", "crank"), point="oneroot"),
        "drive": kinds.driver(bodies=("crank", "ground"), point="O", curve=SmoothStep(height=0.1, duration=1.0)),
    }
    return scene(kinds, folder, bodies, joints, solver=RunOptions(end_time=0.002, step=0.001))


def test_a_mechanism_that_a_grounded_body_blocks_is_refused_by_the_name_of_the_frame(kinds, folder):
    words = r"repeat or contradict.*Body 'one' is fixed to the ground by frame = \"grounded\", the likely cause"
    with pytest.raises(SingularSystemError, match=words):
        simulate(compile_scene(rocker(kinds, folder, "grounded")))
    simulate(compile_scene(rocker(kinds, folder, "moving")))


def test_a_redundant_driver_names_the_grounded_body_too(kinds, folder):
    blocked = rocker(kinds, folder, "grounded")
    blocked = blocked.model_copy(update={"solver": blocked.solver.model_copy(update={"redundant": "least-squares"})})
    with pytest.raises(InputError, match=r"drives what other joints already determine.*'one' is fixed to the ground"):
        compile_scene(blocked)


def test_no_frame_is_blamed_where_none_is_grounded(kinds, folder):
    bodies = {"block": kinds.block(center="O")}
    joints = {name: kinds.weld(bodies=("block", "ground"), point="O") for name in ("first", "second")}
    with pytest.raises(SingularSystemError, match="repeat or contradict") as error:
        simulate(compile_scene(scene(kinds, folder, bodies, joints)))
    assert "grounded" not in str(error.value)
