"""Matching of two views, compared with OpenCV."""
