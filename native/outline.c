/*
 * Outlines: the polygons around a section.
 *
 * Every line between two neighbouring taxels is a side, and is crossed at most once: there the outline leaves one cell and
 * enters the next. So a side stands for its crossing, and an outline is a chain of sides.
 */
#include "inner.h"

/* What is cut: a frame seen through one taxel of rim, which takes its neighbours' values. */
struct view {
    const struct vh_cut *section;
    int width, height;
};

/* The chain: from each side the one to which the outline runs, -1 for none; whether one arrives; where segments begin. */
struct chain {
    int32_t *next, *begins;
    uint8_t *arrives;
    int n;
};

static size_t divide(void *work, int rows, int cols, struct chain *chain)
{
    const size_t sides = 2 * (size_t)(rows + 2) * (cols + 2);
    size_t used = 0;
    chain->next = vh_take(work, &used, sides, sizeof(int32_t));
    chain->begins = vh_take(work, &used, sides, sizeof(int32_t));
    chain->arrives = vh_take(work, &used, sides, 1);
    chain->n = 0;
    return used;
}

size_t vh_outlines_work(int rows, int cols)
{
    struct chain chain;
    return divide(0, rows, cols, &chain) + 8;
}

static size_t taxel_at(const struct view *view, int r, int c)
{
    const int row = vh_min(vh_max(r - 1, 0), view->height - 3), col = vh_min(vh_max(c - 1, 0), view->width - 3);
    return (size_t)row * view->section->stride + col;
}

static vh_real value_at(const struct view *view, int r, int c)
{
    const vh_real value = view->section->values[taxel_at(view, r, c)];
    return value == value ? value : VH_NOTHING;
}

static int is_in(const struct view *view, int r, int c)
{
    const struct vh_cut *s = view->section;
    return value_at(view, r, c) > s->level && (!s->label || s->label[taxel_at(view, r, c)] == s->index);
}

/* The side after a cell's corner: 2 p for the one from taxel p to the right, 2 p + 1 for the one downward. */
static int32_t side_of(const struct view *view, int r, int c, int corner)
{
    const int p = r * view->width + c;
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
 * Enter a cell's segments: each starts on the side by which a walk around the section leaves it and ends where the walk
 * comes back, so that the section is on its left.
 */
static void add_cell(const struct view *view, struct chain *chain, int r, int c)
{
    const vh_real v[4] = {value_at(view, r, c), value_at(view, r, c + 1), value_at(view, r + 1, c + 1), value_at(view, r + 1, c)};
    const int in[4] = {is_in(view, r, c), is_in(view, r, c + 1), is_in(view, r + 1, c + 1), is_in(view, r + 1, c)};
    const int n = in[0] + in[1] + in[2] + in[3], saddle = n == 2 && in[0] == in[2];
    if (n == 0 || n == 4 || vh_least(vh_least(v[0], v[1]), vh_least(v[2], v[3])) == VH_NOTHING)
        return;
    const int joined = saddle && 4.0 * view->section->level < (v[0] + v[1]) + (v[3] + v[2]);
    for (int leave = 0; leave < 4; leave++) {
        if (!in[leave] || in[(leave + 1) & 3])
            continue;
        /* Joined corners are walked from one to the other, separate ones around each alone. */
        int back = (leave + (joined ? 1 : 3)) & 3;
        while (in[back] || !in[(back + 1) & 3])
            back = (back + 1) & 3;
        const int32_t from = side_of(view, r, c, leave), to = side_of(view, r, c, back);
        chain->next[from] = to;
        chain->arrives[to] = 1;
        chain->begins[chain->n++] = from;
    }
}

int vh_find_outlines(const struct vh_cut *section, int *n_points, void *work)
{
    const struct view view = {section, section->cols + 2, section->rows + 2};
    const size_t sides = 2 * (size_t)view.width * view.height;
    struct chain chain;
    int n_lines = 0;
    divide(work, section->rows, section->cols, &chain);
    for (size_t i = 0; i < sides; i++)
        chain.next[i] = -1;
    memset(chain.arrives, 0, sides);
    for (int r = 0; r < view.height - 1; r++)
        for (int c = 0; c < view.width - 1; c++)
            add_cell(&view, &chain, r, c);
    /* Each line has one point more than segments; a closed one comes back to its first. Seen lines are marked. */
    for (int open = 1; open >= 0; open--) {
        for (int i = 0; i < chain.n; i++) {
            int32_t side = chain.begins[i];
            if ((open && chain.arrives[side]) || chain.arrives[side] > 1)
                continue;
            n_lines++;
            do {
                chain.arrives[side] = 2;
                side = chain.next[side];
            } while (chain.next[side] >= 0 && chain.arrives[side] < 2);
        }
    }
    *n_points = chain.n + n_lines;
    return n_lines;
}

/* Where a padded frame's column or row stands. */
static vh_real position(int i, int count, vh_real pitch)
{
    if (i == 0)
        return -0.5 * count * pitch;
    return i == count + 1 ? 0.5 * count * pitch : (i - 0.5 * (count + 1)) * pitch;
}

/* Write where the outline crosses a side. */
static void write_crossing(const struct view *view, int32_t side, vh_real *point)
{
    const struct vh_cut *s = view->section;
    const int p = side / 2, down = side & 1, r = p / view->width, c = p % view->width;
    const vh_real a = value_at(view, r, c), b = value_at(view, r + down, c + !down);
    const vh_real f = (a - s->level) / (a - b);
    const vh_real x = position(c, s->cols, s->col_pitch), y = position(r, s->rows, s->row_pitch);
    point[0] = down ? x : x + f * (position(c + 1, s->cols, s->col_pitch) - x);
    point[1] = down ? y + f * (position(r + 1, s->rows, s->row_pitch) - y) : y;
}

void vh_write_outlines(const struct vh_cut *section, void *work, vh_real *points, int32_t *stops)
{
    const struct view view = {section, section->cols + 2, section->rows + 2};
    struct chain chain;
    int n_points = 0, n_lines = 0;
    divide(work, section->rows, section->cols, &chain);
    const size_t sides = 2 * (size_t)view.width * view.height;
    memset(chain.arrives, 0, sides);
    for (size_t i = 0; i < sides; i++)
        if (chain.next[i] >= 0) {
            chain.arrives[chain.next[i]] = 1;
            chain.n++;
        }
    for (int open = 1; open >= 0; open--) {
        for (int i = 0; i < chain.n; i++) {
            int32_t side = chain.begins[i];
            if ((open && chain.arrives[side]) || chain.arrives[side] > 1)
                continue;
            write_crossing(&view, side, points + 2 * n_points++);
            do {
                chain.arrives[side] = 2;
                side = chain.next[side];
                write_crossing(&view, side, points + 2 * n_points++);
            } while (chain.next[side] >= 0 && chain.arrives[side] < 2);
            stops[n_lines++] = n_points;
        }
    }
}
