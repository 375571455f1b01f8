"""Frames, colour planes, levels and histograms."""
