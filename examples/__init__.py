"""Programs that show the ops on real photographs: the demo and the gallery, over a common C++ program."""
