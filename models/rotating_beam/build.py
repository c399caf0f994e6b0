"""Write beam.h5, the reduced model of the rotating beam: steel, 1 m long, 20 mm high, 50 mm wide, 20 elements, a little damping.

Run it from the folder of the project: python models/rotating_beam/build.py
"""

from pathlib import Path

import numpy as np

from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from toolkit.reduced_model.file import save

LENGTH, ELEMENTS = 1.0, 20
SECTION = Section(youngs_modulus=210e9, density=7800.0, thickness=0.02, width=0.05, damping_stiffness=1e-3)
# the damping, in s, is 5 % of the critical one at the first bending frequency

nodes = np.column_stack([np.linspace(0, LENGTH, ELEMENTS + 1), np.zeros(ELEMENTS + 1)])
model = polygon_beam(nodes, SECTION, {"hub": 0.0, "tip": LENGTH})

if __name__ == "__main__":
    path = Path(__file__).with_name("beam.h5")
    save(model, path)
    print(f"{path} written: {model.n_f} elastic coordinates, interface points {', '.join(model.interfaces or {})}.")
