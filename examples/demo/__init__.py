"""The demo: the whole catalog on real photographs, run from a C++ program on every backend."""
