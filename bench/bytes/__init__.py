"""Ops on frames of bytes beside OpenCV."""
