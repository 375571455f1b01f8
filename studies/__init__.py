"""The use cases of the Kornia paper at full size, in Python and in C++ (docs/use_cases.md)."""
