"""Geometry ops compared with OpenCV."""
