"""The use case `make study WHAT=training`: a small network trained with augmentation by Kornia, by
torchvision and by chiasm, and without augmentation."""
