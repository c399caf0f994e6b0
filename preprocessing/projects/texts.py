"""The files of a new linkage, with places for what depends on the system of units."""

from string import Template

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
