"""Flexible bodies from a finite-element mesh of any program, or from finished matrices, in the plane and in space.

A spatial body needs a mesh of tetrahedra, hexahedra or wedges with named groups, and a body.toml beside it:

    units = "m-kg-s"
    mesh.file = "arm.msh"
    material = { youngs_modulus = 70e9, density = 2700.0, poisson_ratio = 0.33 }
    clamp.group = "hub"
    interface_points.tip = { group = "bore", tie = "rigid" }
    pressure_surfaces.skin.group = "outside"
    basis = { kind = "craig-bampton", count = 12 }

A slender body that bends far is cut across into groups of elements, for several floating frames; it has no basis then:

    pieces.groups = ["root", "middle", "outer"]

Then `ffrf-preprocess body.toml`, or `preprocessing.save(preprocessing.build("body.toml"), "body.h5")`.
"""
