"""Batches of images: Sobel edges and three pipelines, compared with common libraries (E. Riba et al., Kornia,
WACV 2020, 4.1)."""
