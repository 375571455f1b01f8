"""The use case `make example-attack`: two photographs of different things are changed, hardly visibly, until
their key points match by a wanted homography."""
