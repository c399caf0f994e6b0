"""Every gradient that a designer asks for: thirty thicknesses, a part of another material, and the form of the section."""

# %% [markdown]
# What can be varied on the skin stands in its skin.toml. `separate` gives every element a thickness of its own, a group gives
# some elements a modulus of their own, and a shape mode is a smooth bump whose height is a variable: here seven in a row.

# %%
import shutil
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

import ffrf
from toolkit.render.sheet import SIGNED, symmetric
from toolkit.report.drawing import Drawing

folder = Path(shutil.copytree(Path(__file__).parents[1] / "models" / "morphing_wing", tempfile.mkdtemp(), dirs_exist_ok=True))
skin, scene = folder / "skin.toml", folder / "scene.toml"
scene.write_text(scene.read_text().replace('t_w = "bodies.skin.thickness"\n', ""))  # there will be no common thickness
places = np.arange(20, 300, 40.0)  # arc lengths from F, mm
bumps = [f'[shape.bump_{s:.0f}]\narc_length = {s}\nhalf_width = 30.0\nof = "both"\n' for s in places]
text = skin.read_text() + "[groups.nose]\nelements = [12, 17]\nyoungs_modulus = 60000.0\n" + "".join(bumps)


def rebuild(separate='["thickness"]', basis='kind = "full"', values=None):
    """Preprocess, and keep the file where the scene looks for it."""
    skin.write_text(f"basis = {{ {basis} }}\n" + text.replace("[skin]\n", f"[skin]\nseparate = {separate}\n"))
    ffrf.preprocessing.save(model := ffrf.preprocessing.build(skin, values=values), folder / "skin.h5")
    return model


model = rebuild()
thicknesses, heights = [f"bodies.skin.thickness_{k}" for k in range(30)], [f"bodies.skin.bump_{s:.0f}" for s in places]
others = [f"bodies.skin.{name}" for name in ("youngs_modulus", "youngs_modulus_nose", "chord", "y_scale")]
result = ffrf.compile(ffrf.read_scene(scene), variables=[*thicknesses, *heights, *others]).statics(gradients=True)
slopes = result.gradients["max_stress"]
print(f"largest stress {result.values['max_stress']:.2f} MPa, and its {len(slopes)} derivatives, among them")
for name in (thicknesses[0], thicknesses[29], heights[0], *others):
    print(f"  {name:32} {slopes[name]:9.2e}")

# %% [markdown]
# On the skin: red where a thicker element, or a bump outwards, raises the largest stress, which is that at G, the lower end.

# %%
figure = Figure(figsize=(10, 4.2), layout="constrained")
nodes, along = model.mesh.nodes, model.shape.arc_length
middle, ahead = (np.column_stack([np.interp(places + step, along, xy) for xy in nodes.T]) for step in (0, 0.1))
outward = (ahead - middle) @ np.array([[0, -1], [1, 0]]) * 10  # the skin runs from F over the nose to G
titles = ("by the thickness of every element, MPa per mm", "by the height of every bump, MPa per mm")
for axes, names, title in zip(figure.subplots(1, 2, sharex=True, sharey=True), (thicknesses, heights), titles, strict=True):
    slope = np.array([slopes[name] for name in names])
    ends = np.stack([nodes[:-1], nodes[1:]] if names is thicknesses else [middle, middle + 15 * outward], axis=1)
    axes.plot(*nodes.T, color="0.7")
    lines = LineCollection(ends, array=slope, cmap=SIGNED, norm=symmetric(np.clip(slope, -20, 20)), linewidths=8)
    figure.colorbar(axes.add_collection(lines), ax=axes, location="bottom", extend="min" if slope.min() < -20 else "neither")
    for label, node in {"F": 0, "C": 10, "E": 25, "G": 30}.items():
        axes.annotate(label, nodes[node], xytext=(9, 13 - 26 * (node > 15)), textcoords="offset points", ha="center", va="center")
    axes.set(title=title, aspect="equal")
    axes.margins(0.1)
    axes.axis("off")
figure.suptitle(f"Slopes of the largest stress, {result.values['max_stress']:.0f} MPa at G")
print("a picture:", Drawing("every_gradient", "", "", figure).save(folder)[0])

# %% [markdown]
# Is it right? If all elements get thicker, all thirty slopes add up to that by a common thickness:

# %%
rebuild("[]")
model = ffrf.compile(ffrf.read_scene(scene), variables=["bodies.skin.thickness"])
common = model.statics(gradients=True).gradients["max_stress"]["bodies.skin.thickness"]
check = sum(slopes[name] for name in thicknesses) / common - 1
print(f"sum of the thirty over the common one: 1 {check:+.0e}")

# %% [markdown]
# A scene may set thickness, width, modulus or density: the file holds the exact polynomials (with the full basis, or a frozen
# one). Of the form it holds the derivative only, and refuses to be moved. `extrapolation = "first-order"` moves it along the
# tangent of all matrices, with an error of second order: ten times the step, a hundred times the error. But beware: the skin is
# so stiff against stretching that in the full basis the tangent is soon far off. A straight line through the stress is not.

# %%
height = "bodies.skin.bump_140"
try:
    model.statics({height: 0.1})
except ffrf.ToolkitError as error:
    print("refused:", error)
true, off = {}, {}
for h in (0.01, 0.1):
    rebuild("[]", values={"bump_140": h})
    true[h] = ffrf.compile(ffrf.read_scene(scene)).statics().values["max_stress"]
    print(f"{h:4} mm: the straight line is off by {abs(result.values['max_stress'] + h * slopes[height] - true[h]):.0e} MPa")
for basis in ('kind = "full"', 'kind = "craig-bampton", count = 8'):
    rebuild("[]", basis)
    for h in true:
        changes = {height: h, "bodies.skin.extrapolation": "first-order"}
        tangent = ffrf.compile(ffrf.read_scene(scene, changes)).statics().values
        off[basis, h] = abs(tangent["max_stress"] - true[h])
        print(f"{h:4} mm: first order with {basis} is off by {off[basis, h]:.0e} MPa")
    assert 80 < off[basis, 0.1] / off[basis, 0.01] < 120
