"""A linkage of one's own: a crank-rocker with a motor and a spring, in one of the systems of units."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from string import Template

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import write_whole
from toolkit.foundation.units import UNIT_SYSTEMS


def refuse_occupied(folder: Path) -> None:
    """Refuse a folder that is not empty.

    Raises
    ------
    InputError
        It is a file, or not empty.
    """
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        what = "is not empty" if folder.is_dir() else "is a file"
        raise InputError(f"{str(folder)!r} {what}, and nothing of yours shall be overwritten. Name a new folder.")


def write_folder(folder: Path, content: Mapping[str, bytes]) -> list[Path]:
    """Make the folder and write its files, which may lie in folders of their own.

    Raises
    ------
    InputError
        It cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in content.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            write_whole(folder / name, data)
    except OSError as error:
        raise InputError(f"{str(folder)!r} cannot be written ({error.strerror}). Name another folder.") from error
    return [folder / name for name in content]


def substituted(texts: Mapping[str, object], numbers: Mapping[str, object]) -> dict[str, bytes]:
    """Files of templates (`string.Template`) with their places filled."""
    return {name: text.substitute(numbers).encode() for name, text in texts.items()}  # type: ignore[attr-defined]


SCENE = Template("""\
# A crank-rocker: a motor turns the crank OA once in a second, the coupler AB pushes, and the rocker BC swings against a spring.
# $words
units = "$units"

[points]  # where everything is at the start; move them, and the linkage is another one
O = $O
A = $A
B = $B
C = $C

[bodies]  # rods of steel: their length is the distance of their points
crank = { type = "rod", between = ["O", "A"], area = $area, density = $density }
coupler = { type = "rod", between = ["A", "B"], area = $area, density = $density }
rocker = { type = "rod", between = ["B", "C"], area = $area, density = $density }

[joints]
O = { type = "revolute", bodies = ["crank", "ground"], point = "O" }
A = { type = "revolute", bodies = ["crank", "coupler"], point = "A" }
B = { type = "revolute", bodies = ["coupler", "rocker"], point = "B" }
C = { type = "revolute", bodies = ["rocker", "ground"], point = "C" }

[joints.motor]
type = "angle-driver"
bodies = ["crank", "ground"]
point = "O"
curve = { type = "cycloid", height = 6.283185307179586, duration = 1.0 }

[loads]
weight = { type = "gravity", acceleration = [0.0, -$gravity] }

[loads.spring]
type = "rotational-spring-damper"
bodies = ["rocker", "ground"]
point = "C"
stiffness = $stiffness
damping = $damping
rest_angle = 0.5  # rad; it is loaded at the start

[design]  # short names of numbers; `ffrf sensitivity` differentiates by them
x_B = "points.B.x"
y_B = "points.B.y"
k = "loads.spring.stiffness"

[responses]
torque = { type = "time-max", of = { type = "joint-force", joint = "motor", component = "torque" }, measure = "absolute" }
swing_up = { type = "time-max", of = { type = "rotation", body = "rocker", point = "C" } }
swing_down = { type = "time-min", of = { type = "rotation", body = "rocker", point = "C" } }
hold = { type = "joint-force", joint = "motor", component = "torque" }  # at the end, also of an equilibrium
bearing = { type = "time-max", of = { type = "joint-force", joint = "C", component = "magnitude" } }

[solver]
end_time = 1.0
step = 0.005
""")

STUDY = Template("""\
# The place of B and the spring that ask least of the motor, while the rocker swings down by 0.3 rad.
scene = "scene.toml"
analysis = "motion"

[variables]
x_B = { between = $x_B }
y_B = { between = $y_B }
k = { between = $k }

[responses]
effort = { type = "time-mean-square", of = { type = "joint-force", joint = "motor", component = "torque" } }

[objective]
minimize = "effort"

[constraints]
swing_down = { below = -0.3 }  # rad
""")

README = Template("""\
# A crank-rocker

`scene.toml` describes the linkage: points, rods, joints, a motor, a spring. `study.toml` says what of it may change, and for what.

```
ffrf simulate $folder/scene.toml         # one turn of the crank: torque of the motor, swing of the rocker, force in a bearing
ffrf sensitivity $folder/scene.toml      # the same with exact derivatives by the place of B and the spring
ffrf statics $folder/scene.toml          # what the motor has to hold at the end of the turn
ffrf render $folder/scene.toml --output $folder/pictures --animate
ffrf optimize $folder/study.toml --output $folder/optimum
ffrf simulate $folder/scene.toml --set points.B.y=$higher   # any number can be changed for one run
ffrf inspect $folder/scene.toml          # every number that can be a variable, and how the bodies can move
```

A rod that bends is a body of type "flexible": its beams stand in a frame file that `ffrf-preprocess` reads, as in
`models/flexible_slider_crank` of the toolkit.
""")


METRES = {"O": (0.0, 0.0), "A": (0.0, 0.04), "B": (0.11, 0.09), "C": (0.11, 0.0)}
"""Places of the joints: crank 40 mm, coupler 121 mm, rocker 90 mm, ground 110 mm. The shortest and the longest are together shorter
than the others, so that the crank turns fully (Grashof)."""
BESIDE = 0.01
"""Distance in m by which the study may move B."""
STIFFNESS, DAMPING = 0.5, 0.005
"""Stiffness and damping of the spring at the rocker, in N m/rad and N m s/rad."""
WORDS = {
    "mm-t-s": "Lengths in mm, masses in t, times in s; forces in N, torques in N mm.",
    "m-kg-s": "Lengths in m, masses in kg, times in s; forces in N, torques in N m.",
}
PER_METRE = {"mm-t-s": 1000.0, "m-kg-s": 1.0}
"""Units of length in a metre; torques count in as many parts of a newton metre."""
PER_KILOGRAM = {"mm-t-s": 1e-3, "m-kg-s": 1.0}


def new_linkage(folder: str | Path, units: str = "mm-t-s") -> list[Path]:
    """Write a folder with scene.toml, study.toml and README.md.

    Parameters
    ----------
    folder : new, or empty
    units : name of the system of units

    Raises
    ------
    InputError
        The folder is not empty or cannot be written, or there are no such units.
    """
    refuse_units(units)
    refuse_occupied(folder := Path(folder))
    length, mass = PER_METRE[units], PER_KILOGRAM[units]
    x, y = METRES["B"]
    numbers = {
        **{name: _list(*(length * each for each in place)) for name, place in METRES.items()},
        "units": units, "words": WORDS[units], "area": _short(6e-5 * length**2), "density": _short(7850 * mass / length**3),
        "stiffness": _short(STIFFNESS * length), "damping": _short(DAMPING * length), "gravity": _short(9.81 * length),
        "x_B": _list(length * (x - BESIDE), length * (x + BESIDE)), "y_B": _list(length * (y - BESIDE), length * (y + BESIDE)),
        "k": _list(STIFFNESS * length / 2, 2 * STIFFNESS * length), "higher": f"{1.05 * y * length:g}", "folder": shlex.quote(str(folder)),
    }  # fmt: skip
    return write_folder(folder, substituted({"scene.toml": SCENE, "study.toml": STUDY, "README.md": README}, numbers))


def refuse_units(units: str) -> None:
    """Refuse systems of units that no scene has."""
    if units not in UNIT_SYSTEMS:
        raise InputError(f"there are no units {units!r}. Take one of {', '.join(UNIT_SYSTEMS)}.")


def _short(number: float) -> float:
    return float(f"{number:.6g}")


def _list(*numbers: float) -> str:
    return str([_short(number) for number in numbers])
