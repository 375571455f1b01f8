"""NumPy's images, channels last, as tensors with channels first, and back, for eager Python: no value and no
dtype changes."""

from typing import Any, List, Sequence

import numpy as np
import torch
from torch import Tensor

from ..primitives.core.checks import check_tensor
from ..primitives.core.modules import Module, eager_only


@eager_only
def image_to_tensor(image: np.ndarray, keepdim: bool = True) -> Tensor:
    """View an array with channels last as a tensor with channels first.

    The dtype and the values stay, so bytes stay in [0, 255], and the tensor shares the array's memory.
    ``frames_to_tensor``, which exports, takes tensors and makes numbers in [0, 1] of bytes.

    Args:
        image: (H, W), (H, W, C) or (B, H, W, C), of any dtype that PyTorch has.
        keepdim: False adds the dimension of a batch to one image.

    Returns:
        (1, H, W), (C, H, W) or (B, C, H, W); without keepdim (1, C, H, W) of one image.

    Raises:
        TypeError: if image is not an array, or PyTorch lacks its dtype.
        ValueError: if image has fewer than 2 or more than 4 dimensions, or a stride is negative.

    Example:
        >>> import numpy as np
        >>> image_to_tensor(np.zeros((4, 6, 3), np.uint8)).shape
        torch.Size([3, 4, 6])
    """
    if not isinstance(image, np.ndarray):
        also = "; frames_to_tensor takes tensors" if isinstance(image, Tensor) else ""
        raise TypeError(f"image: expected a NumPy array, got {type(image).__name__}{also}")
    if not 2 <= image.ndim <= 4:
        raise ValueError(f"image: expected shape (H, W), (H, W, C) or (B, H, W, C), got {list(image.shape)}")
    if any(stride < 0 for stride in image.strides):
        raise ValueError(f"image: expected strides of at least 0, got {image.strides}: pass image.copy()")
    try:
        tensor = torch.from_numpy(image)
    except (TypeError, ValueError) as error:
        raise TypeError(f"image: expected a dtype that PyTorch has, got {image.dtype}") from error
    if image.ndim == 4:
        return tensor.permute(0, 3, 1, 2)
    tensor = tensor[None] if image.ndim == 2 else tensor.permute(2, 0, 1)
    return tensor if keepdim else tensor[None]


@eager_only
def image_list_to_tensor(images: Sequence[Any]) -> Tensor:
    """Join images with channels last to a batch with channels first; the dtype and the values stay.

    Args:
        images: arrays or tensors (H, W, C) of one shape and dtype, at least one.

    Returns:
        (B, C, H, W), a copy.

    Raises:
        ValueError: if there is no image, or one is not (H, W, C) or not of the first one's shape.

    Example:
        >>> import numpy as np
        >>> image_list_to_tensor([np.zeros((4, 6, 3)), np.ones((4, 6, 3))]).shape
        torch.Size([2, 3, 4, 6])
    """
    made: List[Tensor] = [torch.as_tensor(image) for image in images]
    if not made:
        raise ValueError("images: expected at least one, got none")
    for i, image in enumerate(made):
        if image.dim() != 3 or image.shape != made[0].shape:
            wanted = "shape (H, W, C)" if made[0].dim() != 3 else f"the first one's {list(made[0].shape)}"
            raise ValueError(f"images[{i}]: expected {wanted}, got {list(image.shape)}")
    return torch.stack(made).permute(0, 3, 1, 2)


@eager_only
def tensor_to_image(tensor: Tensor, keepdim: bool = False, force_contiguous: bool = False) -> np.ndarray:
    """View a tensor with channels first as an array with channels last, as ``matplotlib`` shows it.

    The dtype and the values stay, except that NumPy has no bfloat16, which becomes float32. The array shares
    the memory of a tensor on the CPU. ``tensor_to_frames``, which exports, makes bytes of numbers in [0, 1].

    Args:
        tensor: (H, W), (C, H, W) or (B, C, H, W), on any device; its gradient is not followed.
        keepdim: True keeps the dimension of a batch of one image.
        force_contiguous: True copies the values into row-major order.

    Returns:
        (H, W), (H, W, C), or (B, H, W, C) if there are several images. A single channel has no dimension.

    Raises:
        TypeError: if tensor is not a tensor.
        ValueError: if tensor has fewer than 2 or more than 4 dimensions.

    Example:
        >>> tensor_to_image(torch.rand(1, 3, 4, 6)).shape, tensor_to_image(torch.rand(1, 4, 6)).shape
        ((4, 6, 3), (4, 6))
    """
    check_tensor(tensor, "tensor")
    if tensor.dim() < 2 or tensor.dim() > 4:
        raise ValueError(
            f"tensor: expected shape (H, W), (C, H, W) or (B, C, H, W), got {list(tensor.shape)}"
        )
    image = tensor.detach().cpu()
    image = image.float() if image.dtype == torch.bfloat16 else image
    if image.dim() > 2:
        image = image.movedim(-3, -1)
        image = image[..., 0] if tensor.size(-3) == 1 else image
    if tensor.dim() == 4 and tensor.size(0) == 1 and not keepdim:
        image = image[0]
    return (image.contiguous() if force_contiguous else image).numpy()


class ImageToTensor(Module):
    """``image_to_tensor`` as a module, for eager Python, whose ``keepdim`` is False by default.

    Args:
        keepdim: as in ``image_to_tensor``.

    Example:
        >>> import numpy as np
        >>> ImageToTensor()(np.zeros((4, 6, 3))).shape
        torch.Size([1, 3, 4, 6])
    """

    def __init__(self, keepdim: bool = False) -> None:
        super().__init__()
        self.keepdim = keepdim

    def forward(self, x: np.ndarray) -> Tensor:
        """The tensor of an array."""
        return image_to_tensor(x, self.keepdim)
