"""Gradients and how to trust them: four ways to the same derivative, and tests that a wrong one does not pass.

The mechanism is the slider-crank of `models/`, whose gradients were published with the solver SUNDIALS.
"""

# %% [markdown]
# A derivative says how a result changes with a number of the design. The obvious way is to change the number a little and
# simulate again. But how little? Too much, and the curve is no straight line; too little, and the last digits of the results
# are all that differs.

# %%
from pathlib import Path

import ffrf
from toolkit.analyses.sensitivity.certificate.differences import step_study, taylor_rates

MODELS = Path(__file__).parents[1] / "models"
short = {"solver.end_time": "1.0", "solver.step": "0.02"}  # 50 steps, for one of the ways is slow
scene = ffrf.read_scene(MODELS / "slider_crank" / "scene.toml", short)
design = ["k", "c", "J2"]  # stiffness of the spring, damping, inertia of the rod
for step, difference in step_study(scene, design, "transient", steps=(1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9)):
    print(f"central difference, step {step:7.0e} of each number: off by {difference:.1e}")

# %% [markdown]
# A V: the error falls with the square of the step, then round-off takes over. The best step differs from case to case, and
# without the truth nobody knows it. That list was made against *direct differentiation*: the program differentiates its
# equations and solves for the derivatives along with the motion, for a fraction of the price of one simulation per variable.
# How do we know that it is right?
#
# The judge is the *complex step*. Give the number a tiny imaginary part, i h with h = 1e-30, and compute everything with
# complex numbers: f(x + i h) = f(x) + i h f'(x) + ..., so the imaginary part of the result over h is the derivative. Nothing
# is subtracted, so no digit is lost.

# %%
model = ffrf.compile(scene, variables=design)
exact = model.simulate(gradients="direct")
for method in ("forward-difference", "central-difference", "complex-step"):
    other = model.simulate(gradients=method)
    worst = max(abs(other.gradients[r][x] / slope - 1) for r, slopes in exact.gradients.items() for x, slope in slopes.items())
    print(f"{method:18} differs from direct differentiation by {worst:.1e}")

# %% [markdown]
# Two ways that share no line of differentiation agree to the last digits. The differences agree as well as differences can.
#
# If there is no second way, there is still the *Taylor test*: what is left of f(x + h d) after f(x) + h times the slope must
# vanish with h^2. Take another gradient, even one wrong by 1 %, and it vanishes with h only.

# %%
for response, rate in taylor_rates(scene, design, "transient").items():
    print(f"{response}: the remainder vanishes like h^{rate:.3f}")

# %% [markdown]
# Lastly, ask someone else. SUNDIALS published the integral of the kinetic energy over 10 s and its slopes by k and c. Our
# time steps of 5 ms have an error too, and the derivative is that of what the steps give; so it gets better with the steps,
# like the result itself.

# %%
full = ffrf.compile(ffrf.read_scene(MODELS / "slider_crank" / "scene.toml"), variables=["k", "c"]).simulate(gradients=True)
published = {"k": 0.33346, "c": -0.36375}
print(f"G = {full.values['G']:.5f}, published 3.33662")
for name, value in published.items():
    print(f"dG/d{name} = {full.gradients['G'][name]:.5f}, published {value:.5f}")
check = worst
