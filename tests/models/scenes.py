"""Scenes that several tests share."""

from pathlib import Path

from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.responses.shape_error import ShapeMax, ShapeMSE, ShapeRMS
from toolkit.responses.stress import KSStress, MaxStress
from toolkit.scene.scene import Scene

MODELS = Path(__file__).parents[2] / "models" / "morphing_wing"
WING = MODELS / "scene.toml"


def hanging_skin(**changes) -> Scene:
    """The skin hangs, with a moving frame, from a pendulum and a distance rod; every kind of response looks at it."""
    skin = {"body": "skin"}
    parts = {
        "units": "mm-t-s",
        "directory": MODELS,
        "points": {
            "O": Point(x=20.0, y=80.0),
            "C": BodyPoint(body="skin", interface="C"),
            "E": BodyPoint(body="skin", interface="E"),
            "P": Point(x=120.0, y=90.0),
            "S": Point(x=-30.0, y=10.0),
        },
        "bodies": {
            "skin": Flexible(model="skin.h5", frame="moving", position=(3.0, 5.0), angle=0.1),
            "arm": Rod(between=("O", "C"), area=50.0, density=2.7e-9),
            "block": Rigid(mass=1e-4, inertia=0.05, center="S"),
        },
        "joints": {
            "O": Revolute(bodies=("arm", "ground"), point="O"),
            "C": Revolute(bodies=("arm", "skin"), point="C"),
            "rod": Distance(bodies=("skin", "ground"), points=("E", "P")),
            "guide": Slider(bodies=("block", "arm"), point="S", axis=(1.0, 0.3)),
        },
        "loads": {
            "weight": Gravity(acceleration=(0.0, -9810.0)),
            "drive": Torque(body="arm", point="O", torque=300.0, curve=SmoothStep(duration=0.02)),
        },
        "responses": {
            "ks": KSStress(**skin, aggregation=2.0),
            "ks_absolute": KSStress(**skin, aggregation=30.0, reference_stress=1.0, measure="absolute", when="end"),
            "largest": MaxStress(**skin),
            "mse": ShapeMSE(**skin),
            "rms": ShapeRMS(**skin),
            "gap": ShapeMax(**skin),
            "angle": Rotation(body="arm", point="O"),
            "early_angle": Rotation(**skin, point="E", time=0.004),
            "dx": Displacement(**skin, point="E", component="x"),
            "move": Displacement(body="block", point="S", component="magnitude"),
            "force": JointForce(joint="C", component="magnitude"),
            "rod_force": JointForce(joint="rod", component="x", time=0.006),
            "guide_torque": JointForce(joint="guide", component="y"),
            "energy": TimeIntegral(of=KineticEnergy()),
            "strain": StrainEnergy(),
        },
        "solver": RunOptions(end_time=0.01, step=0.001),
    }
    return Scene(**{**parts, **changes})


HANGING_DESIGN = [
    "points.O.x",
    "points.P.y",
    "points.S.x",
    "bodies.skin.thickness",
    "bodies.skin.youngs_modulus",
    "bodies.skin.density",
    "bodies.skin.angle",
    "bodies.skin.position.x",
    "bodies.block.mass",
    "joints.guide.axis.x",
    "loads.drive.torque",
    "loads.drive.curve.duration",
    "loads.weight.acceleration.y",
]
