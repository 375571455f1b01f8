"""Robust estimation of two-view models from correspondences with outliers, by random sample consensus
(RANSAC). M. Fischler, R. Bolles, Random sample consensus, CACM 24(6), 1981. The random numbers are an input
tensor, so that the same call gives the same result on every engine; its size is the number of samples. To get
a sample without outliers with probability p, if a share w of the correspondences are inliers, log(1 - p) /
log(1 - w ** m) samples of size m are enough: 1000 samples give p = 0.999 for w of 0.29 (m = 4), 0.49 (m = 7)
and 0.37 (m = 5). With noise, several samples without outliers are needed so that one of them is accurate.
"""

from ...primitives.core.modules import lazy_modules
from .essential import ransac_essential
from .estimator import RANSAC
from .fundamental import ransac_fundamental
from .homography import ransac_homography

__all__ = ["RANSAC", "ransac_essential", "ransac_fundamental", "ransac_homography"]

__getattr__, __dir__ = lazy_modules(__name__, globals())
