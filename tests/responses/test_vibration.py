"""Frequencies and damping about an equilibrium, against closed forms and against the modes, which are found otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import ffrf
from tests.models.directions import along, derivative_along
from tests.models.response_cases import CASES, write_models
from toolkit.analyses.modes import solve_modes
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.curves.rise import Ramp
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.responses.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene

MASS, STIFFNESS, DAMPING = 2.0, 300.0, 7.0


def block(name: str, at: float, stiffness: float) -> Scene:
    """Parts of a block on a damped spring that slides along x, for a scene."""
    return {
        "points": {f"{name}E": Point(x=at, y=0.0), name: Point(x=at + 1.0, y=0.0)},
        "bodies": {name: Rigid(mass=MASS, inertia=0.1, center=name)},
        "joints": {f"guide{name}": Slider(bodies=(name, "ground"), point=name, axis=(1.0, 0.0), lock_rotation=True)},
        "loads": {
            f"spring{name}": SpringDamper(
                bodies=(name, "ground"), points=(name, f"{name}E"), stiffness=stiffness, damping=DAMPING
            )
        },
    }


def blocks(*stiffness: float) -> Scene:
    parts = [block(f"B{k}", 3.0 * k, each) for k, each in enumerate(stiffness)]
    groups = {group: {name: item for part in parts for name, item in part[group].items()} for group in parts[0]}
    loads = {**groups.pop("loads"), "weight": Gravity(acceleration=(-1.0, 0.0))}
    responses = {"f": Frequency(), "zeta": DampingRatio(), "last": Frequency(number=len(stiffness))}
    return Scene(units="m-kg-s", **groups, loads=loads, responses=responses)


@pytest.mark.parametrize("method", ["direct", "adjoint", "complex-step"])
def test_a_block_on_a_spring_vibrates_as_theory_says(method):
    """f = sqrt(k/m) / 2 pi, zeta = c / (2 sqrt(k m)); the damper does not change the undamped frequency."""
    design = {"k": "loads.springB0.stiffness", "m": "bodies.B0.mass", "c": "loads.springB0.damping"}
    found = gradients_by(method, blocks(STIFFNESS), list(design.values()), "static")
    f, zeta = np.sqrt(STIFFNESS / MASS) / (2 * np.pi), DAMPING / (2 * np.sqrt(STIFFNESS * MASS))
    # round-off of a problem of two numbers
    assert found.values["f"] == pytest.approx(f, rel=1e-12)
    assert found.values["zeta"] == pytest.approx(zeta, rel=1e-12)
    slopes = {"f": {"k": f / STIFFNESS / 2, "m": -f / MASS / 2, "c": 0.0}}
    slopes["zeta"] = {"k": -zeta / STIFFNESS / 2, "m": -zeta / MASS / 2, "c": zeta / DAMPING}
    for name, expected in slopes.items():
        ours = {letter: found.gradients[name][path] for letter, path in design.items()}
        assert ours == pytest.approx(expected, rel=1e-10, abs=1e-12 * found.values[name]), name


@pytest.mark.parametrize("method", ["direct", "adjoint", "complex-step"])
def test_a_block_that_comes_to_rest_has_the_frequency_of_its_equilibrium_with_its_damper(method):
    """sqrt(k/m - (c/2m)^2) / 2 pi at the end of a motion that starts 9.81 m/k from its equilibrium."""
    strong, end = 40.0, {"f": Frequency(when="end"), "zeta": DampingRatio(when="end")}
    scene = blocks(STIFFNESS)
    loads = {**scene.loads, "springB0": scene.loads["springB0"].model_copy(update={"damping": strong})}
    scene = scene.model_copy(update={"loads": loads, "responses": end, "solver": RunOptions(end_time=2.0, step=0.02)})
    found = gradients_by(method, scene, ["loads.springB0.stiffness"], "transient")
    square = STIFFNESS / MASS - (strong / MASS / 2) ** 2
    assert found.values["f"] == pytest.approx(np.sqrt(square) / (2 * np.pi), rel=1e-9)
    assert found.values["zeta"] == pytest.approx(strong / MASS / 2 / np.sqrt(STIFFNESS / MASS), rel=1e-9)
    slope = 1 / (2 * MASS * np.sqrt(square)) / (2 * np.pi)
    assert found.gradients["f"]["loads.springB0.stiffness"] == pytest.approx(slope, rel=1e-9)


def test_vibrations_of_one_frequency_have_no_derivative_of_their_own():
    """Which of both is the first would be decided by round-off."""
    found = gradients_by("direct", blocks(STIFFNESS, STIFFNESS), ["loads.springB0.stiffness"], "static")
    assert found.values["f"] == pytest.approx(found.values["last"], rel=1e-12)
    assert all(np.isnan(found.gradients[name]["loads.springB0.stiffness"]) for name in ("f", "last"))


@pytest.mark.parametrize("where", CASES)
def test_frequencies_are_those_of_the_modes_and_gradients_differences_of_whole_equilibria(where, tmp_path):
    write_models(tmp_path)
    asked = {"first": Frequency(), "second": Frequency(number=2), "damping": DampingRatio(number=2)}
    scene = CASES[where][0](tmp_path).model_copy(update={"responses": asked})
    names = ["loads.coil.stiffness", "bodies.crank.density", "loads.spring.damping", "points.A.y"]
    found = gradients_by("direct", scene, names, "static")
    modes = solve_modes(solve(prepare(scene), "static"), 2)
    assert [found.values["first"], found.values["second"]] == pytest.approx(modes.frequencies, rel=1e-8)  # round-off of both
    factors = {name: scene.number(name) for name in names}
    assert all(factors.values())
    wide, narrow = (derivative_along(scene, factors, "static", difference=h) for h in (2e-4, 1e-4))
    for response, slopes in found.gradients.items():
        near, far = narrow[response], wide[response]
        largest = max(abs(slopes[name] * factors[name]) for name in names)
        # round-off of a damping ratio of 1e-3, 1e-13, over the step of the extrapolated quotient: 1e-9 in 5e-4
        assert along(slopes, factors) == pytest.approx(near + (near - far) / 3, rel=0, abs=5e-6 * largest), response


def test_a_vibration_that_is_not_there_and_a_number_that_is_none_are_refused():
    scene = blocks(STIFFNESS)
    with pytest.raises(InputError, match=r"there are 1 vibrations about this equilibrium; number = 3 is none of them"):
        gradients_by("direct", scene.model_copy(update={"responses": {"f": Frequency(number=3)}}), [], "static")
    with pytest.raises(ValueError, match="greater than or equal to 1"):
        Frequency(number=0)


def ziegler(force: float, damping: float) -> Scene:
    """Two equal bars of 1 m and 1 kg, springs of 1 N m/rad in their hinges, and a force on the tip that follows the last bar."""
    places = {"O": 0.0, "A": 1.0, "B": 2.0, "M": 0.5, "N": 1.5}
    hinges = {"first": (("a", "ground"), "O"), "second": (("b", "a"), "A")}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=0.0) for name, x in places.items()},
        bodies={name: Rigid(mass=1.0, inertia=1 / 12, center=center) for name, center in (("a", "M"), ("b", "N"))},
        joints={name: Revolute(bodies=bodies, point=point) for name, (bodies, point) in hinges.items()},
        loads={
            **{
                name: RotationalSpringDamper(bodies=bodies, point=point, stiffness=1.0, damping=damping)
                for name, (bodies, point) in hinges.items()
            },
            "follower": PointForce(body="b", point="B", force=(-force, 0.0), frame="body"),
        },
        responses={"f": Frequency(), "zeta": DampingRatio()},
    )


@pytest.mark.parametrize(
    ("force", "damping", "asked"),
    [(2.5, 0.0, ()), (2.5, 0.0, ("f",)), (3.0, 0.0, ()), (3.0, 0.0, ("f",)), (2.0, 0.01, ("f",)), (2.0, 0.01, ("f", "zeta"))],
)
def test_what_flutters_is_doubted(force, damping, asked):
    """Ziegler's column: M = [4/3, 1/2; 1/2, 1/3], K = [2 - P, P - 1; -1, 1], which flutters beyond P = 2.54, and with a little damping
    before; statics are stable up to any load. A damping ratio that is asked for and negative says it itself."""
    mass, stiffness = np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]]), np.array([[2 - force, force - 1], [-1.0, 1.0]])
    dampers = damping * np.array([[2, -1], [-1, 1]])
    rates = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, each) for each in (stiffness, dampers)]])
    s = max(np.linalg.eigvals(rates), key=lambda root: root.real / abs(root))
    given = ziegler(force, damping)
    run = ffrf.compile(given.model_copy(update={"responses": {f: given.responses[f] for f in asked}})).statics()
    if "zeta" in asked:
        assert run.values["zeta"] == pytest.approx(-s.real / abs(s), rel=1e-8)
    found = [warning for warning in run.verdict.warnings if warning.code == "unstable-vibration"]
    assert [each.doubt for each in found] == ([] if force == 2.5 else ["zeta" not in asked])
    assert all(f"{np.exp(2 * np.pi * s.real / abs(s.imag)):.4g} times as large" in each.text for each in found)


@pytest.mark.parametrize(("beyond", "doubted"), [(2e-5, False), (2e-3, True)])
def test_a_flutter_that_the_damping_of_any_structure_holds_is_no_doubt(beyond, doubted):
    """Just beyond the force at which the squares of the same column are double, (tr)^2 = 4 det; Re s / |s| is 0.5 % and 5 %."""
    mass = np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]])

    def squares(force: float) -> np.ndarray:
        return np.linalg.eigvals(np.linalg.solve(mass, [[2 - force, force - 1], [-1.0, 1.0]]))

    critical = brentq(lambda force: np.real((squares(force)[0] - squares(force)[1]) ** 2), 2.0, 3.0)
    given = ziegler((1 + beyond) * critical, 0.0)
    found = ffrf.compile(given.model_copy(update={"responses": {}})).statics().verdict
    part = max(np.sqrt(-squares((1 + beyond) * critical)), key=lambda s: s.real)
    (caution,) = (each for each in found.warnings if each.code == "unstable-vibration")
    assert caution.doubt == doubted == (part.real / abs(part) > 0.01)
    assert (f"{part.real / abs(part):.1%} of the critical one would hold it" in caution.text) == (not doubted)


def test_modes_that_dampers_make_flutter_are_doubted():
    """The same: real frequencies without dampers, and s = 0.0145 +- 0.7048 i with them for point masses of 2 and 1 kg at the ends."""
    given = ziegler(2.0, 0.02)
    bodies = {"a": Rigid(mass=2.0, inertia=1e-9, center="A"), "b": Rigid(mass=1.0, inertia=1e-9, center="B")}
    found = ffrf.compile(given.model_copy(update={"bodies": bodies})).modes()
    assert found.damping is None
    assert found.verdict.codes[0] == "unstable-vibration"
    assert "0.1122 cycles per time" in found.verdict.reasons[0]
    assert "exp(0.01452 t)" in found.verdict.reasons[0]


@pytest.mark.parametrize(("force", "kick", "told"), [(2.0, 0.0, True), (1.3, 0.0, False), (2.0, 1e-3, False)])
def test_a_straight_motion_that_flutter_would_end_is_doubted(force, kick, told):
    """The same for 500 s; from the end of the pulse on a disturbance grows by exp(0.01452 t), and one that is there shows it by itself."""
    given = ziegler(force, 0.02)
    pulse = PointForce(body="b", point="B", force=(0.0, kick), curve=Ramp(initial=1.0, final=0.0, start=1.0, end=2.0))
    bodies = {"a": Rigid(mass=2.0, inertia=1e-6, center="A"), "b": Rigid(mass=1.0, inertia=1e-6, center="B")}
    changes = {"bodies": bodies, "loads": {**given.loads, "pulse": pulse}, "responses": {}}
    found = ffrf.compile(
        given.model_copy(update={**changes, "solver": RunOptions(end_time=500.0, step=0.25, rho_inf=1.0)})
    ).simulate()
    doubts = [each.text for each in found.verdict.warnings if each.code == "unstable-vibration"]
    assert len(doubts) == told
    grown = [float(each.split("what does becomes ")[1].split(" times")[0]) for each in doubts]
    assert grown == pytest.approx([np.exp(0.01452 * 498)] * told, rel=0.01)
