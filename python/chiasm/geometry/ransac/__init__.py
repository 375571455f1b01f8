"""Models of two views from correspondences some of which are wrong: random sample consensus.

M. Fischler, R. Bolles, Random sample consensus, CACM 24(6), 1981. What is random comes as a tensor of uniform
numbers, so that the same call gives the same result on every engine, and how many samples are tried is its
size. To find one sample without a wrong correspondence with probability p, where the share w of all is right,
log(1 - p) / log(1 - w ** m) samples of size m are enough: 1000 samples are for p = 0.999 where w is 0.29 (m =
4), 0.49 (m = 7) and 0.37 (m = 5). With noise several of them are needed, for one of them to be good.
"""

from ...primitives.core.modules import lazy_modules
from .essential import ransac_essential
from .fundamental import ransac_fundamental
from .homography import ransac_homography

__all__ = ["ransac_essential", "ransac_fundamental", "ransac_homography"]

__getattr__, __dir__ = lazy_modules(__name__, globals())
