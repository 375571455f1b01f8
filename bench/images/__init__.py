"""The most common image ops of OpenCV's users, compared with OpenCV and Kornia."""
