"""What messages are made of: how a value travels, arrays packed into bytes, and the fields that many messages share.

Poses are [x m, y m, theta rad]; covariances of a pose are the upper triangle, row by row, of the 3 x 3 matrix in the body frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat, InstanceOf, model_validator

from protocol.errors import GeometryError
from protocol.geometry import Pose2

METRE_SCALE = 1e-4  # one unit of a packed length is 0.1 mm

Name = Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[a-z0-9][a-z0-9_-]*$")]
PoseTuple = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
PoseCovariance = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
Count = Annotated[int, Field(ge=0, lt=2**63)]
Label = Annotated[int, Field(ge=0, lt=2**15)]  # numbers of things long gone are used again
StampNs = Annotated[int, Field(ge=0, lt=2**63)]

Item = Literal["u1", "i2", "i4", "i8", "f8"]
_ITEM_TYPES: dict[Item, np.dtype[Any]] = {
    "u1": np.dtype("u1"),
    "i2": np.dtype("<i2"),
    "i4": np.dtype("<i4"),
    "i8": np.dtype("<i8"),
    "f8": np.dtype("<f8"),
}


class Message(BaseModel):
    """Base of every value on the bus: immutable, no unknown fields.

    It travels (codec.py) as the bare values of its fields in their order: a word of a fixed choice as its position in that choice, a packed
    array as its data.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    _fields: ClassVar[tuple[str, ...]] = ()  # their names, in order
    _choices: ClassVar[dict[str, tuple[str, ...]]] = {}  # the words to choose from, by field

    @classmethod
    def __pydantic_init_subclass__(cls, **_: object) -> None:
        """Find the fields, and those that hold a word of a fixed choice."""
        kinds = {name: field.annotation for name, field in cls.model_fields.items()}
        cls._fields = tuple(kinds)
        cls._choices = {name: get_args(kind) for name, kind in kinds.items() if get_origin(kind) is Literal}

    def travelling(self) -> tuple[object, ...]:
        """Return the values that travel."""
        values = vars(self)  # pydantic keeps them in the order of declaration
        if not self._choices:
            return tuple(values.values())
        return tuple(self._choices[name].index(value) if name in self._choices else value for name, value in values.items())

    @model_validator(mode="before")
    @classmethod
    def _from_travelling(cls, values: object) -> object:
        """Give the values that travelled, which come as a tuple, their names and words again."""
        if not isinstance(values, tuple):
            return values
        if len(values) != len(cls._fields):
            raise ValueError(f"{len(values)} values for {len(cls._fields)} fields")
        named = dict(zip(cls._fields, values, strict=True))
        for name, words in cls._choices.items():
            if type(named[name]) is int and 0 <= named[name] < len(words):
                named[name] = words[named[name]]
        return named


@dataclass(frozen=True, slots=True)
class Packed:
    """A little-endian array of shape (n,), or (n, columns) where columns is not 0; `item` is its numpy type code.

    A plain dataclass because a local map holds two for each region, and pydantic would take half the time of decoding for them.
    """

    item: Item
    columns: int  # 0 to 255
    data: bytes

    def __post_init__(self) -> None:
        """Raise ValueError where the data are not whole rows of finite values."""
        if len(self.data) % self._row_bytes:
            raise ValueError(f"{len(self.data)} bytes are no whole rows of {max(self.columns, 1)} {self.item}")
        if self.item == "f8" and not np.isfinite(self.array()).all():
            raise ValueError("NaN or infinity in a packed array")

    @classmethod
    def of(cls, array: ArrayLike, item: Item) -> Self:
        """Pack an array of shape (n,) or (n, columns) as it is. Raises GeometryError where a value does not fit the item type."""
        values = np.asarray(array)
        with np.errstate(invalid="ignore"):  # what does not survive the cast is refused by the comparison
            packed = values.astype(_ITEM_TYPES[item])
        if values.ndim not in (1, 2) or not (packed == values).all() or (item == "f8" and not np.isfinite(packed).all()):
            raise GeometryError(f"{values.dtype} array of shape {values.shape} cannot be packed as rows of {item}")
        return cls(item=item, columns=values.shape[1] if values.ndim == 2 else 0, data=packed.tobytes())

    @classmethod
    def of_metres(cls, lengths_m: ArrayLike) -> Self:
        """Pack lengths as 16-bit multiples of 0.1 mm; what lies beyond +-3.2767 m is clipped to that border."""
        units = np.clip(np.rint(np.asarray(lengths_m, dtype=np.float64) / METRE_SCALE), -32767, 32767)
        return cls.of(units, "i2")

    @property
    def rows(self) -> int:
        """Return n."""
        return len(self.data) // self._row_bytes

    @property
    def _row_bytes(self) -> int:
        return _ITEM_TYPES[self.item].itemsize * max(self.columns, 1)

    def array(self) -> NDArray[Any]:
        """Return the values as stored, read-only, shape (n,) or (n, columns)."""
        values: NDArray[Any] = np.frombuffer(self.data, dtype=_ITEM_TYPES[self.item])
        return values.reshape(-1, self.columns) if self.columns else values

    def metres(self) -> NDArray[np.float64]:
        """Return packed lengths [m]."""
        return self.array().astype(np.float64) * METRE_SCALE


def packed_as(item: Item, columns: int = 0, at_least: int = 0) -> BeforeValidator:
    """Return the reader of a packed array with this item type, these columns and at least so many rows; of it only the data travel."""

    def read(value: object) -> object:
        packed = Packed(item, columns, value) if isinstance(value, bytes) else value
        if isinstance(packed, Packed) and (packed.item != item or packed.columns != columns or packed.rows < at_least):
            raise ValueError(f"expected {item} in {columns or 1} columns and {at_least} rows or more")
        return packed

    return BeforeValidator(read)


def check_same_rows(*arrays: Packed) -> None:
    """Raise ValueError where arrays that belong together differ in length."""
    if len({array.rows for array in arrays}) > 1:
        raise ValueError(f"arrays of {', '.join(str(array.rows) for array in arrays)} rows do not belong together")


PackedCounts = Annotated[InstanceOf[Packed], packed_as("i2")]
PackedPoints = Annotated[InstanceOf[Packed], packed_as("i2", columns=2)]  # [0.1 mm]
PackedOutline = Annotated[InstanceOf[Packed], packed_as("i2", columns=2, at_least=3)]  # [0.1 mm], closed polygon, counter-clockwise
PackedFootprint = Annotated[InstanceOf[Packed], packed_as("f8", columns=2, at_least=3)]  # [m], closed polygon, counter-clockwise
PackedStamps = Annotated[InstanceOf[Packed], packed_as("i8")]  # [ns]


def pose_tuple(pose: Pose2) -> PoseTuple:
    """Return a pose as a message field."""
    return (pose.x_m, pose.y_m, pose.theta_rad)


def covariance_tuple(covariance: ArrayLike) -> PoseCovariance:
    """Return a symmetric (3, 3) matrix as a message field."""
    c = np.asarray(covariance, dtype=np.float64)
    return (float(c[0, 0]), float(c[0, 1]), float(c[0, 2]), float(c[1, 1]), float(c[1, 2]), float(c[2, 2]))


def covariance_matrix(field: PoseCovariance) -> NDArray[np.float64]:
    """Return the (3, 3) matrix of a covariance field."""
    xx, xy, xt, yy, yt, tt = field
    return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
