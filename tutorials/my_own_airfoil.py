"""My own airfoil: from a list of points to a morphing wing, and closer to its target.

What is done here in Python is also one command each: `ffrf new wing`, `ffrf-preprocess`, `ffrf statics`, `ffrf render`.
"""

# %% [markdown]
# An airfoil file is a list of points round a wing section, in parts of its length (the chord): from the trailing edge over
# the upper side to the nose and back below. Any of the common formats will do. To have one that is surely your own, let us
# draw one with the formulas of NACA's four digits: 2415 has 2 % camber at 40 % of the chord and is 15 % thick.

# %%
import tempfile
from pathlib import Path

import numpy as np

import ffrf

folder = Path(tempfile.mkdtemp())
camber, place, thick = 0.02, 0.4, 0.15
x = (1 - np.cos(np.linspace(0, np.pi, 60))) / 2  # close together at the nose, where the section is round
half = 5 * thick * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
ahead, behind = 2 * place * x - x**2, 1 - 2 * place + 2 * place * x - x**2
middle = camber * np.where(x < place, ahead / place**2, behind / (1 - place) ** 2)
points = np.vstack([np.column_stack([x, middle + half])[::-1], np.column_stack([x, middle - half])[1:]])
np.savetxt(folder / "naca2415.dat", points, fmt="%.6f", header="NACA 2415", comments="")

# %% [markdown]
# Now a wing from it: `ffrf new wing MY_WING --airfoil naca2415.dat`. It writes the description of the skin (`skin.toml`),
# that of the linkage inside (`scene.toml`), and a target: without one of your own, the same section with its nose drooped by
# 1 % of the chord.

# %%
wing = folder / "my_wing"
for file in ffrf.preprocessing.new_wing(wing, folder / "naca2415.dat"):
    print("written:", file.name)

# %% [markdown]
# The skin is meshed and turned into a "reduced model", a file with all matrices that the simulation needs: `ffrf-preprocess
# MY_WING/skin.toml`.

# %%
skin = ffrf.preprocessing.build(wing / "skin.toml")
ffrf.preprocessing.save(skin, wing / "skin.h5")
print(skin.n_f, "elastic coordinates; joints may grip at", ", ".join(skin.interfaces or {}))

# %% [markdown]
# `ffrf statics MY_WING/scene.toml`: how far is the skin from the target, as a root mean square? Without any torque it is the
# whole droop. The torque was tuned for another section, so let us look for a better one for this; the stress is the price.

# %%
model = ffrf.compile(ffrf.read_scene(wing / "scene.toml"), variables=["M_t"])
found = {}
for torque in (1.0, 2000.0, 4000.0, 4400.0, 4800.0, 5000.0):  # N mm
    result = model.statics({"M_t": torque}, gradients=True)
    found[torque] = result.values["shape_rmse"]
    slope, stress = result.gradients["shape_rmse"]["M_t"], result.values["max_stress_true"]
    print(f"{torque:6.0f} N mm: off by {found[torque]:.3f} mm, changing by {slope:9.2e} mm/(N mm); {stress:5.1f} MPa")

# %% [markdown]
# Where the slope changes its sign lies the best torque. What is then left, the linkage cannot do where it sits now: next, ask
# for the slopes by the places of its joints, `ffrf statics MY_WING/scene.toml --set M_t=... ` and `ffrf sensitivity --static
# --variables points.B.x,points.D.y`.

# %%
best = min(found, key=lambda torque: found[torque])
check = found[best]
print(f"best: {best:.0f} N mm, off by {check:.3f} mm instead of {found[1.0]:.1f} mm")

# %% [markdown]
# The wing with this torque, its target in green and its stress in colours; `ffrf render MY_WING/scene.toml --static --set M_t=...`
# draws the same.

# %%
model.statics({"M_t": best}).plot().savefig(folder / "my_wing.png", dpi=150)
