/* How far presses are from those that were learned. */
#include "inner.h"

/* Differences are added up as numpy adds them, for the same bits: eight sums side by side, of runs this long at most. */
#define LANES 8
#define LONGEST 128
/* Others that are worked on together, so that no sum waits for its last addition. */
#define TOGETHER 4

static inline vh_real difference(vh_real one, vh_real other, int power)
{
    vh_real off = other - one;
    return power == 1 ? (vh_real)fabs(off) : off * off;
}

static inline void add_run(const vh_real *one, const vh_real *const others[TOGETHER], size_t first, size_t n, int power,
                           vh_real out[TOGETHER])
{
    vh_real lanes[TOGETHER][LANES];
    size_t whole = n - n % LANES;
    for (int k = 0; k < TOGETHER; k++)
        for (int lane = 0; lane < LANES; lane++)
            lanes[k][lane] = difference(one[first + (size_t)lane], others[k][first + (size_t)lane], power);
    for (size_t i = first + LANES; i < first + whole; i += LANES)
        for (int k = 0; k < TOGETHER; k++) {
            VH_SIDE_BY_SIDE
            for (int lane = 0; lane < LANES; lane++)
                lanes[k][lane] += difference(one[i + (size_t)lane], others[k][i + (size_t)lane], power);
        }
    for (int k = 0; k < TOGETHER; k++) {
        const vh_real *r = lanes[k];
        out[k] = ((r[0] + r[1]) + (r[2] + r[3])) + ((r[4] + r[5]) + (r[6] + r[7]));
        for (size_t i = first + whole; i < first + n; i++)
            out[k] += difference(one[i], others[k][i], power);
    }
}

static void add_up(const vh_real *one, const vh_real *const others[TOGETHER], size_t first, size_t n, int power,
                   vh_real out[TOGETHER])
{
    if (n > LONGEST) {
        size_t half = n / 2 - n / 2 % LANES;
        vh_real behind[TOGETHER];
        add_up(one, others, first, half, power, out);
        add_up(one, others, first + half, n - half, power, behind);
        for (int k = 0; k < TOGETHER; k++)
            out[k] += behind[k];
    } else if (n < LANES) {
        for (int k = 0; k < TOGETHER; k++) {
            out[k] = 0;
            for (size_t i = first; i < first + n; i++)
                out[k] += difference(one[i], others[k][i], power);
        }
    } else if (power == 1) {
        add_run(one, others, first, n, 1, out);
    } else {
        add_run(one, others, first, n, 2, out);
    }
}

void vh_distances(const vh_real *ones, int n_ones, const vh_real *others, int n_others, int n_measures, int power,
                  vh_real *out)
{
    size_t width = (size_t)n_measures;
    for (int j = 0; j < n_others; j += TOGETHER) {
        int there = n_others - j < TOGETHER ? n_others - j : TOGETHER;
        const vh_real *rows[TOGETHER];
        for (int k = 0; k < TOGETHER; k++)
            rows[k] = others + width * (size_t)(j + (k < there ? k : there - 1));
        for (int i = 0; i < n_ones; i++) {
            vh_real sums[TOGETHER];
            add_up(ones + width * (size_t)i, rows, 0, width, power, sums);
            for (int k = 0; k < there; k++)
                out[(size_t)i * (size_t)n_others + (size_t)(j + k)] = sums[k] / (vh_real)n_measures;
        }
    }
}
