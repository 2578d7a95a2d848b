/*
 * Marching squares on a contact's window, for all thresholds at once.
 *
 * As the threshold falls, a cell's corners come in one by one, and the section in it is first a triangle at the highest
 * corner, then a strip along the side between the two highest, then the whole cell but a triangle at the lowest. Cut
 * lines run straight between crossings, and a crossing runs along its side in proportion to u = v - t. So a triangle's
 * legs are u times two constants, its area, moments and outline are polynomials in u, and no root is taken of any but a
 * strip. What is covered wholly is added once, at the threshold from which on it is; a border closes by itself.
 *
 * Corners run from x to y: 0 and 1 in the cell's first row, 3 and 2 in its second.
 */
#include "inner.h"

/* One cell: its corners' values, the thresholds at which they come in, and where it is. */
struct cell {
    vh_real v[4];
    int in[4];
    /* Positions along x and along y. */
    vh_real at[2][2];
};

/*
 * Add the triangle at a corner, or take it away (sign -1) at one that is out: its legs are u * along and u * across, u as
 * v - t.
 *
 * The integrals of 1, x, y, x^2, x y, y^2 over a right triangle with legs a, b at the origin are a b / 2 times 1, a / 3,
 * b / 3, a^2 / 6, a b / 12, b^2 / 6.
 */
static void add_triangle(
    struct vh_group *groups, const vh_real *t, int from, int stop, const struct cell *cell, int corner, vh_real sign)
{
    if (from >= stop)
        return;
    const int right = corner == 1 || corner == 2, down = corner >= 2;
    const vh_real v = cell->v[corner], x = cell->at[0][right], y = cell->at[1][down];
    /* How far V falls to the neighbours in its row and in its column; u is counted in the lesser of both. */
    const vh_real fall_x = v - cell->v[corner ^ 1], fall_y = v - cell->v[3 - corner];
    const int x_least = fabs(fall_x) < fabs(fall_y);
    const vh_real over = 1.0 / (x_least ? fall_x : fall_y), ratio = x_least ? fall_x / fall_y : fall_y / fall_x;
    const vh_real along = (cell->at[0][!right] - x) * (x_least ? 1.0 : ratio);
    const vh_real across = (cell->at[1][!down] - y) * (x_least ? ratio : 1.0);
    const vh_real area = 0.5 * sign * fabs(along * across), length = sqrt(along * along + across * across);
    const vh_real third_x = along * (1.0 / 3.0), third_y = across * (1.0 / 3.0);
    /* Powers of u in the moments, over the area's u^2. */
    const vh_real xx1 = 2.0 * x * third_x, xx2 = along * along * (1.0 / 6.0);
    const vh_real xy1 = x * third_y + y * third_x, xy2 = along * across * (1.0 / 12.0);
    const vh_real yy1 = 2.0 * y * third_y, yy2 = across * across * (1.0 / 6.0);
    const vh_real top = t[from], bottom = t[stop - 1];
    for (int g = from / VH_LANES; g <= (stop - 1) / VH_LANES; g++) {
        struct vh_group *group = groups + g;
        for (int i = 0; i < VH_LANES; i++) {
            const vh_real level = group->t[i];
            const vh_real u = ((level <= top) & (level >= bottom)) ? (v - level) * over : 0.0;
            const vh_real a = area * u * u;
            group->sum[VH_S_AREA][i] += a;
            group->sum[VH_S_X][i] += a * (x + third_x * u);
            group->sum[VH_S_Y][i] += a * (y + third_y * u);
            group->sum[VH_S_XX][i] += a * (x * x + u * (xx1 + u * xx2));
            group->sum[VH_S_XY][i] += a * (x * y + u * (xy1 + u * xy2));
            group->sum[VH_S_YY][i] += a * (y * y + u * (yy1 + u * yy2));
            group->sum[VH_S_LENGTH][i] += length * u;
        }
    }
}

/*
 * Add the strip along a side, between corners at p < q of the other axis: it reaches from the side, at `base`, to a line
 * that crosses where the corners' values fall to t. `sign` is the way in which it reaches, `far` where the opposite side is.
 *
 * With the line's middle at m and its ends at m - d and m + d, the integrals over the half-plane beside it are polynomials
 * in m and d (a^n / n integrated along the line); those beside the base are taken off.
 */
struct strip {
    vh_real base, far, p, q;
    vh_real vp, vq, over_p, over_q;
};

static void add_strip(
    struct vh_group *groups, const vh_real *t, int from, int stop, const struct strip *strip, int axis)
{
    if (from >= stop)
        return;
    const int a_ = axis ? VH_S_Y : VH_S_X, b_ = axis ? VH_S_X : VH_S_Y;
    const int aa_ = axis ? VH_S_YY : VH_S_XX, bb_ = axis ? VH_S_XX : VH_S_YY;
    const vh_real base = strip->base, height = strip->q - strip->p, middle = 0.5 * (strip->p + strip->q);
    const vh_real side = strip->far > base ? height : -height, lean = side * height * (1.0 / 6.0);
    /* The line's ends run so far for a unit of V. */
    const vh_real run_p = (strip->far - base) / (strip->vp - strip->over_p);
    const vh_real run_q = (strip->far - base) / (strip->vq - strip->over_q);
    const vh_real m1 = 0.5 * (run_p + run_q), d1 = 0.5 * (run_q - run_p);
    const vh_real m0 = base + 0.5 * (run_p * strip->vp + run_q * strip->vq);
    const vh_real d0 = 0.5 * (run_q * strip->vq - run_p * strip->vp);
    const vh_real square = base * base, cube = square * base, twelfth = height * height * (1.0 / 12.0);
    const vh_real top = t[from], bottom = t[stop - 1];
    for (int g = from / VH_LANES; g <= (stop - 1) / VH_LANES; g++) {
        struct vh_group *group = groups + g;
        for (int i = 0; i < VH_LANES; i++) {
            const vh_real level = group->t[i];
            const int live = (level <= top) & (level >= bottom);
            const vh_real at = live ? level : 0.0;
            const vh_real m = live ? m0 - m1 * at : base, d = live ? d0 - d1 * at : 0.0;
            const vh_real mm = m * m, dd = d * d;
            const vh_real area = side * (m - base), first = 0.5 * side * (mm + dd * (1.0 / 3.0) - square);
            const vh_real leaning = lean * d;
            group->sum[VH_S_AREA][i] += area;
            group->sum[a_][i] += first;
            group->sum[b_][i] += leaning + middle * area;
            group->sum[aa_][i] += side * (1.0 / 3.0) * (m * (mm + dd) - cube);
            group->sum[VH_S_XY][i] += leaning * m + middle * first;
            group->sum[bb_][i] += twelfth * area + middle * (2.0 * leaning + middle * area);
            group->sum[VH_S_LENGTH][i] += live ? sqrt(4.0 * dd + height * height) : 0.0;
        }
    }
}

/*
 * A cell's sides, each between two neighbouring corners: the axis along which a strip reaches from it, which of the two
 * positions on that axis is its own, its corners by growing position on the other axis, and those across from them.
 */
static const struct {
    uint8_t axis, own, p, q, over_p, over_q;
} sides[4] = {{1, 0, 0, 1, 3, 2}, {0, 1, 1, 2, 0, 3}, {1, 1, 3, 2, 0, 1}, {0, 0, 0, 3, 1, 2}};
/* The side between two corners, of which neither is the other's opposite, by the sum of a bit for each. */
static const uint8_t side_of[16] = {[1 | 2] = 0, [2 | 4] = 1, [4 | 8] = 2, [8 | 1] = 3};

/* Add the strip along the side between two neighbouring corners, which are in. */
static void add_side(struct vh_group *groups, const vh_real *t, int from, int stop, const struct cell *cell, int a, int b)
{
    const int side = side_of[1 << a | 1 << b], axis = sides[side].axis, own = sides[side].own;
    const struct strip strip = {
        cell->at[axis][own], cell->at[axis][!own], cell->at[!axis][0], cell->at[!axis][1],
        cell->v[sides[side].p], cell->v[sides[side].q], cell->v[sides[side].over_p], cell->v[sides[side].over_q],
    };
    if (axis)
        add_strip(groups, t, from, stop, &strip, 1);
    else
        add_strip(groups, t, from, stop, &strip, 0);
}

/* Add a whole cell from a threshold on. */
static void add_rectangle(vh_real whole[VH_N_WHOLE], vh_real x0, vh_real x1, vh_real y0, vh_real y1)
{
    const vh_real dx = x1 - x0, dy = y1 - y0;
    const vh_real mx = 0.5 * dx * (x0 + x1), my = 0.5 * dy * (y0 + y1);
    whole[VH_S_AREA] += dx * dy;
    whole[VH_S_X] += mx * dy;
    whole[VH_S_Y] += dx * my;
    whole[VH_S_XX] += dx * (x0 * x0 + x0 * x1 + x1 * x1) * (1.0 / 3.0) * dy;
    whole[VH_S_XY] += mx * my;
    whole[VH_S_YY] += dx * dy * (y0 * y0 + y0 * y1 + y1 * y1) * (1.0 / 3.0);
}

static void sort_two(int *one, int *other)
{
    const int lesser = vh_min(*one, *other), greater = vh_max(*one, *other);
    *one = lesser;
    *other = greater;
}

/* Add a cut cell's pieces; returns the threshold from which on it counts as a whole. */
static int add_cut(struct vh_group *groups, const vh_real *t, const struct cell *cell, int last)
{
    /* The corners in the order in which they come in, by a sorting network: no branch for the processor to guess. */
    int first = 4 * cell->in[0], second = 4 * cell->in[1] + 1, third = 4 * cell->in[2] + 2, fourth = 4 * cell->in[3] + 3;
    sort_two(&first, &second);
    sort_two(&third, &fourth);
    sort_two(&first, &third);
    sort_two(&second, &fourth);
    sort_two(&second, &third);
    const int a = first & 3, b = second & 3, c = third & 3, d = fourth & 3;
    const int one = first >> 2, two = second >> 2, three = third >> 2;
    if ((a ^ b) != 2) {
        add_triangle(groups, t, one, two, cell, a, 1.0);
        add_side(groups, t, two, three, cell, a, b);
        add_triangle(groups, t, three, last, cell, d, -1.0);
        return three;
    }
    /* A saddle: the two high corners are apart until the mean of the cell is above the threshold. */
    const vh_real four_means = (cell->v[0] + cell->v[1]) + (cell->v[3] + cell->v[2]);
    int joined = two;
    while (joined < three && !(4.0 * t[joined] < four_means))
        joined++;
    add_triangle(groups, t, one, joined, cell, a, 1.0);
    add_triangle(groups, t, two, joined, cell, b, 1.0);
    add_triangle(groups, t, joined, three, cell, c, -1.0);
    add_triangle(groups, t, joined, last, cell, d, -1.0);
    return joined;
}

void vh_add_cells(const struct vh_window *w, struct vh_group *groups, vh_real (*whole)[VH_N_WHOLE])
{
    const int end = w->end;
    for (int r = w->top; r < w->bottom; r++) {
        const vh_real *v0 = w->v + (size_t)r * w->width, *v1 = v0 + w->width;
        const int32_t *e0 = w->enters + (size_t)r * w->width, *e1 = e0 + w->width;
        const vh_real y0 = w->ys[r] - w->y, y1 = w->ys[r + 1] - w->y;
        /* Cells beside each other that are whole from the same threshold on are one rectangle. */
        int run = end, start = w->left;
        for (int c = w->left; c < w->right; c++) {
            const int in[4] = {e0[c], e0[c + 1], e1[c + 1], e1[c]};
            const int first = vh_min(vh_min(in[0], in[1]), vh_min(in[2], in[3]));
            const int last = vh_max(vh_max(in[0], in[1]), vh_max(in[2], in[3]));
            int covered = end;
            if (first < end && vh_least(vh_least(v0[c], v0[c + 1]), vh_least(v1[c], v1[c + 1])) > VH_NOTHING) {
                covered = first;
                if (first < last) {
                    const struct cell cell = {
                        {v0[c], v0[c + 1], v1[c + 1], v1[c]},
                        {in[0], in[1], in[2], in[3]},
                        {{w->xs[c] - w->x, w->xs[c + 1] - w->x}, {y0, y1}},
                    };
                    covered = add_cut(groups, w->t, &cell, last);
                }
            }
            if (covered != run) {
                if (run < end)
                    add_rectangle(whole[run], w->xs[start] - w->x, w->xs[c] - w->x, y0, y1);
                run = covered;
                start = c;
            }
        }
        if (run < end)
            add_rectangle(whole[run], w->xs[start] - w->x, w->xs[w->right] - w->x, y0, y1);
    }
}
