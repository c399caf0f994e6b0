"""Adding a force of your own that depends on states: a fan's drag, and a motor that needs time, checked before they are used."""

# %% [markdown]
# A load acts along what it measures between two bodies: an angle, an offset along an axis, a distance g. Its law is a number u: a torque or
# force that does work as g grows. The functions below turn u and its derivatives by g, by the rate r = g' and by the load's numbers into
# what the equations need, in the plane (6 numbers of both poses) and in space (24) alike:
#
# * `plane_angle`, `plane_offset`, `space_angle`, `space_offset`, `distance` measure g,
# * `rate_along` gives its rate r,
# * `act_along` takes u, u_g and u_r; `add_parameter` the derivative by a number z[k], `add_state` that by a state,
# * `scale_force` comes last.
#
# Numbers of the load stand behind the poses in z, the value of its time curve in the last place.

# %%
from typing import Annotated

import numpy as np

import ffrf
from ffrf import extend, plane
from toolkit.api.extend import act_along, add_parameter, add_state, plane_angle, rate_along, scale_force


@extend.kernel
def fan_law(z, w, force, force_z, force_w):
    """u = - c r |r|, c = z[6]; |r| is written so that it takes complex numbers, by which derivatives are checked."""
    plane_angle(z, force, force_z)
    rate = rate_along(6, w, force)
    size = rate if rate.real > 0 else -rate
    u = -z[6] * rate * size
    act_along(6, u, 0 * u, -2 * z[6] * size, w, force, force_z, force_w)
    add_parameter(6, 6, -rate * size, force, force_z)
    scale_force(6, u, force)


class Fan(extend.BetweenBodies, extend.PlanarLoad):
    """Drag that grows with the square of the rate of rotation."""

    kind = "fan"
    formula = fan_law
    drag: Annotated[extend.NotNegative, extend.Quantity("torque time^2/angle^2")]

    def parameters(self, scene):
        return [self.drag]


# %% [markdown]
# A rotor of inertia J under a torque M has r = sqrt(M/c) tanh(t sqrt(M c) / J). `check_load` holds every derivative against a complex step.

# %%
place = {"bodies": ("rotor", "ground"), "point": "O"}
fan = Fan(**place, drag=0.02)
scene = ffrf.Scene(
    units="m-kg-s",
    points={"O": plane.Point(x=0.0, y=0.0)},
    bodies={"rotor": plane.Rigid(mass=1.0, inertia=0.05, center="O")},
    joints={"axle": plane.Revolute(**place)},
    loads={"fan": fan, "torque": plane.Torque(body="rotor", point="O", torque=0.5)},
    responses={"energy": plane.KineticEnergy()},
    solver=ffrf.RunOptions(end_time=0.5, step=0.001),
)
extend.check_load(fan, scene)
run = ffrf.compile(scene, variables=["loads.fan.drag"]).simulate(gradients=True)
rate = np.sqrt(0.5 / 0.02) * np.tanh(0.5 * np.sqrt(0.5 * 0.02) / 0.05)
print(
    f"energy {run.values['energy']:.6f} J, theory {0.05 * rate**2 / 2:.6f}; by the drag {run.gradients['energy']['loads.fan.drag']:.4f}"
)

# %% [markdown]
# Some forces have a state of their own, x with a rate x' of its own: a motor whose torque needs time to build up, a filter, an integral.
# The state stands in w behind the rates of the poses, w[6] in the plane and w[24] in space; its rate goes into the same place of
# `force`. The property `state` says that there is one, and what it is compared with: a length, or an angle and pure numbers.


# %%
@extend.kernel
def motor_law(z, w, force, force_z, force_w):
    """u = M x, x' = (s - x) / T, (M, T) = z[6:8], s the value of the time curve, in the last place of z, 1 without one."""
    last = len(z) - 1
    plane_angle(z, force, force_z)
    u = z[6] * w[6]
    act_along(6, u, 0 * u, 0 * u, w, force, force_z, force_w)
    add_parameter(6, 6, w[6], force, force_z)
    add_state(6, z[6], force, force_w)
    scale_force(6, u, force)
    force[6] = (z[last] - w[6]) / z[7]
    force_w[6, 6], force_z[6, 7], force_z[6, last] = -1 / z[7], -force[6] / z[7], 1 / z[7]


class SlowMotor(Fan):
    """A torque that follows what it is told within a time."""

    kind = "slow-motor"
    formula = motor_law
    drag: Annotated[extend.Number, extend.Quantity("torque")]
    delay: Annotated[extend.Positive, extend.Quantity("time")]

    @property
    def state(self):
        return "angle"

    def parameters(self, scene):
        return [self.drag, self.delay]


motor = SlowMotor(**place, drag=0.5, delay=0.2)
extend.check_load(motor, scene)
values = ffrf.compile(scene.model_copy(update={"loads": {"motor": motor}})).simulate().values
rate = 0.5 / 0.05 * (0.5 - 0.2 * (1 - np.exp(-0.5 / 0.2)))
print(f"energy {values['energy']:.6f} J, theory {0.05 * rate**2 / 2:.6f}")
check = values["energy"] / (0.05 * rate**2 / 2) - 1
