"""The use case `make study WHAT=training`: a small network trained with Kornia's augmentation, with
torchvision's, with chiasm's and with none."""
