"""Scenes: numbers by path, the same objects from Python and TOML, one reduced model used twice."""

import numpy as np
import pytest

from tests.models.scenes import MODELS, WING, hanging_skin
from toolkit.analyses.statics import solve_statics
from toolkit.components.bodies.body import Body, PlanarBody, SpatialBody
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.joint import Joint, PlanarJoint, SpatialJoint
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.load import AnyLoad, AnyPlanarLoad, AnySpatialLoad, Load
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.scene.space import PLANE, SPACE
from toolkit.system.system import compile_scene


def wing_in_python() -> Scene:
    """The reference scene, written in Python."""
    rod = {"area": 100.0, "density": 2.7e-9}
    written = read_scene(WING)
    return Scene(
        units="mm-t-s",
        directory=MODELS,
        points={
            "A": Point(x=72.5, y=1.3),
            "B": Point(x=75.3, y=-13.4),
            "D": Point(x=61.8, y=3.8),
            **{name: BodyPoint(body="skin", interface=name) for name in "CEG"},
        },
        bodies={
            "skin": Flexible(model="skin.h5", frame="grounded"),
            "body2": Rod(between=("A", "B"), **rod),
            "body3": Rod(between=("B", "C"), **rod),
            "body4": Rod(between=("B", "D"), **rod),
            "body5": Rod(between=("D", "E"), **rod),
        },
        joints={
            "A": Revolute(bodies=("body2", "ground"), point="A"),
            "B": Revolute(bodies=("body2", "body3"), point="B"),
            "B_rigid": RigidJoint(bodies=("body2", "body4"), point="B"),
            "C": Revolute(bodies=("body3", "skin"), point="C"),
            "D": Revolute(bodies=("body4", "body5"), point="D"),
            "E": Revolute(bodies=("body5", "skin"), point="E"),
            "G": Slider(bodies=("skin", "ground"), point="G", axis=(1.0, 0.0), lock_rotation=True),
        },
        loads={"drive": Torque(body="body2", point="A", torque=4200.0, curve=SmoothStep(duration=1.0))},
        design=written.design,
        responses=written.responses,
        solver=RunOptions(end_time=1.2, step=0.05, scheme="paper", rho_inf=0.5),
    )


@pytest.mark.parametrize("base", [Body, Joint, AnyLoad, Load])
def test_neutral_bases_belong_to_no_space_and_know_no_kinds(base):
    assert base.dimension == 0
    assert base.kinds == {}


@pytest.mark.parametrize(
    ("space", "others"), [(PLANE, (SpatialBody, SpatialJoint, AnySpatialLoad)), (SPACE, (PlanarBody, PlanarJoint, AnyPlanarLoad))]
)
def test_no_kind_of_one_space_descends_from_the_other(space, others):
    kinds = [kind for group in space.kinds.values() for kind in group.values()]
    assert len(kinds) >= 15
    assert [kind for kind in kinds if issubclass(kind, others) or kind.dimension != space.dimension] == []


def test_a_scene_in_toml_is_the_same_object_as_in_python():
    assert read_scene(WING) == wing_in_python()


def test_a_rod_has_the_mass_properties_of_its_end_points():
    scene = loaded(wing_in_python())
    mass, center, inertia = scene.bodies["body2"].mass_properties(scene)
    length = np.hypot(75.3 - 72.5, -13.4 - 1.3)
    assert mass == pytest.approx(2.7e-9 * 100 * length, rel=1e-15)
    assert inertia == pytest.approx(mass * length**2 / 12, rel=1e-15)
    np.testing.assert_allclose(center, [(72.5 + 75.3) / 2, (1.3 - 13.4) / 2], rtol=1e-15)


def test_moving_a_point_moves_everything_that_hangs_on_it():
    scene = loaded(wing_in_python())
    moved = scene.with_number("points.B.x", 80.0)
    for body in ("body2", "body3", "body4"):
        assert moved.bodies[body].mass_properties(moved)[0] != scene.bodies[body].mass_properties(scene)[0]


def test_paths_reach_every_number_also_those_of_the_reduced_model():
    paths = wing_in_python().available_paths()
    for path in (
        "points.A.x",
        "loads.drive.torque",
        "loads.drive.curve.duration",
        "bodies.skin.thickness",
    ):
        assert path in paths
    assert wing_in_python().number("bodies.skin.thickness") == 1.5


def test_a_wrong_path_says_what_is_possible():
    with pytest.raises(InputError, match=r"no number 'points.A.z'.*points.A.x, points.A.y"):
        wing_in_python().with_number("points.A.z", 1.0)


def test_an_interface_point_at_a_node_refuses_to_be_a_design_variable():
    with pytest.raises(InputError, match="sits at a node of the mesh"):
        compile_scene(wing_in_python(), ["points.C.arc_length"])


def test_the_coordinates_of_an_interface_point_are_those_of_its_body():
    with pytest.raises(InputError, match=r"leads nowhere: the point lies where 'C' of body 'skin' does.*'points.C.arc_length'"):
        compile_scene(wing_in_python(), ["points.C.x"])


def test_overrides_are_those_of_the_file():
    scene = read_scene(WING, {"points.A.x": "73.0", "solver.rho_inf": "0.8", "bodies.skin.thickness": "1.6"})
    assert (scene.points["A"].x, scene.solver.rho_inf, scene.number("bodies.skin.thickness")) == (73.0, 0.8, 1.6)


def test_one_reduced_model_serves_two_bodies_at_different_places():
    """Two copies of the wing, one shifted and turned: same angles, same elastic coordinates in their own frames."""
    scene, angle, shift = wing_in_python(), 0.7, np.array([300.0, -50.0])
    A = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def moved(point):
        if isinstance(point, BodyPoint):
            return point.model_copy(update={"body": "second_skin"})
        x, y = A @ [point.x, point.y] + shift
        return Point(x=float(x), y=float(y))

    def second(component):
        names = {
            "bodies": tuple(body if body == "ground" else f"second_{body}" for body in getattr(component, "bodies", ())),
            "body": f"second_{getattr(component, 'body', '')}",
            "point": f"second_{component.point}",
            "axis": tuple(A @ getattr(component, "axis", (1.0, 0.0))),
        }
        return component.model_copy(update={key: value for key, value in names.items() if key in type(component).model_fields})

    bodies = {
        f"second_{name}": body.model_copy(update={"between": tuple(f"second_{p}" for p in body.between)})
        for name, body in scene.bodies.items()
        if isinstance(body, Rod)
    }
    bodies["second_skin"] = Flexible(model="skin.h5", frame="grounded", position=tuple(map(float, shift)), angle=angle)
    both = scene.model_copy(
        update={
            "points": {**scene.points, **{f"second_{name}": moved(point) for name, point in scene.points.items()}},
            "bodies": {**scene.bodies, **bodies},
            "joints": {**scene.joints, **{f"second_{name}": second(joint) for name, joint in scene.joints.items()}},
            "loads": {**scene.loads, **{f"second_{name}": second(load) for name, load in scene.loads.items()}},
        }
    )
    solution = solve_statics(compile_scene(both))
    first, other = (solution.q[-1, solution.coordinates(name)] for name in ("skin", "second_skin"))
    # round-off of the equilibrium, relative to displacements of some millimetres
    np.testing.assert_allclose(other, first, atol=1e-9)
    angles = [solution.q[-1, solution.coordinates(name)][2] for name in ("body2", "second_body2")]
    assert angles[1] == pytest.approx(angles[0], abs=1e-11)


def test_the_position_of_a_moving_body_places_its_interface_points():
    scene = hanging_skin()
    local = scene.model("skin.h5").interfaces["C"].position[0, :, 0]
    A = np.array([[np.cos(0.1), -np.sin(0.1)], [np.sin(0.1), np.cos(0.1)]])
    np.testing.assert_allclose(loaded(scene).position("C"), A @ local + [3.0, 5.0], rtol=1e-14)


def test_the_size_of_a_scene_without_points_is_that_of_its_bodies():
    """Displacements need a length to be compared with, in any unit: sqrt(I / m)."""
    block = Rigid(mass=2.0, inertia=18.0, center="P")
    scene = Scene(units="m-kg-s", points={"P": Point(x=7.0, y=1.0)}, bodies={"block": block})
    assert loaded(scene).size == pytest.approx(3.0)
