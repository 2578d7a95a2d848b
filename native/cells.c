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

/* Cells whose pieces are gathered before they are added: few on a controller, which has a small stack. */
#if VH_LANES > 1
#define GATHERED 32
#else
#define GATHERED 4
#endif

/* Two rows of taxels, with cells between them: their values and thresholds, and where they are. */
struct row {
    const vh_real *v[2], *xs, *t;
    const int32_t *in[2];
    vh_real x, y[2];
};

/* A triangle at a corner, or a strip along a side, of the cell in a column, at the thresholds from .. stop - 1. */
struct piece {
    int32_t column, place, from, stop;
};

/* What is still to be added: pieces without one threshold are left out, so that no branch waits for what they are. */
struct pieces {
    struct piece added[2 * GATHERED], taken[2 * GATHERED], strips[GATHERED];
    int n_added, n_taken, n_strips;
};

static int put(struct piece *pieces, int n, int column, int place, int from, int stop)
{
    pieces[n] = (struct piece){column, place, from, stop};
    return n + (from < stop);
}

/* A triangle at a corner: its legs are u * along and u * across, u as v - t. */
struct triangle {
    vh_real v, over, x, y, third_x, third_y, area, length;
};

/* The triangle of a piece, which is added, or taken away (sign -1) where the corner is out. */
static struct triangle triangle_of(const struct row *row, const struct piece *piece, vh_real sign)
{
    const int right = piece->place == 1 || piece->place == 2, down = piece->place >= 2, c = piece->column;
    const vh_real v = row->v[down][c + right], x = row->xs[c + right] - row->x, y = row->y[down];
    /* How far V falls, or rises, to the neighbours in its row and in its column; u is counted in the lesser of both. */
    const vh_real fall_x = v - row->v[down][c + !right], fall_y = v - row->v[!down][c + right];
    const vh_real least = sign * vh_least(sign * fall_x, sign * fall_y);
    const vh_real along = ((row->xs[c + !right] - row->x) - x) * (least / fall_x);
    const vh_real across = (row->y[!down] - y) * (least / fall_y);
    const vh_real third_x = along * (1.0 / 3.0), third_y = across * (1.0 / 3.0);
    return (struct triangle){
        v, 1.0 / least, x, y, third_x, third_y, 0.5 * sign * fabs(along * across), sqrt(along * along + across * across),
    };
}

/*
 * Add a triangle at the thresholds from .. stop - 1.
 *
 * A right triangle with legs a, b at the origin has the area a b / 2 and the centroid (dx, dy) = (a / 3, b / 3), around
 * which its second moments are, over the area, dx^2 / 2, -dx dy / 4 and dy^2 / 2.
 */
static void add_triangle(
    const struct triangle *p, int from, int stop, const vh_real *restrict t, vh_real *restrict area, vh_real *restrict x,
    vh_real *restrict y, vh_real *restrict xx, vh_real *restrict xy, vh_real *restrict yy, vh_real *restrict length)
{
    const vh_real bottom = t[stop - 1];
    for (int first = from; first < stop; first += VH_LANES) {
        VH_SIDE_BY_SIDE
        for (int k = 0; k < VH_LANES; k++) {
            const int i = first + k;
            const vh_real u = t[i] >= bottom ? (p->v - t[i]) * p->over : 0.0, square = u * u, a = p->area * square;
            const vh_real dx = p->third_x * u, dy = p->third_y * u, mx = p->x + dx, my = p->y + dy;
            area[i] += a;
            x[i] += a * mx;
            y[i] += a * my;
            xx[i] += a * (mx * mx + 0.5 * dx * dx);
            xy[i] += a * (mx * my - 0.25 * dx * dy);
            yy[i] += a * (my * my + 0.5 * dy * dy);
            length[i] += p->length * u;
        }
    }
}

/*
 * A cell's sides, each between two neighbouring corners: the axis along which a strip reaches from it, and which of the two
 * positions on that axis is its own.
 */
static const struct {
    uint8_t axis, own;
} sides[4] = {{1, 0}, {0, 1}, {1, 1}, {0, 0}};
/* The side between two corners, of which neither is the other's opposite, by the sum of a bit for each. */
static const uint8_t side_of[16] = {[1 | 2] = 0, [2 | 4] = 1, [4 | 8] = 2, [8 | 1] = 3};

/*
 * A strip along a side, between corners at p < q of the other axis, the height apart: it reaches from the side, at `base`,
 * to a line whose middle runs to m0 - m1 t and whose ends are d0 - d1 t before and behind it.
 */
struct strip {
    vh_real base, middle, height, side, m0, m1, d0, d1;
};

static struct strip strip_of(const struct row *row, const struct piece *piece)
{
    const int axis = sides[piece->place].axis, own = sides[piece->place].own, c = piece->column;
    const vh_real x[2] = {row->xs[c] - row->x, row->xs[c + 1] - row->x};
    const vh_real *along = axis ? row->y : x, *across = axis ? x : row->y;
    /* Where p and q are, and across from them. */
    const int p_row = axis ? own : 0, p_col = axis ? 0 : own, q_row = axis ? own : 1, q_col = axis ? 1 : own;
    const vh_real p = row->v[p_row][c + p_col], over_p = row->v[axis ? !own : 0][c + (axis ? 0 : !own)];
    const vh_real q = row->v[q_row][c + q_col], over_q = row->v[axis ? !own : 1][c + (axis ? 1 : !own)];
    const vh_real base = along[own], far = along[!own], height = across[1] - across[0];
    /* The line's ends run so far for a unit of V. */
    const vh_real run_p = (far - base) / (p - over_p), run_q = (far - base) / (q - over_q);
    return (struct strip){
        base, 0.5 * (across[0] + across[1]), height, height * (2 * (far > base) - 1),
        base + 0.5 * (run_p * p + run_q * q), 0.5 * (run_p + run_q), 0.5 * (run_q * q - run_p * p), 0.5 * (run_q - run_p),
    };
}

/*
 * Add a strip at the thresholds from .. stop - 1; a is the axis along which it reaches, b the other one.
 *
 * With the line's middle at m and its ends at m - d and m + d, the integrals over the half-plane beside it are polynomials
 * in m and d (a^n / n integrated along the line); those beside the base are taken off.
 */
static void add_strip(
    const struct strip *p, int from, int stop, const vh_real *restrict t, vh_real *restrict area, vh_real *restrict a,
    vh_real *restrict b, vh_real *restrict aa, vh_real *restrict ab, vh_real *restrict bb, vh_real *restrict length)
{
    const vh_real bottom = t[stop - 1], base = p->base, middle = p->middle, side = p->side;
    const vh_real square = base * base, cube = square * base, breadth = p->height * p->height;
    const vh_real lean = side * p->height * (1.0 / 6.0), twelfth = breadth * (1.0 / 12.0);
    const vh_real half = 0.5 * side, third = side * (1.0 / 3.0);
    for (int first = from; first < stop; first += VH_LANES) {
        VH_SIDE_BY_SIDE
        for (int k = 0; k < VH_LANES; k++) {
            const int i = first + k, live = t[i] >= bottom;
            const vh_real level = live ? t[i] : 0.0;
            const vh_real m = live ? p->m0 - p->m1 * level : base, d = live ? p->d0 - p->d1 * level : 0.0;
            const vh_real mm = m * m, dd = d * d, leaning = lean * d;
            const vh_real size = side * (m - base), moment = half * (mm + dd * (1.0 / 3.0) - square);
            area[i] += size;
            a[i] += moment;
            b[i] += leaning + middle * size;
            aa[i] += third * (m * (mm + dd) - cube);
            ab[i] += leaning * m + middle * moment;
            bb[i] += twelfth * size + middle * (2.0 * leaning + middle * size);
            length[i] += live ? sqrt(4.0 * dd + breadth) : 0.0;
        }
    }
}

static void add_triangles(
    const struct row *row, const struct piece *pieces, int n, vh_real sign, const struct vh_sums *sums)
{
    vh_real *const *s = sums->sum;
    for (int i = 0; i < n; i++) {
        const struct triangle triangle = triangle_of(row, &pieces[i], sign);
        add_triangle(
            &triangle, pieces[i].from, pieces[i].stop, row->t, s[VH_S_AREA], s[VH_S_X], s[VH_S_Y], s[VH_S_XX], s[VH_S_XY],
            s[VH_S_YY], s[VH_S_LENGTH]);
    }
}

static void add_strips(const struct row *row, const struct piece *pieces, int n, const struct vh_sums *sums)
{
    vh_real *const *s = sums->sum;
    for (int i = 0; i < n; i++) {
        const struct strip strip = strip_of(row, &pieces[i]);
        const int axis = sides[pieces[i].place].axis;
        add_strip(
            &strip, pieces[i].from, pieces[i].stop, row->t, s[VH_S_AREA], s[axis ? VH_S_Y : VH_S_X],
            s[axis ? VH_S_X : VH_S_Y], s[axis ? VH_S_YY : VH_S_XX], s[VH_S_XY], s[axis ? VH_S_XX : VH_S_YY],
            s[VH_S_LENGTH]);
    }
}

/* Add what was gathered. */
static void add_pieces(const struct row *row, struct pieces *pieces, const struct vh_sums *sums)
{
    add_triangles(row, pieces->added, pieces->n_added, 1.0, sums);
    add_strips(row, pieces->strips, pieces->n_strips, sums);
    add_triangles(row, pieces->taken, pieces->n_taken, -1.0, sums);
    pieces->n_added = pieces->n_strips = pieces->n_taken = 0;
}

static void sort_two(int *one, int *other)
{
    const int lesser = vh_min(*one, *other), greater = vh_max(*one, *other);
    *one = lesser;
    *other = greater;
}

/* Gather a cut cell's pieces; returns the threshold from which on it counts as a whole. */
static int gather_cut(struct pieces *p, const struct row *row, int column, int last)
{
    const int32_t *in0 = row->in[0] + column, *in1 = row->in[1] + column;
    /* The corners in the order in which they come in, by a sorting network: no branch for the processor to guess. */
    int first = 4 * in0[0], second = 4 * in0[1] + 1, third = 4 * in1[1] + 2, fourth = 4 * in1[0] + 3;
    sort_two(&first, &second);
    sort_two(&third, &fourth);
    sort_two(&first, &third);
    sort_two(&second, &fourth);
    sort_two(&second, &third);
    const int a = first & 3, b = second & 3, c = third & 3, d = fourth & 3;
    const int one = first >> 2, two = second >> 2, three = third >> 2;
    if ((a ^ b) != 2) {
        p->n_added = put(p->added, p->n_added, column, a, one, two);
        p->n_strips = put(p->strips, p->n_strips, column, side_of[1 << a | 1 << b], two, three);
        p->n_taken = put(p->taken, p->n_taken, column, d, three, last);
        return three;
    }
    /* A saddle: the two high corners are apart until the mean of the cell is above the threshold. */
    const vh_real *v0 = row->v[0] + column, *v1 = row->v[1] + column;
    const vh_real four_means = (v0[0] + v0[1]) + (v1[0] + v1[1]);
    int joined = two;
    while (joined < three && !(4.0 * row->t[joined] < four_means))
        joined++;
    p->n_added = put(p->added, p->n_added, column, a, one, joined);
    p->n_added = put(p->added, p->n_added, column, b, two, joined);
    p->n_taken = put(p->taken, p->n_taken, column, c, joined, three);
    p->n_taken = put(p->taken, p->n_taken, column, d, joined, last);
    return joined;
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

/* Add the cells of a row, from column `left` to before `right`. */
static void add_row(const struct row *row, int left, int right, int end, const struct vh_sums *sums)
{
    const vh_real *v0 = row->v[0], *v1 = row->v[1];
    const int32_t *e0 = row->in[0], *e1 = row->in[1];
    struct pieces pieces;
    /* Cells beside each other that are whole from the same threshold on are one rectangle. */
    int run = end, start = left, n_cut = 0;
    pieces.n_added = pieces.n_taken = pieces.n_strips = 0;
    for (int c = left; c < right; c++) {
        const int first = vh_min(vh_min(e0[c], e0[c + 1]), vh_min(e1[c], e1[c + 1]));
        const int last = vh_max(vh_max(e0[c], e0[c + 1]), vh_max(e1[c], e1[c + 1]));
        int covered = end;
        if (first < end && vh_least(vh_least(v0[c], v0[c + 1]), vh_least(v1[c], v1[c + 1])) > VH_NOTHING) {
            covered = first;
            if (first < last) {
                if (n_cut++ % GATHERED == GATHERED - 1)
                    add_pieces(row, &pieces, sums);
                covered = gather_cut(&pieces, row, c, last);
            }
        }
        if (covered != run) {
            if (run < end)
                add_rectangle(sums->whole[run], row->xs[start] - row->x, row->xs[c] - row->x, row->y[0], row->y[1]);
            run = covered;
            start = c;
        }
    }
    if (run < end)
        add_rectangle(sums->whole[run], row->xs[start] - row->x, row->xs[right] - row->x, row->y[0], row->y[1]);
    add_pieces(row, &pieces, sums);
}

void vh_add_cells(const struct vh_window *w, const struct vh_sums *sums)
{
    for (int r = w->top; r < w->bottom; r++) {
        const vh_real *v = w->v + (size_t)r * w->width;
        const int32_t *in = w->enters + (size_t)r * w->width;
        const struct row row = {
            {v, v + w->width}, w->xs, w->t, {in, in + w->width}, w->x, {w->ys[r] - w->y, w->ys[r + 1] - w->y},
        };
        add_row(&row, w->left, w->right, w->end, sums);
    }
}
