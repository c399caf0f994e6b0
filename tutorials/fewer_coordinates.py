"""How many modes are enough, also for the gradients? The wing's skin with fewer and fewer coordinates."""

# %% [markdown]
# The skin has 30 elements and 90 coordinates; most of them are wrinkles that nobody ever sees. `basis` in skin.toml keeps fewer,
# in one of two ways: `eigenmodes` are the shapes in which the skin would vibrate on its own, from the lowest upwards.
# `craig-bampton` takes three shapes for each interface point (where a joint grips), for its motion along x, along y and its
# rotation, and then eigenmodes of the skin held at these points.

# %%
import shutil
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import ffrf
from toolkit.render.sheet import COLORS
from toolkit.report.drawing import Drawing

np.set_printoptions(formatter={"float": "{:.0e}".format})
folder = Path(shutil.copytree(Path(__file__).parents[1] / "models" / "morphing_wing", tempfile.mkdtemp(), dirs_exist_ok=True))
SKIN = (folder / "skin.toml").read_text() + '[shape.nose]  # a bump\narc_length = 148.0\nhalf_width = 60.0\nof = "both"\n'
FAST = {"loads.drive.curve.duration": "0.01", "solver.end_time": "0.03", "solver.step": "3e-4", "solver.scheme": "arnold-bruels"}
RESPONSES = {"max_stress": "largest stress", "shape_rmse": "distance to the target", "drive_angle": "drive angle"}
DESIGN = {"thickness": 1.5, "youngs_modulus": 70000.0, "chord": 550.0, "nose": 0.0}
SIZE = np.array([1.5, 70000.0, 550.0, 5.0])  # what counts as one change of each


def run(basis, kind="transient", change=0.0):
    """Values (3,) and gradients (3, 4) by changes of one SIZE, preprocessed with a basis at a changed design."""
    (folder / "skin.toml").write_text(f"basis = {{ {basis} }}\n{SKIN}")
    values = dict(zip(DESIGN, np.array(list(DESIGN.values())) + change * SIZE, strict=True))
    ffrf.preprocessing.save(ffrf.preprocessing.build(folder / "skin.toml", values=values), folder / "skin.h5")
    scene = ffrf.read_scene(folder / "scene.toml", {**FAST, "solver.tolerance": 1e-12})
    found = ffrf.compile(scene, variables=[f"bodies.skin.{name}" for name in DESIGN]).run(kind, gradients="direct")
    slopes = [list(found.gradients[name].values()) for name in RESPONSES]
    return np.array([found.values[name] for name in RESPONSES]), np.array(slopes) * SIZE


def errors(found, true, label):
    """Relative errors (2, 3) of the values, and of the gradients, these by the largest entry of the true one."""
    values, gradients = np.abs(found[0] / true[0] - 1), np.abs(found[1] - true[1]).max(axis=1) / np.abs(true[1]).max(axis=1)
    print(f"{label:31} values off by {values}, gradients by {gradients}")
    return np.array([values, gradients])


# %% [markdown]
# At rest, the nine shapes of the three interface points are all that is needed: forces act nowhere else. Eigenmodes stall.
# A joint pushes at one point, and the guide at G even turns the skin's end, where the moment is largest; but each eigenmode
# has a free end, without moment. Their sum overshoots beside it, and more modes only make that narrower.

# %%
at_rest = run('kind = "full"', "static")
rest = {}
for basis in ('kind = "static"', 'kind = "eigenmodes", count = 8', 'kind = "eigenmodes", count = 64'):
    rest[basis] = errors(run(basis, "static"), at_rest, basis)

# %% [markdown]
# Now the drive takes 10 ms instead of a second, so that the skin vibrates; values and gradients after 30 ms. `frozen` keeps
# the shapes when the design changes; the default, `differentiated`, knows how they change.

# %%
full, curves = run('kind = "full"'), {"craig-bampton": {}, "eigenmodes": {}, "craig-bampton, frozen": {}}
for name, curve in curves.items():
    kind, _, frozen = name.partition(", ")
    for count in (4, 8, 16, 32, 64) if kind == "eigenmodes" else (0, 1, 4, 8, 16, 32):
        basis = f'kind = "{kind}", count = {count}, derivative = "{frozen or "differentiated"}"'
        curve[count + 9 * (kind != "eigenmodes")] = errors(run(basis), full, f"{name}, {count} modes")
figure = Figure(figsize=(10, 4), layout="constrained")
panels = figure.subplots(1, 3, sharey=True)
for k, (axes, title) in enumerate(zip(panels, RESPONSES.values(), strict=True)):
    for (name, curve), color in zip(curves.items(), COLORS, strict=False):
        for row, line in enumerate(["o-", "s--"]):
            if row or "frozen" not in name:  # the values of a frozen basis are the same
                label = f"{('value', 'gradient')[row]}, {name}"
                axes.loglog(list(curve), [error[row][k] for error in curve.values()], line, color=color, label=label)
    axes.set(title=title, xlabel="coordinates of the skin", xticks=(ticks := [4, 9, 17, 25, 41, 64]), xticklabels=ticks)
    axes.minorticks_off()
    axes.grid(alpha=0.3)
panels[0].set_ylabel("error against all 90 coordinates")
figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
print("a picture:", Drawing("fewer_coordinates", "", "", figure).save(folder)[0])

# %% [markdown]
# With Craig-Bampton the gradients converge as the values do. Frozen gradients need not: shapes that bend the old skin without
# stretching it would stretch a skin of another form, and stretching is far stiffer. Freeze for material, not for form.
#
# Who is right? New preprocessing at other designs, with central differences in a direction in which all four variables change:

# %%
basis, direction = 'kind = "craig-bampton", count = 4', np.array([1.0, -1.0, 1.0, 1.0])
slope = {h: (run(basis, change=h * direction)[0] - run(basis, change=-h * direction)[0]) / (2 * h) for h in (1e-3, 2e-3)}
fresh = (4 * slope[1e-3] - slope[2e-3]) / 3  # without the error of order h^2
off = {}
for derivative in ("frozen", "differentiated"):
    off[derivative] = float(np.abs(run(f'{basis}, derivative = "{derivative}"')[1] @ direction / fresh - 1).max())
    print(f"{derivative:14} differs from new preprocessing by {off[derivative]:.0e}")
check = off["differentiated"]

# %% [markdown]
# How many modes? You may also name a frequency, or an error of the displacements under forces at the interface points. The
# second does not know the scene: 1 % asks for 8 eigenmodes, with which the drive angle at rest was off by 10 %, because the
# guide at G holds the soft motions that these describe best.

# %%
for basis in ('kind = "craig-bampton", frequency = 2500.0', 'kind = "eigenmodes", static_error = 0.01'):
    (folder / "skin.toml").write_text(f"basis = {{ {basis} }}\n{SKIN}")
    model = ffrf.preprocessing.build(folder / "skin.toml")
    print(model.n_f, "coordinates;", model.basis)
assert model.n_f == 8
assert 0.09 < rest['kind = "eigenmodes", count = 8'][0, 2] < 0.11
