"""Powers, ranking, reductions, rounding and search, the same on every engine."""
