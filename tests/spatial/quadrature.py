"""Energy and momenta of a body of spatial beams in motion, by Gauss points along its elements and equal masses in its section.

No matrix of the preprocessing or of the runtime takes part: only the shape functions of `toolkit.foundation.kinematics.beam_elements`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from preprocessing.builders.frame_file import FrameFile, frame_elements, frame_space
from preprocessing.reduction.chosen_basis import reduced_basis
from preprocessing.reduction.discretisation import Discretisation


class Frame(NamedTuple):
    """Elements of one circular section, and their basis."""

    elements: Discretisation
    z: np.ndarray  # [xi, Psi] (n, 1 + n_f)
    area: float
    radius: float  # of the four equal masses that stand for a section
    density: float


class Motion(NamedTuple):
    """A state of the body: place and velocity of its frame, its axes, angular velocity in them, elastic coordinates and their rates."""

    origin: np.ndarray
    velocity: np.ndarray
    axes: np.ndarray  # (3, 3)
    omega: np.ndarray
    q: np.ndarray
    v: np.ndarray


class Total(NamedTuple):
    """Kinetic energy, linear momentum and angular momentum about the origin of space."""

    energy: float
    linear: np.ndarray
    angular: np.ndarray


def raw_frame(file: FrameFile) -> Frame:
    """The beams of a frame.toml with a single section, a circle, and the basis that it asks for."""
    space = frame_space(file)
    elements, nodes = frame_elements(file, space.values), list(file.nodes)
    matrices = elements.parts.at(space.values)
    clamped = [nodes.index(name) for name in file.clamp or []]
    mass, stiffness = map(matrices.coordinates.of_nodes, (matrices.mass, matrices.stiffness))
    rows = elements.interface_rows()
    basis = reduced_basis(file.basis.choice(), mass, stiffness, elements.nodes, clamped, "clamp", rows)
    (section,), (material,) = file.sections.values(), file.materials.values()
    diameter = section.diameter or 0.0
    # I_p = A d^2 / 8 is that of equal masses at this radius
    return Frame(elements, basis.z, np.pi * diameter**2 / 4, diameter / np.sqrt(8), material.density)


def total(frame: Frame, motion: Motion) -> Total:
    """Sums over eight Gauss points of every element, exact for products of cubics, times four masses of the section.

    place = r + A (x + u + e + th x e),   velocity = r' + A (omega x (x + u + e + th x e) + u' + th' x e)
    """
    mesh, displaced, rates = frame.elements.element, frame.z[:, 1:] @ motion.q, frame.z[:, 1:] @ motion.v
    beams_of_mesh = mesh.elements(np.arange(len(mesh.connectivity)))
    shape, turn = beams_of_mesh.shape, beams_of_mesh.rotation
    ratios, weights = np.polynomial.legendre.leggauss(8)
    energy, linear, angular = 0.0, np.zeros(3), np.zeros(3)
    for k, (one, two) in enumerate(mesh.connectivity):
        dofs, along = mesh.dofs[k, :12], mesh.nodes[two] - mesh.nodes[one]
        line = frame.density * frame.area * np.linalg.norm(along)
        for ratio, weight in zip((ratios + 1) / 2, weights / 2, strict=True):
            moved, turned = (np.tensordot(ratio ** np.arange(4), each[k], 1) for each in (shape, turn))
            for side in (1, -1):
                for axis in (1, 2):
                    e = side * frame.radius * mesh.axes[k, axis]
                    local = mesh.nodes[one] + ratio * along + e + moved @ displaced[dofs] + np.cross(turned @ displaced[dofs], e)
                    relative = moved @ rates[dofs] + np.cross(turned @ rates[dofs], e)
                    place = motion.origin + motion.axes @ local
                    velocity = motion.velocity + motion.axes @ (np.cross(motion.omega, local) + relative)
                    mass = line * weight / 4
                    energy += mass * velocity @ velocity / 2
                    linear += mass * velocity
                    angular += mass * np.cross(place, velocity)
    return Total(float(energy), linear, angular)
