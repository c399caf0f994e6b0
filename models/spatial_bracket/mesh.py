"""Write bracket.msh, the mesh of the spatial bracket: an angle of two arms with a fillet and two bores, of tetrahedra with 10 nodes.

Run it from the folder of the project: python models/spatial_bracket/mesh.py
"""

from pathlib import Path
from typing import Any

import gmsh

LONG, HIGH, WIDE, THICK = 90.0, 60.0, 24.0, 8.0  # mm, of the arms from bore to bore, and of their plates
FILLET, BORE, SIZE = 8.0, 6.0, 6.0  # radii of the inner corner and of both bores; size of the elements


def bracket(occ: Any) -> int:
    """The volume: a lying arm along x from the bore at the origin, an upright one along z at its end; the bores go through the plates."""
    end, radius, half = LONG + THICK / 2, WIDE / 2, THICK / 2
    lying = occ.addBox(0, -radius, -half, end, WIDE, THICK)
    upright = occ.addBox(LONG - half, -radius, -half, THICK, WIDE, HIGH + half)
    corner = occ.addBox(LONG - half - FILLET, -radius, half, FILLET, WIDE, FILLET)
    round_off = occ.addCylinder(LONG - half - FILLET, -radius, half + FILLET, 0, WIDE, 0, FILLET)
    fillet, _ = occ.cut([(3, corner)], [(3, round_off)])
    eyes = [occ.addCylinder(0, 0, -half, 0, 0, THICK, radius), occ.addCylinder(LONG - half, 0, HIGH, THICK, 0, 0, radius)]
    body, _ = occ.fuse([(3, lying)], [(3, upright), *fillet, *((3, eye) for eye in eyes)])
    bores = [occ.addCylinder(0, 0, -half, 0, 0, THICK, BORE), occ.addCylinder(LONG - half, 0, HIGH, THICK, 0, 0, BORE)]
    ((_, volume),), _ = occ.cut(body, [(3, bore) for bore in bores])
    return volume


def main(path: Path, size: float = SIZE, around: int = 12) -> None:
    """Draw, name the walls of the two bores, and mesh with elements of a size, and so many round a bore."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        volume = bracket(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [volume], name="bracket")
        reach, half = BORE + 1, THICK / 2 + 1
        boxes = {"crank": (0, 0, 0, reach, reach, half), "pin": (LONG, 0, HIGH, half, reach, reach)}
        for name, (x, y, z, a, b, c) in boxes.items():
            found = gmsh.model.getEntitiesInBoundingBox(x - a, y - b, z - c, x + a, y + b, z + c, 2)
            gmsh.model.addPhysicalGroup(2, [face for _, face in found], name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", around)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        gmsh.model.mesh.optimize("HighOrder")  # or elements round bores and fillet are folded over
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


if __name__ == "__main__":
    target = Path(__file__).with_name("bracket.msh")
    main(target)
    print(f"{target} written.")
