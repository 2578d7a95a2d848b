/* Sorting by falling value, stable, and the value of a rank. */
#include "inner.h"

/* Runs so short are sorted by insertion. */
#define RUN 16

static void sort_run(const vh_real *value, int32_t *order, int start, int stop)
{
    for (int i = start + 1; i < stop; i++) {
        int32_t item = order[i];
        vh_real key = value[item];
        int j = i;
        for (; j > start && value[order[j - 1]] < key; j--)
            order[j] = order[j - 1];
        order[j] = item;
    }
}

static void merge_runs(const vh_real *value, const int32_t *order, int start, int middle, int stop, int32_t *into)
{
    int i = start, j = middle, k = start;
    while (i < middle && j < stop) {
        const int32_t one = order[i], other = order[j];
        const int first = value[one] >= value[other];
        into[k++] = first ? one : other;
        i += first;
        j += !first;
    }
    memcpy(into + k, order + i, (size_t)(middle - i) * sizeof *into);
    memcpy(into + k + middle - i, order + j, (size_t)(stop - j) * sizeof *into);
}

void vh_sort_falling(const vh_real *value, int32_t *order, int n, int32_t *other)
{
    for (int start = 0; start < n; start += RUN)
        sort_run(value, order, start, vh_min(start + RUN, n));
    for (int64_t run = RUN; run < n; run *= 2) {
        for (int64_t start = 0; start < n; start += 2 * run) {
            int middle = (int)(start + run < n ? start + run : n), stop = (int)(start + 2 * run < n ? start + 2 * run : n);
            merge_runs(value, order, (int)start, middle, stop, other);
        }
        memcpy(order, other, (size_t)n * sizeof *order);
    }
}

/* Put the values below a pivot first, or those above it; returns how many. No branch for the processor to guess. */
static int keep(vh_real *values, int n, vh_real pivot, int below)
{
    int kept = 0;
    for (int i = 0; i < n; i++) {
        const vh_real value = values[i];
        values[kept] = value;
        kept += below ? value < pivot : value > pivot;
    }
    return kept;
}

/* The value that stands at `rank` when the values rise (quickselect); they are put in another order, and some are lost. */
vh_real vh_order_statistic(vh_real *values, int n, int rank)
{
    for (;;) {
        const vh_real a = values[0], b = values[n / 2], c = values[n - 1];
        const vh_real pivot = vh_most(vh_least(a, b), vh_least(vh_most(a, b), c));
        vh_int below = 0, above = 0;
        for (int i = 0; i < n; i++) {
            below += values[i] < pivot;
            above += values[i] > pivot;
        }
        if (rank < below) {
            n = keep(values, n, pivot, 1);
        } else if (rank >= n - above) {
            rank -= n - (int)above;
            n = keep(values, n, pivot, 0);
        } else {
            return pivot;
        }
    }
}
