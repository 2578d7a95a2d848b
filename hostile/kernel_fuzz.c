/*
 * Random frames, masks, thresholds and sizes through the kernel's entry points, every array and work space of just the
 * bytes that are asked for. Compiled with sanitizers it ends where one is left, or an operation has no meaning.
 *
 *     kernel_fuzz NUMBER SEED
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "varishold.h"

static uint64_t state;

static uint64_t draw(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

static int below(int n) { return (int)(draw() % (uint64_t)n); }

static double uniform(void) { return (double)(draw() >> 11) / 9007199254740992.0; }

/* Just so many bytes; at least one, so that every pointer is good. */
static void *room(size_t n)
{
    void *p = malloc(n ? n : 1);
    if (!p)
        exit(2);
    memset(p, 0xa5, n);
    return p;
}

/* A value such as sensors give, and such as none should. */
static double value(int kind)
{
    static const double strange[] = {0.0, -0.0, 1.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 1e-308, 5e-324};
    if (kind == 0)
        return uniform();
    if (kind == 1)
        return below(4);
    if (kind == 2)
        return (uniform() - 0.3) * pow(10.0, below(600) - 300);
    return below(3) ? uniform() : strange[below(10)];
}

static uint8_t *random_mask(int size)
{
    uint8_t *mask = room((size_t)size);
    const int share = 1 + below(10);
    for (int i = 0; i < size; i++)
        mask[i] = below(share) > 0;
    return mask;
}

static void fill_thresholds(double *thresholds, int n, int kind)
{
    double last = 2.0 * uniform();
    for (int i = 0; i < n; i++)
        thresholds[i] = kind == 3 ? value(3) : (last -= below(3) ? uniform() / n : 0.0);
}

static void try_outlines(const struct vh_frame *f, int index, const double *levels, int n_levels)
{
    const struct vh_cut cut = {f->padded + f->cols + 3, below(3) ? f->label + f->cols + 3 : 0, f->rows, f->cols,
                               f->cols + 2, index, (int)below(2), n_levels, levels, 1.0, 0.5};
    void *work = room(vh_outlines_work(&cut));
    int32_t *n_lines = room((size_t)n_levels * sizeof *n_lines);
    /* Less room than is wanted, then what is wanted. */
    int64_t n = below(50), wanted = n;
    do {
        n = wanted;
        double *points = room(2 * (size_t)n * sizeof *points);
        int32_t *stops = room((size_t)n / 2 * sizeof *stops);
        wanted = vh_outlines(&cut, points, stops, n_lines, n, work);
        int64_t lines = 0;
        for (int i = 0; i < n_levels; i++)
            lines += n_lines[i];
        if (wanted <= n && lines && stops[lines - 1] != wanted)
            abort();
        free(points);
        free(stops);
    } while (wanted > n);
    free(work);
    free(n_lines);
}

static void try_contacts(struct vh_frame *f)
{
    const size_t n = (size_t)f->n_contacts, levels = (size_t)f->n_levels;
    f->places = room(n * VH_N_PLACES * sizeof *f->places);
    f->values = room(2 * n * sizeof *f->values);
    f->measures = room(n * VH_N_COLUMNS * levels * sizeof *f->measures);
    f->counts = room(2 * n * levels * sizeof *f->counts);
    f->order = room(n * sizeof *f->order);
    vh_measure_contacts(f);
    double *signature = room(VH_SIGNATURE * sizeof *signature);
    for (int i = 0; i < f->n_ordered && i < 3; i++) {
        const int k = f->order[i];
        const struct vh_contact contact = {
            f->padded, f->label, f->places + (size_t)k * VH_N_PLACES, f->measures + k * VH_N_COLUMNS * levels,
            f->counts + 2 * k * levels, f->rows + 2, f->cols + 2, k, f->n_levels, f->row_pitch, f->col_pitch,
            f->values[2 * k], f->values[2 * k + 1], f->sigma};
        if (f->n_levels > 4)
            vh_signature(&contact, signature);
        const double cut_at[3] = {uniform(), uniform(), 0.0};
        try_outlines(f, k, cut_at, 1 + below(3));
    }
    free(signature);
    free(f->places);
    free(f->values);
    free(f->measures);
    free(f->counts);
    free(f->order);
}

/* The same frame some times over, with room for so many of its contacts as it happens. */
static void try_batch(struct vh_frame f)
{
    enum { MOST = 4 };
    const size_t size = (size_t)f.rows * (size_t)f.cols, levels = (size_t)f.n_levels;
    const int64_t n = 1 + below(MOST), free_rows = below(2 * MOST * (1 + f.n_contacts));
    double *frames = room((size_t)n * size * sizeof *frames), sigma[MOST];
    int32_t found[MOST];
    for (int64_t i = 0; i < n; i++)
        memcpy(frames + (size_t)i * size, f.frame, size * sizeof *frames);
    const size_t rows = (size_t)free_rows;
    f.places = room(rows * VH_N_PLACES * sizeof *f.places);
    f.values = room(2 * rows * sizeof *f.values);
    f.measures = room(rows * VH_N_COLUMNS * levels * sizeof *f.measures);
    f.counts = room(2 * rows * levels * sizeof *f.counts);
    f.order = room((size_t)f.n_contacts * sizeof *f.order);
    double *own = f.thresholds && below(2) ? room((size_t)n * levels * sizeof *own) : NULL;
    for (int64_t i = 0; own && i < n; i++)
        fill_thresholds(own + (size_t)i * levels, f.n_levels, below(4));
    struct vh_batch batch = {&f, frames, own, n, free_rows, found, sigma, VH_FINE, 0};
    const int64_t done = vh_measure_frames(&batch);
    if (done < n && batch.fault == VH_FINE && (done + 1) * f.n_contacts <= free_rows)
        abort();
    free(own);
    free(frames);
    free(f.places);
    free(f.values);
    free(f.measures);
    free(f.counts);
    free(f.order);
}

static void try_frame(void)
{
    const int rows = 1 + below(below(4) ? 20 : 70), cols = 1 + below(below(4) ? 20 : 70), size = rows * cols;
    const int kind = below(4), n_levels = 1 + below(40);
    double *frame = room((size_t)size * sizeof *frame), *thresholds = room((size_t)n_levels * sizeof *thresholds);
    uint8_t *field = below(2) ? random_mask(size) : 0, *valid = below(2) ? random_mask(size) : 0;
    for (int i = 0; i < size; i++)
        frame[i] = value(kind);
    fill_thresholds(thresholds, n_levels, kind);
    struct vh_frame f;
    memset(&f, 0, sizeof f);
    f.frame = frame;
    f.field = field;
    f.valid = valid;
    f.thresholds = below(2) ? thresholds : 0;
    f.row_pitch = 0.5;
    f.col_pitch = 1.0;
    f.floor = below(2) ? -1.0 : uniform();
    f.timed_sigma = below(3) ? -1.0 : 0.1 * uniform();
    f.rows = rows;
    f.cols = cols;
    f.n_levels = n_levels;
    f.padded = room((size_t)(rows + 2) * (cols + 2) * sizeof *f.padded);
    f.label = room((size_t)(rows + 2) * (cols + 2) * sizeof *f.label);
    f.dead = room((size_t)size);
    f.work = room(vh_contacts_work(rows, cols, n_levels));
    if (vh_find_contacts(&f) == VH_FINE) {
        try_contacts(&f);
        try_batch(f);
    }
    if (isfinite(thresholds[0]) && kind < 2) {
        double measures[VH_N_COLUMNS];
        vh_int counts[2];
        free(f.work);
        f.n_levels = 1;
        f.work = room(vh_contacts_work(rows, cols, 1));
        f.thresholds = thresholds;
        f.measures = measures;
        f.counts = counts;
        vh_measure_whole(&f);
    }
    free(frame);
    free(thresholds);
    free(field);
    free(valid);
    free(f.padded);
    free(f.label);
    free(f.dead);
    free(f.work);
}

/* What works on a frame in place, by itself. */
static void try_parts(void)
{
    const int rows = 1 + below(40), cols = 1 + below(40), size = rows * cols, kind = below(2);
    double *frame = room((size_t)size * sizeof *frame), rest[3];
    uint8_t *usable = random_mask(size), *field = random_mask(size), *dead = room((size_t)size);
    void *work = room(vh_noise_sigma_work(rows, cols));
    for (int i = 0; i < size; i++)
        frame[i] = value(kind) + (below(2) ? 0.1 * (i % cols) : 0.0);
    const double sigma = vh_noise_sigma(frame, usable, rows, cols, work);
    free(work);
    work = room(vh_find_dead_work(rows, cols));
    vh_find_dead(frame, usable, rows, cols, sigma, dead, work);
    free(work);
    vh_find_hot(frame, usable, rows, cols, sigma, dead);
    work = room(vh_level_work(rows, cols));
    vh_level(frame, usable, rows, cols, sigma, rest, work);
    free(work);
    work = room(vh_fill_work(rows, cols));
    vh_fill(frame, usable, field, rows, cols, work);
    free(work);
    free(frame);
    free(usable);
    free(field);
    free(dead);
}

int main(int argc, char **argv)
{
    const int number = argc > 1 ? atoi(argv[1]) : 10000, seed = argc > 2 ? atoi(argv[2]) : 0;
    for (int k = 0; k < number; k++) {
        state = 0x9e3779b97f4a7c15u * (uint64_t)(2 * (seed * 1000003LL + k) + 1);
        for (int i = 0; i < 8; i++)
            draw();
        try_frame();
        try_parts();
    }
    printf("%d frames: no fault\n", number);
    return 0;
}
