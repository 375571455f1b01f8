"""Edges, connected components, extrema, patches, descriptors and their matching."""
