"""A four-bar linkage in Python: build a mechanism without any file, drive it, and differentiate it by its lengths.

The result is compared with the triangle formulas of school geometry.
"""

# %% [markdown]
# A crank A-B turns, a coupler B-C pushes, a rocker C-D swings; A and D sit on the ground. Points come first: rods run between
# them and joints sit at them, so that moving a point moves everything that hangs on it.

# %%
import tempfile

import numpy as np

import ffrf
from ffrf import plane

TURN = 2 * np.pi / 3  # the crank turns by 120 degrees, softly, within a second
rod = {"area": 4e-4, "density": 2700.0}  # aluminium, 20 mm x 20 mm
scene = ffrf.Scene(
    units="m-kg-s",
    points={
        "A": plane.Point(x=0.0, y=0.0),
        "B": plane.Point(x=0.1, y=0.0),
        "C": plane.Point(x=0.25, y=0.2),
        "D": plane.Point(x=0.3, y=0.0),
    },
    bodies={
        "crank": plane.Rod(between=("A", "B"), **rod),
        "coupler": plane.Rod(between=("B", "C"), **rod),
        "rocker": plane.Rod(between=("C", "D"), **rod),
    },
    joints={
        "A": plane.Revolute(bodies=("crank", "ground"), point="A"),
        "B": plane.Revolute(bodies=("crank", "coupler"), point="B"),
        "C": plane.Revolute(bodies=("coupler", "rocker"), point="C"),
        "D": plane.Revolute(bodies=("rocker", "ground"), point="D"),
        "motor": plane.AngleDriver(bodies=("crank", "ground"), point="A", curve=plane.SmoothStep(height=TURN, duration=1.0)),
    },
    responses={
        "swing": plane.Rotation(body="rocker", point="D"),
        "torque": plane.JointForce(joint="motor", component="torque", time=0.25),
    },
    solver=ffrf.RunOptions(end_time=1.2, step=0.005),
)

# %% [markdown]
# The design variables are numbers of the scene, by their path. Which ones there are, `scene.available_paths()` tells. `render`
# draws the motion into a folder.

# %%
model = ffrf.compile(scene, variables=["points.D.x", "points.C.y", "joints.motor.curve.height"])
result = model.simulate(gradients=True)
for name, slopes in result.gradients.items():
    print(
        f"{name:7} {result.values[name]:9.6f} {result.units[name]:4}",
        {path: float(f"{slope:.4g}") for path, slope in slopes.items()},
    )
result.render(tempfile.mkdtemp(), instants=[0.0, 0.4, 0.6, 1.2], width=1200)


# %% [markdown]
# Is it right? The coupler and the rocker keep their lengths, so C lies where two circles round B and D meet. With the
# diagonal from D to B: its angle, and the angle of the triangle at D by the law of cosines.


# %%
def rocker_angle(turn: float, d_x: float = 0.3) -> float:
    """Direction of the rocker seen from D when the crank has turned."""
    tip, pivot, joint = 0.1 * np.array([np.cos(turn), np.sin(turn)]), np.array([d_x, 0.0]), np.array([0.25, 0.2])
    coupler, rocker = np.linalg.norm(joint - [0.1, 0.0]), np.linalg.norm(joint - pivot)
    diagonal = np.linalg.norm(tip - pivot)
    corner = np.arccos((diagonal**2 + rocker**2 - coupler**2) / (2 * diagonal * rocker))
    return float(np.arctan2(*(tip - pivot)[::-1]) % (2 * np.pi) - corner)


swing = rocker_angle(TURN) - rocker_angle(0.0)
farther, nearer = (rocker_angle(TURN, d_x) - rocker_angle(0.0, d_x) for d_x in (0.300001, 0.299999))
slope = (farther - nearer) / 2e-6
print(f"geometry: swing {swing:.6f} rad, by D.x {slope:.4f} rad/m")
check = result.values["swing"] - swing
print(f"difference of the swing: {check:.1e} rad")
