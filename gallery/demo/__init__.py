"""The demo: part of the catalog on real photographs, run from a C++ program on every backend."""
