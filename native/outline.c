/*
 * Outlines: the polygons around a section.
 *
 * Every line between two neighbouring taxels is a side, and is crossed at most once: there the outline leaves one cell and
 * enters the next. So a side stands for its crossing, and an outline is a chain of sides.
 */
#include "inner.h"

/* What is cut: a frame with a rim of one taxel, which takes its neighbours' values; with a second one, of no taxels, where
 * outlines are closed. `may` says which taxels may be in the section, `in` which are. */
struct view {
    const struct vh_cut *cut;
    int width, height, rim;
    vh_real *values;
    uint8_t *may, *in;
};

/* The chain: from each side the one to which the outline runs, -1 for none; whether one arrives; where segments begin. */
struct chain {
    int32_t *next, *begins;
    uint8_t *arrives;
    int n;
};

static size_t divide(void *work, const struct vh_cut *cut, struct view *view, struct chain *chain)
{
    const int rim = cut->closed ? 2 : 1;
    *view = (struct view){cut, cut->cols + 2 * rim, cut->rows + 2 * rim, rim, 0, 0, 0};
    const size_t taxels = (size_t)view->width * view->height, sides = 2 * taxels;
    size_t used = 0;
    view->values = vh_take(work, &used, taxels, sizeof(vh_real));
    view->may = vh_take(work, &used, taxels, 1);
    view->in = vh_take(work, &used, taxels, 1);
    chain->next = vh_take(work, &used, sides, sizeof(int32_t));
    chain->begins = vh_take(work, &used, sides, sizeof(int32_t));
    chain->arrives = vh_take(work, &used, sides, 1);
    chain->n = 0;
    return used;
}

size_t vh_outlines_work(const struct vh_cut *cut)
{
    struct view view;
    struct chain chain;
    return divide(0, cut, &view, &chain) + 8;
}

static void look(struct view *view)
{
    const struct vh_cut *cut = view->cut;
    const int outer = view->rim - 1;
    for (int r = 0; r < view->height; r++)
        for (int c = 0; c < view->width; c++) {
            const size_t at = (size_t)r * view->width + c;
            const int row = vh_min(vh_max(r - view->rim, 0), cut->rows - 1), col = vh_min(vh_max(c - view->rim, 0), cut->cols - 1);
            const size_t taxel = (size_t)row * cut->stride + col;
            const int beyond = r < outer || c < outer || r >= view->height - outer || c >= view->width - outer;
            const vh_real value = beyond ? VH_NOTHING : cut->values[taxel];
            view->values[at] = value == value ? value : VH_NOTHING;
            view->may[at] = !beyond && (!cut->label || cut->label[taxel] == cut->index);
        }
}

/* The side after a cell's corner: 2 p for the one from taxel p to the right, 2 p + 1 for the one downward. */
static int32_t side_of(const struct view *view, int p, int corner)
{
    switch (corner) {
    case 0:
        return 2 * p;
    case 1:
        return 2 * (p + 1) + 1;
    case 2:
        return 2 * (p + view->width);
    default:
        return 2 * p + 1;
    }
}

/*
 * Enter the segments of the cell right and below of a taxel: each starts on the side by which a walk around the section
 * leaves it and ends where the walk comes back, so that the section is on its left.
 */
static void add_cell(const struct view *view, struct chain *chain, int p, vh_real level)
{
    const int corners[4] = {p, p + 1, p + 1 + view->width, p + view->width};
    int in[4], n = 0;
    vh_real v[4];
    for (int i = 0; i < 4; i++) {
        in[i] = view->in[corners[i]];
        v[i] = view->values[corners[i]];
        n += in[i];
    }
    if (n == 0 || n == 4)
        return;
    if (!view->cut->closed && vh_least(vh_least(v[0], v[1]), vh_least(v[2], v[3])) == VH_NOTHING)
        return;
    const int saddle = n == 2 && in[0] == in[2], joined = saddle && 4.0 * level < (v[0] + v[1]) + (v[3] + v[2]);
    for (int leave = 0; leave < 4; leave++) {
        if (!in[leave] || in[(leave + 1) & 3])
            continue;
        /* Joined corners are walked from one to the other, separate ones around each alone. */
        int back = (leave + (joined ? 1 : 3)) & 3;
        while (in[back] || !in[(back + 1) & 3])
            back = (back + 1) & 3;
        const int32_t from = side_of(view, p, leave), to = side_of(view, p, back);
        chain->next[from] = to;
        chain->arrives[to] = 1;
        chain->begins[chain->n++] = from;
    }
}

/* Where a column or row stands. */
static vh_real position(int i, int rim, int count, vh_real pitch)
{
    if (i < rim)
        return -0.5 * count * pitch;
    return i >= count + rim ? 0.5 * count * pitch : (i - (rim - 1) - 0.5 * (count + 1)) * pitch;
}

/* Write as i-th point where the outline crosses a side, if there is room: at the taxel itself where there is none beyond. */
static void write_crossing(const struct view *view, int32_t side, vh_real level, vh_real *points, int64_t i, int64_t room)
{
    if (i >= room)
        return;
    const struct vh_cut *cut = view->cut;
    const int p = side / 2, down = side & 1, rim = view->rim, r = p / view->width, c = p % view->width;
    const vh_real a = view->values[p], b = view->values[p + (down ? view->width : 1)];
    const vh_real f = a == VH_NOTHING ? 1.0 : (a - level) / (a - b);
    const vh_real x = position(c, rim, cut->cols, cut->col_pitch), y = position(r, rim, cut->rows, cut->row_pitch);
    points[2 * i] = down ? x : x + f * (position(c + 1, rim, cut->cols, cut->col_pitch) - x);
    points[2 * i + 1] = down ? y + f * (position(r + 1, rim, cut->rows, cut->row_pitch) - y) : y;
}

/* Whether a point stands between two others along a border of the pad, so that nobody misses it. */
static int is_spare(const struct vh_cut *cut, const vh_real *before, const vh_real *point, const vh_real *after)
{
    const vh_real far[2] = {0.5 * cut->cols * cut->col_pitch, 0.5 * cut->rows * cut->row_pitch};
    for (int i = 0; i < 2; i++)
        if (before[i] == point[i] && point[i] == after[i] && fabs(point[i]) == far[i])
            return 1;
    return 0;
}

/* Take from a closed line's n points what is spare; return how many are left. */
static int64_t straighten(const struct vh_cut *cut, vh_real *line, int64_t n)
{
    int64_t left = 0;
    for (int64_t i = 0; i < n; i++) {
        if (left > 1 && is_spare(cut, line + 2 * (left - 2), line + 2 * (left - 1), line + 2 * i))
            left--;
        line[2 * left] = line[2 * i];
        line[2 * left + 1] = line[2 * i + 1];
        left++;
    }
    while (left > 3 && is_spare(cut, line + 2 * (left - 2), line + 2 * (left - 1), line))
        left--;
    if (left > 3 && is_spare(cut, line + 2 * (left - 1), line, line + 2)) {
        left--;
        line[0] = line[2 * left];
        line[1] = line[2 * left + 1];
    }
    return left;
}

int64_t vh_outlines(const struct vh_cut *cut, vh_real *points, int32_t *stops, int32_t *n_lines, int64_t room, void *work)
{
    struct view view;
    struct chain chain;
    divide(work, cut, &view, &chain);
    look(&view);
    const size_t taxels = (size_t)view.width * view.height;
    int64_t n_points = 0, n_stops = 0;
    for (int i = 0; i < cut->n_levels; i++) {
        const vh_real level = cut->levels[i];
        for (size_t p = 0; p < taxels; p++)
            view.in[p] = (view.values[p] > level) & view.may[p];
        for (size_t s = 0; s < 2 * taxels; s++)
            chain.next[s] = -1;
        memset(chain.arrives, 0, 2 * taxels);
        chain.n = 0;
        for (int r = 0; r < view.height - 1; r++)
            for (int c = 0; c < view.width - 1; c++)
                add_cell(&view, &chain, r * view.width + c, level);
        /* A line has one point more than segments: a closed one comes back to its first. Seen lines are marked. */
        const int64_t before = n_stops;
        for (int open = 1; open >= 0; open--) {
            for (int k = 0; k < chain.n; k++) {
                int32_t side = chain.begins[k];
                if ((open && chain.arrives[side]) || chain.arrives[side] > 1)
                    continue;
                const int64_t first = n_points;
                do {
                    write_crossing(&view, side, level, points, n_points++, room);
                    chain.arrives[side] = 2;
                    side = chain.next[side];
                } while (chain.next[side] >= 0 && chain.arrives[side] < 2);
                if (!cut->closed)
                    write_crossing(&view, side, level, points, n_points++, room);
                else if (n_points <= room)
                    n_points = first + straighten(cut, points + 2 * first, n_points - first);
                if (n_points <= room)
                    stops[n_stops] = (int32_t)n_points;
                n_stops++;
            }
        }
        n_lines[i] = (int32_t)(n_stops - before);
    }
    return n_points;
}
