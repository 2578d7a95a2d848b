/*
 * Every contact's sections at all thresholds at once.
 *
 * A cell between four taxel centres is cut only at the thresholds between its lowest and its highest corner, so the work is
 * one visit to each cell plus one short sum for each piece of it and threshold; what is covered wholly is added once, at
 * the threshold from which on it is.
 */
#include "inner.h"

/* Where a bin holds more thresholds than this, they are searched one by one. */
#define FEW 4

/*
 * Falling thresholds (t[n] is -inf, and none) in even bins: begin[b] tells how many stand in the bins before b. As a bin's
 * number only grows as the value falls, only those in the value's own bin must be compared with it.
 */
struct bins {
    const vh_real *t;
    int n, last, most;
    int32_t *begin;
    vh_real scale;
};

struct space {
    vh_real *t;
    int32_t *begin, *first_event, *events, *enters, *gap_contact, *earliest, *other;
    vh_real *gap_value, *xs, *ys, *key;
    struct vh_sums sums;
    vh_real (*support)[2 * VH_N_DIRECTIONS], *reach;
    int n_gaps;
};

static size_t divide(void *work, int rows, int cols, int n, struct space *space)
{
    const size_t width = (size_t)cols + 2, height = (size_t)rows + 2, size = width * height;
    const size_t most_contacts = (size_t)((cols + 1) / 2) * rows, most_gaps = ((width + 1) / 2) * ((height + 1) / 2);
    const size_t most_events = (size_t)rows * cols + (width - 1) * (height - 1);
    size_t used = 0;
    /* Whole vectors of thresholds are read, which may begin before the first and end behind the last. */
    space->t = vh_take(work, &used, (size_t)n + 3 * VH_LANES, sizeof(vh_real));
    space->t = work ? space->t + 2 * VH_LANES : 0;
    space->begin = vh_take(work, &used, 2 * (size_t)n + 1, sizeof(int32_t));
    space->first_event = vh_take(work, &used, most_contacts + 2, sizeof(int32_t));
    space->events = vh_take(work, &used, most_events, sizeof(int32_t));
    space->enters = vh_take(work, &used, size, sizeof(int32_t));
    space->gap_contact = vh_take(work, &used, most_gaps, sizeof(int32_t));
    space->gap_value = vh_take(work, &used, most_gaps, sizeof(vh_real));
    space->earliest = vh_take(work, &used, width + height, sizeof(int32_t));
    space->xs = vh_take(work, &used, width, sizeof(vh_real));
    space->ys = vh_take(work, &used, height, sizeof(vh_real));
    space->key = vh_take(work, &used, most_contacts, sizeof(vh_real));
    space->other = vh_take(work, &used, most_contacts, sizeof(int32_t));
    /* The gaps are looked for before these are needed. */
    void *after = work ? (char *)work + used : 0;
    size_t sums = 0;
    for (int j = 0; j < VH_N_SUMS; j++)
        space->sums.sum[j] = vh_take(after, &sums, (size_t)n + VH_LANES, sizeof(vh_real));
    space->sums.whole = vh_take(after, &sums, (size_t)n + 1, sizeof *space->sums.whole);
    space->support = vh_take(after, &sums, (size_t)n, sizeof *space->support);
    space->reach = vh_take(after, &sums, vh_reach_room(n), sizeof(vh_real));
    const size_t gaps = vh_gap_events_work((int)width, (int)height);
    return used + (gaps > sums ? gaps : sums);
}

size_t vh_measure_work(int rows, int cols, int n_levels)
{
    struct space space;
    return divide(0, rows, cols, n_levels, &space);
}

static int bin_of(const struct bins *bins, vh_real value)
{
    vh_real b = (bins->t[0] - value) * bins->scale;
    /* Not a number (nothing times infinity) is the first bin. */
    b = b > 0.0 ? b : 0.0;
    return b < bins->last ? (int)b : bins->last;
}

static void lay_out(struct bins *bins)
{
    const int n = bins->n;
    const vh_real span = bins->t[0] - bins->t[n - 1];
    bins->last = 2 * n;
    bins->scale = span > 0.0 ? bins->last / span : 0.0;
    bins->most = 0;
    for (int i = 0, b = 0, next = 0, alike = 0; i <= n; i++) {
        const int before = b;
        b = i < n ? bin_of(bins, bins->t[i]) : bins->last;
        alike = b == before ? alike + (i < n) : 1;
        bins->most = vh_max(bins->most, alike);
        for (; next <= b; next++)
            bins->begin[next] = i;
    }
}

/* The index of the first threshold below a value of that bin: where it comes in. */
static inline int first_in_bin(const struct bins *bins, int bin, vh_real value)
{
    int i = bins->begin[bin];
    if (bins->most > FEW) {
        while (bins->t[i] >= value)
            i++;
        return i;
    }
    for (int k = 0; k < bins->most; k++)
        i += bins->t[i] >= value;
    return i;
}

static int first_below(const struct bins *bins, vh_real value) { return first_in_bin(bins, bin_of(bins, value), value); }

/* Enter a run of one contact's taxels, from column c to before `stop`, into its places. */
static void place_run(const struct vh_frame *task, int r, int c, int stop)
{
    const int width = task->cols + 2, p = r * width + c, q = r * width + stop;
    const vh_real *v = task->padded;
    vh_int *place = task->places + (size_t)task->label[p] * VH_N_PLACES;
    int up = 0, down = 0;
    for (int i = p; i < q; i++) {
        up |= v[i - width] == VH_NOTHING;
        down |= v[i + width] == VH_NOTHING;
    }
    if (place[VH_N_TAXELS] == 0) {
        place[VH_TOP] = r;
        place[VH_LEFT] = c;
    }
    place[VH_BOTTOM] = r;
    place[VH_LEFT] = c < place[VH_LEFT] ? c : place[VH_LEFT];
    place[VH_RIGHT] = stop - 1 > place[VH_RIGHT] ? stop - 1 : place[VH_RIGHT];
    place[VH_N_TAXELS] += stop - c;
    place[VH_BORDERS] |= (v[p - 1] == VH_NOTHING) | (v[q] == VH_NOTHING) << 1 | up << 2 | down << 3;
}

/* Each contact's peak, bounding box, number of taxels and touched borders. */
static void find_places(struct vh_frame *task, const struct vh_tree *tree)
{
    const int width = task->cols + 2;
    memset(task->places, 0, (size_t)tree->n_contacts * VH_N_PLACES * sizeof *task->places);
    for (int k = 0; k < tree->n_contacts; k++) {
        task->places[k * VH_N_PLACES + VH_PEAK_ROW] = tree->peak_at[k] / width;
        task->places[k * VH_N_PLACES + VH_PEAK_COL] = tree->peak_at[k] % width;
        task->values[2 * k] = task->padded[tree->peak_at[k]];
        task->values[2 * k + 1] = tree->ends[k];
    }
    for (int r = 1; r <= task->rows; r++) {
        const int32_t *label = task->label + (size_t)r * width;
        for (int c = 1; c <= task->cols;) {
            const int k = label[c], start = c++;
            while (c <= task->cols && label[c] == k)
                c++;
            if (k >= 0)
                place_run(task, r, start, c);
        }
    }
}

/* List each contact's events: those of contact k are events[first_event[k] .. first_event[k + 1] - 1]. */
static void list_events(const struct vh_frame *task, const struct vh_tree *tree, const struct space *space)
{
    int32_t *first = space->first_event;
    memset(first, 0, ((size_t)tree->n_contacts + 2) * sizeof *first);
    for (int e = 0; e < tree->n_events; e++)
        first[task->label[tree->event_at[e]] + 2]++;
    /* Those of no contact come first, and are left out. */
    const int before = first[1];
    for (int k = 1; k <= tree->n_contacts + 1; k++)
        first[k] += first[k - 1];
    for (int e = 0; e < tree->n_events; e++) {
        const int k = task->label[tree->event_at[e]];
        if (k >= 0)
            space->events[first[k + 1]++ - before] = e;
    }
    /* Where a contact's events began, the one before has ended now. */
    for (int k = 1; k <= tree->n_contacts; k++)
        first[k] -= before;
}

/* Count a contact's parts and holes at each threshold. */
static void count(
    const struct vh_tree *tree, const struct space *space, const struct bins *bins, int k, int end, vh_real lowest,
    vh_int *parts, vh_int *holes)
{
    for (int j = space->first_event[k]; j < space->first_event[k + 1]; j++) {
        const int e = space->events[j];
        if (!(tree->event_value[e] > lowest))
            continue;
        const int i = first_below(bins, tree->event_value[e]);
        if (i < end) {
            parts[i] += tree->event_parts[e];
            holes[i] += tree->event_holes[e];
        }
    }
    for (int g = 0; g < space->n_gaps; g++)
        if (space->gap_contact[g] == k && space->gap_value[g] > bins->t[end - 1])
            holes[first_below(bins, space->gap_value[g])]--;
    vh_int n_parts = 0, n_holes = 0;
    for (int i = 0; i < end; i++) {
        parts[i] = n_parts += parts[i];
        holes[i] = n_holes += holes[i];
    }
}

/* Write the bin of each of n values; by itself, so that it runs in vectors. */
static void find_bins(const struct bins *bins, const vh_real *restrict values, int n, int32_t *restrict at)
{
    const vh_real top = bins->t[0], scale = bins->scale, last = bins->last;
    for (int i = 0; i < n; i++) {
        const vh_real b = (top - values[i]) * scale, below = b > 0.0 ? b : 0.0;
        at[i] = (int32_t)(below < last ? below : last);
    }
}

/*
 * Write the thresholds at which a window's taxels come in: those of contact k, and no others. Those of the others are
 * found too, and left out: no branch for the processor to guess.
 */
static void find_entries(const struct vh_frame *task, const struct vh_window *w, const struct bins *bins, int k, int32_t *enters)
{
    const int n = w->right - w->left + 1;
    for (int r = w->top; r <= w->bottom; r++) {
        const size_t first = (size_t)r * w->width + w->left;
        const vh_real *v = w->v + first;
        const int32_t *label = task->label + first;
        int32_t *at = enters + first;
        find_bins(bins, v, n, at);
        for (int c = 0; c < n; c++) {
            /* No threshold reaches infinity: of another's taxel, which may be -inf, none behind the last is looked at. */
            const vh_real value = label[c] == k ? v[c] : INFINITY;
            const int entry = vh_min(w->end, first_in_bin(bins, at[c], value));
            at[c] = label[c] == k ? entry : w->end;
        }
    }
}

/* Add up a window's cells. */
static void add_up(const struct vh_window *w, const struct space *space, int has_gaps)
{
    const struct vh_sums *sums = &space->sums;
    const int end = w->end;
    for (int j = 0; j < VH_N_SUMS; j++)
        memset(sums->sum[j], 0, ((size_t)end + VH_LANES) * sizeof(vh_real));
    memset(sums->whole, 0, ((size_t)end + 1) * sizeof *sums->whole);
    vh_real *support = space->support[0];
    for (size_t i = 0; i < 2 * VH_N_DIRECTIONS * (size_t)end; i++)
        support[i] = -INFINITY;
    vh_add_cells(w, sums);
    if (has_gaps)
        vh_add_border_cells(w, sums, space->support);
    vh_add_supports(w, space->support, space->reach, space->earliest);
    vh_real whole[VH_N_WHOLE] = {0.0};
    for (int i = 0; i < end; i++) {
        for (int j = 0; j < VH_N_WHOLE; j++) {
            whole[j] += sums->whole[i][j];
            sums->sum[j][i] += whole[j];
        }
    }
}

/*
 * Write the measures of the levels from .. stop - 1 from their sums around (x, y), whatever they are: those of a level
 * without a section are to be written again. By themselves, so that they run in vectors.
 */
static void write_moments(
    vh_real *restrict measures, int n, int from, int stop, const struct vh_sums *sums, vh_real x, vh_real y)
{
    const vh_real *restrict area = sums->sum[VH_S_AREA], *restrict sx = sums->sum[VH_S_X], *restrict sy = sums->sum[VH_S_Y];
    const vh_real *restrict xx = sums->sum[VH_S_XX], *restrict xy = sums->sum[VH_S_XY], *restrict yy = sums->sum[VH_S_YY];
    vh_real *restrict centroid = measures + VH_CENTROID * n, *restrict covariance = measures + VH_COVARIANCE * n;
    memcpy(measures + VH_AREA * n + from, area + from, (size_t)(stop - from) * sizeof *area);
    memcpy(measures + VH_PERIMETER * n + from, sums->sum[VH_S_LENGTH] + from, (size_t)(stop - from) * sizeof *area);
    for (int i = from; i < stop; i++) {
        const vh_real over = 1.0 / area[i], mx = sx[i] * over, my = sy[i] * over, mixed = xy[i] * over - mx * my;
        centroid[2 * i] = x + mx;
        centroid[2 * i + 1] = y + my;
        covariance[4 * i] = xx[i] * over - mx * mx;
        covariance[4 * i + 1] = mixed;
        covariance[4 * i + 2] = mixed;
        covariance[4 * i + 3] = yy[i] * over - my * my;
    }
}

static void write_widths(
    vh_real *restrict extent, int from, int stop, const vh_real (*restrict support)[2 * VH_N_DIRECTIONS])
{
    for (int i = from; i < stop; i++) {
        VH_SIDE_BY_SIDE
        for (int d = 0; d < VH_N_DIRECTIONS; d++)
            extent[VH_N_DIRECTIONS * i + d] = support[i][d] + support[i][d + VH_N_DIRECTIONS];
    }
}

/* Write the measures of levels that have no section: nothing above the peak, unknown below the contact's end. */
static void write_nothing(vh_real *measures, int n, int from, int stop, vh_real size)
{
    for (int i = from; i < stop; i++)
        measures[VH_AREA * n + i] = measures[VH_PERIMETER * n + i] = size;
    for (int i = 2 * from; i < 2 * stop; i++)
        measures[VH_CENTROID * n + i] = NAN;
    for (int i = 4 * from; i < 4 * stop; i++)
        measures[VH_COVARIANCE * n + i] = NAN;
    for (int i = VH_N_DIRECTIONS * from; i < VH_N_DIRECTIONS * stop; i++)
        measures[VH_EXTENT * n + i] = size;
}

/* Write the measures of the levels from the first on that has a section, up to the contact's end, and of the others. */
static void write_measures(
    vh_real *measures, int n, int end, const vh_int *parts, const struct space *space, vh_real x, vh_real y)
{
    const vh_real *area = space->sums.sum[VH_S_AREA];
    int from = 0;
    while (from < end && !(parts[from] > 0 && area[from] > 0.0))
        from++;
    write_nothing(measures, n, 0, from, 0.0);
    write_moments(measures, n, from, end, &space->sums, x, y);
    write_widths(measures + VH_EXTENT * n, from, end, (const vh_real(*)[2 * VH_N_DIRECTIONS])space->support);
    for (int i = from; i < end; i++)
        if (!(parts[i] > 0 && area[i] > 0.0))
            write_nothing(measures, n, i, i + 1, 0.0);
    write_nothing(measures, n, end, n, NAN);
}

static void measure_contact(
    struct vh_frame *task, const struct vh_tree *tree, const struct space *space, const struct bins *bins, int k)
{
    const int n = task->n_levels, width = task->cols + 2, height = task->rows + 2;
    vh_int *place = task->places + (size_t)k * VH_N_PLACES, *parts = task->counts + 2 * (size_t)k * n;
    vh_real *measures = task->measures + (size_t)k * VH_N_COLUMNS * n;
    const vh_real x = space->xs[place[VH_PEAK_COL]], y = space->ys[place[VH_PEAK_ROW]];
    int end = n;
    while (task->thresholds && end > 0 && bins->t[end - 1] < tree->ends[k])
        end--;
    place[VH_N_MEASURED] = end;
    memset(parts, 0, 2 * (size_t)n * sizeof *parts);
    memcpy(measures, bins->t, (size_t)n * sizeof *measures);
    if (end > 0) {
        const struct vh_window w = {
            .v = task->padded, .enters = space->enters, .width = width, .height = height,
            .top = (int)place[VH_TOP] - 1, .bottom = (int)place[VH_BOTTOM] + 1,
            .left = (int)place[VH_LEFT] - 1, .right = (int)place[VH_RIGHT] + 1,
            .xs = space->xs, .ys = space->ys, .x = x, .y = y, .t = bins->t, .end = end,
        };
        count(tree, space, bins, k, end, tree->ends[k], parts, parts + n);
        find_entries(task, &w, bins, k, space->enters);
        vh_fetch(measures, VH_N_COLUMNS * (size_t)n);
        add_up(&w, space, task->has_gaps);
    }
    write_measures(measures, n, end, parts, space, x, y);
}

void vh_measure(struct vh_frame *task, const struct vh_tree *tree, const vh_real *levels, void *work)
{
    const int n = task->n_levels, width = task->cols + 2, height = task->rows + 2;
    struct space space;
    divide(work, task->rows, task->cols, n, &space);
    struct bins bins = {.t = space.t, .n = n, .begin = space.begin};
    find_places(task, tree);
    list_events(task, tree, &space);
    vh_positions(task->cols, task->col_pitch, space.xs);
    vh_positions(task->rows, task->row_pitch, space.ys);
    space.n_gaps = 0;
    /* Without gaps the rim's cells, half a taxel wide, are cells like the others. */
    if (task->has_gaps)
        space.n_gaps = vh_gap_events(
            task->padded, width, height, task->label, space.gap_contact, space.gap_value, space.sums.sum[0]);
    else
        vh_fill_rim(task->padded, task->label, width, height);
    for (int i = 0; i < VH_LANES; i++)
        space.t[n + i] = -INFINITY;
    for (int i = 0; task->thresholds && i < n; i++)
        space.t[i] = levels[i];
    for (int k = 0; k < tree->n_contacts; k++) {
        const vh_real peak = task->padded[tree->peak_at[k]], step = (peak - tree->ends[k]) / n;
        for (int i = 0; !task->thresholds && i < n; i++)
            space.t[i] = peak - (i + 0.5) * step;
        if (k == 0 || !task->thresholds)
            lay_out(&bins);
        measure_contact(task, tree, &space, &bins, k);
    }
    vh_order(task, space.key, space.other);
}

void vh_measure_section(struct vh_frame *task, const struct vh_tree *tree, vh_real level, void *work)
{
    const int width = task->cols + 2, height = task->rows + 2, size = width * height;
    struct space space;
    int64_t n_parts = 0, n_holes = 0;
    divide(work, task->rows, task->cols, 1, &space);
    struct bins bins = {.t = space.t, .n = 1, .begin = space.begin};
    vh_positions(task->cols, task->col_pitch, space.xs);
    vh_positions(task->rows, task->row_pitch, space.ys);
    for (int e = 0; e < tree->n_events; e++) {
        n_parts += tree->event_parts[e];
        n_holes += tree->event_holes[e];
    }
    for (int p = 0; p < size; p++)
        task->label[p] = task->padded[p] > level ? 0 : -1;
    if (task->has_gaps) {
        const int n = vh_gap_events(
            task->padded, width, height, task->label, space.gap_contact, space.gap_value, space.sums.sum[0]);
        for (int g = 0; g < n; g++)
            n_holes -= space.gap_value[g] > level;
    } else {
        vh_fill_rim(task->padded, task->label, width, height);
    }
    space.t[0] = level;
    for (int i = 0; i < VH_LANES; i++)
        space.t[1 + i] = -INFINITY;
    lay_out(&bins);
    const struct vh_window w = {
        .v = task->padded, .enters = space.enters, .width = width, .height = height, .bottom = height - 1,
        .right = width - 1, .xs = space.xs, .ys = space.ys, .t = space.t, .end = 1,
    };
    find_entries(task, &w, &bins, 0, space.enters);
    add_up(&w, &space, task->has_gaps);
    task->counts[0] = (vh_int)n_parts;
    task->counts[1] = (vh_int)n_holes;
    task->measures[VH_THRESHOLD] = level;
    write_measures(task->measures, 1, 1, task->counts, &space, 0.0, 0.0);
}
