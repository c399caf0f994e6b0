"""Airfoil files: every real file reads as documented, every defect is repaired with a message or refused with one."""

from pathlib import Path

import numpy as np
import pytest

from preprocessing.airfoil.airfoil_file import read_airfoil
from toolkit.foundation.errors import InputError

FILES = Path(__file__).parents[1] / "data" / "airfoils"
MORPHING = Path(__file__).parents[2] / "models" / "morphing_wing"

# file: format, rows in the file, thickness in percent, repairs, warnings; counts and thickness as tabulated with the files.
# Formats of two blocks hold the leading edge twice, so that the loop has one row less than the file.
REAL_FILES = {
    "ah88k136.dat": ("Selig", 120, 13.6, [], []),
    "ah93k131.dat": ("Selig", 120, 13.1, [], []),
    "du84132v.dat": ("Selig", 97, 13.6, [], []),
    "du86137_25.dat": ("Selig", 193, 13.7, ["line 196: text behind"], []),
    "e171.dat": ("Selig", 61, 12.3, [], []),
    "e337.dat": ("Selig", 73, 13.1, ["line 27: repeats line 26"], []),
    "fx60126.dat": ("Selig", 97, 12.6, [], []),
    "fx60126_lednicer_noheader.txt": ("headless Lednicer", 98, 12.6, [], []),
    "fx62k131.dat": ("Selig", 97, 13.1, [], ["cross at the tail near x = 0.99"]),
    "fx63120.dat": ("Selig", 35, 12.0, [], ["only 7 rows ahead"]),
    "fx63137.dat": ("Selig", 97, 13.7, [], []),
    "fx67k150_lednicer.dat": ("Lednicer", 88, 15.0, [], []),
    "fx79k144.dat": ("Selig", 97, 14.4, [], []),
    "fxlv152.dat": ("Selig", 97, 15.3, ["line 51: repeats line 50", "line 98: trailing-edge row missing"], []),
    "hq1512.dat": ("Selig", 77, 12.0, [], []),
    "hq17.dat": ("Selig", 95, 15.2, [], []),
    "hq3512.dat": ("Selig", 77, 12.0, [], []),
    "naca23015.af": ("OpenVSP", 36, 15.0, [], ["only 5 rows ahead"]),
    "naca63412_lednicer.dat": ("Lednicer", 52, 12.0, [], []),
    "nlf416_lednicer_noheader.txt": ("headless Lednicer", 63, 16.0, [], []),
}


def naca0012(n: int = 31) -> np.ndarray:
    """Closed NACA 0012 from its thickness polynomial, rows (2 n - 1, 2) in normal form."""
    x = (1 - np.cos(np.linspace(0, np.pi, n))) / 2
    y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    y[-1] = 0.0
    return np.concatenate([np.column_stack([x, y])[::-1], np.column_stack([x, -y])[1:]])


def lines(points: np.ndarray, title: str | None = "Section") -> list[str]:
    return ([title] if title is not None else []) + [f"{x:.7f} {y:.7f}" for x, y in points]


@pytest.fixture
def read(tmp_path):
    """Write lines (or bytes) into a file and read it as an airfoil."""

    def write_and_read(content, **options):
        path = tmp_path / "section.dat"
        path.write_bytes(content if isinstance(content, bytes) else "\n".join(content).encode())
        return read_airfoil(path, **options)

    return write_and_read


def same_points(a, b) -> bool:
    return np.array_equal(a.points, b.points)


def test_every_real_file_is_listed():
    assert {path.name for path in FILES.iterdir()} - {"README.md"} == set(REAL_FILES)


@pytest.mark.parametrize("name", REAL_FILES)
def test_real_file_reads_with_its_tabulated_rows_thickness_and_repairs(name):
    file_format, rows, thickness, repairs, warnings = REAL_FILES[name]
    airfoil = read_airfoil(FILES / name)
    blocks = file_format in ("Lednicer", "headless Lednicer", "OpenVSP")
    dropped = sum("dropped" in repair for repair in airfoil.repairs)
    added = sum("stands for it" in repair for repair in airfoil.repairs)
    assert airfoil.format == file_format
    assert len(airfoil.points) == rows - blocks - dropped + added
    assert 100 * airfoil.thickness[0] == pytest.approx(thickness, abs=0.05 + 1e-9)  # half of the last printed digit
    assert len(airfoil.repairs) == len(repairs)
    assert all(text in repair for text, repair in zip(repairs, airfoil.repairs, strict=True))
    assert len(airfoil.warnings) == len(warnings)
    assert all(text in warning for text, warning in zip(warnings, airfoil.warnings, strict=True))


@pytest.mark.parametrize("path", [*(FILES / name for name in REAL_FILES), *MORPHING.glob("*.dat")], ids=lambda path: path.name)
def test_normal_form_is_anticlockwise_from_tail_to_tail_without_repeated_rows(path):
    points = read_airfoil(path).points
    x, y = points.T
    assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0
    assert min(x[0], x[-1]) > 0.99
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).min() > 1e-9
    assert not points.flags.writeable


def test_selig_and_lednicer_copies_of_one_section_are_equal():
    assert same_points(read_airfoil(FILES / "fx60126.dat"), read_airfoil(FILES / "fx60126_lednicer_noheader.txt"))


def test_frame_of_the_file_is_kept():
    assert read_airfoil(FILES / "ah88k136.dat").points[:, 0].max() == 1.00058
    low = read_airfoil(MORPHING / "low_speed.dat").points
    assert tuple(low[50]) == (0.25, 0.072392637)


def test_open_trailing_edges_stay_open():
    assert read_airfoil(FILES / "fx79k144.dat").trailing_edge_gap == pytest.approx(0.002)
    assert read_airfoil(FILES / "ah93k131.dat").trailing_edge_gap == pytest.approx(0.00069)
    assert not read_airfoil(FILES / "ah93k131.dat").closed
    assert read_airfoil(FILES / "hq1512.dat").closed


def test_thickness_and_leading_edge_follow_a_rotation_that_the_reader_itself_never_makes(read):
    straight = read(lines(naca0012()))
    c, s = np.cos(0.05), np.sin(0.05)
    turned = read(lines(naca0012() @ np.array([[c, s], [-s, c]])))
    assert straight.thickness[0] == pytest.approx(0.12, abs=1e-4)  # the polynomial's own maximum is 0.12003 near 0.30
    assert straight.thickness[1] == pytest.approx(0.30, abs=0.01)  # flat maximum
    # Seven decimals in the file; the place of a flat maximum moves with the samples, 1/2000 of a side.
    assert turned.thickness[0] == pytest.approx(straight.thickness[0], abs=1e-6)
    assert turned.thickness[1] == pytest.approx(straight.thickness[1], abs=2e-3)
    np.testing.assert_allclose(turned.leading_edge, 0.0, atol=1e-6)
    np.testing.assert_allclose(turned.points[0], [c, s], atol=1e-7)


# --- writings of the same section ------------------------------------------------------------------------------------


def upper_and_lower(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    nose = int(np.argmin(points[:, 0]))
    return points[nose::-1], points[nose:]


WRITINGS = {
    "CRLF": lambda p: "\r\n".join(lines(p)).encode(),
    "old Macintosh ends": lambda p: "\r".join(lines(p)).encode(),
    "byte-order mark": lambda p: "\ufeff".encode() + "\n".join(lines(p)).encode(),
    "byte-order mark without title": lambda p: "\ufeff".encode() + "\n".join(lines(p, None)).encode(),
    "Latin-1 title": lambda p: "\n".join(lines(p, "Göttingen 535")).encode("latin-1"),
    "tabs": lambda p: [line.replace(" ", "\t") for line in lines(p)],
    "commas": lambda p: [line.replace(" ", ", ") for line in lines(p)],
    "semicolons": lambda p: [line.replace(" ", ";") for line in lines(p)],
    "no zero before the point": lambda p: [line.replace(" 0.", " .").replace("-0.", "-.") for line in lines(p)],
    "D exponents": lambda p: ["Section", *(f"{x:.7f}D+00 {y * 10:.6f}d-01" for x, y in p)],
    "digits in the title": lambda p: lines(p, "E207 (12.04%)"),
    "title that starts with numbers": lambda p: lines(p, "00 12 NACA"),
    "title of one number": lambda p: lines(p, "0012"),
    "title of several blanks": lambda p: lines(p, "NACA   0012   "),
    "title T": lambda p: lines(p, "T"),
    "no title": lambda p: lines(p, None),
    "comment lines": lambda p: ["# made by hand", *lines(p, None), "# end 1.0 2.0"],
    "comments behind rows": lambda p: [*lines(p)[:5], lines(p)[5] + "  # hinge", *lines(p)[6:]],
    "empty lines": lambda p: ["", "  ", *lines(p)[:20], "", *lines(p)[20:], "", "   ", ""],
    "Lednicer": lambda p: ["S", f"{len(p) // 2 + 1}. {len(p) // 2 + 1}.", "", *blocks(p)],
    "headless Lednicer": lambda p: blocks(p),
    "Lednicer without counts": lambda p: ["S", "", *blocks(p)],
    "Lednicer, lower block first": lambda p: ["S", f"{len(p) // 2 + 1}. {len(p) // 2 + 1}.", *blocks(p * [1, -1])],
    "clockwise": lambda p: lines(p[::-1]),
    "starts at the leading edge": lambda p: lines(from_the_nose(p)[np.r_[: len(p) // 2 + 1, len(p) // 2 + 2 : len(p) + 1]]),
    "starts at the leading edge, tail twice": lambda p: lines(from_the_nose(p)),
    "every row twice": lambda p: lines(np.repeat(p, 2, axis=0)),
    "upper tail row missing": lambda p: lines(p[1:]),
    "lower tail row missing": lambda p: lines(p[:-1]),
    "prose behind": lambda p: [*lines(p), "", "< hinge at 75 % .", " 25 - flap chord"],
    "MSES": lambda p: ["Section", "-2.0 3.0 -2.5 3.5", *lines(p, None)],
    "title of two numbers": lambda p: lines(p, "63 412"),
}


def from_the_nose(p: np.ndarray) -> np.ndarray:
    """Leading edge, upper side, tail twice, lower side, leading edge."""
    upper, lower = upper_and_lower(p)
    return np.concatenate([upper, lower[::-1]])


def blocks(p: np.ndarray) -> list[str]:
    upper, lower = upper_and_lower(p)
    return [*lines(upper, None), "", *lines(lower, None)]


@pytest.mark.parametrize("writing", WRITINGS)
def test_all_writings_of_a_section_give_the_same_points(writing, read):
    section = naca0012()
    expected = read(lines(section))
    np.testing.assert_allclose(expected.points, section, atol=0.5e-7)  # seven decimals in the file
    # One unit in the last place: a D exponent is scaled by ten.
    np.testing.assert_allclose(read(WRITINGS[writing](section)).points, expected.points, atol=1e-15)


@pytest.mark.parametrize(
    ("writing", "message"),
    [
        ("clockwise", "ran clockwise: reversed"),
        ("Lednicer, lower block first", "ran clockwise: reversed"),
        ("starts at the leading edge", "line 2: loop started at the leading edge"),
        ("every row twice", "line 3: repeats line 2, dropped"),
        ("upper tail row missing", "line 2: trailing-edge row missing here, line 61 stands for it"),
        ("lower tail row missing", "line 61: trailing-edge row missing here, line 2 stands for it"),
        ("prose behind", "line 64: text behind the coordinates"),
        ("MSES", "line 2: grid domain"),
        ("title of two numbers", "line 1: numbers 63 412 far off the other rows, taken as the title"),
    ],
)
def test_repairs_are_told_with_their_lines(writing, message, read):
    assert any(message in repair for repair in read(WRITINGS[writing](naca0012())).repairs)


@pytest.mark.parametrize("writing", ["CRLF", "byte-order mark", "tabs", "commas", "Lednicer", "headless Lednicer", "empty lines"])
def test_regular_writings_need_no_repair(writing, read):
    airfoil = read(WRITINGS[writing](naca0012()))
    assert (airfoil.repairs, airfoil.warnings) == ((), ())


def test_name_is_the_title_or_the_name_of_the_file(read):
    assert read(lines(naca0012(), "  E207 (12.04%) ")).name == "E207 (12.04%)"
    assert read(lines(naca0012(), None)).name == "section"
    assert read_airfoil(FILES / "naca23015.af").name == "NACA 23015"


@pytest.mark.parametrize("direction", [1, -1])
def test_direction_is_judged_by_area_also_if_the_upper_side_lies_below_zero(direction, read):
    bowed = naca0012()
    bowed[:, 1] -= 0.4 * bowed[:, 0] * (1 - bowed[:, 0])  # mean height of the upper side: -0.02
    assert bowed[:31, 1].mean() < 0
    np.testing.assert_allclose(read(lines(bowed[::direction])).points, bowed, atol=0.5e-7)  # seven decimals


def test_open_tail_survives_a_loop_from_the_leading_edge(read):
    section = naca0012()
    section[0, 1], section[-1, 1] = 0.001, -0.001
    airfoil = read(lines(from_the_nose(section)[:-1]))
    assert airfoil.trailing_edge_gap == pytest.approx(0.002)
    assert len(airfoil.points) == len(section)


# --- units -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("factor", "options"), [(100, {"units": "percent"}), (550, {"units": "mm", "chord": 550.0}),
                                                 (0.55, {"units": "m", "chord": 0.55}), (1, {"units": "chord"})])  # fmt: skip
def test_stated_units_give_fractions_of_the_chord(factor, options, read):
    np.testing.assert_allclose(read(lines(naca0012() * factor), **options).points, naca0012(), atol=1e-7)  # seven decimals


@pytest.mark.parametrize("factor", [100, 550, 2, 0.5])
def test_unclear_scale_is_refused_with_the_options(factor, read):
    with pytest.raises(InputError, match=rf"section.dat: x reaches {factor:g}.*percent, or mm or m with the length of the chord"):
        read(lines(naca0012() * factor))


@pytest.mark.parametrize(("options", "message"), [
    ({"units": "percent"}, "x reaches 550, that is 5.5 chord .* read as percent of the chord: say what"),
    ({"units": "mm", "chord": 55.0}, "x reaches 550, that is 10 chord .* read as mm with a chord of 55 mm: say what"),
    ({"units": "mm"}, "units 'mm' need chord="),
    ({"units": "mm", "chord": -1.0}, "units 'mm' need chord="),
    ({"chord": 550.0}, "goes with units 'mm' or 'm' only"),
    ({"units": "inch"}, "units 'inch' are unknown; available: chord, percent, mm, m"),
])  # fmt: skip
def test_contradictory_units_are_refused(options, message, read):
    with pytest.raises(InputError, match=message):
        read(lines(naca0012() * 550), **options)


# --- refusals --------------------------------------------------------------------------------------------------------


def replaced(row: int, text: str, p: np.ndarray | None = None) -> list[str]:
    """Lines of the section with the given line (counted from 1) replaced."""
    content = lines(naca0012() if p is None else p)
    return [*content[: row - 1], text, *content[row:]]


def moved(row: int, dx: float, dy: float) -> np.ndarray:
    p = naca0012()
    p[row] += (dx, dy)
    return p


def swapped(i: int, j: int) -> np.ndarray:
    p = naca0012()
    p[[i, j]] = p[[j, i]]
    return p


def crossing_at(x: float) -> np.ndarray:
    """The lower side raised behind x until it lies above the upper one."""
    p = naca0012()
    lower = np.arange(len(p)) > len(p) // 2
    p[lower & (p[:, 0] > x) & (p[:, 0] < 1), 1] += 0.2 * (1 - x)
    return p


def sides_exchanged_behind_a_common_row() -> np.ndarray:
    p = naca0012()
    i = 14  # x about 0.55
    p[[i, -1 - i], 1] = 0.0
    p[:i, 1], p[-i:, 1] = -p[:i, 1], -p[-i:, 1]
    return p


def reflexed_tail_twice() -> list[str]:
    return [*lines(naca0012()), *lines(naca0012() * [1, 0.5], None)]


REFUSALS = {
    "empty file": ([""], "holds no row of coordinates"),
    "title only": (["NACA 0012"], "holds no row of coordinates"),
    "few rows": (lines(naca0012(5)), "only 9 rows; at least 10"),
    "not a number": (replaced(9, "0.8 nan"), "line 9: a coordinate is not finite"),
    "Fortran overflow": (replaced(9, "0.8 ******"), "line 9: a coordinate is not finite"),
    "infinite": (replaced(9, "0.8 -Infinity"), "line 9: a coordinate is not finite"),
    "one number": (replaced(9, "0.8"), "line 9: one number"),
    "damaged row": (replaced(9, "0.8 0.0x2"), "line 9 is no row of coordinates, but line 10 holds 2 numbers again"),
    "decimal commas": ([line.replace(".", ",") for line in lines(naca0012())], "line 2: decimal commas"),
    "decimal commas and commas": ([line.replace(".", ",").replace(" ", ", ") for line in lines(naca0012())], "line 2: decimal comm"),
    "counting column": ([f"{i} {row}" for i, row in enumerate(lines(naca0012(), None), 1)], r"line 1: the first column only counts "
                        r"the rows \(1, 2, ...\). Remove it"),
    "counting column from 0": (["S", *(f"{i} {row}" for i, row in enumerate(lines(naca0012(), None)))], "line 2: the first column o"),
    "too many rows": (lines(naca0012(1501)), "3001 rows; at most 3000 are accepted. Keep every n-th row"),
    "flat": (lines(naca0012() * [1, 0]), "the section has no thickness: .* Check the column of y"),
    "nose row drawn out": (lines(moved(30, -0.05, 0.0)), "line 32: the contour folds back by 1.. degrees at x = -0.05. Fix"),
    "fold back behind the nose": (lines(moved(15, 0.0, 0.2)), "line 17: the contour folds back by 1.. degrees at x = 0.5"),
    "several elements": ([*lines(naca0012()), "999. 999.", *lines(naca0012(), None)], "ISES/MSES file with several elements"),
    "MSES elements": (["S", "-2 3 -2 3", *lines(naca0012(), None), "999.0 999.0", "1 0"], "line 64: '999. 999.'"),
    "two sections": (reflexed_tail_twice(), "x turns back at line"),
    "row out of order": (lines(swapped(12, 15)), "x turns back at line 15"),
    "crossing surfaces": (lines(crossing_at(0.7)), "crosses itself near x = 0.7"),
    "sides exchanged": (lines(sides_exchanged_behind_a_common_row()), "negative thickness"),
    "rows missing": (lines(np.delete(naca0012(), range(8, 22), axis=0)), "gap of 0.7.* between lines 9 and 10"),
    "lower side missing": (lines(naca0012()[:31]), "a surface is missing"),
    "lower tail missing": (lines(naca0012()[:-6]), "line 56: one side ends at x = 0.9.* the other at 1 .line 2"),
    "table x upper lower": ([f"{x:.5f} {y:.5f} {-y:.5f}" for x, y in naca0012()[30::-1]], "a surface is missing"),
    "counts disagree": (["S", "31. 30.", *blocks(naca0012())], r"line 2 announces 31 \+ 30 rows, but 62 follow"),
    "counts exchanged": (["S", "30. 32.", *blocks(naca0012())], "line 2 announces 30 upper rows, but line 33 .x = 1"),
    "three blocks": ([*blocks(naca0012()), *blocks(naca0012())], "falls back to the leading edge 3 times"),
    "symmetric OpenVSP": (["S", "S", "1 Sym Flag (0 - No, 1 - Yes)", "31 Num Pnts", *blocks(naca0012())], "symmetry flag 1"),
    "binary": (b"\x00\x01section", "is not a text file"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_defect_is_refused_with_its_place(case, read):
    content, message = REFUSALS[case]
    with pytest.raises(InputError, match="airfoil section.dat: .*" + message):
        read(content)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"airfoil nowhere\.dat: cannot be read: No such file"):
        read_airfoil(tmp_path / "nowhere.dat")


# --- files of OpenFAST -----------------------------------------------------------------------------------------------


def openfast(points: np.ndarray, count: str | None = None) -> list[str]:
    """A file of coordinates as AeroDyn's manual describes it and as r-test and the IEA 15 MW turbine have it."""
    return [
        f"   {len(points) + 1 if count is None else count}   NumCoords   ! The number of coordinates in the airfoil shape file "
        "(including an extra coordinate for airfoil reference).  Set to zero if coordinates not included.",
        "! ......... x-y coordinates are next if NumCoords > 0 .............",
        "! x-y coordinate of airfoil reference",
        "!  x/c        y/c",
        " 0.250000       0",
        "! coordinates of airfoil shape",
        "!  x/c        y/c",
        *lines(points, None),
    ]


OPENFAST = {
    "from the tail over the upper side": naca0012(),
    "from the tail over the lower side": naca0012()[::-1],
    "from the leading edge": np.vstack([naca0012()[30:], naca0012()[1:31]]),
    "from the leading edge over the upper side": np.vstack([naca0012()[30::-1], naca0012()[-2:29:-1]]),
}


@pytest.mark.parametrize("way", OPENFAST)
def test_file_of_openfast_reads_as_the_section_without_its_reference_point(way, read):
    airfoil = read(openfast(OPENFAST[way]))
    assert (airfoil.format, airfoil.warnings) == ("OpenFAST", ())
    assert same_points(airfoil, read(lines(naca0012())))
    assert airfoil.repairs[0] == "line 5: reference point of an OpenFAST file, no part of the contour"


@pytest.mark.parametrize("place", [(0.375, 0.0), (0.5, 0.1), (1.0, 0.0), (0.0, 0.0)])
def test_reference_point_of_openfast_may_be_anywhere(place, read):
    content = openfast(naca0012())
    content[4] = "{} {}".format(*place)
    assert same_points(read(content), read(lines(naca0012())))


@pytest.mark.parametrize(
    ("count", "message"),
    [
        ("61", "NumCoords announces 61 rows, one of them the reference point, but 62 follow. Fix the number"),
        ("100", "NumCoords announces 100 rows"),
        ("0", "NumCoords is not the number of rows that follow: this is a file of polars"),
        ('@"AF01_Coords.txt"', "NumCoords is not the number of rows that follow: this is a file of polars"),
    ],
)
def test_file_of_openfast_whose_count_is_not_that_of_its_rows_is_refused(count, message, read):
    with pytest.raises(InputError, match=message):
        read(openfast(naca0012(), count))


# --- warnings --------------------------------------------------------------------------------------------------------


def test_crossing_in_the_last_two_percent_only_warns(read):
    section = naca0012(61)
    i = -1 - np.flatnonzero(section[::-1, 0] < 0.99)[0]
    section[i + 1 : -1, 1] += 0.01
    assert any("cross at the tail" in warning for warning in read(lines(section)).warnings)


def test_kink_is_told_with_its_line(read):
    section = naca0012()
    section[10, 1] += 0.05
    assert any("line 12: kink of" in warning for warning in read(lines(section)).warnings)


@pytest.mark.parametrize(("row", "shift"), [(28, (0.0, -0.008)), (33, (0.0, 0.008))])
def test_dented_nose_is_told_with_its_line(row, shift, read):
    assert any(f"line {row + 2}: kink of" in warning for warning in read(lines(moved(row, *shift))).warnings)


@pytest.mark.parametrize("name", REAL_FILES)
def test_leading_edge_drawn_out_of_a_real_section_is_refused(name, read):
    section = read_airfoil(FILES / name).points.copy()
    section[np.argmin(section[:, 0]), 0] -= 0.05
    with pytest.raises(InputError, match=r"the contour folds back by 1\d\d degrees at x = -0\.0"):
        read(lines(section))


COARSE = np.array([0, 0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1])  # as in old tables


def between_arcs(x: np.ndarray, upper: float, lower: float) -> np.ndarray:
    """A section between two parabolas of given heights over the chord, with a sharp nose."""
    arc = 4 * x * (1 - x)
    return np.concatenate([np.column_stack([x, upper * arc])[::-1], np.column_stack([x, lower * arc])[1:]])


SHARP = {
    "thin": between_arcs(COARSE, 0.02, -0.02),
    "thick": between_arcs(COARSE, 0.06, -0.05),
    "cambered": between_arcs(COARSE, 0.08, 0.03),
    "flat below": between_arcs(COARSE, 0.04, 0.0),
    "many rows": between_arcs((1 - np.cos(np.linspace(0, np.pi, 61))) / 2, 0.03, -0.03),
    "diamond": np.vstack([between_arcs(np.array([0, 0.5, 1]), 0.04, -0.04)[k // 8] * (1 - k % 8 / 8)
                          + between_arcs(np.array([0, 0.5, 1]), 0.04, -0.04)[k // 8 + 1] * (k % 8 / 8) for k in range(32)]
                         + [[1.0, 0.0]]),
}  # fmt: skip


@pytest.mark.parametrize("case", SHARP)
def test_sharp_nose_is_no_fold(case, read):
    """The contour turns by up to 175 degrees at one row, but it is hollow on neither side of it."""
    section = SHARP[case]
    airfoil = read(lines(section))
    nose = int(np.argmin(section[:, 0]))
    assert any(f"line {nose + 2}: sharp nose: the contour turns by 1" in text for text in airfoil.warnings)
    np.testing.assert_allclose(airfoil.points, section, atol=1e-7)
    # measured normal to the chord line, whose end is at the nose; the arcs are highest in the middle
    assert airfoil.thickness[0] == pytest.approx(np.ptp(section[np.isclose(section[:, 0], 0.5), 1]), abs=5e-4)
    np.testing.assert_allclose(airfoil.leading_edge, 0.0, atol=2e-3)


def test_sharp_nose_with_a_wrong_row_beside_it_is_refused(read):
    section = between_arcs(COARSE, 0.02, -0.02)
    section[14, 1] = -0.0015  # hollow by 15 degrees between the nose and the next row
    with pytest.raises(InputError, match="line 17: the contour folds back by 1"):
        read(lines(section))


def test_columns_of_an_mses_file_are_counted_without_its_grid_domain(read):
    rows = [line + " 0.0" if i else line for i, line in enumerate(lines(naca0012(), None))]
    assert "line 4: more than two columns in 60 rows" in read(["Section", "-2.0 3.0 -2.5 3.5", *rows]).warnings[0]


def test_few_rows_at_the_nose_are_told(read):
    assert "only 5 rows ahead of 0.05 chord" in read(lines(naca0012(16))).warnings[0]


def test_further_columns_are_told(read):
    section = read([line + " 0.0" for line in lines(naca0012())])
    assert "line 2: more than two columns in 61 rows" in section.warnings[0]


def test_cap_at_the_tail_is_tolerated(read):
    section = naca0012(61)
    section[0], section[-1] = (0.9995, 0.002), (0.9995, -0.002)
    section[1], section[-2] = (1.0, 0.003), (1.0, -0.003)
    section[2], section[-3] = (0.9990, 0.004), (0.9990, -0.004)
    assert read(lines(section)).trailing_edge_gap == pytest.approx(0.004)


@pytest.mark.parametrize(("degrees", "told"), [(-5.0, True), (-2.5, False), (2.5, False), (5.0, True)])
def test_a_section_that_is_turned_in_its_file_is_told(degrees, told, read):
    turn = np.exp(1j * np.radians(degrees))
    turned = naca0012() @ np.array([[turn.real, turn.imag], [-turn.imag, turn.real]])
    warnings = read(lines(turned)).warnings
    assert [f"turned by {degrees:.1f} degrees" in warning for warning in warnings] == [True] * told
