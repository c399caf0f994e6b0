"""A rotating flexible beam against theory: how a body can be flexible and turn as far as it likes.

The floating frame of reference: a frame turns with the body, and only the small deformations are measured in it.
"""

# %% [markdown]
# Swing a rubber band round your head and it gets longer: every piece pulls at the pieces further in. For a beam of length L
# that rotates with Omega, a piece at x pulls with its mass times Omega^2 x. All pieces beyond x together give the stress
#
#     sigma(x) = rho Omega^2 (L^2 - x^2) / 2,
#
# if it does not stretch visibly. First the beam: 20 elements of steel, 1 m long, 20 mm by 50 mm, with a little damping, so
# that it comes to rest in its frame.

# %%
import tempfile
from pathlib import Path

import numpy as np

import ffrf
from ffrf import plane

folder = Path(tempfile.mkdtemp())
steel = ffrf.preprocessing.Section(youngs_modulus=210e9, density=7800.0, thickness=0.02, width=0.05, damping_stiffness=1e-3)
nodes = np.column_stack([np.linspace(0, 1, 21), np.zeros(21)])
ffrf.preprocessing.save(ffrf.preprocessing.polygon_beam(nodes, steel, {"hub": 0.0, "tip": 1.0}), folder / "beam.h5")


# %% [markdown]
# Then the scene: the beam hangs on a hinge at its hub and starts with the rate Omega. It has a floating frame with
# three coordinates, x, y and the angle; 60 more describe how it is bent and stretched in that frame.


# %%
model = ffrf.compile(
    ffrf.Scene(
        units="m-kg-s",
        directory=folder,
        points={"hub": plane.BodyPoint(body="beam", interface="hub")},
        bodies={"beam": plane.Flexible(model="beam.h5", angular_velocity=20.0)},
        joints={"hub": plane.Revolute(bodies=("beam", "ground"), point="hub")},
        responses={"stress": plane.MaxStress(body="beam", when="end")},
        solver=ffrf.RunOptions(end_time=1.0, step=0.001, rho_inf=0.8),
    ),
    variables=["bodies.beam.density"],
)

# %% [markdown]
# The stress at the hub for several rates, and its derivative by the density, which theory gives as well: sigma / rho. An
# element carries the mean of the stress over its length h = L / 20, which is rho Omega^2 (L^2 - h^2 / 3) / 2 for the first.

# %%
for rate in (20.0, 40.0):
    result = model.simulate({"bodies.beam.angular_velocity": rate}, gradients=True)
    theory = 7800 * rate**2 * (1 - 0.05**2 / 3) / 2
    ratio, slope = result.values["stress"] / theory, result.gradients["stress"]["bodies.beam.density"] * 7800 / theory
    print(f"{rate:3.0f} rad/s: {theory / 1e6:.4f} MPa; simulation / theory {ratio:.6f}, for the slope {slope:.6f}")

# %% [markdown]
# The small rest is the stretching itself: a longer beam turns more slowly, because nothing drives it. And the whole curve,
# element by element:

# %%
stress = result.stress("beam")[0][-1].reshape(20, 4).mean(axis=1)
x = (np.arange(20) + 0.5) / 20
curve = 7800 * 40.0**2 * (1 - x**2 - 0.05**2 / 12) / 2
check = float(np.abs(stress / curve - 1).max())
print(f"largest relative difference along the beam at 40 rad/s: {check:.1e}")
