"""The gallery: a picture of every op's work, computed by its bundle."""
