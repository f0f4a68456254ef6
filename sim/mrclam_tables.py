"""The tables of the UTIAS multi-robot data set: columns of numbers between blanks, checked line by line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from protocol.errors import RecordingError
from sim.tables import finite_number, read_text


def read_table(folder: Path, name: str, columns: tuple[str, ...], *, stamped: bool = False) -> NDArray[np.float64]:
    """Return the rows of a table, shape (n, columns); lines that start with # are comments.

    Raises RecordingError, with line and column, where a field is no finite number or, of a `stamped` table, where times run backwards.
    """
    rows = [_row(place, fields, columns) for place, fields in _lines(folder, name)]
    table = np.array(rows, dtype=np.float64).reshape(-1, len(columns))
    if stamped and ((back := np.diff(table[:, 0]) < 0.0).any() or (table[:, 0] < 0.0).any()):
        row = int(np.argmax(back)) + 1 if back.any() else 0
        raise RecordingError(f"{name}, {columns[0]}: {table[row, 0]:.3f} runs backwards or is negative; times must not decrease")
    return table


def _lines(folder: Path, name: str) -> Iterator[tuple[str, list[str]]]:
    """Yield (where it stands, fields) of what is neither comment nor blank."""
    for number, line in enumerate(read_text(folder, name).splitlines(), start=1):
        fields = line.split()
        if fields and not fields[0].startswith("#"):
            yield f"{name}, line {number}", fields


def _row(place: str, fields: list[str], columns: tuple[str, ...]) -> list[float]:
    if len(fields) != len(columns):
        raise RecordingError(f"{place}: {len(fields)} columns instead of {', '.join(columns)}")
    return [_field(place, column, text) for column, text in zip(columns, fields, strict=True)]


def _field(place: str, column: str, text: str) -> float:
    try:
        return finite_number(text)
    except ValueError as error:
        raise RecordingError(f"{place}, {column}: {error}") from None
