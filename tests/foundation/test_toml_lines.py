"""The line of a key in a TOML file, however it is written."""

import pytest

from toolkit.foundation.files.toml_file import line_of

TEXT = """units = "mm-N-s"  # 1
[points]
A = [1.0, 2.0]
"B.1" = [
  1.0,
  2.0,
]
[bodies]  # with a remark
rod = { type = "rod", between = ["A", "B"] }
loads.drive.torque = 3
"loads.drive.torque.x" = 3
[joints."my joint"]
type = "revolute"
[[cases]]
name = "one"
"""


@pytest.mark.parametrize(
    ("place", "line"),
    [
        ("units", 1),
        ("points.A", 3),
        ("points.A.x", 3),
        ("bodies", 8),
        ("bodies.rod.area", 9),
        ("bodies.loads.drive.torque", 10),
        ("bodies.loads.drive.torque.x", 11),
        ("bodies.loads.drive", 8),
        ("joints.my joint", 12),
        ("joints.my joint.type", 13),
        ("joints.my joint.axis", 12),
        ("cases.name", 15),
        ("solver.step", None),
    ],
)
def test_a_place_has_the_line_of_its_key_or_of_the_table_around_it(place, line):
    assert line_of(TEXT, place) == line


def test_what_is_no_key_is_passed_over():
    assert line_of('text = """\n[[[ = \n"""\nb = 1\n', "b") == 4
