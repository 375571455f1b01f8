"""Data keys: the names of the tensors that a call takes besides its images."""

from typing import Any, List, Optional, Sequence

#: Other names of keys, from Kornia.
_ALIASES = {"image": "input", "label": "class"}


def read_keys(data_keys: Sequence[Any], known: Sequence[str]) -> List[str]:
    """The names of the keys, which must include "input"; an enum member is read by its name.

    >>> read_keys(["image", "mask"], ["input", "mask"])
    ['input', 'mask']
    """
    names = [str(getattr(key, "name", key)).lower() for key in data_keys]
    keys = [_ALIASES.get(name, name) for name in names]
    for key, given in zip(keys, data_keys):
        if key not in known:
            raise ValueError(f"data_keys: expected some of {list(known)}, got {given!r}")
    if "input" not in keys:
        raise ValueError(f"data_keys: expected 'input' among them, got {list(data_keys)}")
    return keys


def keys_of_call(
    own: List[str], given: Optional[Sequence[Any]], known: Sequence[str], count: int
) -> List[str]:
    """The keys of a call with ``count`` tensors: the call's own keys, or those of the constructor."""
    keys = own if given is None else read_keys(given, known)
    if len(keys) != count:
        raise ValueError(f"args: expected {len(keys)} tensors, for data_keys {keys}, got {count}")
    return keys
