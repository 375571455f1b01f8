"""Matching of two views beside OpenCV."""
