"""Studies of the truss that snaps through, for many designs."""

from __future__ import annotations

from pathlib import Path

from tests.models.truss import write_truss

LOAD, LEFT, RIGHT = "loads.push.force.y", "loads.left.stiffness", "loads.right.stiffness"

SWEEP = f"""
scene = "scene.toml"
[variables]
"{LOAD}" = {{ between = [-90.0, -10.0] }}
[sweep]
levels = 9
"""
"""Beyond some 43 N it snaps through: these designs fail."""

UNCERTAIN = f"""
scene = "scene.toml"
[uncertain]
"{LOAD}" = {{ distribution = "normal", mean = -28.0, sigma = 2.0 }}
k = {{ distribution = "uniform", between = [-60.0, 60.0], of = ["{LEFT}", "{RIGHT}"] }}
[uncertainty]
responses = ["rise"]
runs = 12
"""


def sweep_file(folder: Path, text: str = SWEEP, **scene: str) -> Path:
    """A study of the truss in a folder."""
    folder.mkdir(exist_ok=True)
    return write_truss(folder, text, **scene)
