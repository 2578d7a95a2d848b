/* A frame made fit, and its contacts found. */
#include "inner.h"

/* A controller's pads are too small for a rest that curves. */
#ifdef VH_SMALL
#define UNBEND(flat, usable, rows, cols, sigma, rest, work) 0
#define UNBEND_WORK(rows, cols) 0
#else
#define UNBEND vh_unbend
#define UNBEND_WORK vh_unbend_work
#endif

/* The work space of both calls: what the first leaves to the second, and what each uses in turn. */
struct space {
    vh_real *levels;
    uint8_t *inside, *usable, *broken, *face;
    void *kept, *scratch;
};

static size_t divide(void *work, int rows, int cols, int n_levels, struct space *space)
{
    struct vh_tree tree;
    size_t used = 0, scratch;
    space->levels = vh_take(work, &used, (size_t)n_levels + 1, sizeof(vh_real));
    space->kept = vh_take(work, &used, vh_tree_room(cols + 2, rows + 2, &tree, 0), 1);
    space->face = vh_take(work, &used, (size_t)(cols + 2) * (rows + 2), 1);
    /* All that follows is used by one at a time, but for the masks, which the contacts no longer need. */
    space->scratch = work ? (char *)work + used : 0;
    const size_t masks = 3 * ((size_t)rows * cols + 8);
    scratch = vh_most_bytes(vh_noise_sigma_work(rows, cols), vh_fill_work(rows, cols));
    scratch = vh_most_bytes(scratch, vh_most_bytes(vh_find_dead_work(rows, cols), vh_level_work(rows, cols)));
    scratch = vh_most_bytes(scratch, UNBEND_WORK(rows, cols));
    size_t prepared = scratch + masks + 8;
    space->inside = space->scratch ? (uint8_t *)space->scratch + scratch : 0;
    space->usable = space->scratch ? space->inside + (size_t)rows * cols : 0;
    space->broken = space->scratch ? space->usable + (size_t)rows * cols : 0;
    prepared = vh_most_bytes(prepared, vh_merge_tree_work(cols + 2, rows + 2));
    prepared = vh_most_bytes(prepared, vh_most_bytes(vh_keep_work(rows, cols), vh_faces_work(cols + 2, rows + 2)));
    return used + vh_most_bytes(prepared, vh_measure_work(rows, cols, n_levels));
}

size_t vh_contacts_work(int rows, int cols, int n_levels)
{
    struct space space;
    return divide(0, rows, cols, n_levels, &space);
}

/* Copy thresholds that fall, or rise, as falling ones; 0 if they do neither or are not finite. */
static int take_thresholds(const vh_real *thresholds, int n, vh_real *levels)
{
    int falls = 1, rises = 1;
    if (n < 1)
        return 1;
    for (int i = 0; i + 1 < n; i++) {
        falls &= thresholds[i] >= thresholds[i + 1];
        rises &= thresholds[i] <= thresholds[i + 1];
    }
    for (int i = 0; i < n; i++)
        levels[i] = thresholds[falls ? i : n - 1 - i];
    return (falls || rises) && isfinite(levels[0]) && isfinite(levels[n - 1]);
}

/* Rounding lifts a taxel, or a few, by one count of the sensor. */
#define ROUNDED 1.500001

/* Fill what is marked besides in `broken` from its neighbours. */
static void fill_broken(struct vh_frame *task, vh_real *flat, const struct space *space, const uint8_t *broken)
{
    for (int i = 0; i < task->rows * task->cols; i++) {
        space->usable[i] &= broken[i] ^ 1;
        task->dead[i] |= broken[i];
    }
    vh_fill(flat, space->usable, space->inside, task->rows, task->cols, space->scratch);
}

/*
 * Fill dead and hot taxels and take off a rest, in place; where something was done the noise and the peak are found
 * again. What is hot stands above the rest, which is taken off first.
 */
static void mend(struct vh_frame *task, vh_real *flat, const struct space *space, vh_real *peak)
{
    const int rows = task->rows, cols = task->cols, size = rows * cols;
    uint8_t *usable = space->usable, *broken = space->broken;
    const int n_dead = vh_find_dead(flat, usable, rows, cols, task->sigma, broken, space->scratch);
    if (n_dead)
        fill_broken(task, flat, space, broken);
    const int levelled = vh_level(flat, usable, rows, cols, task->sigma, task->rest, space->scratch) ||
                         UNBEND(flat, usable, rows, cols, task->sigma, task->rest, space->scratch);
    const int n_hot = vh_find_hot(flat, usable, rows, cols, task->sigma, broken);
    if (n_hot)
        fill_broken(task, flat, space, broken);
    if (!n_dead && !levelled && !n_hot)
        return;
    task->sigma = vh_noise_sigma(flat, usable, rows, cols, space->scratch);
    *peak = 0.0;
    for (int i = 0; i < size; i++)
        *peak = vh_most(*peak, flat[i]);
}

enum vh_fault vh_find_contacts(struct vh_frame *task)
{
    const int rows = task->rows, cols = task->cols, even = task->thresholds == 0;
    struct space space;
    struct vh_checked found;
    struct vh_tree tree;
    vh_real floor = task->floor;
    divide(task->work, rows, cols, task->n_levels, &space);
    task->sigma = NAN;
    task->reach = task->rest[0] = task->rest[1] = task->rest[2] = 0.0;
    task->n_contacts = task->n_ordered = task->n_events = 0;
    memset(task->dead, 0, (size_t)rows * cols);
    vh_real *flat = task->padded;
    const enum vh_fault fault = vh_check_frame(
        task->frame, task->field, task->valid, (size_t)rows * cols, flat, space.inside, space.usable, &found);
    if (fault != VH_FINE)
        return fault;
    if (!even && !take_thresholds(task->thresholds, task->n_levels, space.levels))
        return VH_UNORDERED;
    task->has_gaps = found.n_inside < rows * cols;
    if (floor < 0.0)
        task->sigma = vh_noise_sigma(flat, space.usable, rows, cols, space.scratch);
    if (found.n_usable < found.n_inside)
        vh_fill(flat, space.usable, space.inside, rows, cols, space.scratch);
    if (floor < 0.0) {
        /* Thresholds in the frame's own unit speak of the frame as it is. */
        if (even)
            mend(task, flat, &space, &found.peak);
        task->reach = vh_noise_reach(vh_most(task->sigma, task->timed_sigma), found.n_usable);
        const vh_real count = vh_count_of(flat, space.usable, rows, cols, task->reach / ROUNDED);
        task->reach = vh_most(task->reach, ROUNDED * count);
        floor = task->timed_sigma < 0.0 ? vh_default_floor(task->sigma, found.peak)
                                        : vh_timed_floor(task->timed_sigma, found.peak);
    }
    vh_add_rim(task->padded, rows, cols);
    vh_tree_room(cols + 2, rows + 2, &tree, space.kept);
    /* Of whole counts some may be just so high as a floor that is a share of the peak: they are not above it. */
    const vh_real clear = task->floor < 0.0 ? floor * (1.0 + VH_SAME) : floor;
    vh_merge_tree(task->padded, cols + 2, rows + 2, clear, task->reach, 0, task->label, &tree, space.scratch);
    if (tree.n_contacts > 1 && vh_find_faces(task->padded, cols + 2, rows + 2, clear, &tree, space.face, space.scratch))
        vh_merge_tree(task->padded, cols + 2, rows + 2, clear, task->reach, space.face, task->label, &tree, space.scratch);
    for (int k = 0; k < tree.n_contacts; k++)
        tree.ends[k] = tree.ends[k] == clear ? floor : tree.ends[k];
    task->n_contacts = tree.n_contacts;
    task->n_events = tree.n_events;
    return VH_FINE;
}

void vh_keep_largest(struct vh_frame *task, int most)
{
    struct space space;
    struct vh_tree tree;
    if (task->n_contacts <= most)
        return;
    divide(task->work, task->rows, task->cols, task->n_levels, &space);
    vh_tree_room(task->cols + 2, task->rows + 2, &tree, space.kept);
    tree.n_contacts = task->n_contacts;
    vh_keep(task, &tree, most, space.scratch);
}

void vh_measure_contacts(struct vh_frame *task)
{
    struct space space;
    struct vh_tree tree;
    divide(task->work, task->rows, task->cols, task->n_levels, &space);
    vh_tree_room(task->cols + 2, task->rows + 2, &tree, space.kept);
    tree.n_contacts = task->n_contacts;
    tree.n_events = task->n_events;
    vh_measure(task, &tree, space.levels, space.scratch);
}

enum vh_fault vh_contacts(
    struct vh_frame *task, const vh_real *frame, const vh_real *thresholds, vh_real *numbers, int room, void *work)
{
    const size_t taxels = (size_t)task->rows * task->cols, padded = (size_t)(task->rows + 2) * (task->cols + 2);
    const size_t levels = (size_t)task->n_levels, most = (size_t)room;
    task->frame = frame;
    task->thresholds = thresholds;
    task->work = work;
    task->padded = numbers;
    task->label = (int32_t *)(numbers + padded);
    task->dead = (uint8_t *)(task->label + padded);
    task->values = numbers + padded + (padded * sizeof(int32_t) + taxels + sizeof *numbers - 1) / sizeof *numbers;
    task->measures = task->values + 2 * most;
    task->counts = (vh_int *)(task->measures + VH_N_COLUMNS * levels * most);
    task->places = task->counts + 2 * levels * most;
    const enum vh_fault fault = vh_find_contacts(task);
    if (fault == VH_FINE && task->n_contacts > 0 && task->n_contacts <= room)
        vh_measure_contacts(task);
    return fault;
}

void vh_measure_whole(struct vh_frame *task)
{
    const int rows = task->rows, cols = task->cols;
    const vh_real level = task->thresholds[0];
    struct space space;
    struct vh_checked found;
    struct vh_tree tree;
    divide(task->work, rows, cols, 1, &space);
    vh_check_frame(task->frame, task->field, task->valid, (size_t)rows * cols, task->padded, space.inside, space.usable, &found);
    task->has_gaps = found.n_inside < rows * cols;
    vh_add_rim(task->padded, rows, cols);
    vh_tree_room(cols + 2, rows + 2, &tree, space.kept);
    vh_merge_tree(task->padded, cols + 2, rows + 2, level, 0.0, 0, task->label, &tree, space.scratch);
    vh_measure_section(task, &tree, level, space.scratch);
}
