"""Reads JSON and YAML files into typed models; whatever is wrong with one becomes a single line that names file and field."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, TypeVar

import yaml
from pydantic import BaseModel, Field, FiniteFloat, ValidationError

from protocol.errors import RecordingError

Point = tuple[FiniteFloat, FiniteFloat]
Ring = Annotated[list[Point], Field(min_length=3)]
M = TypeVar("M", bound=BaseModel)


def read_text(file: Path) -> str:
    """Return a file's text; RecordingError where it is missing or no text."""
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{file}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise RecordingError(f"{file}: is not a text file") from error


def read_json(file: Path, model: type[M]) -> M:
    """Return a JSON file as `model`; RecordingError names file and field."""
    try:
        content = json.loads(read_text(file))
    except ValueError as error:
        raise RecordingError(f"{file}: is not JSON ({error})") from error
    return _validated(file, content, model)


def read_yaml(file: Path, model: type[M]) -> M:
    """Return a YAML file as `model`; RecordingError names file and field."""
    try:
        content = yaml.safe_load(read_text(file))
    except yaml.YAMLError as error:
        raise RecordingError(f"{file}: is not YAML ({' '.join(str(error).split())})") from error
    return _validated(file, content, model)


def _validated(file: Path, content: object, model: type[M]) -> M:
    try:
        return model.model_validate(content)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"]) or "top level"
        raise RecordingError(f"{file}: {field}: {first['msg']}") from error
