/*
 * Widths of sections by their support function, in 16 directions.
 *
 * Only the outermost crossing of a grid line can be a corner of a section's convex hull: the rightmost and leftmost of
 * each row, the lowest and highest of each column. As sections nest, a line's outermost taxel only moves outward as the
 * threshold falls, so each line is walked once for all thresholds. A crossing to the right counts only for directions
 * that point to the right: for the others, the taxel to its left reaches farther.
 */
#include "inner.h"

/* Cosines and sines of multiples of pi / 16; the axes exactly, so that a square's width is its breadth to the last bit. */
#define C1 0.9807852804032304
#define C2 0.9238795325112867
#define C3 0.8314696123025452
#define C4 0.7071067811865476
#define C5 0.5555702330196022
#define C6 0.3826834323650898
#define C7 0.19509032201612825

const vh_real vh_cos[2 * VH_N_DIRECTIONS] = {
    1.0, C1, C2, C3, C4, C5, C6, C7, 0.0, -C7, -C6, -C5, -C4, -C3, -C2, -C1,
    -1.0, -C1, -C2, -C3, -C4, -C5, -C6, -C7, 0.0, C7, C6, C5, C4, C3, C2, C1,
};
const vh_real vh_sin[2 * VH_N_DIRECTIONS] = {
    0.0, C7, C6, C5, C4, C3, C2, C1, 1.0, C1, C2, C3, C4, C5, C6, C7,
    0.0, -C7, -C6, -C5, -C4, -C3, -C2, -C1, -1.0, -C1, -C2, -C3, -C4, -C5, -C6, -C7,
};

void vh_reach(vh_real support[2 * VH_N_DIRECTIONS], vh_real x, vh_real y)
{
    for (int d = 0; d < 2 * VH_N_DIRECTIONS; d++) {
        const vh_real s = x * vh_cos[d] + y * vh_sin[d];
        support[d] = s > support[d] ? s : support[d];
    }
}

/* The grid lines of a window along one way: its rows or its columns. */
struct lines {
    /* Lines run from `first` to `last`; one's taxels are `apart` * line + `step` * place, places from `low` to `high`. */
    int first, last, apart, step, low, high;
    /* Positions of a line's taxels, and of the lines; the origin of either. */
    const vh_real *along, *across;
    vh_real along_origin, across_origin;
    /* How far each direction looks along a line and across. */
    const vh_real *by_along, *by_across;
    /* The quarters of the circle that look to low ends and greater positions across, and to high ends and lesser ones. */
    int low_greater, high_lesser;
    /* The thresholds at which each line comes in. */
    const int32_t *earliest;
};

/* A line's outermost points at its high and at its low end, at the thresholds from that on at which it comes in. */
struct points {
    vh_real *high, *low;
    int from;
};

/* Points that are written at once: as many as most taxels have, so that the processor need not guess whether more follow. */
#define AT_ONCE (VH_LANES > 1 ? 2 * VH_LANES : 1)

/*
 * Write a line's outermost points, from the end at place `from` inward by steps of `inward`, at the thresholds from
 * `earliest` on; up to AT_ONCE - 1 numbers before them are overwritten. What a taxel writes before the threshold at which
 * it comes in, the next one writes again: so one group of points is written of each, also of those that never come in,
 * and the processor need not guess which do.
 */
static void walk(
    const struct vh_window *w, const struct lines *lines, int line, int from, int inward, vh_real *restrict reach)
{
    const int earliest = lines->earliest[line], outward = -inward * lines->step;
    const vh_real *restrict t = w->t;
    for (int seen = w->end, a = from; seen > earliest; a += inward) {
        const int p = line * lines->apart + a * lines->step, first = w->enters[p];
        if (AT_ONCE == 1 && first >= seen)
            continue;
        const vh_real here = lines->along[a] - lines->along_origin, top = w->v[p];
        vh_real slope = 0.0;
        if (a != from && w->v[p + outward] > VH_NOTHING)
            slope = (lines->along[a - inward] - lines->along[a]) / (top - w->v[p + outward]);
        int j = seen;
        do {
            j -= AT_ONCE;
            VH_SIDE_BY_SIDE
            for (int k = 0; k < AT_ONCE; k++)
                reach[j + k] = here + (top - t[j + k]) * slope;
        } while (j > first);
        seen = vh_min(seen, first);
    }
}

/* Directions in a quarter of the circle. */
#define QUARTER (VH_N_DIRECTIONS / 2)

/* With wide vectors a quarter of the circle is raised sooner than it is found out whether a point counts there. */
#ifdef __AVX__
#define ALL_COUNT 1
#else
#define ALL_COUNT 0
#endif

/* Whether a point may be outermost in a quarter that leans to the line beside it: it is not where that one reaches as far. */
static inline int is_high(const struct points *line, const struct points *beside, int i)
{
    return ALL_COUNT || i < beside->from || line->high[i] > beside->high[i];
}

static inline int is_low(const struct points *line, const struct points *beside, int i)
{
    return ALL_COUNT || i < beside->from || line->low[i] < beside->low[i];
}

/* Raise the supports in a quarter of the circle by a point. */
static inline void raise_quarter(
    vh_real *restrict at, vh_real point, const vh_real *restrict along, const vh_real *restrict across)
{
    VH_SIDE_BY_SIDE
    for (int d = 0; d < QUARTER; d++) {
        const vh_real s = point * along[d] + across[d];
        at[d] = s > at[d] ? s : at[d];
    }
}

/* Raise the supports by a line's points, each quarter of the circle by those of the end to which it looks. */
static void raise(
    vh_real (*restrict support)[2 * VH_N_DIRECTIONS], const struct lines *lines, const vh_real *restrict along,
    const struct points *before, const struct points *line, const struct points *after, int stop, vh_real place)
{
    const int second = QUARTER * lines->low_greater, fourth = QUARTER * lines->high_lesser;
    const vh_real *restrict high = line->high, *restrict low = line->low;
    vh_real across[2 * VH_N_DIRECTIONS];
    for (int d = 0; d < QUARTER; d++) {
        across[d] = place * lines->by_across[d];
        across[QUARTER + d] = place * lines->by_across[second + d];
        across[2 * QUARTER + d] = place * lines->by_across[2 * QUARTER + d];
        across[3 * QUARTER + d] = place * lines->by_across[fourth + d];
    }
    for (int i = line->from; i < stop; i++) {
        vh_real *restrict at = support[i];
        if (is_high(line, after, i))
            raise_quarter(at, high[i], along, across);
        if (is_low(line, after, i))
            raise_quarter(at + second, low[i], along + QUARTER, across + QUARTER);
        if (is_low(line, before, i))
            raise_quarter(at + 2 * QUARTER, low[i], along + 2 * QUARTER, across + 2 * QUARTER);
        if (is_high(line, before, i))
            raise_quarter(at + fourth, high[i], along + 3 * QUARTER, across + 3 * QUARTER);
    }
}

/* Raise the supports by all lines. */
static void add_lines(
    const struct vh_window *w, const struct lines *lines, vh_real (*support)[2 * VH_N_DIRECTIONS], vh_real *reach)
{
    const struct points none = {reach, reach, w->end};
    const int quarters[4] = {0, lines->low_greater, 2, lines->high_lesser};
    struct points points[3];
    vh_real along[2 * VH_N_DIRECTIONS];
    for (int d = 0; d < 2 * VH_N_DIRECTIONS; d++)
        along[d] = lines->by_along[QUARTER * quarters[d / QUARTER] + d % QUARTER];
    for (int i = 0; i < 3; i++) {
        points[i].high = reach + AT_ONCE + (size_t)(2 * i) * (w->end + AT_ONCE);
        points[i].low = points[i].high + w->end + AT_ONCE;
        points[i].from = w->end;
    }
    for (int line = lines->first; line <= lines->last + 1; line++) {
        struct points *const after = &points[line % 3];
        const struct points *const here = &points[(line + 2) % 3], *const before = &points[(line + 1) % 3];
        if (line <= lines->last) {
            after->from = lines->earliest[line];
            walk(w, lines, line, lines->high, -1, after->high);
            walk(w, lines, line, lines->low, 1, after->low);
        }
        if (line == lines->first || here->from == w->end)
            continue;
        const vh_real place = lines->across[line - 1] - lines->across_origin;
        raise(support, lines, along, before, here, line <= lines->last ? after : &none, w->end, place);
    }
}

size_t vh_reach_room(int n_levels) { return 6 * ((size_t)n_levels + AT_ONCE) + AT_ONCE; }

void vh_add_supports(
    const struct vh_window *w, vh_real (*support)[2 * VH_N_DIRECTIONS], vh_real *reach, int32_t *earliest)
{
    int32_t *rows = earliest, *columns = earliest + w->height;
    for (int c = w->left; c <= w->right; c++)
        columns[c] = w->end;
    for (int r = w->top; r <= w->bottom; r++) {
        const int32_t *row = w->enters + (size_t)r * w->width;
        rows[r] = w->end;
        for (int c = w->left; c <= w->right; c++) {
            rows[r] = vh_min(rows[r], row[c]);
            columns[c] = vh_min(columns[c], row[c]);
        }
    }
    const struct lines in_rows = {
        .first = w->top, .last = w->bottom, .apart = w->width, .step = 1, .low = w->left, .high = w->right,
        .along = w->xs, .across = w->ys, .along_origin = w->x, .across_origin = w->y,
        .by_along = vh_cos, .by_across = vh_sin, .low_greater = 1, .high_lesser = 3, .earliest = rows,
    };
    const struct lines in_columns = {
        .first = w->left, .last = w->right, .apart = 1, .step = w->width, .low = w->top, .high = w->bottom,
        .along = w->ys, .across = w->xs, .along_origin = w->y, .across_origin = w->x,
        .by_along = vh_sin, .by_across = vh_cos, .low_greater = 3, .high_lesser = 1, .earliest = columns,
    };
    add_lines(w, &in_rows, support, reach);
    add_lines(w, &in_columns, support, reach);
}
