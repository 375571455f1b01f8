// The threads of kernels in tests: those of the artifacts' own OpenMP functions
// (runtime/artifact/aoti/openmp.cpp), provided by a host.
#pragma once

/** Lets kernels that this thread calls share their work among `count` threads. */
void use_threads(int count);
