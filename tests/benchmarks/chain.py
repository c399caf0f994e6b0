"""A chain of rods swinging under gravity: a mechanism whose size can be chosen."""

from toolkit.components.bodies.rigid import Rod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.scene.scene import Scene


def chain(n: int, step: float = 1e-3, steps: int = 200) -> Scene:
    """`n` rods of 1 m between revolute joints, let go from the horizontal; its points and densities are design variables."""
    names = [f"P{k}" for k in range(n + 1)]
    bodies = {f"rod{k}": Rod(between=(names[k], names[k + 1]), area=1e-4, density=7800.0) for k in range(n)}
    joints = {f"J{k}": Revolute(bodies=(f"rod{k}", f"rod{k - 1}" if k else "ground"), point=names[k]) for k in range(n)}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=float(k), y=0.0) for k, name in enumerate(names)},
        bodies=bodies,
        joints=joints,
        loads={"gravity": Gravity(acceleration=(0.0, -9.81))},
        design={f"x{k}": f"points.P{k + 1}.x" for k in range(n)}
        | {f"y{k}": f"points.P{k + 1}.y" for k in range(n)}
        | {f"density{k}": f"bodies.rod{k}.density" for k in range(n)},
        solver=RunOptions(end_time=step * steps, step=step),
    )
