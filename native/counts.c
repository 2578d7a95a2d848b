/* The range of the readings of a frame, and the least step between them. */
#include "inner.h"

/* A sensor of three counts and fewer shows no noise. */
#define COARSEST 0.3
/* What rounding of numbers leaves is no step. */
#define ROUNDING VH_SAME

/* The range of values that all count. */
static void range_of_all(const vh_real *values, int n, vh_real *lowest, vh_real *highest)
{
    vh_real low[VH_LANES], high[VH_LANES];
    int i = 0;
    for (int k = 0; k < VH_LANES; k++)
        low[k] = high[k] = values[0];
    for (; i + VH_LANES <= n; i += VH_LANES) {
        VH_SIDE_BY_SIDE
        for (int k = 0; k < VH_LANES; k++) {
            low[k] = values[i + k] < low[k] ? values[i + k] : low[k];
            high[k] = values[i + k] > high[k] ? values[i + k] : high[k];
        }
    }
    for (int k = 0; k < VH_LANES; k++) {
        *lowest = vh_least(*lowest, low[k]);
        *highest = vh_most(*highest, high[k]);
    }
    for (; i < n; i++) {
        *lowest = vh_least(*lowest, values[i]);
        *highest = vh_most(*highest, values[i]);
    }
}

int vh_all_count(const uint8_t *counts, int n) { return !memchr(counts, 0, (size_t)n); }

int vh_range(const vh_real *values, const uint8_t *counts, int n, vh_real *lowest, vh_real *highest)
{
    int n_counted = 0;
    *lowest = INFINITY;
    *highest = -INFINITY;
    if (n > 0 && vh_all_count(counts, n)) {
        range_of_all(values, n, lowest, highest);
        return n;
    }
    for (int i = 0; i < n; i++) {
        n_counted += counts[i];
        *lowest = counts[i] && values[i] < *lowest ? values[i] : *lowest;
        *highest = counts[i] && values[i] > *highest ? values[i] : *highest;
    }
    return n_counted;
}

/* The lesser of `least` and the steps between two rows of values, where both count (masks may be NULL); four side by side. */
static void least_step(const vh_real *a, const vh_real *b, const uint8_t *ua, const uint8_t *ub, int n, vh_real least[4])
{
    int i = 0;
    for (; !ua && i + 4 <= n; i += 4) {
        VH_SIDE_BY_SIDE
        for (int j = 0; j < 4; j++) {
            const vh_real step = fabs(a[i + j] - b[i + j]), counted = step > ROUNDING * fabs(a[i + j]) ? step : INFINITY;
            least[j] = counted < least[j] ? counted : least[j];
        }
    }
    for (; i < n; i++) {
        const vh_real step = fabs(a[i] - b[i]);
        if ((!ua || (ua[i] && ub[i])) && step > ROUNDING * fabs(a[i]))
            least[0] = vh_least(least[0], step);
    }
}

/*
 * The least difference between neighbours that is not zero: a sensor's count, where it has one; 0 where all neighbours
 * are equal, or where so few counts reach the peak that they are the steps of the form. Readings that are not rounded
 * have none: where it is no more than `enough` it is not looked for to the end, and 0 is returned.
 */
vh_real vh_count_of(const vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real enough)
{
    vh_real least[4] = {INFINITY, INFINITY, INFINITY, INFINITY}, one = INFINITY, lowest, peak;
    const int whole = vh_all_count(usable, rows * cols);
    for (int r = 0; r < rows && one > enough; r++) {
        const vh_real *f = frame + (size_t)r * cols;
        const uint8_t *u = whole ? 0 : usable + (size_t)r * cols;
        least_step(f, f + 1, u, u + !whole, cols - 1, least);
        if (r + 1 < rows)
            least_step(f, f + cols, u, u + (whole ? 0 : cols), cols, least);
        one = vh_least(vh_least(least[0], least[1]), vh_least(least[2], least[3]));
    }
    if (!(one > enough))
        return 0.0;
    vh_range(frame, usable, rows * cols, &lowest, &peak);
    return one < COARSEST * peak ? one : 0.0;
}
