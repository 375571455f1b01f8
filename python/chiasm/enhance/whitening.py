"""Linear transforms of features, and the whitening transform."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank, check_tensor
from ..primitives.linalg.matrices import small_matmul
from ..primitives.linalg.matrix_roots import spd_square_roots


def linear_transform(inp: Tensor, transform_matrix: Tensor, mean_vector: Tensor, dim: int = 0) -> Tensor:
    """Flatten each sample to a row of features and compute (inp - mean_vector) @ transform_matrix.

    Args:
        inp: samples along dim, floating point; the product D of its other sizes is the number of features.
        transform_matrix: (D, D).
        mean_vector: (1, D) or (D,).
        dim: the dimension of the samples.

    Returns:
        Tensor of inp's shape and dtype.

    Raises:
        TypeError: if inp is not floating point.
        ValueError: if inp has fewer than two dimensions, not the dimension dim, or the shape of
            transform_matrix or mean_vector is not as above.

    Example:
        >>> linear_transform(torch.tensor([[1.0, 2.0]]), torch.eye(2) * 2, torch.tensor([[0.0, 1.0]]))
        tensor([[2., 2.]])
    """
    rows, order = _rows(inp, dim)
    features = rows.size(1)
    check_rank(transform_matrix, 2, "(D, D)", "transform_matrix")
    if transform_matrix.size(0) != features or transform_matrix.size(1) != features:
        raise ValueError(
            f"transform_matrix: expected shape ({features}, {features}), got {list(transform_matrix.shape)}"
        )
    check_tensor(mean_vector, "mean_vector")
    if mean_vector.numel() != features:
        raise ValueError(f"mean_vector: expected shape (1, {features}), got {list(mean_vector.shape)}")
    moved = small_matmul(rows - mean_vector.to(inp.dtype).reshape(1, -1), transform_matrix.to(inp.dtype))
    back = [0 for _ in order]
    for i in range(len(order)):
        back[order[i]] = i
    return moved.reshape(inp.permute(order).shape).permute(back)


def zca_mean(
    inp: Tensor, dim: int = 0, unbiased: bool = True, eps: float = 1e-6, return_inverse: bool = False
) -> Tuple[Tensor, Tensor, Optional[Tensor]]:
    """The matrix (covariance + eps I)^(-1/2) and the mean of ZCA whitening, the smallest change that
    decorrelates.

    A. J. Bell, T. J. Sejnowski, The independent components of natural scenes are edge filters, Vision
    Research 37, 1997. The root is computed in float64 by matrix products (Newton-Schulz), not by an
    eigendecomposition; its gradient goes through these products. The result is inexact for eigenvalues below
    1e-10 times their sum.

    Args:
        inp: samples along dim, floating point; the product D of its other sizes is the number of features.
        dim: the dimension of the samples.
        unbiased: divide the covariance by the number of samples minus one.
        eps: added to the eigenvalues of the covariance.
        return_inverse: also return the inverse matrix, (covariance + eps I)^(1/2).

    Returns:
        (D, D) matrix, (1, D) mean, and (D, D) inverse or None.

    Raises:
        TypeError: if inp is not floating point.
        ValueError: if inp has fewer than two dimensions or not the dimension dim.

    Example:
        >>> zca_mean(torch.tensor([[0.0, 1.0], [2.0, 5.0], [0.0, 5.0], [2.0, 1.0]]), unbiased=False)[0]
        tensor([[1.0000, 0.0000],
                [0.0000, 0.5000]])
    """
    rows, _ = _rows(inp, dim)
    samples = rows.to(torch.float64)
    mean = samples.mean(0, keepdim=True)
    centred = samples - mean
    covariance = small_matmul(centred.transpose(0, 1), centred)
    if unbiased:
        covariance = covariance / (rows.size(0) - 1)
    else:
        covariance = covariance / rows.size(0)
    eye = torch.eye(rows.size(1), dtype=torch.float64, device=inp.device)
    root, inverse = spd_square_roots(covariance + eps * eye)
    if return_inverse:
        return inverse.to(inp.dtype), mean.to(inp.dtype), root.to(inp.dtype)
    return inverse.to(inp.dtype), mean.to(inp.dtype), None


def zca_whiten(inp: Tensor, dim: int = 0, unbiased: bool = True, eps: float = 1e-6) -> Tensor:
    """Apply the transform of ``zca_mean``: the features of the result are uncorrelated and have variance 1.

    Args:
        inp: samples along dim, floating point; the product of its other sizes is the number of features.
        dim: the dimension of the samples.
        unbiased: divide the covariance by the number of samples minus one.
        eps: added to the eigenvalues of the covariance.

    Returns:
        Tensor of inp's shape and dtype.

    Raises:
        TypeError: if inp is not floating point.
        ValueError: if inp has fewer than two dimensions or not the dimension dim.

    Example:
        >>> zca_whiten(torch.tensor([[0.0, 1.0], [2.0, 5.0], [0.0, 5.0], [2.0, 1.0]]), unbiased=False)[0]
        tensor([-1.0000, -1.0000])
    """
    matrix, mean, _ = zca_mean(inp, dim, unbiased, eps, False)
    return linear_transform(inp, matrix, mean, dim)


def _rows(inp: Tensor, dim: int) -> Tuple[Tensor, List[int]]:
    """The samples as rows (N, D), and the order of dimensions that puts them first."""
    check_floating(inp, "inp")
    if inp.dim() < 2:
        raise ValueError(f"inp: expected at least two dimensions, got {list(inp.shape)}")
    if dim < -inp.dim() or dim >= inp.dim():
        raise ValueError(f"dim: expected a dimension of a tensor with {inp.dim()}, got {dim}")
    first = dim + inp.dim() if dim < 0 else dim
    order = [first]
    for i in range(inp.dim()):
        if i != first:
            order.append(i)
    return inp.permute(order).flatten(1), order
