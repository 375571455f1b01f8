"""Responses as modules that take an image and its scales, the interface of Kornia's detectors."""

from typing import Optional, Union

from torch import Tensor, nn

from ..primitives.core.modules import Module, hold
from .harris import harris_response
from .responses import dog_response, dog_response_single, gftt_response, hessian_response


class CornerHarris(Module):
    """``harris_response`` of an image (B, C, H, W) and optional scales (B,).

    Args:
        k, grads_mode: see ``harris_response``.

    >>> CornerHarris(0.04)(torch.rand(2, 1, 8, 9), torch.ones(2)).shape
    torch.Size([2, 1, 8, 9])
    """

    def __init__(self, k: Union[float, Tensor], grads_mode: str = "sobel") -> None:
        super().__init__()
        if isinstance(k, Tensor):
            hold(self, "k", k)
        else:
            self.k = float(k)
        self.grads_mode = grads_mode

    def forward(self, input: Tensor, sigmas: Optional[Tensor] = None) -> Tensor:
        return harris_response(input, self.k, self.grads_mode, sigmas)


class CornerGFTT(Module):
    """``gftt_response`` of an image (B, C, H, W) and optional scales (B,).

    >>> CornerGFTT()(torch.rand(2, 1, 8, 9)).shape
    torch.Size([2, 1, 8, 9])
    """

    def __init__(self, grads_mode: str = "sobel") -> None:
        super().__init__()
        self.grads_mode = grads_mode

    def forward(self, input: Tensor, sigmas: Optional[Tensor] = None) -> Tensor:
        return gftt_response(input, self.grads_mode, sigmas)


class BlobHessian(Module):
    """``hessian_response`` of an image (B, C, H, W) and optional scales (B,).

    >>> BlobHessian()(torch.rand(2, 1, 8, 9)).shape
    torch.Size([2, 1, 8, 9])
    """

    def __init__(self, grads_mode: str = "sobel") -> None:
        super().__init__()
        self.grads_mode = grads_mode

    def forward(self, input: Tensor, sigmas: Optional[Tensor] = None) -> Tensor:
        return hessian_response(input, self.grads_mode, sigmas)


class BlobDoG(Module):
    """``dog_response`` of a scale space (B, C, D, H, W); scales have no effect here.

    >>> BlobDoG()(torch.rand(1, 1, 4, 8, 9)).shape
    torch.Size([1, 1, 3, 8, 9])
    """

    def forward(self, input: Tensor, sigmas: Optional[Tensor] = None) -> Tensor:
        return dog_response(input)


class BlobDoGSingle(Module):
    """``dog_response_single`` of an image (B, C, H, W); scales have no effect here.

    Args:
        sigma1, sigma2: see ``dog_response_single``.

    >>> BlobDoGSingle()(torch.rand(1, 1, 16, 16)).shape
    torch.Size([1, 1, 16, 16])
    """

    def __init__(self, sigma1: float = 1.0, sigma2: float = 1.6) -> None:
        super().__init__()
        self.sigma1, self.sigma2 = float(sigma1), float(sigma2)

    def forward(self, input: Tensor, sigmas: Optional[Tensor] = None) -> Tensor:
        return dog_response_single(input, self.sigma1, self.sigma2)


def response_name(module: nn.Module) -> str:
    """The ``response`` of ``detect_keypoints`` that a module of Kornia's detector stands for."""
    if isinstance(module, CornerHarris) and module.k == 0.04 and module.grads_mode == "sobel":
        return "harris"
    if isinstance(module, CornerGFTT) and module.grads_mode == "sobel":
        return "gftt"
    if isinstance(module, BlobHessian) and module.grads_mode == "sobel":
        return "hessian"
    if isinstance(module, BlobDoG):
        return "dog"
    raise ValueError(
        "resp_module: expected CornerHarris(0.04), CornerGFTT(), BlobHessian() or BlobDoG(), with"
        f" grads_mode 'sobel', got {module}"
    )
