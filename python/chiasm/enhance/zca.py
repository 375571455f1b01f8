"""Whitening that is fitted once and applied many times."""

from typing import Any, Dict, Optional

import torch
from torch import Tensor

from ..primitives.core.modules import Module
from .whitening import linear_transform, zca_mean


class ZCAWhitening(Module):
    """Fit ``zca_mean`` to some samples and apply it to other ones; in eager Python only.

    What is fitted are buffers: it moves with the module, and is in its ``state_dict``, which a module that is
    not fitted can load too.

    Args:
        dim: the dimension of the samples.
        eps: added to the covariance's eigenvalues.
        unbiased: divide the covariance by the number of samples minus one.
        detach_transforms: True stops the gradient at the fitted matrices.
        compute_inv: also fit the inverse, for ``inverse_transform``.

    >>> x = torch.tensor([[0.0, 1.0], [1.0, 0.0], [-1.0, 0.0], [0.0, -1.0]])
    >>> ZCAWhitening().fit(x)(x).std(0)
    tensor([1.0000, 1.0000])
    """

    #: The fitted mean (1, D), matrix (D, D) and its inverse; None before.
    mean_vector: Optional[Tensor]
    transform_matrix: Optional[Tensor]
    transform_inv: Optional[Tensor]

    def __init__(
        self,
        dim: int = 0,
        eps: float = 1e-6,
        unbiased: bool = True,
        detach_transforms: bool = True,
        compute_inv: bool = False,
    ) -> None:
        super().__init__()
        self.dim, self.eps, self.unbiased = dim, eps, unbiased
        self.detach_transforms, self.compute_inv = detach_transforms, compute_inv
        for name in ("mean_vector", "transform_matrix", "transform_inv"):
            self.register_buffer(name, None)

    @property
    def fitted(self) -> bool:
        """Whether there is a fit."""
        return self.transform_matrix is not None

    def _load_from_state_dict(self, state_dict: Dict[str, Any], prefix: str, *others: Any) -> None:
        # PyTorch copies into tensors, which a module that is not fitted does not have.
        for name, value in self._buffers.items():
            if value is None and prefix + name in state_dict:
                self._buffers[name] = torch.empty_like(state_dict[prefix + name])
        super()._load_from_state_dict(state_dict, prefix, *others)

    def fit(self, x: Tensor) -> "ZCAWhitening":
        """Learn the mean and the matrix that whiten samples."""
        matrix, mean, inverse = zca_mean(x, self.dim, self.unbiased, self.eps, self.compute_inv)
        self.mean_vector = mean.detach() if self.detach_transforms else mean
        self.transform_matrix = matrix.detach() if self.detach_transforms else matrix
        self.transform_inv = inverse.detach() if inverse is not None and self.detach_transforms else inverse
        return self

    def forward(self, x: Tensor, include_fit: bool = False) -> Tensor:
        """The whitened samples; with ``include_fit``, the transform is first fitted to them."""
        if include_fit:
            self.fit(x)
        matrix, mean = self.transform_matrix, self.mean_vector
        if matrix is None or mean is None:
            raise RuntimeError("ZCAWhitening: nothing is fitted yet: call fit() first, or with include_fit")
        return linear_transform(x, matrix, mean, self.dim)

    def inverse_transform(self, x: Tensor) -> Tensor:
        """The original samples from whitened ones."""
        matrix, mean, inverse = self.transform_matrix, self.mean_vector, self.transform_inv
        # Kornia's state has an empty inverse where none is fitted.
        if matrix is None or mean is None or inverse is None or inverse.numel() == 0:
            raise RuntimeError(
                "ZCAWhitening: no inverse is fitted: ZCAWhitening(compute_inv=True), then fit()"
            )
        return linear_transform(x, inverse, -(mean @ matrix), self.dim)
