// AOTInductor's headers include this one by name; what they use of it is in cuda_runtime_api.h.
#include <cuda_runtime_api.h>
