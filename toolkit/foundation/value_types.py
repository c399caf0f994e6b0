"""Types of values that many rooms hand on: numbers of a design, tables of TOML files, records that JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date, time
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    import scipy.sparse

Number: TypeAlias = float | complex
"""A number of a scene, of a design or of a result: complex where a complex step differentiates it."""
Matrix: TypeAlias = "np.ndarray | scipy.sparse.csr_array"
"""A matrix, sparse where it is large and zero nearly everywhere."""
TomlValue: TypeAlias = "str | float | complex | date | time | Sequence[TomlValue] | Mapping[str, TomlValue]"
"""A value of a TOML file, or the number that a complex step puts there."""
TomlTable: TypeAlias = dict[str, TomlValue]
Json: TypeAlias = "str | float | Sequence[Json] | Mapping[str, Json] | None"
"""A value that JSON can hold."""
Record: TypeAlias = dict[str, Json]
"""What a result, or a part of one, is written as: names with values that JSON can hold."""
