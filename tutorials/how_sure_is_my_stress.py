"""How sure is my stress? What the tolerances of a wing's numbers do to its stress, from twenty runs with gradients.

What is done here in Python is also one command, with the study in a file: `ffrf uncertainty STUDY.toml`. Polynomials of uncertain numbers
need OpenTURNS: pip install 'ffrf-toolkit[studies]'.
"""

# %% [markdown]
# The morphing wing bears 56.8 MPa, and 60 are allowed. But nobody rolls a sheet of exactly 1.5 mm, drills a hole exactly where the
# drawing has it, or sets a torque to the last digit. Each of these numbers has a distribution: a normal one, a lognormal one that
# cannot become negative, or a uniform one where nothing but the tolerance is known.

# %%
from pathlib import Path

import ffrf

MODELS = Path(__file__).parents[1] / "models"
study = {
    "scene": str(MODELS / "morphing_wing" / "scene.toml"),
    "uncertain": {
        "t_w": {"distribution": "normal", "sigma": 0.036},  # its mean is the scene's
        "M_t": {"distribution": "lognormal", "sigma": 126.0},
        "x_A": {"distribution": "uniform", "between": (72.2, 72.8)},
        "y_A": {"distribution": "uniform", "between": (1.0, 1.6)},
        "E": {"distribution": "normal", "sigma": 2100.0, "between": (65800.0, 74200.0)},  # sheets outside are sent back
    },
    "constraints": {"max_stress": {"below": 60.0}},
    "uncertainty": {"runs": 20, "responses": ("max_stress", "shape_rmse"), "warm_starts": True},
}
found = ffrf.uncertainty(ffrf.Study.model_validate(study))
stress = found.responses["max_stress"]
print(f"max_stress: {stress.mean:.2f} +- {stress.sigma:.2f} MPa; 99 % of all wings stay below {stress.quantiles[0.99]:.2f} MPa")
print(f"above 60 MPa: one wing of {1 / stress.beyond['above 60']:.0f}")

# %% [markdown]
# Every run gives a value and five derivatives, six equations for a polynomial. How good it is follows from the fits that leave a run
# out: `left_out` is their error over the spread. The first derivatives at the means alone would do for this stress; for the distance
# to the target, which is near its least value, they do not.

# %%
for name, each in found.responses.items():
    print(f"{name}: sigma {each.sigma:.4f}, by first derivatives {each.first_order[1]:.4f}; left out {each.left_out:.1e}")

# %% [markdown]
# Which tolerance should be made tighter? Sobol's indices are the shares of the variance that come from each number.

# %%
for name, share in sorted(stress.alone.items(), key=lambda each: -each[1]):
    print(f"{name}: {100 * share:.0f} % of the variance of the stress")

# %% [markdown]
# Is it right? Random wings judge it, without gradients and without any polynomial. Two hundred of them tell mean and sigma to a
# fourteenth of sigma only, but at the same wings the polynomials can be compared with the runs themselves. What no mathematics fixes is
# the model: the verdict says that this skin leaves the range of small deformations.

# %%
study["uncertainty"] = {**study["uncertainty"], "monte_carlo": 200}
judged = ffrf.uncertainty(ffrf.Study.model_validate(study)).responses["max_stress"].sampled
print(f"random wings: {judged.mean[0]:.2f} +- {judged.sigma[0]:.2f} MPa, known to {judged.mean[1]:.2f} and {judged.sigma[1]:.2f}")
print(f"the polynomials are off by {judged.missed:.1e} sigma there")
print(found.verdict)

assert stress.left_out < 0.01
assert abs(judged.mean[0] - stress.mean) < 4 * judged.mean[1]
assert 0.98 < sum(stress.alone.values()) < 1.0  # the rest is what numbers do together
check = judged.missed
