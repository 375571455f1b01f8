"""A model without the contents of its large tensors."""

from __future__ import annotations

from typing import Any

import onnx
from google.protobuf.message import DecodeError

#: Smaller messages are copied unread.
_LARGE = 4096
_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5


def outline(data: bytes) -> onnx.ModelProto:
    """The model in `data`, without the contents of its large tensors, which protobuf would copy.

    Raises:
        DecodeError: it is no model.
    """
    try:
        return onnx.load_from_string(_without_contents(memoryview(data), onnx.ModelProto.DESCRIPTOR))
    except RecursionError:
        raise DecodeError("too many messages inside one another") from None


def _without_contents(data: memoryview, message: Any) -> bytes:
    """The serialized `message` (its descriptor) in `data`, in the same order, without large tensors'
    contents."""
    kept: list[bytes | memoryview] = []
    at = 0
    while at < len(data):
        begin = at
        tag, at = _varint(data, at)
        wire = tag & 7
        if wire == _VARINT:
            _, at = _varint(data, at)
        elif wire == _BYTES:
            size, start = _varint(data, at)
            at = start + size
            field = message.fields_by_number.get(tag >> 3) if size > _LARGE else None
            inner = None if field is None else field.message_type
            if inner is not None and at <= len(data):
                part = _without_contents(data[start:at], inner)
                kept += [_encoded(tag), _encoded(len(part)), part]
                continue
            if field is not None and message is onnx.TensorProto.DESCRIPTOR and at <= len(data):
                continue
        elif wire in (_FIXED64, _FIXED32):
            at += 8 if wire == _FIXED64 else 4
        else:  # a group, which no model has
            raise DecodeError(f"wire type {wire}")
        if at > len(data):
            raise DecodeError("truncated")
        kept.append(data[begin:at])
    return b"".join(kept)


def _varint(data: memoryview, at: int) -> tuple[int, int]:
    """The number at a position, and the position after it."""
    number = 0
    for shift in range(0, 70, 7):
        if at == len(data):
            raise DecodeError("truncated")
        byte = data[at]
        at += 1
        number |= (byte & 127) << shift
        if byte < 128:
            return number, at
    raise DecodeError("a number of more than ten bytes")


def _encoded(number: int) -> bytes:
    """A number as a varint."""
    coded = bytearray()
    while number > 127:
        coded.append(number & 127 | 128)
        number >>= 7
    return bytes([*coded, number])
