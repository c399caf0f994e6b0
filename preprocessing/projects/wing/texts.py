"""The files of a new morphing wing, with places for the numbers that depend on its section."""

from string import Template

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
