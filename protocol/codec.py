"""Messages to bytes and back: `[version, type name, values of the fields in their order]`, in msgpack.

Names of fields, words of a fixed choice and the item types and columns of packed arrays do not travel, since the version stands for them:
any change of a message's fields, of their order, choices or types is a new PROTOCOL_VERSION.
Whatever the bytes hold, `decode` returns a valid message or raises DecodeError with one of the reasons below.
"""

from __future__ import annotations

from typing import Any, TypeVar

import msgpack
from pydantic import ValidationError

from protocol.errors import DecodeError
from protocol.fields import Message, Packed
from protocol.messages import PROTOCOL_VERSION

M = TypeVar("M", bound=Message)

OVERSIZED = "oversized"
MALFORMED = "malformed"
FOREIGN_VERSION = "foreign version"
WRONG_TYPE = "wrong type"

_MAX_ITEMS = 2**16  # of one array, map or text


def encode(message: Message) -> bytes:
    """Return the message as it travels."""
    return bytes(msgpack.packb((PROTOCOL_VERSION, type(message).__name__, message), default=_wire_form))


def decode(data: bytes, message_type: type[M], limit_bytes: int) -> M:
    """Return the message that `data` holds.

    Raises DecodeError, whose text is `oversized`, `malformed`, `foreign version`, `wrong type` or `invalid: <field>`.
    """
    if len(data) > limit_bytes:
        raise DecodeError(OVERSIZED)
    try:
        return message_type.model_validate(_body(data, message_type.__name__), strict=True)
    except ValidationError as error:
        raise DecodeError(f"invalid: {_first_field(error) or message_type.__name__}") from None


def _wire_form(value: object) -> object:
    """Return what msgpack is to write in place of a message or a packed array."""
    if isinstance(value, Packed):
        return value.data
    if isinstance(value, Message):
        return value.travelling()
    raise TypeError(f"{type(value).__name__} is no part of a message")


def _body(data: bytes, type_name: str) -> tuple[Any, ...]:
    """Return the values in an envelope of this version and type."""
    match _unpack(data):
        case (int(version), *_) if version != PROTOCOL_VERSION:
            raise DecodeError(FOREIGN_VERSION)
        case (int(), str(name), tuple()) if name != type_name:
            raise DecodeError(WRONG_TYPE)
        case (int(), str(), tuple(values)):
            return values
    raise DecodeError(MALFORMED)


def _unpack(data: bytes) -> Any:
    """Return the plain values that the bytes hold; a short message cannot claim a large memory."""
    try:
        return msgpack.unpackb(
            data, use_list=False, max_array_len=_MAX_ITEMS, max_map_len=_MAX_ITEMS, max_str_len=_MAX_ITEMS, max_ext_len=0
        )
    except ValueError:  # the base of all of msgpack's complaints, and of those of UTF-8
        raise DecodeError(MALFORMED) from None


def _first_field(error: ValidationError) -> str:
    """Return the outermost field that is at fault: deeper names may come from the network."""
    location = error.errors(include_url=False, include_context=False, include_input=False)[0]["loc"]
    return str(location[0]) if location else ""
