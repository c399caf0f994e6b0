"""The sections of the beam elements behind a reduced model, element by element, as the preprocessing knew them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class BeamSections:
    """Stiffness and mass per length of straight beam elements, and the fibres whose stress the model tells.

    A section lies in the principal axes e_2 and e_3 of its element. In the plane there is one plane of bending: e_2 is the direction of the
    element turned by +90 degrees, and e_3 the z axis. The stress of a fibre at y_2, y_3 is

        stress_per_strain (eps - y_2 kappa_2 - y_3 kappa_3)

    with the axial strain eps and the curvatures kappa of the deflections along e_2 and e_3.
    """

    axis: np.ndarray  # (n_elements, 3), the e_3 of each section before it is made normal to its element
    stress_per_strain: np.ndarray  # (n_elements,), E or, in plane strain, E / (1 - nu^2)
    axial_stiffness: np.ndarray  # E A (n_elements,)
    bending_stiffness: np.ndarray  # E I (n_elements, 1), in space (n_elements, 2) of deflections along e_2 and e_3
    torsional_stiffness: np.ndarray  # G J (n_elements,), zero in the plane
    shear_stiffness: np.ndarray  # kappa G A (n_elements,), zero where shear does not deform the elements
    mass_per_length: np.ndarray  # (n_elements,)
    fibre_distance: np.ndarray  # y_2 (n_stress, 1), in space y_2 and y_3 (n_stress, 2), of every stress point

    def of_elements(self, first: int, last: int) -> BeamSections:
        """Sections of the elements from `first` up to, but without, `last`, without the fibres of stress points."""
        found = {name: array[first:last] for name, array in vars(self).items() if name != "fibre_distance"}
        return BeamSections(**found, fibre_distance=self.fibre_distance[:0])

    @property
    def real(self) -> BeamSections:
        """Sections without imaginary steps."""
        return BeamSections(**{name: np.real(array) for name, array in vars(self).items()})
