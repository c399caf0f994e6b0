"""Words of Abaqus and CalculiX: element types and keywords, and what they say about a body of solids or of the plane."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

SOLIDS = {4: "tetra", 6: "wedge", 8: "hexahedron", 10: "tetra10", 15: "wedge15", 20: "hexahedron20"}
"""Number of nodes of a solid -> its kind; the order of nodes is that of the kind."""
FACES = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
"""The same of elements of the plane, membranes and shells."""
LINES = {2: "line", 3: "line3"}
"""The same of trusses: middle nodes last, as the kind has it."""

PATTERNS = (
    ("solid", r"C3D(4|6|8|10|15(?!V)|20)[A-Z]*"),
    ("plane", r"CPS(3|4|6|8)[A-Z]*|CPE(3|4|6|8)[A-Z]*"),
    ("skin", r"(?:M3D|SFM3D|S|STRI|DS)(3|4|6|8|9)(?:R[S57]?|[TW5S])?|STRI(6)5|S(9|8|4)R5"),
    ("bar", r"T[23]D(2|3)[A-Z]*"),
    ("mass", r"(MASS|ROTARYI)"),
)
"""Role -> names of its types; what they carry is told by their sections."""
SHAPES = {"B31H": "line", "B33H": "line3", "R3D3": "triangle", "CAX4P": "quad"}
"""Types that meshio 5.3 writes for what has a shape and no more; in a deck with sections they are what their names say."""
OTHERS = {
    "axisymmetric solids": r"CAX[A-Z]*[0-9]+[A-Z]*|CGAX[0-9]+[A-Z]*|CCL[0-9]+[A-Z]*|CAXA[0-9A-Z]*",
    "solids of generalised plane strain": r"CPEG[0-9]+[A-Z]*",
    "solids whose middle nodes vary": r"C3D(15V|27)[A-Z]*",
    "pyramids": r"C3D5[A-Z]*|C3D13[A-Z]*",
    "infinite solids": r"CIN[0-9A-Z]+",
    "continuum shells": r"CSS8|SC[68]R[A-Z]*",
    "axisymmetric shells and membranes": r"S?SAX[0-9A-Z]*|SAXA[0-9A-Z]*|M[CG]?AX[0-9]|MCL[0-9]",
    "shells": r"DS[0-9]+|US[0-9]+",
    "beams": r"B[23][123][A-Z]*|PIPE[23][0-9A-Z]*|ELBOW[0-9A-Z]*|FRAME[23]D",
    "user elements": r"U[0-9]+[A-Z0-9]*",
    "springs": r"SPRING[12A]|JOINTC|JOINT[23]D",
    "dashpots": r"DASHPOT[12A]",
    "connectors": r"CONN[23]D2",
    "gaps": r"GAP(UNI|CYL|SPHER)[A-Z0-9]*|ITS[A-Z0-9]*|ITT[0-9A-Z]*|ISL[0-9A-Z]*|IRS[0-9A-Z]*|PSI[0-9A-Z]*",
    "couplings": r"D?COUP[23]D|DCOUP3D",
    "rigid elements": r"R2D2|R3D[34]|RAX2|RB[23]D2",
    "cohesive elements": r"COH[0-9A-Z]+",
    "gaskets": r"GK[0-9A-Z]+",
    "heat transfer elements": r"D(C|CC)?[123]D[0-9A-Z]+|DCAX[0-9A-Z]+|DGAP|D|HEATCAP|F3D[0-9A-Z]+|DC[0-9A-Z]+",
    "acoustic elements": r"AC[123]D[0-9A-Z]+|ACAX[0-9A-Z]+|ACIN[0-9A-Z]+|ASI[0-9A-Z]*",
    "piezoelectric and electromagnetic elements": r"EMC[0-9A-Z]+",
    "particles": r"PC3D|PD3D|EC3D[0-9A-Z]+|FC3D[0-9A-Z]+",
    "substructures": r"Z[0-9]+",
    "drag chains": r"DRAG[23]D",
}
"""What they are -> names of types that a body of solids cannot take."""


class ElementType(NamedTuple):
    """Properties of an element type."""

    name: str  # in capitals
    role: str  # solid, plane, skin, bar, shape, mass, or other
    kind: str  # of meshes, in the words of meshio; empty of mass and other
    n_nodes: int  # 0 of other
    words: str  # what such elements are


WORDS = {
    "shape": "beams, rigid or axisymmetric elements",
    "solid": "solids",
    "plane": "plane solids",
    "skin": "shells or membranes",
    "bar": "trusses",
    "mass": "concentrated masses",
}


def element_type(name: str) -> ElementType | None:
    """Properties of an element type by its name in capitals; None if it is not known."""
    if name in SHAPES:
        kind = SHAPES[name]
        return ElementType(name, "shape", kind, {"line": 2, "line3": 3, "triangle": 3, "quad": 4}[kind], WORDS["shape"])
    for role, pattern in PATTERNS:
        if found := re.fullmatch(pattern, name):
            return _meshed(name, role, next((text for text in found.groups() if text), ""))
    for words, pattern in OTHERS.items():
        if re.fullmatch(pattern, name):
            return ElementType(name, "other", "", 0, words)
    return None


def _meshed(name: str, role: str, digits: str) -> ElementType:
    if role == "mass":
        return ElementType(name, role, "vertex", 1, WORDS[role])
    n_nodes = int(digits)
    kinds = SOLIDS if role == "solid" else LINES if role == "bar" else FACES
    return ElementType(name, role, kinds[n_nodes], n_nodes, WORDS[role])


CARRIES = {
    "NONSTRUCTURAL MASS": "mass spread over elements",
    "REBAR": "reinforcement",
    "REBAR LAYER": "reinforcement",
    "MATRIX ASSEMBLE": "matrices of another file",
    "MATRIX INPUT": "matrices of another file",
    "IMPERFECTION": "displacements of nodes",
    "ADJUST": "nodes that are moved onto a surface",
    "MASS ADJUST": "masses that are changed to given ones",
    "NMAP": "nodes that are mapped to other places",
    "SYMMETRIC MODEL GENERATION": "a model that is made of another one",
    "IMPORT": "a model of another analysis",
    "IMPORT ELSET": "a model of another analysis",
    "IMPORT NSET": "a model of another analysis",
    "REFINE MESH": "a mesh that is made of this one",
    "SUBSTRUCTURE PROPERTY": "a substructure",
    "FASTENER": "fasteners",
    "FASTENER PROPERTY": "fasteners",
    "BRITTLE FAILURE": "elements that fail",
    "ENRICHMENT": "elements with cracks",
    "RANDOM FIELD": "a field that changes the body",
}
"""Keyword -> what it adds to the body or changes of it, which cannot be taken."""

TIES = {
    "TIE", "RIGID BODY", "COUPLING", "KINEMATIC", "DISTRIBUTING", "KINEMATIC COUPLING", "DISTRIBUTING COUPLING", "MPC", "EQUATION",
    "EMBEDDED ELEMENT", "SHELL TO SOLID COUPLING", "CYCLIC SYMMETRY MODEL", "PRE-TENSION SECTION", "CONTACT PAIR", "CONTACT",
    "MULTI-POINT CONSTRAINT", "EQUATIONF", "NETWORK MPC", "MODEL CHANGE",
}  # fmt: skip
"""Keywords that tie nodes or take elements away in the analysis; the body itself is free of them."""

SAY_NOTHING = {
    "AMPLITUDE", "BASE", "BASE MOTION", "BASELINE", "BEAM SECTION", "BEAM SECTION GENERATE", "BEAM SECTION OFFSET",
    "BOUNDARY", "BOUNDARYF", "BUCKLE", "BULK VISCOSITY", "CAP", "CAPACITY", "CAST", "CECHARGE", "CECURRENT", "CENTROID",
    "CFD", "CFILM", "CFLOW", "CFLUX", "CHANGE", "CHANGE CONTACT TYPE", "CHANGE FRICTION", "CHANGE MATERIAL", "CHANGE PLASTIC",
    "CHANGE SOLID SECTION", "CHANGE SURFACE BEHAVIOR", "CLAY", "CLEARANCE", "CLOAD", "COHESIVE", "COMBINED", "COMPLEX",
    "COMPLEX FREQUENCY", "COMPOSITE", "CONCRETE", "CONDUCTIVITY", "CONNECTOR", "CONNECTOR BEHAVIOR", "CONNECTOR DAMPING",
    "CONNECTOR ELASTICITY", "CONNECTOR LOAD", "CONNECTOR MOTION", "CONNECTOR SECTION", "CONNECTOR STOP", "CONSTRAINT",
    "CONTACT CLEARANCE", "CONTACT CONTROLS", "CONTACT DAMPING", "CONTACT EXCLUSIONS", "CONTACT FILE", "CONTACT FORMULATION",
    "CONTACT INCLUSIONS", "CONTACT INITIALIZATION", "CONTACT INTERFERENCE", "CONTACT OUTPUT", "CONTACT PERMEABILITY",
    "CONTACT PRINT", "CONTACT PROPERTY", "CONTACT RESPONSE", "CONTACT STABILIZATION", "CONTROLS", "CORRELATION",
    "CORRELATION LENGTH", "COUPLED", "COUPLED TEMPERATURE-DISPLACEMENT", "CRACK", "CRACK PROPAGATION", "CRADIATE", "CREEP",
    "CRUSHABLE", "CSTRESS", "CYCLED", "CYCLIC", "CYCLIC HARDENING", "D", "DAMAGE", "DAMAGE INITIATION", "DAMPING", "DASHPOT",
    "DEBOND", "DECHARGE", "DECURRENT", "DEFORMATION", "DEFORMATION PLASTICITY", "DENSITY", "DEPVAR", "DESIGN",
    "DESIGN RESPONSE", "DESIGN VARIABLES", "DETONATION", "DFLOW", "DFLUX", "DIAGNOSTICS", "DIELECTRIC", "DIFFUSIVITY",
    "DIRECT", "DISCRETE", "DISPLAY", "DISTRIBUTION", "DLOAD", "DRAG", "DRUCKER", "DSA", "DSECHARGE", "DSECURRENT", "DSFLOW",
    "DSFLUX", "DSLOAD", "DYNAMIC", "EL", "EL FILE", "EL PRINT", "ELASTIC", "ELECTRIC", "ELECTRICAL",
    "ELECTRICAL CONDUCTIVITY", "ELECTROMAGNETIC", "ELECTROMAGNETICS", "ELEMENT MATRIX OUTPUT", "ELEMENT OPERATOR OUTPUT",
    "ELEMENT OUTPUT", "ELEMENT RESPONSE", "EMISSIVITY", "END LOAD CASE", "END STEP", "ENERGY", "EOS", "EPJOINT", "EULERIAN",
    "EXPANSION", "EXTREME", "FABRIC", "FACE", "FACE PRINT", "FAIL", "FEASIBLE", "FEASIBLE DIRECTION", "FIELD", "FIELDS",
    "FILE", "FILM", "FILTER", "FIXED", "FLEXIBLE", "FLOW", "FLUID", "FLUID CONSTANTS", "FLUID SECTION", "FOUNDATION",
    "FRACTURE", "FRAME SECTION", "FREQUENCY", "FRICTION", "GAP", "GAP CONDUCTANCE", "GAP HEAT GENERATION", "GAS", "GASKET",
    "GEL", "GEOMETRIC", "GEOMETRIC CONSTRAINT", "GEOMETRIC TOLERANCES", "GEOSTATIC", "GLOBAL", "GREEN", "HCF", "HEADING",
    "HEAT", "HEAT TRANSFER", "HEATCAP", "HOURGLASS", "HYPERELASTIC", "HYPERFOAM", "HYPOELASTIC", "HYSTERESIS", "IMPEDANCE",
    "INCIDENT", "INCREMENTATION", "INELASTIC", "INERTIA", "INITIAL", "INITIAL CONDITIONS", "INITIAL STRAIN INCREASE",
    "INITIAL STRESS", "INTEGRATED", "INTERFACE", "ITS", "JOINT", "JOINTED", "JOULE", "LATENT", "LOAD", "LOADING",
    "LOW-DENSITY", "M1", "M2", "MAGNETIC", "MAGNETIC PERMEABILITY", "MAP", "MASS DIFFUSION", "MASS FLOW", "MASSFLOW",
    "MATERIAL", "MATRIX GENERATE", "MATRIX OUTPUT", "MEDIA", "MEMBRANE SECTION", "MODAL", "MODAL DAMPING", "MODAL DYNAMIC",
    "MODEL", "MOHR", "MOHR COULOMB", "MOHR COULOMB HARDENING", "MOISTURE", "MOLECULAR", "MONITOR", "MOTION", "MULLINS", "NO",
    "NO ANALYSIS", "NO COMPRESSION", "NO TENSION", "NODAL", "NODAL THICKNESS", "NODE FILE", "NODE OUTPUT", "NODE PRINT",
    "NODE RESPONSE", "NONLINEAR", "NORMAL", "OBJECTIVE", "ORIENTATION", "ORNL", "OUTPUT", "PARAMETER", "PARAMETER DEPENDENCE",
    "PARAMETER SHAPE VARIATION", "PARTICLE", "PERIODIC", "PERMEABILITY", "PHYSICAL", "PHYSICAL CONSTANTS", "PIEZOELECTRIC",
    "PIPE-SOIL", "PLANAR", "PLASTIC", "POROUS", "POST", "POTENTIAL", "PREPRINT", "PRESSURE", "PRESTRESS", "PRINT",
    "PROBABILITY", "PSD-DEFINITION", "RADIATE", "RADIATION", "RADIATION FILE", "RANDOM", "RATE", "RATIOS", "RELEASE",
    "RESPONSE", "RESTART", "RETAINED", "RETAINED NODAL DOFS", "RIGID", "ROBUST", "ROBUST DESIGN", "SECTION", "SECTION PRINT",
    "SELECT", "SELECT CYCLIC SYMMETRY MODES", "SENSITIVITY", "SFILM", "SFLOW", "SHEAR", "SHELL GENERAL SECTION",
    "SHELL SECTION", "SIMPEDANCE", "SLIDE", "SLOAD", "SOILS", "SOLID SECTION", "SOLUBILITY", "SOLUTION", "SOLUTION CONTROLS",
    "SOLVER", "SORPTION", "SPECIFIC", "SPECIFIC GAS CONSTANT", "SPECIFIC HEAT", "SPECTRUM", "SPRING", "SRADIATE", "STATIC",
    "STEADY", "STEADY STATE DYNAMICS", "STEP", "SUBCYCLING", "SUBMODEL", "SUBSTRUCTURE COPY", "SUBSTRUCTURE DELETE",
    "SUBSTRUCTURE DIRECTORY", "SUBSTRUCTURE GENERATE", "SUBSTRUCTURE LOAD CASE", "SUBSTRUCTURE MATRIX OUTPUT",
    "SUBSTRUCTURE MODAL DAMPING", "SUBSTRUCTURE PATH", "SURFACE BEHAVIOR", "SURFACE FLAW", "SURFACE INTERACTION",
    "SURFACE PROPERTY", "SURFACE PROPERTY ASSIGNMENT", "SURFACE SECTION", "SWELLING", "SYMMETRIC RESULTS TRANSFER",
    "TEMPERATURE", "TENSILE", "TENSION", "TENSION CUTOFF", "THERMAL", "TIME", "TIME POINTS", "TORQUE", "TRACER", "TRANSFORM",
    "TRANSFORMF", "TRANSPORT", "TRANSVERSE", "TRIAXIAL", "TRS", "UEL", "UNCOUPLED", "UNCOUPLED TEMPERATURE-DISPLACEMENT",
    "UNDEX", "UNIAXIAL", "UNLOADING", "USER", "USER ELEMENT", "USER MATERIAL", "USER SECTION", "VALUES", "VALUES AT INFINITY",
    "VARIABLE", "VIEWFACTOR", "VIEWFACTOR OUTPUT", "VISCO", "VISCOELASTIC", "VISCOUS", "VOID", "VOLUMETRIC", "WAVE", "WIND",
}  # fmt: skip
"""Keywords, or first words of several, of materials, sections, loads, steps and output."""

OWN = {
    "NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "SYSTEM", "PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "INSTANCE",
    "END INSTANCE", "MASS", "ROTARY INERTIA", "SHELL GENERAL SECTION", "BEAM GENERAL SECTION", "NGEN", "NFILL", "NCOPY",
    "ELGEN", "ELCOPY", "INCLUDE", "REF NODE", "ROT NODE", "TIE NSET", "PIN NSET", "CONSTRAINT NAME", "OLD SET", "NEW SET",
    "CHANGE NUMBER", "ELEMENT SHIFT", "SHIFT NODES", "TWO STEP", "ALL NODES",
}  # fmt: skip
"""Keywords and parameters that are read."""
PARAMETERS = {
    "NODE": ("INPUT", "NSET", "SYSTEM"),
    "ELEMENT": ("ELSET", "FILE", "INPUT", "OFFSET", "TYPE"),
    "NSET": ("ELSET", "GENERATE", "INPUT", "INSTANCE", "INTERNAL", "NSET", "UNSORTED"),
    "ELSET": ("ELSET", "GENERATE", "INPUT", "INSTANCE", "INTERNAL", "UNSORTED"),
    "SURFACE": ("COMBINE", "CROP", "INTERNAL", "NAME", "NO OFFSET", "NO THICK", "TRIM", "TYPE"),
    "SYSTEM": (),
    "PART": ("NAME",),
    "INSTANCE": ("INSTANCE", "LIBRARY", "NAME", "PART"),
    "NGEN": ("LINE", "NSET", "SYSTEM"),
    "NFILL": ("BIAS", "NSET", "SINGULAR", "TWO STEP"),
    "NCOPY": ("CHANGE NUMBER", "MULTIPLE", "NEW SET", "OLD SET", "POLE", "REFLECT", "SHIFT"),
    "ELGEN": ("ALL NODES", "ELSET"),
    "ELCOPY": ("ELEMENT SHIFT", "NEW SET", "OLD SET", "REFLECT", "SHIFT NODES"),
    "MASS": ("ALPHA", "COMPOSITE", "ELSET", "INPUT", "ORIENTATION", "TYPE"),
    "ROTARY INERTIA": ("ALPHA", "COMPOSITE", "ELSET", "INPUT", "ORIENTATION"),
}
"""Keyword that is read -> its parameters."""
SPELLED = {name.replace(" ", ""): name for name in (*SAY_NOTHING, *CARRIES, *TIES, *OWN)}
"""Name without blanks -> name: blanks count nowhere, so that *ENDSTEP is *END STEP."""


def spelled(name: str) -> str:
    """Keyword or parameter, in capitals, as it is spelled here; an unknown one with single blanks between its words."""
    return SPELLED.get("".join(name.split()).upper(), " ".join(name.upper().split()))


def spelled_parameter(keyword: str, name: str) -> str:
    """Parameter of a keyword as it is spelled here; its first letters suffice where no other begins with them."""
    known = PARAMETERS.get(keyword, ())
    plain = "".join(name.split()).upper()
    exact = [each for each in known if each.replace(" ", "") == plain]
    begun = exact or [each for each in known if each.replace(" ", "").startswith(plain)]
    return begun[0] if len(begun) == 1 else spelled(name)


def unknown_parameters(keyword: str, parameters: Mapping[str, str]) -> list[str]:
    """Parameters that a keyword, if it is one that is read, does not know."""
    return [name for name in parameters if name not in PARAMETERS[keyword]] if keyword in PARAMETERS else []


def says_nothing(keyword: str) -> bool:
    """Whether a keyword is known and says nothing about nodes, elements or masses."""
    return keyword in SAY_NOTHING or keyword.partition(" ")[0] in SAY_NOTHING


TETRA = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
HEXAHEDRON = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
WEDGE = ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0))
CORNERS = {
    "tetra": TETRA, "tetra10": TETRA, "hexahedron": HEXAHEDRON, "hexahedron20": HEXAHEDRON, "wedge": WEDGE, "wedge15": WEDGE,
    "triangle": ((0, 1), (1, 2), (2, 0)), "triangle6": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)), "quad8": ((0, 1), (1, 2), (2, 3), (3, 0)),
}  # fmt: skip
"""Kind of element -> corners of its faces S1, S2 and so on."""
MIDDLES = {
    "tetra10": ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)),
    "hexahedron20": ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    "wedge15": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    "triangle6": ((0, 1), (1, 2), (2, 0)),
    "quad8": ((0, 1), (1, 2), (2, 3), (3, 0)),
}
"""Kind of element -> corners of the edges whose middle nodes follow the corners."""
FLAT = {"triangle": 3, "quad": 4, "triangle6": 6, "quad8": 8, "quad9": 9}
NAMES = {2: "line", 3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}


SIDE = re.compile(r"([SE])([1-6])")
BOTH_SIDES = ("SPOS", "SNEG")
"""The two sides of a shell or membrane, which have the same nodes."""


def side_of(kind: str, name: str) -> tuple[str, list[int]] | None:
    """Kind of a side by its name in Abaqus, and the places of its nodes among those of the element; None of one that is not read."""
    flat = not kind.startswith(("tetra", "wedge", "hexahedron"))
    if name in BOTH_SIDES and kind in FLAT:
        return kind, [*range(FLAT[kind])]
    found = SIDE.fullmatch(name)
    return face_of(kind, int(found[2]) - 1) if found and (flat or found[1] == "S") else None


def face_of(kind: str, number: int) -> tuple[str, list[int]] | None:
    """Kind of a face, from 0 for S1 on, and the places of its nodes among those of the element; None where there is no such face."""
    if kind not in CORNERS or not 0 <= number < len(CORNERS[kind]):
        return None
    corners = CORNERS[kind][number]
    if kind not in MIDDLES:
        return NAMES[len(corners)], [*corners]
    first = 1 + max(max(edge) for edge in MIDDLES[kind])
    middle = {frozenset(edge): first + k for k, edge in enumerate(MIDDLES[kind])}
    if len(corners) == 2:
        return "line3", [*corners, middle[frozenset(corners)]]
    around = [middle[frozenset(pair)] for pair in zip(corners, corners[1:] + corners[:1], strict=True)]
    return NAMES[2 * len(corners)], [*corners, *around]


def lie_on_solids(kind: str, elements: np.ndarray, solids: list[tuple[str, np.ndarray]]) -> np.ndarray:
    """Which elements of lower dimension (n_e, n_local) are faces, or between nodes, of solids of these kinds and nodes."""
    n_corners = {"line": 2, "line3": 2, "triangle": 3, "triangle6": 3}.get(kind, 4)
    wanted = np.sort(elements[:, :n_corners], axis=1)
    if n_corners == 2:
        ends: np.ndarray = np.isin(wanted, np.concatenate([block.ravel() for _, block in solids]))
        return ends[:, 0] & ends[:, 1]
    marked, found = np.unique(wanted), [np.zeros((0, n_corners), np.int64)]
    for solid, block in solids:
        near = block[np.isin(block, marked).sum(axis=1) >= n_corners]
        found += [np.sort(near[:, list(face)], axis=1) for face in CORNERS[solid] if len(face) == n_corners]
    faces = np.concatenate(found)
    _, number = np.unique(np.concatenate([faces, wanted]), axis=0, return_inverse=True)
    number = number.ravel()
    return np.isin(number[len(faces) :], number[: len(faces)])
