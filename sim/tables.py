"""The tables of a recording: rows of a stamp and some fields, checked line by line."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

from protocol.errors import RecordingError

T = TypeVar("T")

_STAMP_LIMIT_NS = 2**63


def read_rows(folder: Path, name: str, columns: tuple[str, ...], parse: Callable[[str], T]) -> list[tuple[int, list[T]]]:
    """Return the rows (stamp [ns], parsed fields) of the table `name` in a recording's folder; lines that start with # are comments.

    `columns` names what follows the stamp. `parse` turns one field's text into its value, or raises ValueError that says what is wrong.
    Raises RecordingError, with line and column, where a field cannot be used or where stamps do not increase.
    """
    rows: list[tuple[int, list[T]]] = []
    for place, line in _lines(folder, name):
        stamp_ns, values = _row(place, line, columns, parse)
        if rows and stamp_ns <= rows[-1][0]:
            problem = "repeats" if stamp_ns == rows[-1][0] else "runs backwards"
            raise RecordingError(f"{place}, timestamp [ns]: {stamp_ns} {problem}; stamps must increase from row to row")
        rows.append((stamp_ns, values))
    return rows


def read_text(folder: Path, name: str) -> str:
    """Return the text of the file `name` in a recording's folder, or raise RecordingError."""
    try:
        return (folder / name).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise RecordingError(f"{name}: the file is missing from {folder}") from None
    except OSError as error:
        raise RecordingError(f"{name}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError:
        raise RecordingError(f"{name}: is not a text file") from None


def finite_number(text: str) -> float:
    """Parse a field that holds a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is not a finite number")
    return value


def file_name(text: str) -> str:
    """Parse a field that names a file of the folder beside the table."""
    if text in ("", ".", "..") or "/" in text or "\\" in text or "\0" in text:
        raise ValueError(f"{text!r} is not the plain name of a file")
    return text


def _lines(folder: Path, name: str) -> Iterator[tuple[str, str]]:
    """Yield (where it stands, line) of what is neither comment nor blank."""
    for number, line in enumerate(read_text(folder, name).splitlines(), start=1):
        if line.strip() and not line.startswith("#"):
            yield f"{name}, line {number}", line


def _row(place: str, line: str, columns: tuple[str, ...], parse: Callable[[str], T]) -> tuple[int, list[T]]:
    fields = [field.strip() for field in line.split(",")]
    if len(fields) != len(columns) + 1:
        raise RecordingError(f"{place}: {len(fields)} columns instead of timestamp [ns],{','.join(columns)}")
    stamp_ns = _field(place, "timestamp [ns]", fields[0], _stamp)
    return stamp_ns, [_field(place, column, text, parse) for column, text in zip(columns, fields[1:], strict=True)]


def _field(place: str, column: str, text: str, parse: Callable[[str], T]) -> T:
    try:
        return parse(text)
    except ValueError as error:
        raise RecordingError(f"{place}, {column}: {error}") from None


def _stamp(text: str) -> int:
    if not (text.isascii() and text.isdigit()) or len(text) > 19 or int(text) >= _STAMP_LIMIT_NS:
        raise ValueError(f"{text!r} is not a whole number of nanoseconds")
    return int(text)
