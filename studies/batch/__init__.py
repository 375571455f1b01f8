"""Batches of images: Sobel edges and three pipelines, beside the libraries that people use for them (E. Riba
et al., Kornia, WACV 2020, 4.1)."""
