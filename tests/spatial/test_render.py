"""Pictures of space: bodies, axes and loads are where the solution has them, the camera sees them, and a time series can be read."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from preprocessing import build
from tests.models.cases import PROFILE
from tests.models.pictures import distinct_colors, image, rest, skip_where_nothing_draws
from tests.models.solid_bodies import box, cantilever
from toolkit.analyses.sensitivity.direct import direct
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import Rod, SpatialRigid, SpatialRod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.cam import SpatialSwingCam
from toolkit.components.joints.cylindrical import Cylindrical
from toolkit.components.joints.distance import SpatialDistance
from toolkit.components.joints.gear import SpatialGear
from toolkit.components.joints.point_on_plane import PointOnPlane
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.rack import SpatialRack
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.rigid_joint import SpatialRigidJoint
from toolkit.components.joints.screw import Screw
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.components.loads.bushing import SpatialBushing
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.point_force import SpatialPointForce
from toolkit.components.loads.pressure import Pressure
from toolkit.components.loads.springs import SpatialSpringDamper
from toolkit.components.loads.torque import SpatialTorque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.files.results import collect
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import OWN
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of
from toolkit.reduced_model.file import save
from toolkit.render.packages import drawing
from toolkit.render.pictures import render_solution
from toolkit.render.readable_units import View
from toolkit.render.space.configuration import SpatialConfiguration, body_shape, counted_angle, drawn_as_built, stress_extremes
from toolkit.render.space.look import ISOMETRIC, Camera, arrows, choose_spatial_look, natural_aspect, outermost
from toolkit.render.space.scene_picture import spatial_caption
from toolkit.report.material import ReportMaterial
from toolkit.report.write import write_report
from toolkit.responses.stress import MaxStress, stress_field
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene

WIDTH, LENGTHS = 600, (1.0, 0.2, 0.15)
TOP = "[pressure_surfaces.top]\nbox = [0.0, -0.1, 0.075, 1.0, 0.1, 0.075]\n"
TURN = np.array([0.3, -0.7, 0.5])
"""A rotation vector without symmetry."""
FRAME = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0, 0, 0], B = [0, 0, 1], C = [0.6, 0, 1] }
beams = [
    { from = "A", to = "B", section = "leg", elements = 2 },
    { from = "B", to = "C", section = "arm", elements = 2, orientation = [0, 1, 0] },
]
sections.leg = { kind = "circle", diameter = 0.05, material = "steel" }
sections.arm = { kind = "rectangle", thickness = 0.01, width = 0.04, material = "steel" }
materials.steel = { youngs_modulus = 2.1e11, poisson_ratio = 0.3, density = 7850.0 }
interface_points = { tip = { node = "C" } }
basis = { kind = "static" }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Reduced models: beam.h5, a box of hexahedra, and frame.h5."""
    place = tmp_path_factory.mktemp("models")
    save(cantilever(place, box("hexahedron", (4, 2, 1), LENGTHS), 'kind = "static"', more=TOP), place / "beam.h5")
    (place / "frame.toml").write_text(FRAME)
    save(build(place / "frame.toml"), place / "frame.h5")
    return place


@pytest.fixture(scope="module")
def opengl():
    skip_where_nothing_draws()


def at(x, y, z):
    return Point(x=x, y=y, z=z)


def gallows(folder, **more):
    """A frame of beams with a pendulum, a spring and loads."""
    return Scene(
        units="m-kg-s",
        dimension=3,
        directory=folder,
        points={"T": BodyPoint(body="frame", interface="tip"), "E": at(0.7, 0.1, 0.4), "W": at(0.8, -0.4, 0.5)},
        bodies={
            "frame": SpatialFlexible(model="frame.h5", frame="grounded"),
            "rod": SpatialRod(between=("T", "E"), area=4e-4, density=7850.0),
        },
        joints={"hinge": SpatialRevolute(bodies=("rod", "frame"), point="T", axis=(0.0, 1.0, 0.0))},
        loads={
            "gravity": SpatialGravity(acceleration=(0.0, 0.0, -9.81)),
            "push": SpatialPointForce(body="rod", point="E", force=(3.0, 0.0, 4.0), curve=SmoothStep(duration=2.0), frame="body"),
            "twist": SpatialTorque(body="rod", point="T", torque=(0.0, 5.0, 0.0), reaction="frame"),
            "stay": SpatialSpringDamper(bodies=("rod", "ground"), points=("E", "W"), stiffness=10.0),
        },
        **more,
    )


def crank(folder, frame="moving", **more):
    """A solid box, turned and moved from where its model was made, with a pressure on its top."""
    return Scene(
        units="m-kg-s",
        dimension=3,
        directory=folder,
        points={"H": BodyPoint(body="beam", interface="hub"), "T": BodyPoint(body="beam", interface="tip")},
        bodies={"beam": SpatialFlexible(model="beam.h5", frame=frame, position=(0.1, 0.2, 0.3), orientation=tuple(TURN))},
        loads={"wind": Pressure(body="beam", surface="top", pressure=100.0)},
        **more,
    )


def bent(solution, body, size=1e-3):
    """The solution with random elastic coordinates at its last step."""
    elastic = solution.q[-1, solution.coordinates(body)][solution.system.scene.bodies[body].frame_size :]
    elastic[:] = size * np.random.default_rng(1).normal(size=len(elastic))
    return solution


def test_every_kind_of_joint_and_load_is_drawn_in_all_pictures(opengl, folder, tmp_path):
    names = "abcdefg"
    points = {name: at(0.2 * k, 0.3, 0.3 + 0.1 * k) for k, name in enumerate(names)}
    lump = SpatialRigid(mass=1.0, inertia=(0.01, 0.01, 0.01), center="a")
    joints = {
        "sleeve": Cylindrical(bodies=("body", "ground"), point="a", axis=(1.0, 0.0, 0.0)),
        "slider": Prismatic(bodies=("body", "ground"), point="b", axis=(1.0, 1.0, 0.0)),
        "plane": PointOnPlane(bodies=("body", "ground"), point="c", axis=(0.0, 0.0, 1.0)),
        "cross": Universal(bodies=("body", "ground"), point="d", axes_of_cross=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))),
        "weld": SpatialRigidJoint(bodies=("body", "ground"), point="e"),
        "ball": Spherical(bodies=("body", "ground"), point="f"),
        "link": SpatialDistance(bodies=("body", "ground"), points=("f", "g")),
        "screw": Screw(bodies=("body", "ground"), point="g", axis=(0.0, 0.0, 1.0), pitch=0.1),
        "gear": SpatialGear(bodies=("body", "ground"), points=("a", "b"), axis=(0.0, 0.0, 1.0), teeth=(20, 40)),
        "rack": SpatialRack(bodies=("body", "ground"), points=("c", "d"), axis=(0.0, 0.0, 1.0), along=(0.0, 1.0, 0.0)),
        "cam": SpatialSwingCam(bodies=("body", "ground"), points=("e", "f"), axis=(0.0, 0.0, 1.0), curve=PROFILE),
    }
    scene = gallows(folder)
    scene = scene.model_copy(
        update={
            "points": {**scene.points, **points},
            "bodies": {**scene.bodies, "body": lump},
            "joints": {**scene.joints, **joints},
            "loads": {**scene.loads, "bushing": SpatialBushing(bodies=("body", "ground"), point="a", stiffness=(1.0, 2.0, 3.0))},
        }
    )
    solution = bent(rest(scene, 1), "frame")
    files = render_solution(solution, tmp_path, [0.0, 1.0], WIDTH, View(triads=True), animate=True)
    assert [file.name for file in files] == ["step-0.png", "step-1.png", "overview.png", "curves.png", "animation.gif"]
    assert sorted([*files, tmp_path / OWN]) == sorted(tmp_path.iterdir())  # no temporary file is left
    for file in files[:4]:
        assert image(file).shape[1] == WIDTH
        assert distinct_colors(image(file)) > 100  # a colour bar and shaded surfaces; an empty sheet has one
    assert not np.array_equal(image(files[0]), image(files[1]))


def test_a_solid_is_drawn_in_perspective(opengl, folder, tmp_path):
    (file,) = render_solution(rest(crank(folder), 0), tmp_path, width=WIDTH, view=View(perspective=True))
    assert distinct_colors(image(file)) > 100


def test_a_planar_scene_has_no_perspective(folder):
    points = {"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0)}
    planar = Scene(units="m-kg-s", points=points, bodies={"rod": Rod(between=("O", "P"), area=1e-4, density=1e3)})
    View().check(planar)
    View(perspective=True).check(gallows(folder))
    with pytest.raises(InputError, match="planar: leave them out"):
        View(triads=True).check(planar)


def test_space_has_no_vector_pictures_and_nothing_has_pictures_of_an_unknown_format(folder):
    with pytest.raises(InputError, match="consist of pixels and cannot be written as svg: leave the format out"):
        View(format="svg").check(gallows(folder))
    with pytest.raises(InputError, match=r"no pictures of format 'jpeg'\. Take one of png, svg, pdf"):
        View(format="jpeg").check(gallows(folder))


def test_a_report_of_a_scene_in_space_has_pictures_curves_and_numbers(folder, opengl, tmp_path):
    found = direct(gallows(folder, solver=RunOptions(end_time=0.002, step=0.001)), [], "transient")
    path = write_report(ReportMaterial(found.solution, collect(found)), tmp_path, "Gallows")
    text = path.read_text(encoding="utf-8")
    assert text.count("data:image/png") == 2  # instants and curves
    assert text.count("data:image/gif") == 1
    assert {"overview.png", "curves.png", "animation.gif", "numbers.json", "results.h5"} <= {
        file.name for file in tmp_path.iterdir()
    }
    assert "monitors.svg" in {file.name for file in (tmp_path / "figures").iterdir()}


@pytest.mark.parametrize("frame", ["moving", "translating", "turning", "grounded"])
def test_the_surface_of_a_body_goes_with_its_interface_points_whatever_its_frame_is(folder, frame):
    """The tip of the frame is the middle of its section's four fibres, which its rotation turns about it."""
    body = {"axis": (1.0, 2.0, -1.0)} if frame == "turning" else {}
    scene = gallows(folder).model_copy(update={"joints": {}, "loads": {}})
    beams = SpatialFlexible(model="frame.h5", frame=frame, position=(0.1, 0.2, 0.3), orientation=tuple(TURN), **body)
    solution = bent(rest(scene.model_copy(update={"bodies": {"frame": beams}}), 1), "frame")
    q = solution.q[1, solution.coordinates("frame")]
    q[: beams.moves] += 0.5
    q[beams.moves : beams.frame_size] = {"moving": quaternion_of(2 * TURN), "turning": [0.8]}.get(frame, [])
    moment = SpatialConfiguration(solution, 1)
    ends = body_shape(moment, "frame").points[-8:].reshape(-1, 2, 3)[:, 1]  # of the last element's four fibres
    np.testing.assert_allclose(ends.mean(axis=0), moment.position("frame", "T"), atol=1e-14)  # m, round-off


def test_undeformed_is_where_the_scene_puts_its_bodies(folder):
    solution = rest(crank(folder), 1)
    solution.q[:] = 7.0
    start = SpatialConfiguration.undeformed(solution)
    np.testing.assert_allclose(start.position("beam", "T"), solution.system.scene.position("T"), atol=1e-15)  # round-off
    corner = np.array([0.1, 0.2, 0.3]) + matrix_of(quaternion_of(TURN)) @ [0.0, -0.1, -0.075]
    assert np.abs(body_shape(start, "beam").points - corner).max(axis=1).min() < 1e-15


def test_drawn_stress_has_the_range_of_the_response(folder):
    for scene, body in ((crank(folder), "beam"), (gallows(folder), "frame")):
        solution = bent(rest(scene, 1), body, 1e-4)
        low, high = stress_extremes(SpatialConfiguration(solution, 1), body)
        field = stress_field(solution, body)[0][1]
        np.testing.assert_allclose([low, high], [min(field.min(), 0.0), field.max()], rtol=1e-12)  # the same sums
        assert high == pytest.approx(MaxStress(body=body, when="end").value(solution), rel=1e-12)
        look = choose_spatial_look(solution, [1], View())
        assert look.signed == (body == "frame")  # fibres have a sign, von Mises' stress has none
        assert max(-low, high) <= look.stress_limit < 2 * max(-low, high)


def test_beams_are_closed_round_their_fibres(folder):
    shape = body_shape(SpatialConfiguration(rest(gallows(folder), 0), 0), "frame")
    assert [len(each) for each in shape.sides if each.shape[1] == 8] == [2 * 2]  # both ends of two round elements
    (quads,) = (each for each in shape.sides if each.shape[1] == 4)
    assert len(quads) == 2 * 8 + 2 * (4 + 2)  # sides of round ones, sides and ends of flat ones
    p = shape.points[quads]
    areas = np.linalg.norm(np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]), axis=1) / 2
    around = 2 * 8 * 0.5 * 2 * 0.025 * np.sin(np.pi / 8) + 2 * (
        0.3 * 0.1 + 2 * 0.0004
    )  # octagonal prisms, and bars of 10 by 40 mm
    assert areas.sum() == pytest.approx(around, rel=1e-12)  # no side is crossed


def test_what_is_clamped_is_still(folder):
    from toolkit.render.space.parts import clamped_faces, clamped_points

    (clamp,) = clamped_points(SpatialConfiguration(rest(gallows(folder), 0), 0))
    np.testing.assert_allclose(clamp, 0, atol=1e-15)  # the node A
    moment = SpatialConfiguration(rest(crank(folder, "grounded"), 0), 0)
    assert clamped_faces(body_shape(moment, "beam")).area == pytest.approx(0.2 * 0.15, rel=1e-12)  # the left end of the box
    (middle,) = clamped_points(moment)
    np.testing.assert_allclose(middle, [0.1, 0.2, 0.3], atol=1e-15)  # where the box begins
    assert not clamped_points(SpatialConfiguration(rest(crank(folder), 0), 0))  # its frame moves


def test_axes_of_a_joint_turn_with_the_body_that_carries_them(folder):
    from toolkit.render.space.parts import spatial_symbols

    scene = gallows(folder)
    joint = Prismatic(bodies=("ground", "rod"), point="E", axis=(0.0, 0.0, 2.0))
    solution = rest(scene.model_copy(update={"joints": {"slide": joint}}), 0)
    where = solution.coordinates("rod").start
    solution.q[0, where + 3 : where + 7] = quaternion_of(TURN)
    (slider,) = (symbol for symbol in spatial_symbols(SpatialConfiguration(solution, 0)) if symbol.kind == "slider")
    np.testing.assert_allclose(slider.axes[:, 2], matrix_of(quaternion_of(TURN))[:, 2], atol=1e-15)  # round-off
    np.testing.assert_array_equal(slider.point, loaded(scene).position("E"))  # where the ground has it


class Drawer(Prismatic):
    """A user's own slide."""

    kind = ""


class Vague(Drawer):
    """One that nobody can draw."""

    symbol = "cloud"


def test_a_joint_says_itself_what_it_is_drawn_as(folder):
    from toolkit.render.space.parts import spatial_symbols

    scene = gallows(folder)
    drawn = {}
    for kind in (Drawer, Vague):
        joint = kind(bodies=("ground", "rod"), point="E", axis=(0.0, 0.0, 2.0))
        drawn[kind] = SpatialConfiguration(rest(scene.model_copy(update={"joints": {"slide": joint}}), 0), 0)
    assert "slider" in [symbol.kind for symbol in spatial_symbols(drawn[Drawer])]
    with pytest.raises(InputError, match=r"Vague has the symbol 'cloud', which nobody can draw; take one of: .*hinge"):
        spatial_symbols(drawn[Vague])


def test_arrows_are_the_loads_of_the_moment(folder):
    solution = rest(gallows(folder), 1)
    where = solution.coordinates("rod").start
    solution.q[1, where + 3 : where + 7] = quaternion_of(TURN)
    moment = SpatialConfiguration(solution, 1)
    force, torque, reaction = arrows(moment)
    half = matrix_of(quaternion_of(TURN)) @ [1.5, 0.0, 2.0]  # at half of its step the curve is 1 / 2
    np.testing.assert_allclose(force.vector, half, atol=1e-15)
    np.testing.assert_array_equal(force.point, moment.position("rod", "E"))
    np.testing.assert_array_equal([torque.vector, reaction.vector], [[0, 5, 0], [0, -5, 0]])
    assert np.all([a.vector == 0 for a in arrows(SpatialConfiguration(solution, 0)) if a.kind == "force"])


def test_a_turning_frame_stands_on_the_ground_and_a_welded_point_is_a_pin():
    from toolkit.render.space.parts import spatial_symbols

    def at(name):
        scene = read_scene(Path(__file__).parents[2] / "models" / name / "scene.toml")
        moment = SpatialConfiguration(rest(scene, 0), 0)
        return moment.named_points(), spatial_symbols(moment)

    points, found = at("governor")
    (ground,) = (symbol for symbol in found if symbol.kind == "ground")
    (hinge,) = (symbol for symbol in found if symbol.kind == "hinge" and np.array_equal(symbol.point, ground.point))
    np.testing.assert_array_equal(ground.point, points["O"])
    np.testing.assert_array_equal(hinge.axes[:, 2], [0.0, 0.0, 1.0])
    points, found = at("spinning_beam")
    pins = [symbol.point for symbol in found if symbol.kind == "pin"]
    assert all(any(np.allclose(points[f"T{k}"], pin, rtol=0, atol=1e-9) for pin in pins) for k in range(1, 8))


def test_every_symbol_has_its_word_in_the_legend():
    from toolkit.render.space.parts import _SURFACES
    from toolkit.render.space.scene_picture import SYMBOLS

    known = {kind for name, (_, *beside) in SYMBOLS.items() for kind in (name, *beside)}
    assert known - {"spring"} == set(_SURFACES) - {"pin"}  # a spring is a coil, and a pin the end of a link


def test_pictures_leave_room_below_for_what_they_explain_alone(folder):
    from toolkit.render.space.scene_picture import foot

    solution = rest(crank(folder), 1)
    moment, look = SpatialConfiguration(solution, 1), choose_spatial_look(solution, [1], View())
    coloured = replace(look, stress_limit=1.0)
    bare, forces, both = (
        replace(look, stress_limit=0.0, largest={"force": force, "torque": torque}) for force, torque in ((0, 0), (1, 0), (1, 1))
    )
    heights = [foot(moment, each) for each in (bare, forces, both, coloured)]
    assert heights[0] <= heights[1] < heights[2] < heights[3]  # a line for each kind of arrows, fewer than a bar of colours needs


def test_what_stands_faintly_behind_is_called_what_it_is(folder):
    from toolkit.render.space.scene_picture import _faint

    solution = rest(crank(folder), 1)
    look = choose_spatial_look(solution, [1], View())
    assert _faint(SpatialConfiguration(solution, 1), look) == "at the start"
    solution.q[0, :3] += 0.5  # it begins elsewhere
    assert _faint(SpatialConfiguration(solution, 1), look) == "as the scene is written"
    assert _faint(SpatialConfiguration(rest(crank(folder), 0), 0), look) == "as the scene is written"
    named = replace(solution, names=("as given", "free motion 1 of 1"))
    assert _faint(SpatialConfiguration(named, 1), look) == "as given"


@pytest.mark.parametrize(
    ("number", "told"),
    [("diameter_leg", "motion to scale; surface of frame as built"), ("youngs_modulus_steel", "motion and shape to scale")],
)
def test_a_surface_that_has_not_the_size_of_the_scene_says_so(folder, number, told):
    from toolkit.render.space.scene_picture import _scale

    scene, path = gallows(folder), f"bodies.frame.{number}"
    tangent = {**scene.bodies, "frame": scene.bodies["frame"].model_copy(update={"extrapolation": "first-order"})}
    moved = scene.model_copy(update={"bodies": tangent}).with_number(path, 1.01 * scene.number(path))
    solution = rest(moved, 0)
    assert _scale(SpatialConfiguration(solution, 0), choose_spatial_look(solution, [0], View())) == told


@pytest.mark.parametrize("frames", [1, 2])
def test_a_surface_follows_the_sizes_of_its_sections(tmp_path, frames):
    """A frame at other sizes is drawn as the one that is built with them: at rest, and with elastic coordinates that turn its nodes."""
    other = FRAME.replace("diameter = 0.05", "diameter = 0.07").replace(
        "thickness = 0.01, width = 0.04", "thickness = 0.02, width = 0.05"
    )
    for name, text in (("frame", FRAME), ("other", other)):
        (tmp_path / f"{name}.toml").write_text(text.replace('"static"', '"full"'))
        save(build(tmp_path / f"{name}.toml"), tmp_path / f"{name}.h5")
    sizes = {"diameter_leg": 0.07, "thickness_arm": 0.02, "width_arm": 0.05}
    bodies = [{"model": "frame.h5", **sizes}, {"model": "other.h5"}]
    found = []
    for body in bodies:
        one = SpatialFlexible.model_validate({**body, "frame": "grounded", "frames": frames})
        scene = Scene(
            units="m-kg-s",
            dimension=3,
            directory=tmp_path,
            points={"T": BodyPoint(body="frame", interface="tip")},
            bodies={"frame": one},
            loads={"push": SpatialPointForce(body="frame", point="T", force=(3.0, 0.0, 4.0))},
        )
        solution = rest(scene, 1)
        if frames == 1:
            bent(solution, "frame")
        moment = SpatialConfiguration(solution, 1)
        assert not drawn_as_built(moment.scene, "frame")
        found.append(body_shape(moment, "frame").points)
    np.testing.assert_allclose(*found, atol=1e-15)


def test_a_rigid_motion_has_no_stress_whatever_its_round_off_is(folder):
    solution = rest(crank(folder), 1)
    elastic = solution.q[1, solution.coordinates("beam")][solution.system.scene.bodies["beam"].frame_size :]
    elastic[:] = 1e-16  # m
    assert choose_spatial_look(solution, [1], View()).stress_limit == 0
    assert spatial_caption(SpatialConfiguration(solution, 1), choose_spatial_look(solution, [1], View()))[1:] == ["no stress"]
    elastic[:] = 1e-9
    assert choose_spatial_look(solution, [1], View()).stress_limit > 0


@pytest.mark.parametrize("frame", ["moving", "grounded"])
def test_a_pressure_is_its_resultant_in_the_middle_of_its_surface(folder, frame):
    (arrow,) = arrows(SpatialConfiguration(rest(crank(folder, frame), 0), 0))
    A = matrix_of(quaternion_of(TURN))
    np.testing.assert_allclose(arrow.vector, -100.0 * 1.0 * 0.2 * A[:, 2], atol=1e-12)  # N, round-off
    np.testing.assert_allclose(arrow.point, [0.1, 0.2, 0.3] + A @ [0.5, 0.0, 0.075], atol=1e-14)


def test_a_free_rigid_body_is_the_box_of_its_inertia():
    a, b, c = 0.3, 0.2, 0.1
    inertia = tuple((one**2 + other**2) / 12 * 5.0 for one, other in ((b, c), (a, c), (a, b)))
    scene = Scene(
        units="m-kg-s", dimension=3, points={"C": at(1.0, 2.0, 3.0)},
        bodies={"brick": SpatialRigid(mass=5.0, inertia=inertia, center="C")},
    )  # fmt: skip
    solution = rest(scene, 0)
    solution.q[0, 3:7] = quaternion_of(TURN)
    edges = SpatialConfiguration(solution, 0).segments("brick")
    lengths = sorted(np.linalg.norm(np.diff(edge, axis=0)) for edge in edges)
    np.testing.assert_allclose(lengths, 4 * [c] + 4 * [b] + 4 * [a], rtol=1e-12)  # round-off
    local = (np.vstack(edges) - [1.0, 2.0, 3.0]) @ matrix_of(quaternion_of(TURN))
    np.testing.assert_allclose(np.abs(local), np.tile([a / 2, b / 2, c / 2], (24, 1)), atol=1e-14)


@pytest.mark.parametrize("perspective", [False, True])
def test_the_camera_frames_all_points_and_moves_none_sideways(perspective):
    points = np.random.default_rng(2).normal(size=(40, 3)) * [3.0, 1.0, 0.5] + 5.0
    camera = Camera.framing(points, 1.6, 0.08, perspective)
    seen = camera.seen(points)
    assert np.all((seen > 0) & (seen < camera.size))
    assert camera.size[0] == pytest.approx(1.6 * camera.size[1])
    gap = np.minimum(seen, camera.size - seen).min(axis=0) / camera.size
    assert gap.min() < 0.15  # no nearer view would do: the margin is 0.08 of the extent
    depth = points @ ISOMETRIC[2]
    for moved in (camera.nearer(points, 0.3), camera.before_all(points), camera.behind_all(points)):
        np.testing.assert_allclose(camera.seen(moved), seen, atol=1e-11)  # round-off of coordinates near 5, some far away
    assert (camera.before_all(points) @ ISOMETRIC[2]).min() > depth.max()
    assert (camera.behind_all(points) @ ISOMETRIC[2]).max() < depth.min()


def test_panels_are_as_tall_as_what_they_show_within_bounds():
    x = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]])  # from the left to the right; z is up
    z = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for points, aspect in ((x, 1.8), (z, 1.2), (np.vstack([x, 2 * z]), 1.2), (np.zeros((1, 3)), 1.8)):
        assert natural_aspect(points, 1.2, 1.8) == aspect
    wide = np.vstack([[[0.0, 0.0, 0.0]], 1.5 * np.array([[1.0, 1.0, 0.0]]) / np.sqrt(2), [[0.0, 0.0, np.sqrt(1.5)]]])
    assert natural_aspect(wide, 1.2, 1.8) == pytest.approx(1.5)


def test_the_outermost_points_frame_like_all_points():
    points = np.random.default_rng(3).normal(size=(500, 3))
    few, every = (Camera.framing(some, 1.6, 0.1, False) for some in (outermost(points), points))
    np.testing.assert_allclose(few.size, every.size, rtol=1e-12)
    np.testing.assert_allclose(few.seen(points), every.seen(points), atol=1e-12)


@pytest.mark.parametrize("perspective", [False, True])
def test_a_point_is_drawn_at_the_pixel_that_the_panel_says(opengl, perspective, tmp_path):
    points = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 0.5], [1.2, -0.4, 0.9]])
    with drawing():
        from toolkit.render.space.parts import ball
        from toolkit.render.space.plotter import SpatialPanel, canvas

        with canvas(tmp_path / "balls.png", 400, 300, 1) as plotter:
            panel = SpatialPanel(plotter, 1, (50, 40, 320, 240), 10, Camera.framing(points, 320 / 240, 0.1, perspective))
            panel.open()
            for point, color in zip(points, np.eye(3), strict=True):
                panel.draw_front(ball(point, 0.05), color=color.tolist(), lighting=False)
    pixels = image(tmp_path / "balls.png").astype(int)
    for point, channel in zip(points, range(3), strict=True):
        rows, columns = np.nonzero((pixels[..., channel] > 200) & (np.delete(pixels, channel, axis=2).max(axis=2) < 60))
        found = np.array([columns.mean() - 50 + 0.5, 300 - rows.mean() - 0.5 - 40])
        np.testing.assert_allclose(found, panel.pixel(point), atol=1.0)  # pixels


@pytest.mark.parametrize("perspective", [False, True])
def test_a_mesh_that_is_drawn_in_front_covers_what_is_nearer(opengl, perspective, tmp_path):
    points = np.array([[0.0, 0.0, 0.0], [1.0, -1.0, 1.0]])  # one behind the other
    with drawing():
        from toolkit.render.space.parts import ball
        from toolkit.render.space.plotter import SpatialPanel, canvas

        with canvas(tmp_path / "balls.png", 300, 300, 1) as plotter:
            panel = SpatialPanel(plotter, 1, (0, 0, 300, 300), 10, Camera.framing(points, 1.0, 0.5, perspective))
            panel.open()
            panel.draw(ball(points[1], 0.2), color="red", lighting=False)
            panel.draw_front(ball(points[0], 0.1), color="blue", lighting=False)
            panel.draw_back(ball(points[1], 0.3), color="green", lighting=False)
    pixels = image(tmp_path / "balls.png")
    assert pixels[150, 150].tolist()[:3] == [0, 0, 255]
    assert distinct_colors(pixels) >= 4  # red round blue, green round red, white


def test_paraview_reads_displacement_von_mises_and_components(folder, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    from toolkit.render.paraview import export_paraview

    scene = gallows(folder)
    both = scene.model_copy(
        update={"bodies": {**scene.bodies, "beam": SpatialFlexible(model="beam.h5", frame="moving", position=(0.0, 1.0, 0.0))}}
    )
    design = ["bodies.beam.density", "bodies.frame.youngs_modulus_steel"]
    solution = bent(bent(rest(both, 3, design), "frame"), "beam", 1e-5)
    solution.q[3, solution.coordinates("beam").start] += 0.25
    solution.dq[3] = np.random.default_rng(4).normal(size=solution.dq[3].shape)
    reader = pyvista.get_reader(export_paraview(solution, tmp_path / "series"))
    assert reader.time_values == solution.times.tolist()
    reader.set_active_time_point(3)
    beams, solid, mechanism = reader.read()
    moment = SpatialConfiguration(solution, 3)
    np.testing.assert_array_equal(solid.points, body_shape(moment, "beam").points)
    moved = solid.points - body_shape(SpatialConfiguration(solution, 0), "beam").points
    np.testing.assert_allclose(solid["displacement in m"], moved, atol=1e-15)
    assert moved[:, 0].min() > 0.2
    xx, yy, zz, xy, yz, xz = solid["stress in Pa"].T  # in the order of VTK
    equivalent = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + xz**2))
    np.testing.assert_allclose(solid["von Mises stress in Pa"], equivalent, rtol=1e-12)  # round-off
    array = solid.GetPointData().GetArray("stress in Pa")
    assert [array.GetComponentName(k) for k in range(6)] == ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]
    field, rates = stress_field(solution, "beam")
    np.testing.assert_allclose(solid["von Mises stress in Pa"], field[3], rtol=1e-12)
    np.testing.assert_array_equal(solid[f"von Mises stress by {design[0]}"], rates[3, :, 0])
    assert beams["stress in Pa"].max() == pytest.approx(stress_field(solution, "frame")[0][3].max(), rel=1e-12)
    assert mechanism.n_points == 4  # a rod and a spring
    reader.set_active_time_point(0)
    assert all(not mesh[name].any() for mesh in reader.read()[:2] for name in ("displacement in m", "stress in Pa"))


def test_curves_of_rotations_count_whole_turns_and_swing_back():
    """About an axis that a tilted body carries round: its turns about the fixed axis, which its small rotation from the start hides."""
    about = np.append(np.linspace(0, 20, 401), np.linspace(20, 15, 101))
    axis, tilt = np.array([0.0, 0.6, 0.8]), Rotation.from_rotvec([0.3, 0.0, 0.0])
    turned = Rotation.from_rotvec(about[:, None] * axis) * tilt
    assert counted_angle(turned.as_matrix()) == pytest.approx(about, abs=1e-9)
    assert counted_angle(Rotation.from_rotvec(-about[:, None] * axis).as_matrix()) == pytest.approx(about, abs=1e-9)
    assert counted_angle(np.array([np.eye(3)])) == [0.0]
