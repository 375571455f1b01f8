"""Losses."""

from .ssim import ssim_loss

__all__ = ["ssim_loss"]
