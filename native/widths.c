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

/* Grid lines on one side of a window, one beside the other: rows' right or left ends, columns' upper or lower ones. */
struct side {
    /* Lines run from `first` to `last`; a line's outermost taxel is `start` + line * `apart`, each next one `inward`. */
    int first, last, start, apart, inward, count;
    /* Positions of a line's taxels, from index `at` by steps of `step`, and of the lines; the origin of either. */
    const vh_real *along, *across;
    int at, step;
    vh_real along_origin, across_origin;
    /* What tells how far a direction looks along a line and across; which way along points out of the window. */
    const vh_real *by_along, *by_across;
    vh_real way;
    /* The quarters of the circle to whose directions its lines look: that of greater positions across, and of lesser. */
    int greater, lesser;
    /* The thresholds at which each line comes in. */
    const int32_t *earliest;
};

/* How far a line reaches at the thresholds from that on at which it comes in. */
struct points {
    vh_real *reach;
    int from;
};

/* Write a line's outermost points; up to VH_LANES - 1 numbers before them are overwritten. */
static void walk(const struct vh_window *w, const struct side *side, int line, struct points *points)
{
    int seen = w->end, p = side->start + line * side->apart, a = side->at;
    vh_real *restrict reach = points->reach;
    const vh_real *restrict t = w->t;
    points->from = side->earliest[line];
    for (int i = 0; i < side->count && seen > points->from; i++, p += side->inward, a += side->step) {
        const int first = w->enters[p];
        if (first >= seen)
            continue;
        const vh_real here = side->way * (side->along[a] - side->along_origin), top = w->v[p];
        vh_real slope = 0.0;
        if (i > 0 && w->v[p - side->inward] > VH_NOTHING)
            slope = side->way * (side->along[a - side->step] - side->along[a]) / (top - w->v[p - side->inward]);
        /* By whole groups from below: what one writes before `first` the next taxel writes again. */
        for (int j = seen - VH_LANES; j > first - VH_LANES; j -= VH_LANES) {
            VH_SIDE_BY_SIDE
            for (int k = 0; k < VH_LANES; k++)
                reach[j + k] = here + (top - t[j + k]) * slope;
        }
        seen = first;
    }
}

/* Directions in a quarter of the circle. */
#define QUARTER (VH_N_DIRECTIONS / 2)

/* Raise the supports in a quarter of the circle by a line's points. */
static void raise(
    vh_real (*support)[2 * VH_N_DIRECTIONS], const struct side *side, int quarter, const vh_real *reach, int from, int stop,
    vh_real place)
{
    vh_real along[QUARTER], across[QUARTER];
    for (int d = 0; d < QUARTER; d++) {
        along[d] = side->way * side->by_along[QUARTER * quarter + d];
        across[d] = place * side->by_across[QUARTER * quarter + d];
    }
    for (int i = from; i < stop; i++) {
        const vh_real point = reach[i];
        vh_real *at = support[i] + QUARTER * quarter;
        VH_SIDE_BY_SIDE
        for (int d = 0; d < QUARTER; d++) {
            const vh_real s = point * along[d] + across[d];
            at[d] = s > at[d] ? s : at[d];
        }
    }
}

/* Whether any of VH_LANES points reaches farther than the one beside it. */
static int any_beyond(const vh_real *one, const vh_real *other)
{
    vh_int beyond = 0;
    VH_SIDE_BY_SIDE
    for (int k = 0; k < VH_LANES; k++)
        beyond |= one[k] > other[k];
    return beyond != 0;
}

/*
 * Raise the supports in a quarter of the circle by those points of a line that reach farther than the ones of the line
 * beside it, to which the quarter leans: the others are nowhere outermost there. All between the first and the last.
 */
static void raise_beyond(
    vh_real (*support)[2 * VH_N_DIRECTIONS], const struct side *side, int quarter, const struct points *line,
    const struct points *beside, int end, vh_real place)
{
    const vh_real *one = line->reach, *other = beside->reach;
    const int both = vh_max(line->from, beside->from);
    int from = line->from, stop = end;
    while (stop - VH_LANES >= both && !any_beyond(one + stop - VH_LANES, other + stop - VH_LANES))
        stop -= VH_LANES;
    if (both == from)
        while (from + VH_LANES <= stop && !any_beyond(one + from, other + from))
            from += VH_LANES;
    raise(support, side, quarter, one, from, stop, place);
}

/* Raise the supports by all lines of a side. */
static void add_side(
    const struct vh_window *w, const struct side *side, vh_real (*support)[2 * VH_N_DIRECTIONS], vh_real *reach)
{
    const struct points none = {reach, w->end};
    struct points points[3];
    for (int i = 0; i < 3; i++)
        points[i] = (struct points){reach + VH_LANES + (size_t)i * (w->end + VH_LANES), w->end};
    for (int line = side->first; line <= side->last + 1; line++) {
        const struct points *here = &points[(line + 2) % 3];
        const struct points *after = line <= side->last ? &points[line % 3] : &none;
        const struct points *before = line > side->first + 1 ? &points[(line + 1) % 3] : &none;
        if (line <= side->last)
            walk(w, side, line, &points[line % 3]);
        if (line == side->first || here->from == w->end)
            continue;
        const vh_real place = side->across[line - 1] - side->across_origin;
        raise_beyond(support, side, side->greater, here, after, w->end, place);
        raise_beyond(support, side, side->lesser, here, before, w->end, place);
    }
}

size_t vh_reach_room(int n_levels) { return 3 * ((size_t)n_levels + VH_LANES) + VH_LANES; }

void vh_add_supports(
    const struct vh_window *w, vh_real (*support)[2 * VH_N_DIRECTIONS], vh_real *reach, int32_t *earliest)
{
    const int width = w->right - w->left + 1, height = w->bottom - w->top + 1;
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
    const struct side right = {
        .first = w->top, .last = w->bottom, .start = w->right, .apart = w->width, .inward = -1, .count = width,
        .along = w->xs, .across = w->ys, .at = w->right, .step = -1, .along_origin = w->x, .across_origin = w->y,
        .by_along = vh_cos, .by_across = vh_sin, .way = 1.0, .greater = 0, .lesser = 3, .earliest = rows,
    };
    const struct side down = {
        .first = w->left, .last = w->right, .start = w->bottom * w->width, .apart = 1, .inward = -w->width, .count = height,
        .along = w->ys, .across = w->xs, .at = w->bottom, .step = -1, .along_origin = w->y, .across_origin = w->x,
        .by_along = vh_sin, .by_across = vh_cos, .way = 1.0, .greater = 0, .lesser = 1, .earliest = columns,
    };
    struct side left = right, up = down;
    left.start = left.at = w->left;
    up.start = w->top * w->width;
    up.at = w->top;
    left.inward = left.step = up.step = 1;
    up.inward = w->width;
    left.way = up.way = -1.0;
    left.greater = 1;
    left.lesser = up.lesser = 2;
    up.greater = 3;
    add_side(w, &right, support, reach);
    add_side(w, &left, support, reach);
    add_side(w, &down, support, reach);
    add_side(w, &up, support, reach);
}
