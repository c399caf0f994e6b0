"""Adding a joint of your own: a pair of gears, with all derivatives, checked before it is used."""

# %% [markdown]
# A joint says what two bodies may not do. Two gears may not turn as they like: angle_a + n angle_b = 0, with the ratio n of
# their teeth. Forces, accelerations and sensitivities are made from that by the program, if it comes with its derivatives, in
# one function, which is compiled. Its arguments z are x, y, angle of body a (0, 1, 2), x, y, angle of body b (3, 4, 5), then
# the joint's parameters (6, ...): here n.
#
# What numbers measure stands beside them: `rows` names each row of phi and says whether it is a length or an angle, and the ratio
# is a pure number. Units of gradients and scenes in other units follow from that.

# %%
from typing import Annotated

import toolkit as ffrf
from toolkit import extend, plane


@extend.kernel
def gear_law(z, w, phi, phi_z, phi_zz, phi_zww):
    """phi = angle_a + n angle_b, its first and its second derivatives; whatever is not written here is zero."""
    phi[0] = z[2] + z[6] * z[5]
    phi_z[0, 2], phi_z[0, 5], phi_z[0, 6] = 1, z[6], z[5]
    phi_zz[0, 5, 6] = phi_zz[0, 6, 5] = 1


class Gears(extend.PlanarJoint):
    """Body a turns -n times as far as body b; each body is gripped at its own point."""

    kind = "gears"
    formula = gear_law
    points: tuple[str, str]
    ratio: Annotated[extend.Number, extend.Quantity("none")]

    @property
    def grips(self):
        return (self.bodies[0], self.points[0]), (self.bodies[1], self.points[1])

    @property
    def rows(self):
        return [("rotation", "angle")]

    def parameters(self, scene):
        return [self.ratio]


# %% [markdown]
# Two wheels on their axles, geared 1 : 3, and a motor on the first. `check_joint` holds every derivative against a complex
# step of the law.

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
# Change a sign in `gear_law` and run that cell again: the error names the derivative that is wrong, and by how much.
#
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
