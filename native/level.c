/*
 * The rest of one frame: a slope or an offset, found where the taxels that nothing presses show it.
 *
 * The rest is a plane that about a quarter of the field or more lies in, that hardly a taxel lies below, and that
 * something stands clearly above.
 */
#include "inner.h"

/* Of a larger frame only every so manyeth row and column is looked at. */
#define MOST_TAXELS (64 * 64)
#define FEWEST_TAXELS 16
#define FEWEST_LINES 4
/* Readings that differ by less than this share of themselves show a plane that fills the field, not a rest. */
#define LEAST_SPAN 0.01
/* Where the search begins: this quantile of the values, and this share of the range to either side of it. */
#define QUANTILE 0.150001
#define BAND 0.250002
#define ROUNDS 12
/* Residuals beyond this many standard deviations are pressed, or another thing. */
#define KEPT 3.0
/* A band that shrinks by less is found. */
#define SETTLED 0.98
/* Share of the field that must lie in the plane, and that may lie below it. */
#define FEWEST_FREE 0.219999
#define MOST_BELOW 0.012001
/* The free taxels must reach over this share of the field's own spread, across as well as along. */
#define LEAST_SPREAD 0.12
/* A plane that stays within this share of the range is no rest but noise, or the skirt of a contact. */
#define LEAST_RISE 0.04
/* Nor is one that rises higher than this share of the range. */
#define MOST_RISE 0.6
/* The free taxels scatter as the noise does, or by this share of the range: a flank of a form scatters more. */
#define MOST_SCATTER_SIGMAS 1.5
#define MOST_SCATTER 0.012
/* What stands above must be at least so high (share of the range, sigmas, counts) and so broad (taxels). */
#define STANDS 0.25
#define STANDS_SIGMAS 8.0
#define STANDS_COUNTS 2.5
#define FEWEST_STANDING 3
/* Just above a rest there is little: at most this many times as many taxels as in it. */
#define MOST_NEAR 0.300001
#define LOWER_BY 0.02

/* Sums of each column: how many taxels, their rows and the squares of these, their values and these times their rows. */
struct columns {
    vh_real *n, *yn, *yyn, *v, *yv;
};

/* What is looked at of a frame: infinity where there is nothing, which lies in no plane. */
struct seen {
    vh_real *values;
    int rows, cols, n;
    vh_real low, peak;
    struct columns sums;
};

static void clear_columns(const struct seen *f) { memset(f->sums.n, 0, 5 * (size_t)f->cols * sizeof(vh_real)); }

/* A plane: its value at the first taxel, its rise by column and by row; how many lie in it, and how. */
struct plane {
    vh_real at, by_col, by_row, n, scatter, spread;
};

/* Add up, column by column, what of a row lies in a band around a plane: so that it runs over columns in vectors. */
static void add_row(
    vh_real *restrict n, vh_real *restrict yn, vh_real *restrict yyn, vh_real *restrict v, vh_real *restrict yv,
    const vh_real *restrict row, int cols, vh_real y, vh_real at, vh_real by_col, vh_real band)
{
    for (int c = 0; c < cols; c++) {
        const vh_real value = row[c], residual = fabs(value - (at + by_col * c));
        const vh_real one = residual <= band ? 1.0 : 0.0, in = residual <= band ? value : 0.0;
        n[c] += one;
        yn[c] += y * one;
        yyn[c] += y * y * one;
        v[c] += in;
        yv[c] += y * in;
    }
}

/* The same for what lies below a new plane, of what lies in a band around an old one. */
static void add_below(
    vh_real *restrict n, vh_real *restrict squares, const vh_real *restrict row, int cols, vh_real old, vh_real old_by_col,
    vh_real band, vh_real new, vh_real new_by_col)
{
    for (int c = 0; c < cols; c++) {
        const vh_real value = row[c], residual = fabs(value - (old + old_by_col * c));
        const vh_real below = value - (new + new_by_col * c);
        const vh_real one = (residual <= band) & (below <= 0.0) ? 1.0 : 0.0;
        n[c] += one;
        squares[c] += one > 0.0 ? below * below : 0.0;
    }
}

/* How the taxels scatter that lie below a new plane, of those that lie in a band around another. */
static vh_real scatter_below(const struct seen *f, const struct plane *old, vh_real band, const struct plane *new)
{
    vh_real squares = 0.0, n = 0.0;
    clear_columns(f);
    for (int r = 0; r < f->rows; r++)
        add_below(f->sums.n, f->sums.v, f->values + (size_t)r * f->cols, f->cols, old->at + old->by_row * r, old->by_col, band,
                  new->at + new->by_row * r, new->by_col);
    for (int c = 0; c < f->cols; c++) {
        squares += f->sums.v[c];
        n += f->sums.n[c];
    }
    return n > 0.0 ? sqrt(squares / n) : 0.0;
}

/* Fit a plane to the taxels within `band` of another, which it replaces. */
static void fit_plane(const struct seen *f, struct plane *plane, vh_real band)
{
    const vh_real my = 0.5 * (f->rows - 1), mx = 0.5 * (f->cols - 1);
    const struct columns s = f->sums;
    vh_real n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0, sv = 0.0, sxv = 0.0, syv = 0.0;
    clear_columns(f);
    for (int r = 0; r < f->rows; r++)
        add_row(s.n, s.yn, s.yyn, s.v, s.yv, f->values + (size_t)r * f->cols, f->cols, r - my,
                plane->at + plane->by_row * r, plane->by_col, band);
    for (int c = 0; c < f->cols; c++) {
        const vh_real x = c - mx;
        n += s.n[c];
        sx += x * s.n[c];
        sy += s.yn[c];
        sxx += x * x * s.n[c];
        sxy += x * s.yn[c];
        syy += s.yyn[c];
        sv += s.v[c];
        sxv += x * s.v[c];
        syv += s.yv[c];
    }
    plane->n = n;
    if (n < 6.0)
        return;
    const vh_real cx = sx / n, cy = sy / n, cv = sv / n;
    const vh_real vxx = sxx / n - cx * cx, vxy = sxy / n - cx * cy, vyy = syy / n - cy * cy;
    const vh_real vxv = sxv / n - cx * cv, vyv = syv / n - cy * cv;
    const vh_real determinant = vxx * vyy - vxy * vxy;
    const vh_real whole_x = ((vh_real)f->cols * f->cols - 1.0) / 12.0, whole_y = ((vh_real)f->rows * f->rows - 1.0) / 12.0;
    /* The lesser of the two spreads, against those of the whole field. */
    const vh_real a = vxx / whole_x, b = vxy / sqrt(whole_x * whole_y), d = vyy / whole_y;
    plane->spread = 0.5 * (a + d) - sqrt(0.25 * (a - d) * (a - d) + b * b);
    if (!(determinant > VH_CLOSE * (vxx * vyy + VH_LEAST_NORMAL))) {
        plane->spread = 0.0;
        return;
    }
    struct plane new = *plane;
    new.by_col = (vxv * vyy - vyv * vxy) / determinant;
    new.by_row = (vyv * vxx - vxv * vxy) / determinant;
    new.at = cv - new.by_col * (cx + mx) - new.by_row * (cy + my);
    /* What is pressed lies above the rest: how the rest scatters is told by what lies below it. */
    new.scatter = scatter_below(f, plane, band, &new);
    *plane = new;
}

/* Write every so manyeth taxel, and its usable values in a row as well; 0 where they are too few or too much alike. */
static int look_at(struct seen *f, const vh_real *frame, const uint8_t *usable, int rows, int cols, int step, vh_real *row)
{
    /* Something small may stand between the taxels that are looked at. */
    const int whole = vh_range(frame, usable, rows * cols, &f->low, &f->peak) == rows * cols && step == 1;
    f->rows = (rows + step - 1) / step;
    f->cols = (cols + step - 1) / step;
    f->n = whole ? rows * cols : 0;
    if (whole) {
        memcpy(f->values, frame, (size_t)f->n * sizeof *row);
        memcpy(row, frame, (size_t)f->n * sizeof *row);
    }
    for (int r = 0; !whole && r < f->rows; r++) {
        for (int c = 0; c < f->cols; c++) {
            const size_t at = (size_t)r * step * cols + (size_t)c * step;
            f->values[(size_t)r * f->cols + c] = usable[at] ? frame[at] : INFINITY;
            row[f->n] = frame[at];
            f->n += usable[at];
        }
    }
    return f->n >= FEWEST_TAXELS && f->rows >= FEWEST_LINES && f->cols >= FEWEST_LINES &&
           f->peak - f->low > LEAST_SPAN * vh_most(fabs(f->peak), fabs(f->low));
}

/* Search for the plane that many taxels lie in; returns the band that holds them, 0 where there is none. */
static vh_real find_plane(const struct seen *f, struct plane *plane, vh_real sigma)
{
    const vh_real span = f->peak - f->low;
    vh_real band = BAND * span;
    for (int round = 0; round < ROUNDS; round++) {
        fit_plane(f, plane, band);
        if (plane->n < vh_most(FEWEST_FREE * f->n, 8.0) || plane->spread < LEAST_SPREAD)
            return 0.0;
        const vh_real rounding = VH_SAME * vh_most(fabs(f->peak), fabs(f->low));
        vh_real tighter = vh_most(vh_most(KEPT * plane->scatter, KEPT * sigma), rounding);
        if (tighter >= SETTLED * band)
            break;
        band = tighter;
    }
    return band;
}

/* Whether a plane rises as a rest does: enough to be one, and not as a form's flank. */
static int rises_as_rest(const struct seen *f, const struct plane *plane, vh_real sigma)
{
    const vh_real span = f->peak - f->low, scatter = vh_most(plane->scatter, sigma);
    const vh_real along = plane->by_col * (f->cols - 1), across = plane->by_row * (f->rows - 1);
    const vh_real lowest = plane->at + vh_least(vh_least(0.0, along), vh_least(across, along + across));
    const vh_real highest = plane->at + vh_most(vh_most(0.0, along), vh_most(across, along + across));
    if (plane->scatter > vh_most(MOST_SCATTER_SIGMAS * sigma, MOST_SCATTER * span))
        return 0;
    return highest - lowest <= MOST_RISE * span &&
           vh_most(fabs(lowest), fabs(highest)) >= vh_most(LEAST_RISE * span, 6.0 * scatter / sqrt(plane->n));
}

/* Whether enough taxels of the whole frame stand higher than `clear` above a plane of every so manyeth taxel. */
static int stands_above(const vh_real *frame, const uint8_t *usable, int rows, int cols, int step,
                        const struct plane *plane, vh_real clear)
{
    int standing = 0;

    for (int r = 0; r < rows && standing < FEWEST_STANDING; r++)
        for (int c = 0; c < cols; c++) {
            const size_t at = (size_t)r * cols + c;
            standing += usable[at] && frame[at] - (plane->at + plane->by_col * c / step + plane->by_row * r / step) > clear;
        }
    return standing >= FEWEST_STANDING;
}

/* Whether hardly anything lies below the plane, or just above it. */
static int lies_free(const struct seen *f, const struct plane *plane, vh_real band, vh_real sigma)
{
    const vh_real span = f->peak - f->low, scatter = vh_most(plane->scatter, sigma);
    const vh_real lower = vh_most(KEPT * scatter, LOWER_BY * span);
    int below = 0, near = 0;
    for (int r = 0; r < f->rows; r++) {
        for (int c = 0; c < f->cols; c++) {
            const vh_real value = f->values[(size_t)r * f->cols + c];
            const vh_real residual = value - (plane->at + plane->by_col * c + plane->by_row * r);
            below += residual < -lower;
            near += (residual > band) & (residual <= 2.0 * band);
        }
    }
    return below <= MOST_BELOW * f->n && near <= MOST_NEAR * plane->n;
}

size_t vh_level_work(int rows, int cols)
{
    size_t most = (size_t)rows * cols;
    /* Rows and columns that are left out are counted down, so that a few more than MOST_TAXELS may be seen. */
    if (most > 4 * MOST_TAXELS)
        most = 4 * MOST_TAXELS + (size_t)rows + cols;
    return (2 * most + 5 * (size_t)cols + 8) * sizeof(vh_real);
}

int vh_level(vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, vh_real rest[3], void *work)
{
    struct seen f = {work, 0, 0, 0, 0.0, 0.0, {0, 0, 0, 0, 0}};
    int step = 1;
    rest[0] = rest[1] = rest[2] = 0.0;
    while ((int64_t)(rows / step) * (cols / step) > MOST_TAXELS)
        step++;
    const size_t n_cols = (size_t)(cols + step - 1) / step, n_seen = (size_t)((rows + step - 1) / step) * n_cols;
    vh_real *row = f.values + n_seen, *sums = row + n_seen;
    f.sums = (struct columns){sums, sums + n_cols, sums + 2 * n_cols, sums + 3 * n_cols, sums + 4 * n_cols};
    if (!look_at(&f, frame, usable, rows, cols, step, row))
        return 0;
    struct plane plane = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    plane.at = vh_order_statistic(row, f.n, (int)(QUANTILE * f.n));
    vh_real band = find_plane(&f, &plane, sigma);
    if (band == 0.0 || !rises_as_rest(&f, &plane, sigma) || !lies_free(&f, &plane, band, sigma))
        return 0;
    vh_real clear = vh_most(STANDS * (f.peak - f.low), STANDS_SIGMAS * vh_most(plane.scatter, sigma));
    clear = vh_most(clear, STANDS_COUNTS * vh_count_of(frame, usable, rows, cols, clear / STANDS_COUNTS));
    if (!stands_above(frame, usable, rows, cols, step, &plane, clear))
        return 0;
    rest[0] = plane.at;
    rest[1] = plane.by_col / step;
    rest[2] = plane.by_row / step;
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < cols; c++)
            frame[(size_t)r * cols + c] -= rest[0] + rest[1] * c + rest[2] * r;
    return 1;
}
