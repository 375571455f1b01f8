"""The timestamp of reproducible builds (SOURCE_DATE_EPOCH)."""

from __future__ import annotations

import os
import re

from .errors import ExportError

#: The end of the year 9999, the last that Python and a manifest can write.
_LAST = 253402300799


def given_time() -> int | None:
    """The seconds since 1970 in $SOURCE_DATE_EPOCH; None if it is not set.

    Raises:
        ExportError: its value is not such a number.
    """
    text = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not text:
        return None
    if not re.fullmatch("[0-9]{1,12}", text) or int(text) > _LAST:
        raise ExportError(f"SOURCE_DATE_EPOCH: expected seconds since 1970, at most {_LAST}, got {text!r}")
    return int(text)
