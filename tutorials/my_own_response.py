"""Asking a question of your own: how near does a crank come to a post, with all derivatives, checked before it is used."""

# %% [markdown]
# A response is a number of the motion with its derivatives. Most look at points of bodies: then it is one formula of the motion of
# these points, `y` (their position, and in the plane their angle), `rate` and `acceleration`, with the derivatives by them. How they
# depend on coordinates, velocities and the design is the program's business.
#
# The clearance of a tool beside a round post is the distance of two points less the post's radius.

# %%
from typing import Annotated

import numpy as np

import ffrf
from ffrf import extend, plane


class Clearance(extend.MarkerFormula):
    """Distance of a point of a body from a round post on the ground."""

    kind = "clearance"
    quantity = "length"
    body: str
    point: str
    post: str
    radius: Annotated[extend.Positive, extend.Quantity("length")]

    def markers(self):
        return (self.body, self.point), ("ground", self.post)

    def formula(self, tool, post):
        way = tool.y[:2] - post.y[:2]
        length = np.sqrt(way @ way)
        side = np.array([[*way / length, 0.0]])
        return np.array([length - self.radius]), [extend.Motion(y=side), extend.Motion(y=-side)]


# %% [markdown]
# A crank of 1 m turns by a right angle and passes a post. `check_response` holds every derivative against a complex step.

# %%
clearance = Clearance(body="crank", point="A", post="P", radius=0.05)
scene = ffrf.Scene(
    units="m-kg-s",
    points={"O": plane.Point(x=0.0, y=0.0), "A": plane.Point(x=1.0, y=0.0), "P": plane.Point(x=0.9, y=0.9)},
    bodies={"crank": plane.Rod(between=("O", "A"), area=1e-4, density=7800.0)},
    joints={
        "axle": plane.Revolute(bodies=("crank", "ground"), point="O"),
        "drive": plane.AngleDriver(bodies=("crank", "ground"), point="O", curve=plane.SmoothStep(height=np.pi / 2, duration=1.0)),
    },
    responses={"nearest": plane.TimeMin(of=clearance), "at the end": clearance},
    solver=ffrf.RunOptions(end_time=1.0, step=0.005),
)
extend.check_response(clearance, scene)
print("the clearance is right in all its derivatives")

# %% [markdown]
# Over time it is one of the questions that are there: `TimeMin`, `TimeMean`, `TimeKS`, ... take any response at one time, yours too. After
# half of the time the crank points at the post: sqrt(2) 0.9 - 1 - 0.05 are left, and by the post's x it is cos(45 deg).

# %%
run = ffrf.compile(scene, variables=["points.P.x"]).simulate(gradients=True)
nearest, slope = run.values["nearest"], run.gradients["nearest"]["points.P.x"]
print(f"nearest {nearest:.6f} {run.units['nearest']}, geometry {np.sqrt(2) * 0.9 - 1.05:.6f}")
print(f"by the post's x {slope:.6f}, geometry {np.sqrt(0.5):.6f}")
check = slope / np.sqrt(0.5) - 1
