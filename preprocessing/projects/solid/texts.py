"""The files of a new solid on a motor, with places for what its mesh and the system of units decide."""

from string import Template

BODY = Template("""\
# $what, between a hub on a motor and a tip that carries a weight.
# $words
units = "$units"

[mesh]
file = "$mesh"

[material]  # aluminium
youngs_modulus = $modulus
density = $density
poisson_ratio = 0.33
$section
[damping]
stiffness = 2e-5

[clamp]  # where the body's frame is
group = "$clamp"

[interface_points]  # where joints grip
hub = { group = "$clamp" }
tip = { group = "$grip", tie = "rigid" }

[basis]
kind = "craig-bampton"
count = $count
""")

SCENE = Template("""\
# A motor turns the body by a quarter of a turn about the hub; at the tip a weight is fixed, as heavy as half the body.
# $words
units = "$units"$dimension

[points]
H = { body = "solid", interface = "hub" }
T = { body = "solid", interface = "tip" }

[bodies]
solid = { type = "flexible", model = "body.h5", frame = "moving" }
weight = { type = "rigid", mass = $mass, inertia = $inertia, center = "T" }

[joints]
hub = { type = "revolute", bodies = ["solid", "ground"], point = "H"$axis }
tip = { type = "rigid", bodies = ["solid", "weight"], point = "T" }

[joints.motor]
type = "angle-driver"
bodies = ["solid", "ground"]
point = "H"
${line_of_axis}curve = { type = "cycloid", height = 1.5707963267948966, duration = $duration }

[loads]
gravity = { type = "gravity", acceleration = $gravity }

[design]  # short names of numbers; `ffrf sensitivity` differentiates by them
T = "joints.motor.curve.duration"
rho = "bodies.solid.density"
m = "bodies.weight.mass"

[responses]
stress = { type = "max-stress", body = "solid"$measure }
torque = { type = "time-max", of = { type = "joint-force", joint = "motor", component = "torque$z" }, measure = "absolute" }
strain = { type = "time-max", of = { type = "strain-energy" } }

[solver]
end_time = $duration
step = $step
rho_inf = 0.8
""")

README = Template("""\
# $what on a motor

`body.toml` describes the body: its mesh `$mesh`, material, where it is held, how many shapes it keeps. `scene.toml` puts it
on a motor.$drawn

```
ffrf-preprocess $folder/body.toml        # writes body.h5, and says how exact the stress of this mesh is; again after every change
ffrf statics $folder/scene.toml          # under its weight, a quarter of a turn on: stress, with exact derivatives
ffrf simulate $folder/scene.toml         # the motion: stress, torque of the motor
ffrf sensitivity $folder/scene.toml      # how these depend on the motor's time, the density and the weight at the tip
ffrf render $folder/scene.toml --output $folder/pictures --animate
ffrf simulate $folder/scene.toml --set bodies.weight.mass=$heavier   # any number can be changed for one run
```
""")
