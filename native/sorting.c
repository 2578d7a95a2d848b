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
    int i = start, j = middle;
    for (int k = start; k < stop; k++) {
        if (i < middle && (j >= stop || value[order[i]] >= value[order[j]]))
            into[k] = order[i++];
        else
            into[k] = order[j++];
    }
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

/* The value that stands at `rank` when the values rise (Hoare's selection); they are put in another order. */
vh_real vh_order_statistic(vh_real *values, int n, int rank)
{
    int low = 0, high = n - 1;
    while (low < high) {
        vh_real pivot = values[low + (high - low) / 2];
        int i = low, j = high;
        while (i <= j) {
            while (values[i] < pivot)
                i++;
            while (pivot < values[j])
                j--;
            if (i <= j) {
                vh_real kept = values[i];
                values[i++] = values[j];
                values[j--] = kept;
            }
        }
        if (rank <= j)
            high = j;
        else if (rank >= i)
            low = i;
        else
            break;
    }
    return values[rank];
}
