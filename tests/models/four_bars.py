"""IFToMM problem A02: four-bar linkages in a row."""

from __future__ import annotations

from toolkit.components.bodies.rigid import Rod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.scene.scene import Scene


def four_bars(count: int) -> Scene:
    """`count` loops of uniform bars of 1 m and 1 kg, all joints at coordinates (i, 0) and (i, 1); B_0 starts with 1 m/s."""
    links, couplers = range(count + 1), range(1, count + 1)
    bar = {"area": 1.0, "density": 1.0}
    bodies = {f"link{i}": Rod(between=(f"A{i}", f"B{i}"), **bar, velocity=(0.5, 0.0, -1.0)) for i in links}
    bodies |= {f"coupler{i}": Rod(between=(f"B{i - 1}", f"B{i}"), **bar, velocity=(1.0, 0.0, 0.0)) for i in couplers}
    joints = {f"A{i}": Revolute(bodies=(f"link{i}", "ground"), point=f"A{i}") for i in links}
    for i in couplers:
        joints[f"left{i}"] = Revolute(bodies=(f"link{i - 1}", f"coupler{i}"), point=f"B{i - 1}")
        joints[f"right{i}"] = Revolute(bodies=(f"link{i}", f"coupler{i}"), point=f"B{i}")
    points = {f"{row}{i}": Point(x=float(i), y=height) for row, height in (("A", 0.0), ("B", 1.0)) for i in links}
    gravity = Gravity(acceleration=(0.0, -9.81))
    return Scene(units="m-kg-s", points=points, bodies=bodies, joints=joints, loads={"gravity": gravity})
