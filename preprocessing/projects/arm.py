"""Write arm.msh, the mesh of an arm: a plate between two eyes with bores and a window, of tetrahedra with 10 nodes. Lengths in mm.

Change the numbers, run it again, python mesh.py, and then ffrf-preprocess body.toml.
"""

from pathlib import Path

import gmsh

LENGTH, THICKNESS = 120.0, 8.0  # between the bores, and of the plate, which lies round z = 0
BORE, EYE = (8.0, 5.0), (16.0, 10.0)  # radii of bores and of the eyes round them, at the hub and at the tip
WINDOW, SIZE = 6.0, 9.0  # radius of the hole in the middle, and of the elements


def arm() -> int:
    """Volume of the arm: a hull of two eyes, three holes, and a thickness."""
    occ = gmsh.model.occ
    low = -THICKNESS / 2
    eyes = [(2, occ.addDisk(x, 0, low, radius, radius)) for x, radius in zip((0.0, LENGTH), EYE, strict=True)]
    corners = [occ.addPoint(x, y, low) for x, y in ((0, -EYE[0]), (LENGTH, -EYE[1]), (LENGTH, EYE[1]), (0, EYE[0]))]
    sides = [occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    web = (2, occ.addPlaneSurface([occ.addCurveLoop(sides)]))
    holes = [(2, occ.addDisk(x, 0, low, r, r)) for x, r in zip((0.0, LENGTH, 0.45 * LENGTH), (*BORE, WINDOW), strict=True)]
    plate, _ = occ.fuse([web], eyes)
    section, _ = occ.cut(plate, holes)
    return next(tag for dimension, tag in occ.extrude(section, 0, 0, THICKNESS) if dimension == 3)


def main(path: Path) -> None:
    """Draw, name the walls of the two bores, and mesh."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        volume = arm()
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [volume], name="arm")
        for name, x, radius in (("hub", 0.0, BORE[0]), ("tip", LENGTH, BORE[1])):
            reach, half = radius + 1, THICKNESS / 2 - 1
            near = gmsh.model.getEntitiesInBoundingBox(x - reach, -reach, -half - 2, x + reach, reach, half + 2, 2)
            gmsh.model.addPhysicalGroup(2, [face for _, face in near], name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        gmsh.model.mesh.optimize("HighOrder")  # or elements round the bores are folded over
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


if __name__ == "__main__":
    target = Path(__file__).with_name("arm.msh")
    main(target)
    print(f"{target} written.")
