"""An augmentation pipeline on a batch of bytes, compared with Kornia, torchvision, Albumentations and
DALI."""
