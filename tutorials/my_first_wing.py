"""My first wing: simulate a wing whose nose changes its shape, and ask what the design does to it.

Run it as a script, or cell by cell in an editor that knows `# %%`. The first run compiles the formulas, which takes two minutes.
"""

# %% [markdown]
# A glider wants a slim wing nose at high speed and a drooped one at low speed. Instead of a flap, this wing bends its own
# skin: a torque turns a small linkage inside the nose, and the linkage pulls the skin into the other shape. Everything about
# it is written in one file.

# %%
import tempfile
from pathlib import Path

import ffrf

MODELS = Path(__file__).parents[1] / "models"
scene = ffrf.read_scene(MODELS / "morphing_wing" / "scene.toml")
print("bodies:", ", ".join(scene.bodies))
print("joints:", ", ".join(scene.joints))

# %% [markdown]
# `bodies` has four rods, `body2` to `body5`, and the `skin`: a thin aluminium sheet, cut into 30 short beams. The skin is
# flexible, so it has many coordinates of its own (90 here), while a rod has three: where it is and how it is turned.
#
# The scene is compiled once, with the numbers by which derivatives are wanted. One call then simulates the motion and gives
# the responses that the file asks for, each with its derivative by each of these design variables.

# %%
model = ffrf.compile(scene, variables=["t_w", "M_t"])
result = model.simulate(gradients=True)
for name, value in result.values.items():
    slopes = {variable: float(f"{slope:.3g}") for variable, slope in result.gradients[name].items()}
    print(f"{name:18} {value:9.4f} {result.units[name]:4}", slopes)

# %% [markdown]
# Pictures show it: the wing at telling instants, coloured by its stress, and curves over time.

# %%
folder = Path(tempfile.mkdtemp())
for file in result.render(folder, instants=[0.0, 0.4, 0.6, 1.2], width=1200):
    print("drawn:", file.name)

# %% [markdown]
# Read it like this: the largest stress is 57 MPa, harmless for aluminium. In the end the skin is 0.33 mm off the wanted shape
# (root mean square). The derivatives say what to do: by `t_w`, the thickness of the skin, and `M_t`, the torque of the drive.
# A skin 0.1 mm thicker should change the stress by about 0.1 times its slope. Is that true?

# %%
for more in (0.001, 0.01, 0.1):
    thicker = model.simulate({"t_w": 1.5 + more})
    change = thicker.values["max_stress"] - result.values["max_stress"]
    print(f"{more:5} mm thicker: predicted {more * result.gradients['max_stress']['t_w']:8.5f} MPa, simulated {change:8.5f} MPa")

# %% [markdown]
# For small steps, very well; for 0.1 mm, 7 % of the thickness, the true curve has bent away. A slope is a straight line:
# trust it near the design where it was taken.
#
# The stress itself is known at both ends of all 30 elements, inside and outside, at all times; so is its derivative.

# %%
stress, stress_by_design = result.stress("skin")  # (times, places), (times, places, variables)
time, place = divmod(int(stress.argmax()), stress.shape[1])
check = float(stress.max())
print(f"largest stress {check:.2f} MPa in element {place // 4 + 1} of 30, at t = {result.solution.times[time]:.2f} s")
print("its derivative by t_w:", float(f"{stress_by_design[time, place, 0]:.4g}"), "MPa/mm")
