"""My linkage, optimised: the largest drop of a toggle that still has a quarter of its load in reserve before it snaps through.

What is done here in Python is also one command, with the study in a file: `ffrf optimize STUDY.toml`.
"""

# %% [markdown]
# Two springs lean against each other like a flat roof, and a force presses the ridge down. The harder one presses, the softer the
# toggle becomes, until it snaps through to the other side. How far can it be pressed, by which force, with some reserve? A study has
# a scene, what of it may change, an objective, and constraints.

# %%
import numpy as np

import ffrf
from ffrf import plane

scene = ffrf.Scene(
    units="m-kg-s",
    points={"ridge": plane.Point(x=0.0, y=0.5), "left": plane.Point(x=-1.0, y=0.0), "right": plane.Point(x=1.0, y=0.0)},
    bodies={"tip": plane.Rigid(mass=1.0, inertia=1.0, center="ridge")},
    joints={"guide": plane.Slider(bodies=("tip", "ground"), point="ridge", axis=(0.0, 1.0), lock_rotation=True)},
    loads={
        "a": plane.SpringDamper(bodies=("tip", "ground"), points=("ridge", "left"), stiffness=1000.0),
        "b": plane.SpringDamper(bodies=("tip", "ground"), points=("ridge", "right"), stiffness=1000.0),
        "push": plane.PointForce(body="tip", point="ridge", force=(0.0, -30.0)),
    },
    design={"F": "loads.push.force.y"},
    responses={"rise": plane.Displacement(body="tip", point="ridge", component="y")},
)

# %% [markdown]
# Two variables: the force, and the stiffness of both springs together, by which they may differ from what the scene has. The load
# margin is built in: by which factor all loads can grow until the first limit point.

# %%
study = {
    "scene": "",  # the scene is here already
    "variables": {
        "F": {"between": (-200.0, -10.0)},
        "softer": {"of": ("loads.a.stiffness", "loads.b.stiffness"), "between": (-300.0, 200.0)},
    },
    "objective": {"minimize": "rise"},
    "constraints": {"load_margin": {"above": 1.25}},
    "search": {"optimality": 1e-6, "certify": False},
}
found = ffrf.optimize(ffrf.Study.model_validate(study), scene=scene)
print(f"F = {found.variables['F']:.3f} N, springs of {1000 + found.variables['softer']:.1f} N/m: {found.values['rise']:.4f} m")
print(f"{found.evaluations} designs, KKT residual {found.optimality:.1e}; {found.verdict}")

# %% [markdown]
# What a limit costs is its price: so much would be gained if it gave way by one.

# %%
for price in found.prices:
    print(price.text)

# %% [markdown]
# Is it right? The force that this toggle bears is known in closed form; the optimum must be at that force over 1.25. Without the
# margin the best design is the cliff itself. The search tries designs beyond it, which snap through, and steps back from them: no
# number stands for a design that has none. Where it ends is no optimum, and that is said: `cliff.check()` would raise it, and the
# command ends with an error.

# %%
stiffness, length = 1000 + found.variables["softer"], np.hypot(1.0, 0.5)
limit = 2 * stiffness * (length ** (2 / 3) - 1.0) ** 1.5
cliff = ffrf.optimize(ffrf.Study.model_validate({**study, "constraints": {}}), scene=scene)
print(f"without the margin: success {cliff.success}, {cliff.failed} of {cliff.evaluations} designs snapped through")

assert found.success
assert not cliff.success
check = -found.variables["F"] / (limit / 1.25) - 1.0
print(f"off the closed form by {check:.1e}")
