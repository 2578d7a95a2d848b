/*
 * varishold.h: the arithmetic of touch in plain C99.
 *
 * A pressure frame is cut by a falling threshold, and what its sections are like tells what is touched. These are the
 * functions that the Python package calls, and a microcontroller can.
 *
 * Rules that hold everywhere:
 *  - No heap, no globals but constant tables, nothing but libm. What a function needs beside its arguments it takes
 *    from `work`, of at least as many bytes as the function of the same name with `_work` says; `work` is aligned as a
 *    double is, and no two calls at one time may share it.
 *  - Frames are row by row, one double a taxel. Masks are bytes, 0 or 1.
 *  - Units are the caller's: lengths in those of the pitch, values in those of the frame.
 */
#ifndef VARISHOLD_H
#define VARISHOLD_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32) && defined(VH_SHARED)
#define VH_API __declspec(dllexport)
#elif defined(VH_SHARED)
#define VH_API __attribute__((visibility("default")))
#else
#define VH_API
#endif

/* Whether this processor has AVX2; a library that was compiled for it must not be called where it has not. */
VH_API int vh_cpu_has_avx2(void);

/*
 * The standard deviation of one frame's noise, from the frame alone; 0 where it is too small to tell.
 *
 * frame   rows x cols values; what is not finite leaves itself out.
 * usable  rows x cols; 0 where there is no taxel or a broken one.
 */
VH_API double vh_noise_sigma(const double *frame, const uint8_t *usable, int rows, int cols, void *work);
VH_API size_t vh_noise_sigma_work(int rows, int cols);

#ifdef __cplusplus
}
#endif

#endif
