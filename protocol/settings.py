"""A settings file as a pydantic model, and every complaint about it in one line that names file and field."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from protocol.errors import ConfigError

S = TypeVar("S", bound=BaseModel)
Location = tuple[int | str, ...]

ENDPOINT_FORM = r"^(tcp|tls)/[^/\s]+:\d{1,5}$"
Endpoint = Annotated[str, Field(pattern=ENDPOINT_FORM)]  # such as tcp/192.168.1.20:7447

_SHOWN_CHARACTERS = 40  # of a value that was refused


class Settings(BaseModel):
    """Base of every table of a settings file: immutable, no unknown keys, no number where a text stands or the other way round."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


def load_toml(file: Path, model: type[S]) -> S:
    """Return a TOML file as `model`; raises ConfigError that names file, field and remedy."""
    try:
        document = tomllib.loads(read_text(file))
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{file}: is not TOML: {error}") from None
    return parse(file, document, model)


def read_text(file: Path) -> str:
    """Return what a settings file holds; raises ConfigError that names it."""
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{file}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise ConfigError(f"{file}: is not UTF-8 text: {error.reason} at byte {error.start}") from None


def parse(file: Path, document: Mapping[str, Any], model: type[S]) -> S:
    """Return a document that was read from `file` as `model`; raises ConfigError.

    The document is validated as JSON, in which even strict models take a list for a tuple and a text for a path.
    """
    try:
        return model.model_validate_json(json.dumps(document, default=str))
    except ValidationError as error:
        raise ConfigError(_complaint(file, error, model)) from None


def check_names_differ(robots: Sequence[str]) -> None:
    """Raise ValueError, as a model's validator does, where two robots share a name."""
    if twice := sorted({name for name in robots if robots.count(name) > 1}):
        raise ValueError(f"robots need names of their own, but {', '.join(twice)} is there more than once")


def _complaint(file: Path, error: ValidationError, model: type[BaseModel]) -> str:
    """Return the first thing that is wrong, an unknown key before all others: it is often why another one is missing."""
    errors = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] != "extra_forbidden")
    more = f" ({len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"{file}: {_sentence(errors[0], model)}{more}"


def _sentence(detail: ErrorDetails, model: type[BaseModel]) -> str:
    location, _ = _found(detail["loc"], model)
    where = f"`{key_path(location)}`" if location else "the whole file"
    match detail["type"]:
        case "extra_forbidden":
            return f"unknown key {where}; {_advice(detail['loc'], model)}"
        case "missing":
            return f"{where} is missing"
        case "union_tag_invalid":
            chosen = detail["ctx"]
            key = key_path((*location, chosen["discriminator"].strip("'")))
            return f"`{key}`: expected one of {chosen['expected_tags']}, not {chosen['tag']!r}"
        case _:
            value = repr(detail["input"])
            shown = value if len(value) <= _SHOWN_CHARACTERS else f"{value[:_SHOWN_CHARACTERS]}..."
            return f"{where}: {detail['msg'].removeprefix('Value error, ')}, not {shown}"


def _advice(location: Location, model: type[BaseModel]) -> str:
    """Return the nearest known key in an unknown key's table, or all of them where none is near."""
    known = sorted({name for table in _found(location[:-1], model)[1] for name in table.model_fields})
    near = get_close_matches(str(location[-1]), known, n=1)
    return f"did you mean `{near[0]}`?" if near else f"known here: {', '.join(known)}"


def _found(location: Location, model: type[BaseModel]) -> tuple[Location, list[type[BaseModel]]]:
    """Return a location below `model` as it reads in the file, and the models that may stand there.

    A union's tag, which says which of several models it is, stands in the location but not in the file. List positions and map keys lead
    no deeper.
    """
    path: Location = ()
    tables = [model]
    for part in location:
        annotations = [table.model_fields[str(part)].annotation for table in tables if part in table.model_fields]
        tagged = [table for table in tables if part in _tags(table)] if len(tables) > 1 else []
        if tagged and not annotations:
            tables = tagged
        else:
            path += (part,)
            tables = [inner for annotation in annotations for inner in _models_in(annotation)] or tables
    return path, tables


def _tags(table: type[BaseModel]) -> set[object]:
    """Return the words by which a model may be chosen from several."""
    kinds = [field.annotation for field in table.model_fields.values()]
    return {word for kind in kinds if get_origin(kind) is Literal for word in get_args(kind)}


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the models inside a type such as `tuple[Robot, ...]` or `Camera | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)


def key_path(location: Location) -> str:
    """Return ('robots', 1, 'name') as robots[1].name."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location).removeprefix(".")
