"""Image registration by gradient descent: E. Riba et al., Kornia: an Open Source Differentiable Computer
Vision Library for PyTorch, WACV 2020, section 4.2."""
