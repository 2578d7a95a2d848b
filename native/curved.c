/*
 * The rest of one frame that curves, as depth maps do whose slopes were summed up: a surface of second degree, found where
 * the taxels that nothing presses show it.
 *
 * That rest is much of the field, reaches into each quarter of it, hardly a taxel lies below it, and something stands
 * clearly above. Where it is even, or few taxels show it, the frame stays as it is: a plane is looked for first.
 */
#include "inner.h"

/* Of fewer taxels a broad form and a rest that curves are not told apart. */
#define FEWEST_TAXELS (64 * 64)
/* Of a larger frame only every so manyeth row and column is looked at. */
#define MOST_SEEN (48 * 48)
#define N_TERMS 6
/* What differs by less, as a share of the highest, is a plane that is pressed. */
#define LEAST_SPAN 0.001
/* Where the search begins: this quantile of the values, and this share of the range to either side of it. */
#define QUANTILE 0.300001
#define BAND 0.250002
#define ROUNDS 16
/* Residuals beyond this many standard deviations are pressed, or another thing; a band that shrinks by less is found. */
#define KEPT 3.0
#define SETTLED 0.98
/* Share of the taxels that must lie in the rest, of the whole field and of each quarter, and that may lie below it. */
#define FEWEST_FREE 0.400001
#define FEWEST_OF_QUARTER 0.200001
#define MOST_BELOW 0.020001
/* How far it curves, as a share of the range: what curves less is the skirt of a contact, what rises more is a form. */
#define LEAST_BEND 0.02
#define MOST_RISE 0.4
/* The free taxels scatter as the noise does, or by this share of the range. */
#define MOST_SCATTER_SIGMAS 1.5
#define MOST_SCATTER 0.012
/* What stands above must be at least so high (share of the range, sigmas) and so broad (taxels). */
#define STANDS 0.25
#define STANDS_SIGMAS 8.0
#define FEWEST_STANDING 3
/* Just above a rest there is little: at most this many times as many taxels as in it. */
#define MOST_NEAR 0.300001
#define LOWER_BY 0.02

/* A surface over the field, whose rows and columns go from -1 to 1: 1, x, y, xx, xy, yy. */
struct surface {
    vh_real of[N_TERMS];
};

/* What is looked at of a frame: its values, where each of them stands, and how far above the surface it lies. */
struct seen {
    vh_real *value, *x, *y, *residual;
    int n;
    vh_real low, peak;
};

static void terms_at(vh_real x, vh_real y, vh_real terms[N_TERMS])
{
    terms[0] = 1.0;
    terms[1] = x;
    terms[2] = y;
    terms[3] = x * x;
    terms[4] = x * y;
    terms[5] = y * y;
}

static vh_real height_at(const struct surface *s, vh_real x, vh_real y)
{
    return s->of[0] + x * (s->of[1] + s->of[3] * x + s->of[4] * y) + y * (s->of[2] + s->of[5] * y);
}

/* Write how far what is seen lies above a surface; by itself, so that it runs in vectors. */
static void write_residuals(
    const vh_real *restrict value, const vh_real *restrict x, const vh_real *restrict y, int n, const struct surface *s,
    vh_real *restrict residual)
{
    const struct surface of = *s;
    for (int i = 0; i < n; i++)
        residual[i] = value[i] - height_at(&of, x[i], y[i]);
}

static vh_real placed(int i, int n) { return (2.0 * i - (n - 1)) / (n - 1); }

/* Solve normal equations, of which the lower triangle is given, in place; 0 where nothing decides them. */
static int solve(vh_real a[N_TERMS][N_TERMS], vh_real b[N_TERMS])
{
    for (int j = 0; j < N_TERMS; j++) {
        const vh_real whole = a[j][j];
        for (int k = 0; k < j; k++)
            a[j][j] -= a[j][k] * a[j][k];
        if (!(a[j][j] > VH_CLOSE * whole))
            return 0;
        a[j][j] = sqrt(a[j][j]);
        for (int i = j + 1; i < N_TERMS; i++) {
            for (int k = 0; k < j; k++)
                a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
        }
    }
    for (int j = 0; j < N_TERMS; j++) {
        for (int k = 0; k < j; k++)
            b[j] -= a[j][k] * b[k];
        b[j] /= a[j][j];
    }
    for (int j = N_TERMS - 1; j >= 0; j--) {
        for (int k = j + 1; k < N_TERMS; k++)
            b[j] -= a[k][j] * b[k];
        b[j] /= a[j][j];
    }
    return 1;
}

/* Fit a surface to what lies within `band` of it; returns how many do, 0 where they do not tell. */
static int fit(const struct seen *f, struct surface *s, vh_real band)
{
    vh_real a[N_TERMS][N_TERMS] = {{0.0}}, b[N_TERMS] = {0.0}, terms[N_TERMS];
    int n = 0;
    for (int i = 0; i < f->n; i++) {
        if (!(fabs(f->residual[i]) <= band))
            continue;
        terms_at(f->x[i], f->y[i], terms);
        for (int j = 0; j < N_TERMS; j++) {
            for (int k = 0; k <= j; k++)
                a[j][k] += terms[j] * terms[k];
            b[j] += terms[j] * f->residual[i];
        }
        n++;
    }
    if (n < FEWEST_FREE * f->n || !solve(a, b))
        return 0;
    for (int j = 0; j < N_TERMS; j++)
        s->of[j] += b[j];
    write_residuals(f->value, f->x, f->y, f->n, s, f->residual);
    return n;
}

/* How what lies in a band scatters: what is pressed lies above, so that what lies below tells. */
static vh_real scatter_of(const struct seen *f, vh_real band)
{
    vh_real squares = 0.0;
    int n = 0;
    for (int i = 0; i < f->n; i++) {
        const vh_real residual = f->residual[i];
        if (residual <= 0.0 && residual >= -band) {
            squares += residual * residual;
            n++;
        }
    }
    return n > 0 ? sqrt(squares / n) : 0.0;
}

/* Search for the surface that many taxels lie in; returns the band that holds them, 0 where there is none. */
static vh_real find_surface(const struct seen *f, struct surface *s, vh_real sigma, vh_real *scatter)
{
    vh_real band = BAND * (f->peak - f->low);
    write_residuals(f->value, f->x, f->y, f->n, s, f->residual);
    for (int round = 0; round < ROUNDS; round++) {
        if (!fit(f, s, band))
            return 0.0;
        *scatter = scatter_of(f, band);
        const vh_real rounding = VH_SAME * vh_most(fabs(f->peak), fabs(f->low));
        const vh_real tighter = vh_most(vh_most(KEPT * *scatter, KEPT * sigma), rounding);
        if (tighter >= SETTLED * band)
            break;
        band = tighter;
    }
    return band;
}

/* Whether a surface curves and rises as a rest does, over the field. */
static int bends_as_rest(const struct seen *f, const struct surface *s, vh_real sigma, vh_real scatter)
{
    const vh_real span = f->peak - f->low;
    struct surface bend = {{0.0, 0.0, 0.0, s->of[3], s->of[4], s->of[5]}};
    vh_real lowest = INFINITY, highest = -INFINITY, least = INFINITY, most = -INFINITY;
    for (int r = -1; r <= 1; r++) {
        for (int c = -1; c <= 1; c++) {
            const vh_real height = height_at(s, c, r), bent = height_at(&bend, c, r);
            lowest = vh_least(lowest, height);
            highest = vh_most(highest, height);
            least = vh_least(least, bent);
            most = vh_most(most, bent);
        }
    }
    return scatter <= vh_most(MOST_SCATTER_SIGMAS * sigma, MOST_SCATTER * span) && highest - lowest <= MOST_RISE * span &&
           most - least >= LEAST_BEND * span;
}

/* Whether the surface shows in all quarters of the field, and hardly anything lies below it, or just above. */
static int lies_free(const struct seen *f, vh_real band, vh_real sigma, vh_real scatter)
{
    const vh_real lower = vh_most(KEPT * vh_most(scatter, sigma), LOWER_BY * (f->peak - f->low));
    int below = 0, near = 0, free = 0, of[4] = {0, 0, 0, 0}, all[4] = {0, 0, 0, 0};
    for (int i = 0; i < f->n; i++) {
        const vh_real residual = f->residual[i];
        const int quarter = (f->x[i] > 0.0) + 2 * (f->y[i] > 0.0);
        const int in = fabs(residual) <= band;
        all[quarter]++;
        of[quarter] += in;
        free += in;
        below += residual < -lower;
        near += (residual > band) & (residual <= 2.0 * band);
    }
    for (int j = 0; j < 4; j++)
        if (of[j] < FEWEST_OF_QUARTER * all[j])
            return 0;
    return below <= MOST_BELOW * f->n && near <= MOST_NEAR * free;
}

size_t vh_unbend_work(int rows, int cols)
{
    /* Rows and columns that are left out are counted down, so that a few more than MOST_SEEN may be seen. */
    return rows * (size_t)cols < FEWEST_TAXELS ? 0 : 4 * (4 * (size_t)MOST_SEEN + rows + cols) * sizeof(vh_real);
}

int vh_unbend(vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, vh_real rest[3], void *work)
{
    struct seen f = {work, 0, 0, 0, 0, 0.0, 0.0};
    struct surface s = {{0.0}};
    vh_real scatter = 0.0;
    int step = 1, standing = 0;
    if (rows * (int64_t)cols < FEWEST_TAXELS || rows < 3 || cols < 3)
        return 0;
    while ((int64_t)(rows / step) * (cols / step) > MOST_SEEN)
        step++;
    const size_t most = (size_t)((rows + step - 1) / step) * ((cols + step - 1) / step);
    f.x = f.value + most;
    f.y = f.x + most;
    f.residual = f.y + most;
    vh_range(frame, usable, rows * cols, &f.low, &f.peak);
    for (int r = 0; r < rows; r += step) {
        for (int c = 0; c < cols; c += step) {
            const size_t at = (size_t)r * cols + c;
            f.value[f.n] = f.residual[f.n] = frame[at];
            f.x[f.n] = placed(c, cols);
            f.y[f.n] = placed(r, rows);
            f.n += usable[at];
        }
    }
    if (4 * f.n < (int)most || !(f.peak - f.low > LEAST_SPAN * fabs(f.peak)))
        return 0;
    s.of[0] = vh_order_statistic(f.residual, f.n, (int)(QUANTILE * f.n));
    const vh_real band = find_surface(&f, &s, sigma, &scatter);
    if (band == 0.0 || !bends_as_rest(&f, &s, sigma, scatter) || !lies_free(&f, band, sigma, scatter))
        return 0;
    const vh_real clear = vh_most(STANDS * (f.peak - f.low), STANDS_SIGMAS * vh_most(scatter, sigma));
    for (int r = 0; r < rows && standing < FEWEST_STANDING; r++)
        for (int c = 0; c < cols; c++)
            standing += usable[(size_t)r * cols + c] &&
                        frame[(size_t)r * cols + c] - height_at(&s, placed(c, cols), placed(r, rows)) > clear;
    if (standing < FEWEST_STANDING)
        return 0;
    /* The plane that is nearest to it over the field: squares are a third on the mean. */
    rest[1] = 2.0 * s.of[1] / (cols - 1);
    rest[2] = 2.0 * s.of[2] / (rows - 1);
    rest[0] = s.of[0] + (s.of[3] + s.of[5]) / 3.0 - s.of[1] - s.of[2];
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < cols; c++)
            frame[(size_t)r * cols + c] -= height_at(&s, placed(c, cols), placed(r, rows));
    return 1;
}
