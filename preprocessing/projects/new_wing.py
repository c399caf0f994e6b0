"""A morphing wing of one's own from any airfoil file: skin and linkage of the reference wing, fitted into another section."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from string import Template

import numpy as np

from preprocessing.airfoil.airfoil_file import UNITS, ScaleError, largest_x, read_airfoil
from preprocessing.airfoil.contour import Contour
from preprocessing.airfoil.skin import Skin
from preprocessing.builders.skin_geometry import drooped
from preprocessing.projects.new_linkage import refuse_occupied, substituted, write_folder
from toolkit.foundation.errors import InputError

SKIN = Template("""\
# The skin of a morphing wing section, from F on the upper side round the nose to G on the lower side.
# Lengths in mm, masses in t, times in s; stresses in MPa, densities in t/mm^3.
units = "mm-t-s"

[airfoil]
file = "airfoil.dat"   # undeformed section
target = "target.dat"  # wanted section, in the same frame and of the same chord
chord = $chord
$units
[skin]
start = { x = $clamp_x, side = "upper" }  # F
end = { x = $clamp_x, side = "lower" }    # G
elements = $elements
clamp = "F"  # the body's frame is tied to F

[section]
thickness = $thickness
width = $width

[material]  # aluminium
youngs_modulus = 70000.0
poisson_ratio = 0.35
density = 2.7e-9

[interface_points]  # node (0 at F), arc_length from F, or x with side
C = { arc_length = $arc_C }  # within the element that ends at node 10, through which the study may move it
E = { arc_length = $arc_E }  # at node 25
G = { node = $elements }
""")

SCENE = Template("""\
# A morphing wing section: a flexible skin, clamped at F, guided at G, driven by a linkage of four rods.
# Lengths in mm, forces in N, masses in t, times in s; stresses in MPa.
units = "mm-t-s"

[points]
A = $A  # on the wing, where the drive sits
B = $B
D = $D
C = { body = "skin", interface = "C" }
E = { body = "skin", interface = "E" }
G = { body = "skin", interface = "G" }

[bodies]
# The skin turns farther than one linear frame allows. "auto" finds into how many parts with frames of their own it has to be cut; each run
# says how many it took, and that number in its place spares it looking.
skin = { type = "flexible", model = "skin.h5", frame = "grounded", frames = "auto" }  # clamped at F
body2 = { type = "rod", between = ["A", "B"], area = $area, density = 2.7e-9 }
body3 = { type = "rod", between = ["B", "C"], area = $area, density = 2.7e-9 }
body4 = { type = "rod", between = ["B", "D"], area = $area, density = 2.7e-9 }
body5 = { type = "rod", between = ["D", "E"], area = $area, density = 2.7e-9 }

[joints]
A = { type = "revolute", bodies = ["body2", "ground"], point = "A" }
B = { type = "revolute", bodies = ["body2", "body3"], point = "B" }
B_rigid = { type = "rigid", bodies = ["body2", "body4"], point = "B" }
C = { type = "revolute", bodies = ["body3", "skin"], point = "C" }
D = { type = "revolute", bodies = ["body4", "body5"], point = "D" }
E = { type = "revolute", bodies = ["body5", "skin"], point = "E" }
G = { type = "slider", bodies = ["skin", "ground"], point = "G", axis = [1.0, 0.0], lock_rotation = true }

[loads]
drive = { type = "torque", body = "body2", point = "A", torque = $torque, curve = { type = "smooth-step", duration = 1.0 } }

[design]
t_w = "bodies.skin.thickness"
M_t = "loads.drive.torque"
x_A = "points.A.x"
y_A = "points.A.y"
E = "bodies.skin.youngs_modulus"

[responses]
max_stress = { type = "ks-stress", body = "skin", aggregation = 200.0 }  # 1/MPa
max_stress_true = { type = "max-stress", body = "skin" }
shape_rmse = { type = "shape-rms", body = "skin" }
shape_max_error = { type = "shape-max", body = "skin" }
drive_angle = { type = "rotation", body = "body2", point = "A" }

[solver]
end_time = 1.2
step = 0.05
start = "equilibrium"  # under the loads at t = 0, so that gravity, if you add it, begins without a blow
""")

STUDY = Template("""\
# The best torque, thickness and places of A to E: nearest to the target, within 60 MPa and far from a snap-through.
scene = "scene.toml"
analysis = "statics"

[variables]
M_t = { between = $M_t }
t_w = { between = $t_w }
$joints
"points.C.arc_length" = { between = $along_C }  # along the skin, within the element that preprocessing has put it into
"points.E.arc_length" = { between = $along_E }

[responses]
shape_mse = { type = "shape-mse", body = "skin" }  # mm^2; the root of it has no derivative at zero
stress = { type = "ks-stress", body = "skin", aggregation = 2.0 }  # smoother than the scene's, and at most 2 MPa above the largest

[objective]
minimize = "shape_mse"

[constraints]
stress = { below = 60.0 }
load_margin = { above = 1.05 }

[search]
starts = 3  # one search alone may creep along the valley for longer than its 100 designs
""")

README = Template("""\
# A morphing wing from $name

`airfoil.dat` is the section as it is, `target.dat` the section that the wing shall take: $target.
`skin.toml` describes the flexible skin, `scene.toml` the linkage that morphs it, and `study.toml` what of it may change to come closer to
the target.

```
ffrf-preprocess $folder/skin.toml        # meshes the skin and writes skin.h5; again after every change of skin.toml
ffrf statics $folder/scene.toml          # the morphed state: stress, distance to the target, and how both depend on the design
ffrf optimize $folder/study.toml --output $folder/optimum   # the best torque, thickness and places of A to E
ffrf render $folder/scene.toml --output $folder/pictures
ffrf sensitivity $folder/scene.toml      # the same of the whole motion
ffrf statics $folder/scene.toml --set M_t=$more   # any number can be changed for one run
```

The skin turns farther than one linear frame allows, which would put values off by some ten percent and turn signs of gradients.
`frames = "auto"` in `scene.toml` cuts it into as many parts, which turn with it, as values and gradients need. A run that ends with
"NOT TO BE TRUSTED" means it, and says what to do.

The linkage is that of `models/morphing_wing`, moved into this section.
""")


REFERENCE_CHORD = 550.0
"""Chord of the reference wing in mm; a wing of another chord is a scaled copy, with the same stresses."""

CHORDS = 1e-3, 1e6
"""mm; the shortest and the longest that is meant: the torque goes with the cube of it."""

LIKELY = 5.0, 1e5
"""mm; chords that are believed of a file of lengths without being asked for."""

CLAMP_PLACE = 0.25
"""Place of F and G along the chord."""

DROOP_DEPTH = 6.0 / 550.0
"""Depth in chords of the droop that is the target if none is given, as in the reference wing."""

LINKAGE = {"A": (72.5 / 550, 0.42214), "B": (75.3 / 550, 0.15679), "D": (61.8 / 550, 0.47488)}
"""Joints of the reference wing: place along the chord, and height as a part of the section's thickness there."""

LARGEST_FRACTION = 1.1
"""Largest x that can be meant as a fraction of the chord."""

ELEMENTS, ON_SKIN = 30, {"C": 10, "E": 25}
"""Number of elements of the skin, and how many of them, from F on, are before its joints in the reference wing."""
FIRST_JOINT_SHIFT, FARTHEST_JOINT_SHIFT = -0.05, -0.95
"""Part of an element by which a joint is nearer to F than that, and by which the study may move it there: between elements the skin has
kinks, and no derivative along it. Farther from F the linkage is near to its snap-through."""
TORQUES, THICKNESSES = (0.6, 1.5), (0.8, 5 / 3)
"""Bounds of the study, in parts of what the scene has."""
JOINT_RANGE_ALONG, JOINT_RANGE_ACROSS, SKIN_CLEARANCE = 0.01, 0.15, 0.02
"""How far the study may move joints: along the chord in parts of it, and in height in parts of the section's thickness there; of which so
much is left beside the skin, wherever along the chord the joint is moved to."""


@dataclass(frozen=True)
class AirfoilFile:
    """Airfoil file, and the unit of its numbers: one of `UNITS`, or None for fractions of the chord unless they cannot be."""

    path: Path
    units: str | None
    option: str = "--units"  # that would say it

    def contour(self, chord: float) -> Contour:
        """Contour of the section in mm.

        Raises
        ------
        InputError
            The file cannot be used, or it is not clear what its numbers are in.
        """
        if self.units is None and (largest := largest_x(self.path)) > LARGEST_FRACTION:
            raise InputError(
                f"airfoil {self.path.name}: x reaches {largest:g}, so its numbers are no fractions of the chord. Say what they are in: "
                f"{self.option} percent, or {self.option} mm."
            )
        try:
            return Contour.through(read_airfoil(self.path, self.units, _in_units(chord, self.units)).points, chord)
        except ScaleError as error:
            raise InputError(f"{str(error).removesuffix('.')}, with {self.option}.") from error


def _in_units(chord: float, units: str | None) -> float | None:
    """Chord in mm in the unit of length that a file is in; None for parts of the chord."""
    return {"mm": chord, "m": chord / 1000}.get(units or "")


@dataclass(frozen=True)
class WingSection:
    """Section of the new wing, in mm."""

    contour: Contour
    skin: Skin
    chord: float

    @classmethod
    def of(cls, airfoil: AirfoilFile, chord: float) -> WingSection:
        """Section from the airfoil, with its skin cut at F and G."""
        contour = airfoil.contour(chord)
        start, end = (contour.at_x(CLAMP_PLACE * chord, side) for side in ("upper", "lower"))
        return cls(contour, Skin(contour, start, end), chord)

    def along(self, name: str, part: float = FIRST_JOINT_SHIFT) -> float:
        """Place of a joint of the skin, as arc length from F, at a part of its element."""
        return float(f"{(ON_SKIN[name] + part) * self.skin.length / ELEMENTS:.6g}")

    def joint(self, along: float, height: float) -> list[float]:
        """Place of a joint of the linkage."""
        x = along * self.chord
        lower, upper = (self.contour.position(self.contour.at_x(x, side))[1] for side in ("lower", "upper"))
        return [float(f"{number:.5g}") for number in (x, lower + height * (upper - lower))]


def new_wing(
    folder: str | Path,
    airfoil: str | Path,
    target: str | Path | None = None,
    chord: float | None = None,
    units: str | None = None,
    target_units: str | None = None,
) -> list[Path]:
    """Write a folder with airfoil.dat, target.dat, skin.toml, scene.toml, study.toml and README.md.

    Parameters
    ----------
    folder : new, or empty
    airfoil, target : airfoil files in one frame; without a target the nose droops by 1.1 % of the chord
    chord : mm; if none is given that of an airfoil in mm or m is its largest x, and that of others the reference wing's
    units, target_units : "fraction" of the chord, "percent" of it, "mm" or "m"; those of the target are the airfoil's if none are given

    Raises
    ------
    InputError
        The folder is not empty or cannot be written, an airfoil is missing or unreadable, or the two do not fit together.
    """
    folder, target = Path(folder), None if target is None else Path(target)
    if target is None and target_units is not None:
        raise InputError("--target-units belong to a target: give it with --target, or leave them out.")
    own = AirfoilFile(Path(airfoil), _known(units))
    theirs = _known(target_units, "--target-units") if target_units is not None else own.units
    wanted = None if target is None else AirfoilFile(target, theirs, "--target-units")
    refuse_occupied(folder)
    section = WingSection.of(own, _chord_of(own, chord))
    content = {
        "airfoil.dat": own.path.read_bytes(),
        "target.dat": _target(section, wanted),
        **_texts(section, folder, own, wanted),
    }
    return write_folder(folder, content)


def _known(units: str | None, option: str = "--units") -> str | None:
    """Units by the name that a skin file gives them."""
    choices = {"fraction": "chord", **{name: name for name in UNITS[1:]}}
    if units is not None and units not in choices:
        raise InputError(f"{option} {units} is unknown. Take one of {', '.join(choices)}.")
    return None if units is None else choices[units]


def _chord_of(airfoil: AirfoilFile, chord: float | None) -> float:
    """Chord in mm that was asked for, or that of a file of lengths."""
    if chord is None:
        factor = {"mm": 1.0, "m": 1000.0}.get(airfoil.units or "")
        chord = REFERENCE_CHORD if factor is None else factor * largest_x(airfoil.path)
        if not LIKELY[0] <= chord <= LIKELY[1]:
            raise InputError(
                f"airfoil {airfoil.path.name}: x reaches {largest_x(airfoil.path):g}, which would be a chord of {chord:g} mm. Say what its "
                f"numbers are in ({airfoil.option} fraction, percent, mm or m), or give that chord: --chord {chord:g}."
            )
    if not CHORDS[0] <= chord <= CHORDS[1]:
        raise InputError(
            f"a chord of {chord:g} mm cannot be. Give a length from {CHORDS[0]:g} to {CHORDS[1]:g} mm, for example --chord 550."
        )
    return chord


def _target(section: WingSection, file: AirfoilFile | None) -> bytes:
    """File of the target, if it fits to the skin; or a droop of the nose."""
    if file is not None:
        section.skin.target_positions(file.contour(section.chord), np.linspace(0, section.skin.length, 31))
        return file.path.read_bytes()
    rows = drooped(section.contour, section.skin, DROOP_DEPTH * section.chord, section.chord) / section.chord
    lines = [f"nose drooped by {DROOP_DEPTH:.2%} of the chord", *(f" {x:.9f} {y:.9f}" for x, y in rows)]
    return ("\n".join(lines) + "\n").encode()


def _units(airfoil: AirfoilFile, target: AirfoilFile | None) -> str:
    """Lines of skin.toml on the units of both files."""
    drooped_in = "chord" if target is None else target.units or "chord"
    own = airfoil.units or "chord"
    lines = [f'units = "{own}"  # of the numbers in airfoil.dat\n'] if own != "chord" else []
    lines += [f'target_units = "{drooped_in}"\n'] if drooped_in != own else []
    return "".join(lines)


def _texts(section: WingSection, folder: Path, airfoil: AirfoilFile, target: AirfoilFile | None) -> dict[str, bytes]:
    """Texts of skin, scene and README; lengths follow the chord, the torque its cube, so that stresses stay."""
    scale = section.chord / REFERENCE_CHORD
    torque = float(f"{4200 * scale**3:.4g}")
    numbers = {
        "chord": float(f"{section.chord:.12g}"), "units": _units(airfoil, target), "clamp_x": CLAMP_PLACE * section.chord,
        "thickness": 1.5 * scale, "width": 1000 * scale, "area": 100 * scale**2, "torque": torque,
        **{name: section.joint(*place) for name, place in LINKAGE.items()},
        "elements": ELEMENTS, **{f"arc_{name}": section.along(name) for name in ON_SKIN},
    }  # fmt: skip
    droop = f"here the nose drooped by {DROOP_DEPTH:.1%} of the chord, in place of a target of your own"
    words = {
        "name": f"`{airfoil.path.name}`", "folder": shlex.quote(str(folder)), "more": f"{1.1 * torque:g}",
        "target": f"`{target.path.name}`" if target else droop,
    }  # fmt: skip
    bounds = _bounds(section, torque, 1.5 * scale)
    texts = {"skin.toml": SKIN, "scene.toml": SCENE, "study.toml": STUDY, "README.md": README}
    return substituted(texts, {**numbers, **bounds, **words})


def _bounds(section: WingSection, torque: float, thickness: float) -> dict[str, str]:
    """Bounds of the numbers that the study may change."""
    lines = []
    for name, (along, height) in LINKAGE.items():
        (x, y), chord = section.joint(along, height), section.chord
        ends = (along - JOINT_RANGE_ALONG, along + JOINT_RANGE_ALONG)
        lowest = max(
            section.joint(along, height - JOINT_RANGE_ACROSS)[1], *(section.joint(end, SKIN_CLEARANCE)[1] for end in ends)
        )
        highest = min(
            section.joint(along, height + JOINT_RANGE_ACROSS)[1], *(section.joint(end, 1 - SKIN_CLEARANCE)[1] for end in ends)
        )
        lines += [
            f'"points.{name}.x" = {{ between = {_between(x - JOINT_RANGE_ALONG * chord, x + JOINT_RANGE_ALONG * chord)} }}',
            f'"points.{name}.y" = {{ between = {_between(min(lowest, y), max(highest, y))} }}',
        ]
    return {
        "M_t": _between(*(part * torque for part in TORQUES)),
        "t_w": _between(*(part * thickness for part in THICKNESSES)),
        "joints": "\n".join(lines),
        **{f"along_{name}": str([section.along(name, FARTHEST_JOINT_SHIFT), section.along(name)]) for name in ON_SKIN},
    }


def _between(low: float, high: float) -> str:
    return str([float(f"{number:.5g}") for number in (low, high)])
