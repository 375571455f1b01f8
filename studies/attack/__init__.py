"""The use case `make study WHAT=attack`: two photographs of different things are changed, hardly visibly,
until their key points match by a wanted homography."""
