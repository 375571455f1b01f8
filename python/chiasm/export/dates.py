"""The time that builds are given to be reproducible."""

from __future__ import annotations

import os
import re

from .errors import ExportError

#: The end of the year 9999, the last that Python and a manifest can write.
_LAST = 253402300799


def given_time() -> int | None:
    """The seconds since 1970 that $SOURCE_DATE_EPOCH says; None where it is not set.

    Raises:
        ExportError: it says what is no such number.
    """
    text = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not text:
        return None
    if not re.fullmatch("[0-9]{1,12}", text) or int(text) > _LAST:
        raise ExportError(f"SOURCE_DATE_EPOCH: expected seconds since 1970, at most {_LAST}, got {text!r}")
    return int(text)
