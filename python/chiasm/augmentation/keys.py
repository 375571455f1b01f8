"""Data keys: the names of the tensors that a call takes besides its images."""

from typing import Any, Callable, Dict, List, Optional, Sequence

from ..geometry.held import Held

#: Other names of keys, from Kornia.
_ALIASES = {"image": "input", "label": "class"}


def read_keys(data_keys: Sequence[Any], known: Sequence[str], with_image: bool = True) -> List[str]:
    """The names of the keys, which include "input" if ``with_image``; an enum member is read by its name.

    >>> read_keys(["image", "mask"], ["input", "mask"])
    ['input', 'mask']
    """
    if isinstance(data_keys, str) or not isinstance(data_keys, (list, tuple)):
        raise TypeError(f"data_keys: expected a list of names, got {data_keys!r}")
    names = [str(getattr(key, "name", key)).lower() for key in data_keys]
    keys = [_ALIASES.get(name, name) for name in names]
    for key, given in zip(keys, data_keys):
        if key not in known:
            raise ValueError(f"data_keys: expected some of {list(known)}, got {given!r}")
    if with_image and "input" not in keys:
        raise ValueError(f"data_keys: expected 'input' among them, got {list(data_keys)}")
    return keys


def key_of_name(name: str, known: Sequence[str]) -> str:
    """The key that an item of a dict has by its name; "" if it has none.

    >>> known = ["input", "bbox", "bbox_xyxy"]
    >>> [key_of_name(name, known) for name in ("Image", "bbox_xyxy-left", "bbox_2", "images")]
    ['input', 'bbox_xyxy', 'bbox', '']
    """
    words = [*known, *(alias for alias, key in _ALIASES.items() if key in known)]
    for word in sorted(words, key=len, reverse=True):
        if name.lower() == word or name.lower().startswith((word + "_", word + "-")):
            return _ALIASES.get(word, word)
    return ""


def on_dict(call: Callable[..., Any], data: Dict[str, Any], known: Sequence[str], **settings: Any) -> Any:
    """A dict whose items with a key have gone through ``call``; the others stay as they are."""
    keys = {name: key_of_name(name, known) for name in data}
    names = [name for name in data if keys[name]]
    if not names:
        raise ValueError(f"args: expected a dict with some of the keys {list(known)}, got {list(data)}")
    made = call(*[data[name] for name in names], data_keys=[keys[name] for name in names], **settings)
    return {**data, **dict(zip(names, made if len(names) > 1 else [made]))}


def on_held(call: Callable[..., Any], args: Sequence[Any], keys: List[str], **settings: Any) -> Any:
    """What ``call`` makes of arguments among which are ``Boxes`` and ``Keypoints``, which come back as such.
    Boxes hold the centres of their corner pixels, whatever format they show."""
    held = [isinstance(arg, Held) for arg in args]
    tensors = [arg.data if one else arg for arg, one in zip(args, held)]
    data_keys = ["bbox" if one and key.startswith("bbox") else key for key, one in zip(keys, held)]
    made = call(*tensors, data_keys=data_keys, **settings)
    made = made if len(args) > 1 else [made]
    made = [arg._with(value) if one else value for arg, value, one in zip(args, made, held)]
    return made if len(args) > 1 else made[0]


def keys_of_call(
    own: List[str], given: Optional[Sequence[Any]], known: Sequence[str], count: int, with_image: bool = True
) -> List[str]:
    """The keys of a call with ``count`` tensors: the call's own keys, or those of the constructor."""
    keys = own if given is None else read_keys(given, known, with_image)
    if len(keys) != count:
        raise ValueError(f"args: expected {len(keys)} tensors, for data_keys {keys}, got {count}")
    return keys
