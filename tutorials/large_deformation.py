"""How large may it deform? From a warning to a gradient that is true, in five steps."""

# %% [markdown]
# 1. A warning. The skin of the morphing wing bends by 6 mm. Its elements are linear in the one frame that the body has: they
# do not turn. The run computes exact derivatives of that model, and says that they are not to be trusted.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import ffrf
from toolkit.analyses.sensitivity.certificate.whole_mechanism import compare_mechanism
from toolkit.responses.shape_error import shape_error_history
from toolkit.validity.bodies.deformation import node_places

WING = Path(__file__).parents[1] / "models" / "morphing_wing" / "scene.toml"
VARIABLES = ["t_w", "M_t", "x_A", "y_A"]


def wing(frames, **more):
    """The scene with other frames in its skin, compiled."""
    changes = {"bodies.skin.frames": str(frames), **{f"bodies.skin.{name}": str(value) for name, value in more.items()}}
    return ffrf.compile(ffrf.read_scene(WING, changes), variables=VARIABLES)


one = wing(1).statics(gradients=True)
for warning in one.verdict.warnings:
    print(f"[{warning.code}] {warning.text}\n")

# %% [markdown]
# The second warning comes from a second run, with twice the frames: it compares the gradients. The sign of d RMS / d x_A is
# in doubt, so an optimiser that moves the joint A may walk the wrong way.
#
# 2. A number that the program finds. `frames = "auto"` solves the scene with few frames and with more, until the nodes are
# known to `geometric_error`, one percent of the displacement by default, and gradients to 5 %. Nothing is preprocessed again,
# and to the scene the skin stays one body.

# %%
auto = wing("auto", geometric_error=1e-3).statics(gradients=True)
chosen = auto.verdict.measures["frames"]["skin"]
print(f"tried {chosen['tried']}, took {chosen['frames']}: error {chosen['estimated_error']:.1e} of the displacement\n")

# %% [markdown]
# 3. Gradients converge later than values: each run says by how much they are still off. The errors fall with the square of
# the number of frames, once the parts turn a little only.

# %%
slopes = {}
for frames in (1, 2, 4, 8, 15, 30):
    run = wing(frames).statics(gradients=True)
    slope = slopes[frames] = run.gradients["shape_rmse"]["x_A"]
    said = run.verdict.measures.get("geometric_error")
    error = (
        f"{said['gradients']['shape_rmse']['x_A']:+.4f} to come" if said else "nothing to compare with: a frame to every element"
    )
    print(f"{frames:2} frames: RMS {run.values['shape_rmse']:.4f} mm, by x_A {slope:+.4f}, {error}")

# %% [markdown]
# 4. A judge. With a frame to every element these are the equations of corotational elements. `ffrf check-deformation` solves
# the whole mechanism so, joints in place, and differentiates it twice: exactly, and by central differences.

# %%
whole = compare_mechanism(one.solution, VARIABLES)
assert whole is not None
assert whole.corotational is not None
for name in VARIABLES:
    exact, quotient = whole.corotational.gradients["shape_rmse"][name], whole.quotients["shape_rmse"][name]
    print(f"d RMS / d {name}: one frame {one.gradients['shape_rmse'][name]:+.6g}, all {exact:+.6g}, differences {quotient:+.6g}")
print("wrong signs:", ", ".join(" by ".join(pair) for pair in whole.wrong_signs()))

# %% [markdown]
# 5. The picture: both shapes, the difference of one frame ten times as large; how far every node is from the wanted shape; and the
# gradient over the number of frames.

# %%
figure, (shape, left, right) = plt.subplots(1, 3, figsize=(13, 3.2), layout="constrained")
true, linear = (node_places(run.solution, "skin")[-1] for run in (whole.corotational, one))
rest = wing(1).statics({"M_t": 0.0}).solution
shape.plot(*node_places(rest, "skin")[-1].T, ":", color="grey", label="without torque")
shape.plot(*(true + 10 * (linear - true)).T, label="frames: 1, its error times ten")
shape.plot(*true.T, label="frames: 30")
shape.set(xlabel="x in mm", ylabel="y in mm", aspect="equal")
shape.legend()
for run, label, style in ((one, "1", "-"), (auto, str(chosen["frames"]), "k--"), (whole.corotational, "30", "-")):
    left.plot(shape_error_history(run.solution, "skin")[0][-1], style, label=f"frames: {label}", zorder=2 + (style == "k--"))
left.set(xlabel="node along the skin", ylabel="distance to the target in mm")
left.legend()
right.axhline(0.0, color="grey", linewidth=0.8)
right.semilogx(list(slopes), list(slopes.values()), "o-")
right.set(xlabel="frames", ylabel="d RMS / d x_A in mm/mm", xticks=list(slopes), xticklabels=list(slopes))
right.minorticks_off()
figure.savefig(Path(tempfile.mkdtemp()) / "large_deformation.png", dpi=140)

# %% [markdown]
# Take as many frames as your gradients need: here seven give the slope to three percent, and a motion takes
# two thirds longer. What is left to check is how well the exact gradients of the mechanism meet its central differences.

# %%
pairs = [(whole.corotational.gradients[f][x], slope) for f, row in whole.quotients.items() for x, slope in row.items()]
check = float(np.max([abs(exact / quotient - 1) for exact, quotient in pairs]))
print(f"largest relative difference of {len(pairs)} gradients to central differences: {check:.1e}")
