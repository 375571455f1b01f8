"""The use case `make study WHAT=attack`: two photographs of different scenes are changed, hardly visibly,
until their key points match by a chosen homography."""
