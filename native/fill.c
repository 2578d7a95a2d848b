/* Filling broken taxels from their neighbours. */
#include "inner.h"

/* Relative to the range of the frame's values; far below any sensor's resolution. */
#define TOLERANCE (0.1 * VH_CLOSE)
#define MOST_SWEEPS 10000

/* One step of a broken taxel toward the mean of its neighbours; returns how far it went. */
static vh_real relax(vh_real *frame, const uint8_t *field, int rows, int cols, int at, vh_real relaxation)
{
    const int r = at / cols, c = at % cols;
    vh_real total = 0.0;
    int count = 0;
    if (r > 0 && field[at - cols]) {
        total += frame[at - cols];
        count++;
    }
    if (r + 1 < rows && field[at + cols]) {
        total += frame[at + cols];
        count++;
    }
    if (c > 0 && field[at - 1]) {
        total += frame[at - 1];
        count++;
    }
    if (c + 1 < cols && field[at + 1]) {
        total += frame[at + 1];
        count++;
    }
    if (count == 0)
        return 0.0;
    vh_real step = relaxation * (total / count - frame[at]);
    frame[at] += step;
    return fabs(step);
}

size_t vh_fill_work(int rows, int cols) { return (size_t)rows * cols * sizeof(int32_t) + 8; }

int vh_fill(vh_real *frame, const uint8_t *usable, const uint8_t *field, int rows, int cols, void *work)
{
    int32_t *broken = work;
    int n = 0;
    vh_real low = INFINITY, high = -INFINITY;
    for (int i = 0; i < rows * cols; i++) {
        if (!field[i])
            continue;
        if (usable[i]) {
            low = vh_least(low, frame[i]);
            high = vh_most(high, frame[i]);
        } else {
            broken[n++] = i;
        }
    }
    if (n == 0 || low > high)
        return n;
    for (int k = 0; k < n; k++)
        frame[broken[k]] = low;
    /* Successive over-relaxation, best for a square hole of n taxels, good for every other. */
    const vh_real relaxation = 2.0 / (1.0 + sin((vh_real)PI / (sqrt((vh_real)n) + 2.0)));
    for (int sweep = 0; sweep < MOST_SWEEPS; sweep++) {
        vh_real change = 0.0;
        for (int k = 0; k < n; k++)
            change = vh_most(change, relax(frame, field, rows, cols, broken[k], relaxation));
        if (change <= TOLERANCE * (high - low))
            break;
    }
    /* Over-relaxation may overshoot the harmonic function by its tolerance. */
    for (int k = 0; k < n; k++)
        frame[broken[k]] = vh_least(vh_most(frame[broken[k]], low), high);
    return n;
}
