"""The image ops that OpenCV's users reach for most, beside OpenCV and Kornia."""
