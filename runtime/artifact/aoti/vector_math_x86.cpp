// The vector functions of Sleef that AOTInductor's code calls (libtorch carries them), by glibc's libmvec,
// which every x86-64 Linux has: at most 4 units in the last place. Functions that libmvec lacks are computed
// lane by lane.
#include <immintrin.h>

#include <cmath>

#define UNARY(name, float_accuracy, double_accuracy)                                              \
  extern "C" __m256 _ZGVdN8v_##name##f(__m256);                                                   \
  extern "C" __m256 Sleef_##name##f8_##float_accuracy(__m256 x) { return _ZGVdN8v_##name##f(x); } \
  extern "C" __m256d _ZGVdN4v_##name(__m256d);                                                    \
  extern "C" __m256d Sleef_##name##d4_##double_accuracy(__m256d x) { return _ZGVdN4v_##name(x); }

#define BINARY(name, accuracy)                                                                            \
  extern "C" __m256 _ZGVdN8vv_##name##f(__m256, __m256);                                                  \
  extern "C" __m256 Sleef_##name##f8_##accuracy(__m256 x, __m256 y) { return _ZGVdN8vv_##name##f(x, y); } \
  extern "C" __m256d _ZGVdN4vv_##name(__m256d, __m256d);                                                  \
  extern "C" __m256d Sleef_##name##d4_##accuracy(__m256d x, __m256d y) { return _ZGVdN4vv_##name(x, y); }

UNARY(acos, u10, u10)
UNARY(acosh, u10, u10)
UNARY(asin, u10, u10)
UNARY(asinh, u10, u10)
UNARY(atan, u10, u10)
UNARY(atanh, u10, u10)
UNARY(cos, u35, u10)
UNARY(cosh, u10, u10)
UNARY(erf, u10, u10)
UNARY(erfc, u15, u15)
UNARY(exp, u10, u10)
UNARY(exp2, u10, u10)
UNARY(expm1, u10, u10)
UNARY(log, u10, u10)
UNARY(log10, u10, u10)
UNARY(log1p, u10, u10)
UNARY(log2, u10, u10)
UNARY(sin, u35, u10)
UNARY(sinh, u10, u10)
UNARY(tan, u10, u10)
UNARY(tanh, u10, u10)
BINARY(atan2, u10)
BINARY(hypot, u05)
BINARY(pow, u10)

// Exact by definition, so computing lane by lane costs only time.
#define BY_LANES(name)                                        \
  extern "C" __m256 Sleef_##name##f8(__m256 x, __m256 y) {    \
    for (int i = 0; i < 8; ++i) x[i] = std::name(x[i], y[i]); \
    return x;                                                 \
  }                                                           \
  extern "C" __m256d Sleef_##name##d4(__m256d x, __m256d y) { \
    for (int i = 0; i < 4; ++i) x[i] = std::name(x[i], y[i]); \
    return x;                                                 \
  }

BY_LANES(copysign)
BY_LANES(fmod)
BY_LANES(nextafter)
