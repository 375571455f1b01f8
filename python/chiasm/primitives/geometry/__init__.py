"""Cameras, lenses, rotations, and consensus of models."""
