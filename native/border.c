/*
 * Cells at the border of a field that is no rectangle: those that lack one to three corners.
 *
 * The region R is the union of the taxels' rectangles. Between the centres of neighbouring taxels V is interpolated; from
 * a centre outward to the border of R it is constant across the border. So a cell with two neighbouring corners is half a
 * cell, one with a single corner a quarter, one with three corners a triangle between the centres and two small triangles
 * out to the border, all of them cut by straight lines.
 */
#include "inner.h"

struct point {
    vh_real x, y;
};

/* A corner of a piece: where it is, its value, whether it belongs to the contact. */
struct corner {
    vh_real x, y, v;
    int ours;
};

struct piece {
    struct corner corner[4];
    int n;
};

/* Where pieces are added. */
struct sums {
    const vh_real *t;
    int end;
    const struct vh_sums *sums;
    vh_real (*support)[2 * VH_N_DIRECTIONS];
};

/*
 * Add the integrals of x dy, x^2/2 dy, x y dy, x^3/3 dy, x^2 y/2 dy and x y^2 dy from p to q: around a closed polygon these
 * are the integrals of 1, x, y, x^2, x y and y^2 over it (Green). Written with the segment's middle and half its length.
 */
static void add_line(vh_real sum[VH_N_WHOLE], struct point p, struct point q)
{
    const vh_real x = 0.5 * (p.x + q.x), y = 0.5 * (p.y + q.y), hx = 0.5 * (q.x - p.x), hy = 0.5 * (q.y - p.y);
    const vh_real dy = q.y - p.y, xx = x * x, third = hx * hx * (1.0 / 3.0), cross = hx * hy * (1.0 / 3.0);
    sum[VH_S_AREA] += dy * x;
    sum[VH_S_X] += dy * 0.5 * (xx + third);
    sum[VH_S_Y] += dy * (x * y + cross);
    sum[VH_S_XX] += dy * x * (xx * (1.0 / 3.0) + third);
    sum[VH_S_XY] += dy * (0.5 * y * (xx + third) + x * cross);
    sum[VH_S_YY] += dy * (x * (y * y + hy * hy * (1.0 / 3.0)) + 2.0 * y * cross);
}

/* Add the part of a piece above a level: a polygon, closed by the line that cuts it, whose length is returned. */
static vh_real add_part(const struct piece *piece, vh_real level, vh_real sum[VH_N_WHOLE], const struct sums *s, int i)
{
    struct point leave = {0.0, 0.0}, enter = {0.0, 0.0};
    int crossed = 0;
    for (int k = 0; k < piece->n; k++) {
        const struct corner *a = &piece->corner[k], *b = &piece->corner[k + 1 < piece->n ? k + 1 : 0];
        const int a_in = a->ours && a->v > level, b_in = b->ours && b->v > level;
        struct point p = {a->x, a->y}, q = {b->x, b->y};
        if (a_in)
            vh_reach(s->support[i], p.x, p.y);
        if (a_in != b_in) {
            const vh_real f = (a->v - level) / (a->v - b->v);
            const struct point cut = {p.x + f * (q.x - p.x), p.y + f * (q.y - p.y)};
            vh_reach(s->support[i], cut.x, cut.y);
            crossed++;
            if (a_in)
                q = leave = cut;
            else
                p = enter = cut;
        }
        if (a_in || b_in)
            add_line(sum, p, q);
    }
    if (crossed != 2)
        return 0.0;
    add_line(sum, leave, enter);
    return sqrt((enter.x - leave.x) * (enter.x - leave.x) + (enter.y - leave.y) * (enter.y - leave.y));
}

/* Add a piece from threshold `first` on; from that on at which all its corners are in, as a whole. */
static void add_piece(const struct piece *piece, int first, const struct sums *s)
{
    int covered = s->end, ours = 1;
    vh_real lowest = INFINITY;
    for (int k = 0; k < piece->n; k++) {
        lowest = vh_least(lowest, piece->corner[k].v);
        ours = ours && piece->corner[k].ours;
    }
    for (int i = first; i < s->end; i++) {
        vh_real sum[VH_N_WHOLE] = {0.0};
        if (ours && lowest > s->t[i])
            covered = i;
        const vh_real length = add_part(piece, s->t[i], sum, s, i);
        for (int j = 0; j < VH_N_WHOLE; j++) {
            if (i == covered)
                s->sums->whole[i][j] += sum[j];
            else
                s->sums->sum[j][i] += sum[j];
        }
        s->sums->sum[VH_S_LENGTH][i] += length;
        if (i == covered)
            return;
    }
}

/* A cell: its corners, the points half way on the side after each, and its centre. */
struct lacking {
    struct corner corner[4];
    struct point middle[4], centre;
};

static struct corner at(struct point p, const struct corner *of) { return (struct corner){p.x, p.y, of->v, of->ours}; }

/* A cell that lacks one corner: the triangle between the centres, and two out to the border. */
static int divide_three(const struct lacking *cell, int without, struct piece *pieces)
{
    const struct corner *b = &cell->corner[(without + 1) & 3], *a = &cell->corner[(without + 2) & 3];
    const struct corner *g = &cell->corner[(without + 3) & 3];
    /* Where the centre is in, the higher of its two neighbours is. */
    const struct corner centre = {cell->centre.x, cell->centre.y, 0.5 * (b->v + g->v), b->v >= g->v ? b->ours : g->ours};
    pieces[0] = (struct piece){{*b, *a, *g}, 3};
    pieces[1] = (struct piece){{*g, at(cell->middle[(without + 3) & 3], g), centre}, 3};
    pieces[2] = (struct piece){{*b, centre, at(cell->middle[without], b)}, 3};
    return 3;
}

/* Divide a cell that lacks corners into convex pieces and return how many. */
static int divide(const struct lacking *cell, struct piece *pieces)
{
    int present = 0, last = 0, without = 0, n = 0;
    for (int j = 0; j < 4; j++) {
        if (cell->corner[j].v == VH_NOTHING) {
            without = j;
        } else {
            present++;
            last = j;
        }
    }
    if (present == 3)
        return divide_three(cell, without, pieces);
    if (present == 2 && cell->corner[(last + 2) & 3].v == VH_NOTHING) {
        const int first = cell->corner[(last + 1) & 3].v > VH_NOTHING ? last : (last + 3) & 3;
        const struct corner *a = &cell->corner[first], *b = &cell->corner[(first + 1) & 3];
        pieces[0] = (struct piece){
            {*a, *b, at(cell->middle[(first + 1) & 3], b), at(cell->middle[(first + 3) & 3], a)}, 4};
        return 1;
    }
    for (int j = 0; j < 4; j++) {
        const struct corner *a = &cell->corner[j];
        if (a->v > VH_NOTHING)
            pieces[n++] =
                (struct piece){{*a, at(cell->middle[j], a), at(cell->centre, a), at(cell->middle[(j + 3) & 3], a)}, 4};
    }
    return n;
}

/* The middle between two columns or rows of a padded frame; the rim stands half a taxel outside already. */
static vh_real middle_of(const vh_real *position, int i, int count)
{
    if (i == 0)
        return position[0];
    return i + 2 == count ? position[i + 1] : 0.5 * (position[i] + position[i + 1]);
}

static struct lacking cell_at(const struct vh_window *w, int r, int c)
{
    const vh_real x[2] = {w->xs[c] - w->x, w->xs[c + 1] - w->x}, y[2] = {w->ys[r] - w->y, w->ys[r + 1] - w->y};
    const struct point h = {middle_of(w->xs, c, w->width) - w->x, middle_of(w->ys, r, w->height) - w->y};
    struct lacking cell;
    for (int j = 0; j < 4; j++) {
        const int down = j >= 2, right = j == 1 || j == 2, p = (r + down) * w->width + c + right;
        cell.corner[j] = (struct corner){x[right], y[down], w->v[p], w->enters[p] < w->end};
    }
    cell.middle[0] = (struct point){h.x, y[0]};
    cell.middle[1] = (struct point){x[1], h.y};
    cell.middle[2] = (struct point){h.x, y[1]};
    cell.middle[3] = (struct point){x[0], h.y};
    cell.centre = h;
    return cell;
}

void vh_add_border_cells(
    const struct vh_window *w, const struct vh_sums *sums, vh_real (*support)[2 * VH_N_DIRECTIONS])
{
    const struct sums s = {w->t, w->end, sums, support};
    struct piece pieces[4];
    for (int r = w->top; r < w->bottom; r++) {
        for (int c = w->left; c < w->right; c++) {
            const int p = r * w->width + c, q = p + w->width;
            const int first =
                vh_min(vh_min(w->enters[p], w->enters[p + 1]), vh_min(w->enters[q], w->enters[q + 1]));
            const vh_real lowest = vh_least(vh_least(w->v[p], w->v[p + 1]), vh_least(w->v[q], w->v[q + 1]));
            if (first == w->end || lowest > VH_NOTHING)
                continue;
            const struct lacking cell = cell_at(w, r, c);
            const int n = divide(&cell, pieces);
            for (int k = 0; k < n; k++)
                add_piece(&pieces[k], first, &s);
        }
    }
    /* Sections nest, and so do their supports. */
    for (int i = 1; i < w->end; i++)
        for (int d = 0; d < 2 * VH_N_DIRECTIONS; d++)
            support[i][d] = vh_most(support[i][d], support[i - 1][d]);
}

size_t vh_gap_events_work(int width, int height) { return (size_t)width * height * (sizeof(int32_t) + 1) + 8; }

/* What surrounds a gap: one contact or several, and the lowest taxel. */
struct shore {
    int contact, one;
    vh_real lowest;
};

static struct shore walk_gap(
    const vh_real *v, int width, int height, const int32_t *label, int source, int32_t *stack, uint8_t *seen)
{
    struct shore shore = {-1, 1, INFINITY};
    int depth = 1;
    stack[0] = source;
    seen[source] = 1;
    while (depth > 0) {
        const int row = stack[--depth] / width, col = stack[depth] % width;
        for (int r = vh_max(row - 1, 0); r < vh_min(row + 2, height); r++) {
            for (int c = vh_max(col - 1, 0); c < vh_min(col + 2, width); c++) {
                const int q = r * width + c;
                if (v[q] == VH_NOTHING) {
                    if (!seen[q]) {
                        seen[q] = 1;
                        stack[depth++] = q;
                    }
                } else if (r == row || c == col) {
                    if (shore.lowest == INFINITY)
                        shore.contact = label[q];
                    shore.one = shore.one && label[q] == shore.contact;
                    shore.lowest = vh_least(shore.lowest, v[q]);
                }
            }
        }
    }
    return shore;
}

/*
 * Find where a hole is nothing but a gap of the field: the contact around it, and the value below which that covers all
 * taxels around the gap. Returns how many there are.
 */
int vh_gap_events(
    const vh_real *v, int width, int height, const int32_t *label, int32_t *contact, vh_real *value, void *work)
{
    int32_t *stack = work;
    uint8_t *seen = (uint8_t *)(stack + (size_t)width * height);
    int n = 0;
    memset(seen, 0, (size_t)width * height);
    for (int source = 0; source < width * height; source++) {
        if (seen[source] || v[source] > VH_NOTHING)
            continue;
        const struct shore shore = walk_gap(v, width, height, label, source, stack, seen);
        /* The first gap is the outside: it holds the rim. */
        if (source > 0 && shore.one && shore.contact >= 0) {
            contact[n] = shore.contact;
            value[n++] = shore.lowest;
        }
    }
    return n;
}
