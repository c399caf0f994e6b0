"""A mechanism with everything: driver, flexible rod, ball joint, cross, slide, spring, torques fixed in space and in a body."""

from __future__ import annotations

from pathlib import Path

from tests.spatial.scenes import at, save_frame
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import SpatialRigid
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import SpatialAngleDriver
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.spherical import Spherical
from toolkit.components.joints.universal import Universal
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.point_force import SpatialPointForce
from toolkit.components.loads.springs import SpatialSpringDamper
from toolkit.components.loads.torque import SpatialTorque
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral
from toolkit.scene.scene import Scene

ROD = """units = "m-kg-s"
clamp = ["T"]
nodes = { T = [0, 0, 0], M = [0.4, 0.05, 0.02], S = [0.8, 0, -0.1] }
beams = [
    { from = "T", to = "M", section = "rod", elements = 2 },
    { from = "M", to = "S", section = "rod", elements = 2 },
]
sections = { rod = { kind = "tube", diameter = 0.02, wall = 0.003, material = "steel" } }
materials = { steel = { youngs_modulus = 2e9, poisson_ratio = 0.3, density = 2000.0 } }
damping = { stiffness = 1e-4 }
interface_points = { T = { node = "T" }, S = { node = "S" } }
basis = { kind = "eigenmodes", count = 2 }
"""


def spatial_crank(folder: Path) -> Scene:
    """A crank that turns about an oblique axis pushes a slider along x through a flexible rod: ball joint at T, cross at S."""
    save_frame(folder, "rod", ROD)
    return Scene(
        units="m-kg-s",
        dimension=3,
        directory=folder,
        points={
            **at(O=(0, 0, 0), H=(0.02, 0.1, 0.03), C=(0.9, 0.3, 0.0), W=(0.5, -0.4, 0.3)),
            "T": BodyPoint(body="rod", interface="T"),
            "S": BodyPoint(body="rod", interface="S"),
        },
        bodies={
            "crank": SpatialRigid(mass=0.5, inertia=(4e-3, 1e-3, 4e-3, 2e-4, 1e-4, -3e-4), center="H"),
            "rod": SpatialFlexible(model="rod.h5", frame="moving", position=(0.05, 0.2, 0.1), orientation=(0.1, -0.05, 0.2)),
            "slider": SpatialRigid(mass=0.8, inertia=(1e-3, 2e-3, 2e-3), center="C"),
        },
        joints={
            "O": SpatialRevolute(bodies=("crank", "ground"), point="O", axis=(0.2, 0.1, 1.0)),
            "drive": SpatialAngleDriver(
                bodies=("crank", "ground"), point="O", axis=(0.2, 0.1, 1.0), curve=SmoothStep(height=1.2, duration=0.5)
            ),
            "T": Spherical(bodies=("crank", "rod"), point="T"),
            "S": Universal(bodies=("rod", "slider"), point="S", axes_of_cross=((0.0, 1.0, 0.2), (0.0, -0.2, 1.0))),
            "slide": Prismatic(bodies=("slider", "ground"), point="C", axis=(1.0, 0.1, 0.0)),
        },
        loads={
            "weight": SpatialGravity(acceleration=(0.0, 0.0, -9.81)),
            "pull": SpatialPointForce(body="slider", point="C", force=(-3.0, 0.0, 1.0), frame="body"),
            "motor": SpatialTorque(body="rod", point="S", torque=(0.1, 0.2, 0.0), frame="body", reaction="slider"),
            "wind": SpatialTorque(body="rod", point="T", torque=(0.05, 0.0, -0.1)),
            "spring": SpatialSpringDamper(bodies=("rod", "ground"), points=("S", "W"), stiffness=50.0, damping=0.5),
        },
        responses={
            "way": Displacement(body="slider", point="C", component="x"),
            "turn": Rotation(body="rod", point="S", axis=(0.0, 0.0, 1.0)),
            "push": JointForce(joint="T", component="magnitude"),
            "couple": JointForce(joint="O", component="torque-y"),
            "energy": TimeIntegral(of=KineticEnergy()),
            "strain": StrainEnergy(),
        },
        solver=RunOptions(end_time=0.2, step=0.02, rho_inf=0.6, tolerance=1e-12, drift_tolerance=0.1),
    )
