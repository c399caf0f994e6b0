"""Von Mises' truss of two springs, which snaps through: its force, its limit load and its drop in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import brentq

HALF, HEIGHT, STIFFNESS = 1.0, 0.5, 1000.0
"""Half of the span, height and stiffness of one spring."""

SCENE = f"""
units = "m-kg-s"

[points]
P = [0.0, {HEIGHT}]
L = [{-HALF}, 0.0]
R = [{HALF}, 0.0]

[bodies]
tip = {{ type = "rigid", mass = 1.0, inertia = 1.0, center = "P" }}

[joints]
guide = {{ type = "slider", bodies = ["tip", "ground"], point = "P", axis = [0.0, 1.0], lock_rotation = true }}

[loads]
left = {{ type = "spring-damper", bodies = ["tip", "ground"], points = ["P", "L"], stiffness = {STIFFNESS} }}
right = {{ type = "spring-damper", bodies = ["tip", "ground"], points = ["P", "R"], stiffness = {STIFFNESS} }}
push = {{ type = "point-force", body = "tip", point = "P", force = [0.0, -30.0] }}

[responses]
rise = {{ type = "displacement", body = "tip", point = "P", component = "y" }}
sway = {{ type = "displacement", body = "tip", point = "P", component = "x" }}
"""

REST = float(np.hypot(HALF, HEIGHT))


def force(y: float, stiffness: float = STIFFNESS) -> float:
    """Force downwards that holds the tip at the height y: 2 k y (L_0 / L - 1)."""
    return 2 * stiffness * y * (REST / float(np.hypot(HALF, y)) - 1)


def force_slope(y: float, stiffness: float = STIFFNESS) -> float:
    """Its derivative by y."""
    return 2 * stiffness * (REST * HALF**2 / float(np.hypot(HALF, y)) ** 3 - 1)


def limit_load(stiffness: float = STIFFNESS) -> float:
    """The largest force that it bears before it snaps through: 2 k (L_0^(2/3) - a^(2/3))^(3/2)."""
    return float(2 * stiffness * (REST ** (2 / 3) - HALF ** (2 / 3)) ** 1.5)


def height(load: float, stiffness: float = STIFFNESS) -> float:
    """Where the tip is under a load below the limit load."""
    top = float(np.sqrt((HALF**2 * REST) ** (2 / 3) - HALF**2))
    return float(brentq(lambda y: force(y, stiffness) - load, top, HEIGHT, xtol=1e-15, rtol=1e-14))


def snapped_height(load: float, stiffness: float = STIFFNESS) -> float:
    """Where the tip is under the same load after it has snapped through."""
    return float(brentq(lambda y: force(y, stiffness) - load, -2.0, -HEIGHT, xtol=1e-15, rtol=1e-14))


def write_truss(folder: Path, study: str = "", **replaced: str) -> Path:
    """The scene and a study of it in a folder; `replaced` texts of the scene. Returns the path of the study."""
    text = SCENE
    for old, new in replaced.items():
        text = text.replace(old, new)
    (folder / "scene.toml").write_text(text)
    path = folder / "study.toml"
    path.write_text(study)
    return path
