#!/usr/bin/env bash
# Version: AeroSandbox 4.2.10.
# Expected: Airfoils come in two usual formats: one contour around (Selig), or the numbers of points of both
#   sides, then both sides from the leading edge on (Lednicer). Both files hold NACA 0012, which is 0.12
#   thick.
# Seen: The line of numbers, 17 and 17, becomes the first point of the contour, and both sides are joined at
#   opposite ends: a thickness of 1.001 and an area of 8.5. No error and no warning.
# Why: Files in this format are passed around as often as others, and the airfoil is meshed, built and
#   optimized from there. A section of 17 chords may be noticed; fewer points or scaled numbers are noticed
#   less.
# Source: Description of formats of the UIUC airfoil coordinates database. The documentation of Airfoil
#   speaks of .dat files and names no format; in aerosandbox/geometry/airfoil/airfoil_families.py every line
#   of two numbers is a point.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check aerosandbox==4.2.10 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
import aerosandbox
import numpy as np

x = (1 - np.cos(np.linspace(0, np.pi, 17))) / 2
y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)
upper, lower = ("".join(f"{a:.6f} {sign * b:.6f}\n" for a, b in zip(x, y)) for sign in (1, -1))
Path("lednicer.dat").write_text("NACA 0012\n 17.       17.\n\n" + upper + "\n" + lower)
around = "".join(upper.splitlines(keepends=True)[::-1]) + "".join(lower.splitlines(keepends=True)[1:])
Path("selig.dat").write_text("NACA 0012\n" + around)
thickness = {}
for name in ("selig", "lednicer"):
    airfoil = aerosandbox.Airfoil(name="own", coordinates=f"{name}.dat")
    thickness[name] = float(airfoil.max_thickness())
    print(f"{name}: {len(airfoil.coordinates)} points, the first one {airfoil.coordinates[0]}")
    print(f"  thickness {thickness[name]:.3f}, area {airfoil.area():.3f}")
assert abs(thickness["selig"] - 0.12) < 1e-3
assert airfoil.coordinates[0].tolist() == [17.0, 17.0]
assert thickness["lednicer"] > 0.9
END
