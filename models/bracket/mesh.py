"""Write bracket.msh, the mesh of the bracket: an arm between two bearings, with a lightening hole, of triangles with 6 nodes.

Run it from the folder of the project: python models/bracket/mesh.py
"""

from pathlib import Path
from typing import Any

import gmsh

LENGTH = 120.0  # mm, between the bearings
HOLE, EYE = (10.0, 6.0), (20.0, 13.0)  # radii of holes and of the eyes round them, at the crank and at the pin
WINDOW, SIZE = 7.0, 4.0  # radius of the hole in the middle, and of the elements


def bracket(occ: Any) -> int:
    """The section: a hull of two eyes, three holes; returns its surface."""
    eyes = [(2, occ.addDisk(x, 0, 0, radius, radius)) for x, radius in zip((0.0, LENGTH), EYE, strict=True)]
    corners = [occ.addPoint(x, y, 0) for x, y in ((0, -EYE[0]), (LENGTH, -EYE[1]), (LENGTH, EYE[1]), (0, EYE[0]))]
    sides = [occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    web = (2, occ.addPlaneSurface([occ.addCurveLoop(sides)]))
    holes = [(2, occ.addDisk(x, 0, 0, r, r)) for x, r in zip((0.0, LENGTH, 0.45 * LENGTH), (*HOLE, WINDOW), strict=True)]
    body, _ = occ.fuse([web], eyes)
    ((_, surface),), _ = occ.cut(body, holes)
    return surface


def main(path: Path) -> None:
    """Draw, name the lines of the two bearings, and mesh."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        surface = bracket(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2, [surface], name="bracket")
        for name, x, radius in (("crank", 0.0, HOLE[0]), ("pin", LENGTH, HOLE[1])):
            reach = radius + 1
            found = gmsh.model.getEntitiesInBoundingBox(x - reach, -reach, -1, x + reach, reach, 1, 1)
            gmsh.model.addPhysicalGroup(1, [line for _, line in found], name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 24)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


if __name__ == "__main__":
    target = Path(__file__).with_name("bracket.msh")
    main(target)
    print(f"{target} written.")
