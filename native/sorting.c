/* Sorting by falling value, stable, and the value of a rank. */
#include "inner.h"

/* So few are sorted by insertion, more by their bits, eight at a time from the least on. */
#define FEW 48
#define DIGITS 256

#ifdef VH_SINGLE
typedef uint32_t bits_of_real;
#else
typedef uint64_t bits_of_real;
#endif
enum { N_DIGITS = sizeof(bits_of_real) };

static void sort_few(const vh_real *value, int32_t *order, int n)
{
    for (int i = 1; i < n; i++) {
        int32_t item = order[i];
        vh_real key = value[item];
        int j = i;
        for (; j > 0 && value[order[j - 1]] < key; j--)
            order[j] = order[j - 1];
        order[j] = item;
    }
}

/* A whole number that grows as a value falls; 0.0 and -0.0 have one. */
static bits_of_real key_of(vh_real value)
{
    const bits_of_real sign = (bits_of_real)1 << (8 * sizeof(bits_of_real) - 1);
    const vh_real without_minus = value + 0.0;
    bits_of_real bits;
    memcpy(&bits, &without_minus, sizeof bits);
    return bits & sign ? bits : ~bits ^ sign;
}

static int digit_of(bits_of_real key, int d) { return (int)(key >> 8 * d & (DIGITS - 1)); }

/* Put items in the order of one digit of their keys, of which each is known to be so often; equal ones keep theirs. */
static void sort_by_digit(const vh_real *value, const int32_t *order, int n, int d, int32_t place[DIGITS], int32_t *into)
{
    for (int32_t k = 0, before = 0; k < DIGITS; k++) {
        const int32_t here = place[k];
        place[k] = before;
        before += here;
    }
    for (int i = 0; i < n; i++)
        into[place[digit_of(key_of(value[order[i]]), d)]++] = order[i];
}

static void sort_many(const vh_real *value, int32_t *order, int n, int32_t *other)
{
    int32_t *from = order, *into = other, often[N_DIGITS][DIGITS] = {{0}};
    for (int i = 0; i < n; i++) {
        const bits_of_real key = key_of(value[order[i]]);
        for (int d = 0; d < N_DIGITS; d++)
            often[d][digit_of(key, d)]++;
    }
    for (int d = 0; d < N_DIGITS; d++) {
        /* What is the same of all puts none before another. */
        if (often[d][digit_of(key_of(value[order[0]]), d)] == n)
            continue;
        sort_by_digit(value, from, n, d, often[d], into);
        int32_t *const sorted = into;
        into = from;
        from = sorted;
    }
    if (from != order)
        memcpy(order, from, (size_t)n * sizeof *order);
}

void vh_sort_falling(const vh_real *value, int32_t *order, int n, int32_t *other)
{
    if (n <= FEW)
        sort_few(value, order, n);
    else
        sort_many(value, order, n, other);
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
