"""Geometry ops beside OpenCV."""
