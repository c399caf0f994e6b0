"""Adding a joint of your own: a pair of gears as a row of poses, a cam as an open formula, checked before they are used."""

# %% [markdown]
# A joint says what two bodies may not do. Two gears may not turn as they like: angle_a + n angle_b = 0, with the ratio n of
# their teeth. Forces, accelerations and sensitivities are made from that by the program. In the plane and in space it is stated in
# the same way: `constraint` gives rows of the two `poses`. A pose has a position `r`, axes `e(1)`, `e(2)` (in space `e(3)`) and in the
# plane an `angle`; vectors are added and multiplied with `@`, and everything else follows, derivatives too.
#
# What numbers measure stands beside them: a row has a name and says whether it is a length or an angle, and the ratio is a pure number.
# Units of gradients and scenes in other units follow from that.

# %%
from typing import Annotated

import numpy as np

import ffrf
from ffrf import extend, plane


class Gears(extend.PlanarJoint):
    """Body a turns -n times as far as body b; each body is gripped at its own point."""

    kind = "gears"
    points: tuple[str, str]
    ratio: Annotated[extend.Number, extend.Quantity("none")]

    @property
    def grips(self):
        return (self.bodies[0], self.points[0]), (self.bodies[1], self.points[1])

    def constraint(self, scene):
        a, b = self.poses
        return (extend.Row("rotation", "angle", a.angle + self.ratio * b.angle),)


# %% [markdown]
# Two wheels on their axles, geared 1 : 3, and a motor on the first. `check_joint` holds every derivative of the equations
# against a complex step.

# %%
gears = Gears(bodies=("small", "large"), points=("A", "B"), ratio=3.0)
axles = {point: plane.Revolute(bodies=(body, "ground"), point=point) for body, point in (("small", "A"), ("large", "B"))}
scene = ffrf.Scene(
    units="m-kg-s",
    points={"A": plane.Point(x=0.0, y=0.0), "B": plane.Point(x=0.4, y=0.0)},
    bodies={"small": plane.Rigid(mass=1.0, inertia=0.02, center="A"), "large": plane.Rigid(mass=9.0, inertia=1.5, center="B")},
    joints={**axles, "gears": gears},
    loads={"motor": plane.Torque(body="small", point="A", torque=0.5)},
    responses={"turned": plane.Rotation(body="small", point="A")},
)
extend.check_joint(gears, scene)
print("the gears are right in all their derivatives")

# %% [markdown]
# Now the motion. The large wheel counts with its inertia over n^2, so after t = 1 s theory has
#
#     angle = t^2 / 2 torque / (0.02 + 1.5 / n^2).

# %%
model = ffrf.compile(scene, variables=["joints.gears.ratio"])
result, inertia = model.simulate(gradients=True), 0.02 + 1.5 / 3**2
slope = 0.5 * 0.5 / inertia**2 * 2 * 1.5 / 3**3
print(f"turned {result.values['turned']:.6f} rad, theory {0.5 * 0.5 / inertia:.6f}")
print(f"by the ratio {result.gradients['turned']['joints.gears.ratio']:.6f}, theory {slope:.6f}")
check = result.gradients["turned"]["joints.gears.ratio"] / slope - 1

# %% [markdown]
# The program has a joint `gear` of its own, which also knows carriers that turn, and a `cam` that follows any curve; these show how one is
# made. Not every law is made of sums and products. A cam is not: a follower's height is a function of how far the cam has turned. Such a
# row takes an open formula, compiled, of whatever it needs of both poses, h: here the height, the angle and the eccentricity, a number.
# It fills g and its derivatives by h: first ones, second ones, and those of w^T g_hh w, w = h' being the rates. What is not written is
# zero. Open formulas are the same in space.


# %%
@extend.kernel
def cam_law(h, w, g, g_h, g_hh, g_hww):
    """g = height - e (1 - cos angle) of h = (height, angle, e)."""
    c, s = np.cos(h[1]), np.sin(h[1])
    g[0] = h[0] - h[2] * (1 - c)
    g_h[0], g_h[1], g_h[2] = 1, -h[2] * s, c - 1
    g_hh[1, 1] = -h[2] * c
    g_hh[1, 2] = g_hh[2, 1] = -s
    g_hww[1] = h[2] * s * w[1] * w[1] - 2 * c * w[1] * w[2]
    g_hww[2] = -c * w[1] * w[1]


class Cam(Gears):
    """Body a rises as the cam, body b, turns."""

    kind = "eccentric"
    ratio: Annotated[extend.Number, extend.Quantity("length")]

    def constraint(self, scene):
        a, b = self.poses
        return (extend.Row("height", "length", (a.r[1] - b.r[1], b.angle, self.ratio), cam_law),)


extend.check_joint(Cam(bodies=("small", "large"), points=("A", "B"), ratio=0.1), scene)
print("the cam is right in all its derivatives")

# %% [markdown]
# Change a sign in `cam_law` and run that cell again: the error names the derivative that is wrong, and by how much.
