"""Borders, stencils, correlation, and order statistics over windows."""
