"""Whitening that is fitted once and applied many times."""

from torch import Tensor

from ..primitives.core.modules import Module
from .whitening import linear_transform, zca_mean


class ZCAWhitening(Module):
    """Fit ``zca_mean`` to some samples and apply it to other ones; in eager Python only.

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
        self.fitted = False
        self.mean_vector: Tensor
        self.transform_matrix: Tensor
        self.transform_inv: Tensor

    def fit(self, x: Tensor) -> "ZCAWhitening":
        """Learn the mean and the matrix that whiten samples."""
        matrix, mean, inverse = zca_mean(x, self.dim, self.unbiased, self.eps, self.compute_inv)
        self.mean_vector = mean.detach() if self.detach_transforms else mean
        self.transform_matrix = matrix.detach() if self.detach_transforms else matrix
        if inverse is not None:
            self.transform_inv = inverse.detach() if self.detach_transforms else inverse
        self.fitted = True
        return self

    def forward(self, x: Tensor, include_fit: bool = False) -> Tensor:
        """The whitened samples; with ``include_fit``, the transform is first fitted to them."""
        if include_fit:
            self.fit(x)
        if not self.fitted:
            raise RuntimeError("ZCAWhitening: nothing is fitted yet: call fit() first, or with include_fit")
        return linear_transform(x, self.transform_matrix, self.mean_vector, self.dim)

    def inverse_transform(self, x: Tensor) -> Tensor:
        """The original samples from whitened ones."""
        if not self.fitted or not self.compute_inv:
            raise RuntimeError(
                "ZCAWhitening: no inverse is fitted: ZCAWhitening(compute_inv=True), then fit()"
            )
        back = -(self.mean_vector @ self.transform_matrix)
        return linear_transform(x, self.transform_inv, back, self.dim)
