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

void vh_reach(vh_real *support, int stride, int i, vh_real x, vh_real y)
{
    for (int d = 0; d < 2 * VH_N_DIRECTIONS; d++) {
        const vh_real s = x * vh_cos[d] + y * vh_sin[d];
        vh_real *at = support + (size_t)d * stride + i;
        *at = s > *at ? s : *at;
    }
}

/* A grid line, walked inward from one end: its first taxel and the step to the next, in the frame and in positions. */
struct line {
    int start, stride, count;
    const vh_real *position;
    int at, step;
    vh_real origin;
};

/* Write a line's outermost point at each threshold from that on at which its first taxel comes in. */
static void walk(const struct vh_window *w, const struct line *line, int earliest, vh_real *reach)
{
    int seen = w->end, p = line->start, a = line->at;
    for (int i = 0; i < line->count && seen > earliest; i++, p += line->stride, a += line->step) {
        const int first = w->enters[p];
        if (first >= seen)
            continue;
        const vh_real here = line->position[a] - line->origin, top = w->v[p];
        vh_real slope = 0.0;
        if (i > 0 && w->v[p - line->stride] > VH_NOTHING)
            slope = (line->position[a - line->step] - line->position[a]) / (top - w->v[p - line->stride]);
        for (int j = first; j < seen; j++)
            reach[j] = here + (top - w->t[j]) * slope;
        seen = first;
    }
}

/*
 * Raise the supports around the direction `centre` by a line's outermost points, `way` times which is how far they reach
 * in that direction; the line stands at `place` along the direction that is a quarter turn on.
 */
static void raise(
    vh_real *support, int stride, const vh_real *reach, int first, int last, int centre, vh_real way, vh_real place)
{
    /* Whole groups of levels: both arrays are longer than the thresholds by one group. */
    const int n = (last - first + VH_GROUP - 1) / VH_GROUP * VH_GROUP;
    const vh_real *points = reach + first;
    vh_real *middle = support + (size_t)centre * stride + first;
    for (int i = 0; i < n; i++) {
        const vh_real s = way * points[i];
        middle[i] = s > middle[i] ? s : middle[i];
    }
    /* Directions to both sides of it see the point as far, and the line's place with either sign. */
    for (int d = 1; d < 8; d++) {
        const vh_real slope = way * vh_cos[d], offset = place * vh_sin[d];
        vh_real *on = support + (size_t)((centre + d) & 31) * stride + first;
        vh_real *back = support + (size_t)((centre - d) & 31) * stride + first;
        for (int i = 0; i < n; i++) {
            const vh_real s = points[i] * slope;
            const vh_real a = s + offset, b = s - offset;
            on[i] = a > on[i] ? a : on[i];
            back[i] = b > back[i] ? b : back[i];
        }
    }
}

static void add_row(const struct vh_window *w, int r, int earliest, vh_real *support, int stride, vh_real *reach)
{
    const int width = w->right - w->left + 1, start = r * w->width;
    const vh_real place = w->ys[r] - w->y;
    const struct line right = {start + w->right, -1, width, w->xs, w->right, -1, w->x};
    const struct line left = {start + w->left, 1, width, w->xs, w->left, 1, w->x};
    walk(w, &right, earliest, reach);
    raise(support, stride, reach, earliest, w->end, 0, 1.0, place);
    walk(w, &left, earliest, reach);
    raise(support, stride, reach, earliest, w->end, 16, -1.0, -place);
}

static void add_column(const struct vh_window *w, int c, int earliest, vh_real *support, int stride, vh_real *reach)
{
    const int height = w->bottom - w->top + 1;
    const vh_real place = w->xs[c] - w->x;
    const struct line down = {w->bottom * w->width + c, -w->width, height, w->ys, w->bottom, -1, w->y};
    const struct line up = {w->top * w->width + c, w->width, height, w->ys, w->top, 1, w->y};
    walk(w, &down, earliest, reach);
    raise(support, stride, reach, earliest, w->end, 8, 1.0, -place);
    walk(w, &up, earliest, reach);
    raise(support, stride, reach, earliest, w->end, 24, -1.0, place);
}

void vh_add_supports(const struct vh_window *w, vh_real *support, int stride, vh_real *reach, int32_t *earliest)
{
    memset(reach, 0, (size_t)stride * sizeof *reach);
    for (int c = w->left; c <= w->right; c++)
        earliest[c] = w->end;
    for (int r = w->top; r <= w->bottom; r++) {
        const int32_t *row = w->enters + (size_t)r * w->width;
        int first = w->end;
        for (int c = w->left; c <= w->right; c++) {
            first = vh_min(first, row[c]);
            earliest[c] = vh_min(earliest[c], row[c]);
        }
        if (first < w->end)
            add_row(w, r, first, support, stride, reach);
    }
    for (int c = w->left; c <= w->right; c++)
        if (earliest[c] < w->end)
            add_column(w, c, earliest[c], support, stride, reach);
}
