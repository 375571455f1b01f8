"""A pipeline of augmentation on a batch of bytes, beside Kornia, torchvision, Albumentations and DALI."""
