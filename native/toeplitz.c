/* The influence of an elastic skin's cells on each other. */
#include <stdlib.h>

#include "varishold.h"

void vh_toeplitz(const float *kernel, int width, const int64_t *row, const int64_t *col, int n, float *out)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++)
            out[(size_t)i * (size_t)n + (size_t)j] = kernel[llabs(row[i] - row[j]) * width + llabs(col[i] - col[j])];
}
