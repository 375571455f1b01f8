"""K-means clustering."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ..primitives.core.checks import check_floating, check_rank
from ..primitives.core.loops import repeated
from ..primitives.core.modules import Module
from ..primitives.linalg.matrices import small_matmul


def kmeans(x: Tensor, centers: Tensor, num_iterations: int) -> Tuple[Tensor, Tensor]:
    """K-means by Lloyd's algorithm, with a fixed number of iterations. Each iteration assigns points to the
    nearest centre and moves each centre to the mean of its points.

    S. P. Lloyd, Least squares quantization in PCM, IEEE Transactions on Information Theory 28(2), 1982. A
    centre without points does not move; of equally near centres the first one gets the point. Kornia's class
    draws the first centres and stops when they move little; here they are an input, and after convergence
    further iterations change nothing. Computed in float64.

    Args:
        x: (N, D), floating point.
        centers: (K, D), the first centres, floating point.
        num_iterations: zero or more.

    Returns:
        The centres (K, D) in x's dtype, and the nearest of them to each point (N,), int64. Gradients are
        those of the means for a fixed assignment of points.

    Raises:
        TypeError: if x or centers is not floating point.
        ValueError: if x is not (N, D), centers not (K, D) with K at least 1, or num_iterations negative.

    Example:
        >>> kmeans(torch.tensor([[0.0], [1.0], [8.0], [10.0]]), torch.tensor([[0.0], [1.0]]), 5)
        (tensor([[0.5000],
                [9.0000]]), tensor([0, 0, 1, 1]))
    """
    check_rank(x, 2, "(N, D)", "x")
    check_floating(x, "x")
    check_floating(centers, "centers")
    if centers.dim() != 2 or centers.size(1) != x.size(1) or centers.size(0) < 1:
        raise ValueError(f"centers: expected shape (K, D) for x {list(x.shape)}, got {list(centers.shape)}")
    if num_iterations < 0:
        raise ValueError(f"num_iterations: expected zero or more, got {num_iterations}")
    # Coordinates relative to the mean, so that their products are not large compared to the distances.
    points = x.to(torch.float64)
    origin = points.mean(0)
    points, found = points - origin, centers.to(torch.float64) - origin
    found = _moved(found, num_iterations, points)
    return (found + origin).to(x.dtype), _nearest(points, found)


def _nearest(points: Tensor, centers: Tensor) -> Tensor:
    """Index of the nearest centre. The term of the squared distance that is the same for every centre is left
    out."""
    fixed = centers.detach()
    return ((fixed * fixed).sum(1) - 2.0 * small_matmul(points.detach(), fixed.t())).argmin(1)


@repeated
def _moved(centers: Tensor, k: Tensor, points: Tensor) -> Tensor:
    """The centres after an iteration."""
    number = torch.arange(centers.size(0), device=centers.device)
    has = (_nearest(points, centers)[None] == number[:, None]).to(points.dtype)
    count = has.sum(1, keepdim=True)
    return torch.where(count > 0, small_matmul(has, points) / count.clamp(min=1.0), centers)


class KMeans(Module):
    """``kmeans`` as a class that chooses the first centres and keeps the result; in eager Python only.

    Args:
        num_clusters: how many clusters, at least 1.
        cluster_centers: (num_clusters, D), the first centres; None draws this many different points.
        tolerance: stop when the sum of the centres' squared movements in one iteration is less than this.
        max_iterations: the maximum number of iterations; 0 means no limit.
        seed: the seed of the random choice.

    >>> model = KMeans(2, None, seed=0)
    >>> model.fit(torch.tensor([[0.0], [1.0], [8.0], [10.0]]))
    >>> sorted(model.cluster_centers.flatten().tolist()), model.cluster_assignments.shape
    ([0.5, 9.0], torch.Size([4]))
    """

    def __init__(
        self,
        num_clusters: int,
        cluster_centers: Optional[Tensor] = None,
        tolerance: float = 1e-3,
        max_iterations: int = 0,
        seed: Optional[int] = None,
    ) -> None:
        super().__init__()
        if num_clusters < 1:
            raise ValueError(f"num_clusters: expected a positive number, got {num_clusters}")
        if cluster_centers is not None and cluster_centers.size(0) != num_clusters:
            raise ValueError(
                f"cluster_centers: expected {num_clusters} of them, got {list(cluster_centers.shape)}"
            )
        if max_iterations < 0:
            raise ValueError(f"max_iterations: expected zero or more, got {max_iterations}")
        self.num_clusters, self.tolerance, self.max_iterations = num_clusters, tolerance, max_iterations
        self.seed, self.first = seed, cluster_centers
        self._centers: Optional[Tensor] = None
        self._assignments: Optional[Tensor] = None

    @property
    def cluster_centers(self) -> Tensor:
        """(num_clusters, D), the fitted centres, or the given ones before ``fit``."""
        found = self.first if self._centers is None else self._centers
        if found is None:
            raise RuntimeError("KMeans: nothing is fitted yet: call fit() first")
        return found

    @property
    def cluster_assignments(self) -> Tensor:
        """(N,), the centre of each point that was fitted."""
        if self._assignments is None:
            raise RuntimeError("KMeans: nothing is fitted yet: call fit() first")
        return self._assignments

    def fit(self, X: Tensor) -> None:
        """Find the centres of points (N, D)."""
        check_rank(X, 2, "(N, D)", "X")
        if self.first is None:
            if X.size(0) < self.num_clusters:
                raise ValueError(f"X: expected at least {self.num_clusters} points, got {X.size(0)}")
            generator = torch.Generator()
            if self.seed is None:
                generator.seed()
            else:
                generator.manual_seed(self.seed)
            centers = X[torch.randperm(X.size(0), generator=generator)[: self.num_clusters].to(X.device)]
        else:
            centers = self.first
        done = 0
        while True:
            moved, self._assignments = kmeans(X, centers, 1)
            shift = float(((moved - centers) ** 2).sum())
            centers, done = moved, done + 1
            if shift < self.tolerance or done == self.max_iterations:
                break
        self._centers, self._assignments = kmeans(X, centers, 0)

    def predict(self, x: Tensor) -> Tensor:
        """(N,), the nearest centre of each point (N, D)."""
        return kmeans(x, self.cluster_centers.to(x.dtype), 0)[1]
