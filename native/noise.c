/* The noise of one frame, from the frame alone: what no smooth pressure makes. */
#include "inner.h"

/* Median of |z| for a standard normal z. */
#define MEDIAN_ABS_NORMAL 0.6744897501960817
/* Residuals beyond this many sigma belong to a contact's rim and are left out of the next round. */
#define CLIP 3.0
#define ROUNDS 3
/* Relative; far below the sampling error of any frame. */
#define PRECISION 1e-3
/* Of a larger frame only every so manyeth row is looked at: sigma is then known to 1 %. */
#define MOST_TAXELS 16384
/* Fewer residuals than this say more about the contact's form than about the noise. */
#define FEWEST 16
/* Where a sensor shows zeros instead of noise, every residual comes from inside the contact. */
#define FEWEST_INSIDE 64
/* The lowest value in this share of the taxels: the sensor cuts off what lies below it. */
#define CUT_SHARE 0.25
/* Neighbours of a cut taxel: in clipped noise 2/3 stand above the cut, around a contact few. */
#define MIXED_SHARE 0.400001
/* max(z, 0) has these fractions of sigma in the residuals' clipped medians (1e6 taxels, seed 0). */
#define CLIPPED_MIXED 0.5691
#define CLIPPED_LAPLACIAN 0.5263
#define CLIPPED_LINE 0.5727
/* State of a taxel that may take part in no residual. */
#define NEVER 100

/* How a sensor shows its noise: wholly; as zeros where it is small; or clipped at zero. */
enum kind { PLAIN, THRESHOLDED, CLIPPED };

/* A value below which some of many values lie, and how many. */
struct rank {
    vh_real value;
    int count;
};

/* How many values are at most `bound`; four vectors side by side. */
static int at_most(const vh_real *a, int n, vh_real bound)
{
    vh_int part[4 * VH_LANES] = {0}, count = 0;
    int i = 0;
    for (; i + 4 * VH_LANES <= n; i += 4 * VH_LANES)
        for (int k = 0; k < 4 * VH_LANES; k++)
            part[k] += a[i + k] <= bound;
    for (; i < n; i++)
        count += a[i] <= bound;
    for (int k = 0; k < 4 * VH_LANES; k++)
        count += part[k];
    return (int)count;
}

/* The sum of many values, four side by side. */
static vh_real sum_of(const vh_real *a, int n)
{
    vh_real part[4] = {0.0, 0.0, 0.0, 0.0};
    int i = 0;
    for (; i + 4 <= n; i += 4)
        for (int j = 0; j < 4; j++)
            part[j] += a[i + j];
    for (; i < n; i++)
        part[0] += a[i];
    return (part[0] + part[1]) + (part[2] + part[3]);
}

/* The greatest of values >= 0 that is at most `bound`. */
static vh_real greatest_to(const vh_real *a, int n, vh_real bound)
{
    vh_real best[VH_LANES] = {0.0};
    int i = 0;
    for (; i + VH_LANES <= n; i += VH_LANES) {
        VH_SIDE_BY_SIDE
        for (int k = 0; k < VH_LANES; k++) {
            const vh_real value = a[i + k] <= bound ? a[i + k] : 0.0;
            best[k] = value > best[k] ? value : best[k];
        }
    }
    for (; i < n; i++)
        best[0] = vh_most(best[0], a[i] <= bound ? a[i] : 0.0);
    for (int k = 1; k < VH_LANES; k++)
        best[0] = vh_most(best[0], best[k]);
    return best[0];
}

/* The least value that is greater than `bound`. */
static vh_real least_beyond(const vh_real *a, int n, vh_real bound)
{
    vh_real best[VH_LANES];
    int i = 0;
    for (int k = 0; k < VH_LANES; k++)
        best[k] = INFINITY;
    for (; i + VH_LANES <= n; i += VH_LANES) {
        VH_SIDE_BY_SIDE
        for (int k = 0; k < VH_LANES; k++) {
            const vh_real value = a[i + k] > bound ? a[i + k] : INFINITY;
            best[k] = value < best[k] ? value : best[k];
        }
    }
    for (; i < n; i++)
        best[0] = vh_least(best[0], a[i] > bound ? a[i] : INFINITY);
    for (int k = 1; k < VH_LANES; k++)
        best[0] = vh_least(best[0], best[k]);
    return best[0];
}

/*
 * The value of that rank among a[0..n-1] >= 0 to PRECISION, and how many values are no greater.
 *
 * n_low values are 0 and `upper.count` > rank are at most `upper.value`. Interpolation by counting: a count runs over
 * many values an instruction, a selection does not. Where only the value itself is left on one side of a bound, it is
 * the one next to the bound.
 */
static struct rank median_of(const vh_real *a, int n, int rank, int n_low, struct rank upper)
{
    vh_real low = 0.0, high = upper.value;
    int n_high = upper.count, above = 0;
    if (n_low > rank)
        return (struct rank){0.0, n_low};
    for (int turn = 1; high - low > PRECISION * high; turn++) {
        vh_real middle;
        if (n_high == rank + 1)
            return (struct rank){greatest_to(a, n, high), n_high};
        if (n_low == rank)
            return (struct rank){least_beyond(a, n, low), rank + 1};
        if (turn % 4 == 0) {
            middle = 0.5 * (low + high);
        } else {
            /* A little beyond the guess, on the side that is not known closely yet. */
            vh_real side = vh_most(0.4 * PRECISION * high, 0.03 * (high - low));
            middle = low + (high - low) * ((rank + 0.5 - n_low) / (n_high - n_low)) + (above ? -side : side);
            middle = vh_most(low + 0.02 * (high - low), middle);
            middle = vh_least(high - 0.02 * (high - low), middle);
        }
        if (middle <= low || middle >= high)
            break;
        int count = at_most(a, n, middle);
        above = count > rank;
        if (above) {
            high = middle;
            n_high = count;
        } else {
            low = middle;
            n_low = count;
        }
    }
    return (struct rank){high, n_high};
}

/* Sigma of n absolute residuals by their median, clipped for outliers in rounds. */
static vh_real robust_sigma(const vh_real *a, int n)
{
    int zeros = at_most(a, n, 0.0), kept = n;
    /* The median of positive values is at most twice their mean. */
    struct rank upper = {2.000001 * sum_of(a, n) / n, n};
    struct rank median = median_of(a, n, n / 2, zeros, upper);
    for (int round = 0; round < ROUNDS; round++) {
        int still = at_most(a, n, CLIP / MEDIAN_ABS_NORMAL * median.value);
        if (still == kept)
            break;
        kept = still;
        median = median_of(a, n, kept / 2, zeros, median);
    }
    return median.value / MEDIAN_ABS_NORMAL;
}

/* Tell noise that is all there from noise that a sensor has cut off, and where. */
static enum kind kind_of(const vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real *cut)
{
    int at_lowest = 0, mixed = 0, same = 0;
    vh_real lowest, highest;
    const int n = vh_range(frame, usable, rows * cols, &lowest, &highest);
    /* What rounding brings between equal readings is no noise. */
    lowest += 0.1 * VH_SAME * highest - 0.1 * VH_SAME * lowest;
    for (int i = 0; i < rows * cols; i++)
        at_lowest += usable[i] & (frame[i] <= lowest);
    *cut = lowest;
    if (at_lowest < CUT_SHARE * n)
        return PLAIN;
    for (int r = 0; r < rows; r++) {
        for (int c = 0; c < cols; c++) {
            int i = r * cols + c, here = frame[i] <= lowest;
            if (!usable[i])
                continue;
            if (r + 1 < rows && usable[i + cols]) {
                int below = frame[i + cols] <= lowest;
                mixed += here != below;
                same += here && below;
            }
            if (c + 1 < cols && usable[i + 1]) {
                int right = frame[i + 1] <= lowest;
                mixed += here != right;
                same += here && right;
            }
        }
    }
    return mixed > MIXED_SHARE * (mixed + same) ? CLIPPED : THRESHOLDED;
}

/* Keep a residual that was written at out[n] if its taxels' states allow it: no branch for the processor to guess. */
static int kept(int n, const vh_real *out, int states, int allowed)
{
    return n + ((states <= allowed) & (out[n] < INFINITY));
}

/* Write the mixed differences that start in every so manyeth row; without states all of them count. */
static int mixed_differences(
    const vh_real *frame, const uint8_t *state, int rows, int cols, int allowed, int every, vh_real *out)
{
    int n = 0;
    for (int r = 0; r < rows - 1; r += every) {
        const vh_real *f0 = frame + (size_t)r * cols, *f1 = f0 + cols;
        if (!state) {
            for (int c = 0; c < cols - 1; c++)
                out[n + c] = fabs(f0[c] - f0[c + 1] - f1[c] + f1[c + 1]) / 2.0;
            n += cols - 1;
            continue;
        }
        const uint8_t *s0 = state + (size_t)r * cols, *s1 = s0 + cols;
        for (int c = 0; c < cols - 1; c++) {
            out[n] = fabs(f0[c] - f0[c + 1] - f1[c] + f1[c + 1]) / 2.0;
            n = kept(n, out, s0[c] + s0[c + 1] + s1[c] + s1[c + 1], allowed);
        }
    }
    return n;
}

/* Write the differences of Laplacians, as `mixed_differences` does. */
static int laplacian_differences(
    const vh_real *frame, const uint8_t *state, int rows, int cols, int allowed, int every, vh_real *out)
{
    int n = 0;
    for (int r = 0; r < rows - 2; r += every) {
        const vh_real *f0 = frame + (size_t)r * cols, *f1 = f0 + cols, *f2 = f1 + cols;
        if (!state) {
            for (int c = 0; c < cols - 2; c++) {
                vh_real sides = (f0[c] - 2 * f1[c] + f2[c]) + (f0[c + 2] - 2 * f1[c + 2] + f2[c + 2]);
                out[n + c] = fabs(sides - 2 * (f0[c + 1] - 2 * f1[c + 1] + f2[c + 1])) / 6.0;
            }
            n += cols - 2;
            continue;
        }
        const uint8_t *s0 = state + (size_t)r * cols, *s1 = s0 + cols, *s2 = s1 + cols;
        for (int c = 0; c < cols - 2; c++) {
            vh_real sides = (f0[c] - 2 * f1[c] + f2[c]) + (f0[c + 2] - 2 * f1[c + 2] + f2[c + 2]);
            int states = 0;
            for (int j = c; j < c + 3; j++)
                states += s0[j] + s1[j] + s2[j];
            out[n] = fabs(sides - 2 * (f0[c + 1] - 2 * f1[c + 1] + f2[c + 1])) / 6.0;
            n = kept(n, out, states, allowed);
        }
    }
    return n;
}

/* Write the second differences of a pad of one row or column. */
static int line_differences(const vh_real *line, const uint8_t *state, int count, int allowed, vh_real *out)
{
    int n = 0;
    for (int c = 0; c < count - 2; c++) {
        out[n] = fabs(line[c] - 2 * line[c + 1] + line[c + 2]) / sqrt(6.0);
        n = kept(n, out, state ? state[c] + state[c + 1] + state[c + 2] : 0, allowed);
    }
    return n;
}

size_t vh_noise_sigma_work(int rows, int cols) { return (size_t)rows * cols * (sizeof(vh_real) + 1); }

vh_real vh_noise_sigma(const vh_real *frame, const uint8_t *usable, int rows, int cols, void *work)
{
    const int size = rows * cols;
    vh_real *out = work, cut;
    /* A residual counts where the states of its taxels sum to no more than is allowed. */
    uint8_t *state = 0;
    int every = 1 + (size - 1) / MOST_TAXELS, fewest = FEWEST;
    int allowed_laplacian = 0, allowed_mixed = 0, allowed_line = 0;
    vh_real scale_laplacian = 1.0, scale_mixed = 1.0, scale_line = 1.0;
    const int whole = vh_all_count(usable, size) && isfinite(sum_of(frame, size));
    enum kind kind = kind_of(frame, usable, rows, cols, &cut);
    if (kind != PLAIN || !whole) {
        state = (uint8_t *)(out + size);
        for (int i = 0; i < size; i++)
            state[i] = usable[i] ? (kind != PLAIN && frame[i] <= cut) : NEVER;
    }
    if (kind == THRESHOLDED) {
        fewest = FEWEST_INSIDE;
        every = 1;
    } else if (kind == CLIPPED) {
        allowed_laplacian = 8;
        allowed_mixed = 3;
        allowed_line = 2;
        scale_laplacian = CLIPPED_LAPLACIAN;
        scale_mixed = CLIPPED_MIXED;
        scale_line = CLIPPED_LINE;
    }
    if (rows < 2 || cols < 2) {
        int n = line_differences(frame, state, size, allowed_line, out);
        return n >= fewest ? robust_sigma(out, n) / scale_line : 0.0;
    }
    vh_real sigma = INFINITY;
    if (rows > 2 && cols > 2) {
        int n = laplacian_differences(frame, state, rows, cols, allowed_laplacian, every, out);
        if (n < fewest)
            return 0.0;
        sigma = robust_sigma(out, n) / scale_laplacian;
    }
    int n = mixed_differences(frame, state, rows, cols, allowed_mixed, every, out);
    return n < fewest ? 0.0 : vh_least(sigma, robust_sigma(out, n) / scale_mixed);
}
