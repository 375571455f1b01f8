"""K-means clustering."""

from typing import Any, Dict, Optional, Tuple

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
    centre without points does not move; of equally near centres the first one gets the point. The class
    ``KMeans`` draws the first centres and stops when they move little; here they are an input, and after
    convergence further iterations change nothing. Computed in float64.

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
    _check(x, centers, "x", "centers")
    if num_iterations < 0:
        raise ValueError(f"num_iterations: expected zero or more, got {num_iterations}")
    # Coordinates relative to the mean, so that their products are not large compared to the distances.
    points = x.to(torch.float64)
    origin = points.mean(0)
    if isinstance(x.size(0), int) and x.size(0) == 0:
        origin = torch.zeros_like(origin)  # the mean of no points is NaN
    points, found = points - origin, centers.to(torch.float64) - origin
    found = _moved(found, num_iterations, points)
    return (found + origin).to(x.dtype), _nearest(points, found)


def _check(x: Tensor, centers: Tensor, name: str, centers_name: str) -> None:
    check_rank(x, 2, "(N, D)", name)
    check_floating(x, name)
    check_floating(centers, centers_name)
    if centers.dim() != 2 or centers.size(1) != x.size(1) or centers.size(0) < 1:
        raise ValueError(
            f"{centers_name}: expected shape (K, D) for {name} {list(x.shape)}, got {list(centers.shape)}"
        )


def _nearest(points: Tensor, centers: Tensor) -> Tensor:
    """Index of the nearest centre. The term of the squared distance that is the same for every centre is left
    out."""
    fixed = centers.detach()
    return ((fixed * fixed).sum(1) - 2.0 * small_matmul(points.detach(), fixed.t())).argmin(1)


@repeated
def _moved(centers: Tensor, k: Tensor, points: Tensor) -> Tensor:
    """The centres after an iteration."""
    return _means(points, _nearest(points, centers), centers)


def _means(points: Tensor, nearest: Tensor, centers: Tensor) -> Tensor:
    """The mean of the points of each centre; a centre without points stays."""
    number = torch.arange(centers.size(0), device=centers.device)
    has = (nearest[None] == number[:, None]).to(points.dtype)
    count = has.sum(1, keepdim=True)
    return torch.where(count > 0, small_matmul(has, points) / count.clamp(min=1.0), centers)


class KMeans(Module):
    """``kmeans`` as a class that chooses the first centres and keeps the result; in eager Python only.

    A centre without points moves to a point that is drawn. The centres are buffers: they move with the
    module, and are in its ``state_dict``, which a module that is not fitted can load too.

    Args:
        num_clusters: how many clusters, at least 1.
        cluster_centers: (num_clusters, D), the first centres; None draws this many different points.
        tolerance: stop when the square of the sum of the centres' movements in one iteration is at most this;
            None means after ``max_iterations`` only.
        max_iterations: the maximum number of iterations; 0 means no limit.
        seed: the seed of what a ``fit`` draws; None draws from PyTorch's default generator.

    Raises:
        ValueError: if a setting is not as above, or both limits are missing.

    >>> model = KMeans(2, None, seed=0)
    >>> model.fit(torch.tensor([[0.0], [1.0], [8.0], [10.0]]))
    >>> sorted(model.cluster_centers.flatten().tolist()), model.cluster_assignments.shape
    ([0.5, 9.0], torch.Size([4]))
    """

    first: Optional[Tensor]
    _centers: Optional[Tensor]
    _assignments: Optional[Tensor]

    def __init__(
        self,
        num_clusters: int,
        cluster_centers: Optional[Tensor] = None,
        tolerance: Optional[float] = 1e-3,
        max_iterations: int = 0,
        seed: Optional[int] = None,
    ) -> None:
        super().__init__()
        if num_clusters < 1:
            raise ValueError(f"num_clusters: expected a positive number, got {num_clusters}")
        if cluster_centers is not None:
            check_rank(cluster_centers, 2, "(num_clusters, D)", "cluster_centers")
            if cluster_centers.size(0) != num_clusters:
                raise ValueError(
                    f"cluster_centers: expected {num_clusters} of them, got {list(cluster_centers.shape)}"
                )
        if max_iterations < 0:
            raise ValueError(f"max_iterations: expected zero or more, got {max_iterations}")
        if tolerance is None and max_iterations == 0:
            raise ValueError("tolerance: expected a number, or max_iterations above 0, got None")
        if tolerance is not None and not tolerance >= 0.0:
            raise ValueError(f"tolerance: expected zero or more, got {tolerance}")
        self.num_clusters, self.tolerance, self.max_iterations = num_clusters, tolerance, max_iterations
        self.seed = seed
        self.register_buffer("first", cluster_centers, persistent=False)
        self.register_buffer("_centers", None)
        self.register_buffer("_assignments", None, persistent=False)

    def _load_from_state_dict(self, state_dict: Dict[str, Any], prefix: str, *others: Any) -> None:
        # PyTorch copies into tensors, which a module that is not fitted does not have.
        if self._centers is None and prefix + "_centers" in state_dict:
            self._centers = torch.empty_like(state_dict[prefix + "_centers"])
        super()._load_from_state_dict(state_dict, prefix, *others)

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
        least = self.num_clusters if self.first is None else 1
        if X.size(0) < least:
            raise ValueError(f"X: expected at least {least} points, got {X.size(0)}")
        generator = None if self.seed is None else torch.Generator().manual_seed(self.seed)
        if self.first is None:
            drawn = torch.randperm(X.size(0), generator=generator)[: self.num_clusters]
            first = X[drawn.to(X.device)]
        else:
            first = self.first.to(X.device)
        _check(X, first, "X", "cluster_centers")
        points = X.to(torch.float64)
        origin = points.mean(0)
        points, centers = points - origin, first.to(torch.float64) - origin
        done, moves = 0, True
        while moves and (done == 0 or done != self.max_iterations):
            nearest = _nearest(points, centers)
            # Drawn in each iteration, as in Kornia: one seed then gives the same clusters.
            drawn = torch.randint(X.size(0), (self.num_clusters,), generator=generator)
            empty = torch.bincount(nearest, minlength=self.num_clusters) == 0
            moved = torch.where(empty[:, None], points[drawn.to(X.device)], _means(points, nearest, centers))
            total = (moved - centers).detach().norm(dim=1).sum()
            # NaN is not above any tolerance, and ends the loop.
            moves = self.tolerance is None or float(total * total) > self.tolerance
            centers, done = moved, done + 1
        self._centers = (centers + origin).to(X.dtype)
        self._assignments = self.predict(X)

    def predict(self, x: Tensor) -> Tensor:
        """(N,), the nearest centre of each point (N, D)."""
        return kmeans(x, self.cluster_centers.to(x.device), 0)[1]
