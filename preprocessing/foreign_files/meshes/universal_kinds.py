"""Numbers that universal files (UNV) give their kinds of elements, and the order in which they number their nodes."""

from __future__ import annotations

KINDS = {
    **dict.fromkeys((11, 21, 22, 31), "line"),
    **dict.fromkeys((23, 24), "line3"),
    **dict.fromkeys((41, 51, 61, 74, 81, 91), "triangle"),
    **dict.fromkeys((42, 52, 62, 72, 82, 92), "triangle6"),
    **dict.fromkeys((44, 54, 64, 71, 84, 94), "quad"),
    **dict.fromkeys((45, 55, 65, 75, 85, 95), "quad8"),
    **{111: "tetra", 118: "tetra10", 112: "wedge", 113: "wedge15", 115: "hexahedron", 116: "hexahedron20"},
}
"""Descriptor of an element -> its kind in the words of meshio."""
BEAMS = (21, 22, 23, 24)
"""Descriptors of elements that have a row more, of their orientation and sections."""
NODES = {
    "line": 2, "line3": 3, "triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8, "tetra": 4, "tetra10": 10, "wedge": 6, "wedge15": 15,
    "hexahedron": 8, "hexahedron20": 20,
}  # fmt: skip
"""Kind -> its number of nodes."""
ORDERS = {
    "line3": [0, 2, 1],
    "triangle6": [0, 2, 4, 1, 3, 5],
    "quad8": [0, 2, 4, 6, 1, 3, 5, 7],
    "tetra10": [0, 2, 4, 9, 1, 3, 5, 6, 7, 8],
    "wedge15": [0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8],
    "hexahedron20": [0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11],
}
"""Kind -> place of every node in a universal file, which goes round each face, corner by middle."""
OTHERS = {
    32: "curved pipe", 121: "rigid bar", 122: "rigid element", 136: "lumped mass", 137: "axisymmetric lumped mass",
    138: "constraint element", 139: "plastic spring", 141: "node to ground translational spring",
    142: "node to ground rotational spring", 151: "node to node translational spring", 152: "node to node rotational spring",
    161: "node to node damper", 171: "gap", 43: "plane stress cubic triangle", 46: "plane stress cubic quadrilateral",
    93: "thin shell cubic triangle", 96: "thin shell cubic quadrilateral", 101: "thick shell linear wedge",
    102: "thick shell parabolic wedge", 104: "thick shell linear brick", 105: "thick shell parabolic brick", 114: "solid cubic wedge",
    117: "solid cubic brick",
}  # fmt: skip
"""Descriptors of elements that are none of the body's, and what they are."""
UNITS = {
    1: "m (SI)", 2: "foot (pound)", 3: "m (kilogram-force)", 4: "foot (poundal)", 5: "mm (millinewton)", 6: "cm (centinewton)",
    7: "inch (pound)", 8: "mm (kilogram-force)", 9: "a unit of the user", 10: "mm (newton)",
}  # fmt: skip
"""Code of dataset 164 -> the length that it stands for."""
