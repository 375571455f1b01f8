// The threads that kernels run on in tests: those of the artifacts' own OpenMP functions
// (runtime/artifact/aoti/openmp.cpp), lent by a host.
#pragma once

/** Has kernels that this thread calls share their work among so many threads. */
void use_threads(int count);
