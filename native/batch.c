/* Many frames of one pad, one after the other. */
#include "inner.h"

static void swap_bytes(void *one, void *other, size_t n)
{
    uint8_t *restrict a = one, *restrict b = other;
    for (size_t i = 0; i < n; i++) {
        const uint8_t kept = a[i];
        a[i] = b[i];
        b[i] = kept;
    }
}

static void swap_contacts(struct vh_frame *task, int i, int j)
{
    const size_t n = (size_t)task->n_levels;
    const size_t places = VH_N_PLACES, measures = VH_N_COLUMNS * n, counts = 2 * n;
    swap_bytes(task->places + i * places, task->places + j * places, places * sizeof *task->places);
    swap_bytes(task->values + 2 * i, task->values + 2 * j, 2 * sizeof *task->values);
    swap_bytes(task->measures + i * measures, task->measures + j * measures, measures * sizeof *task->measures);
    swap_bytes(task->counts + i * counts, task->counts + j * counts, counts * sizeof *task->counts);
}

/* Put a frame's contacts in their order; what stands behind n_ordered belongs to nothing. */
static void put_in_order(struct vh_frame *task)
{
    for (int i = 0; i < task->n_ordered; i++) {
        /* Where a contact stood whose place was taken, it has gone to the place of the one that took it. */
        int at = task->order[i];
        while (at < i)
            at = task->order[at];
        if (at != i)
            swap_contacts(task, i, at);
    }
}

/* Let the room for contacts begin behind those of a frame. */
static void go_on(struct vh_frame *task, int64_t n)
{
    const size_t levels = (size_t)task->n_levels;
    task->places += (size_t)n * VH_N_PLACES;
    task->values += 2 * n;
    task->measures += (size_t)n * VH_N_COLUMNS * levels;
    task->counts += 2 * (size_t)n * levels;
}

int64_t vh_measure_frames(struct vh_batch *batch)
{
    struct vh_frame task = *batch->task;
    const size_t size = (size_t)task.rows * task.cols;
    int64_t i = 0, room = batch->room;
    batch->fault = VH_FINE;
    for (; i < batch->n_frames; i++) {
        task.frame = batch->frames + (size_t)i * size;
        if (batch->thresholds)
            task.thresholds = batch->thresholds + (size_t)i * (size_t)task.n_levels;
        if (i + 1 < batch->n_frames)
            vh_fetch(task.frame + size, size);
        batch->fault = vh_find_contacts(&task);
        if (batch->fault != VH_FINE || task.n_contacts > room)
            break;
        if (task.n_contacts > 0) {
            vh_measure_contacts(&task);
            put_in_order(&task);
        }
        batch->n_found[i] = task.n_ordered;
        batch->sigma[i] = task.sigma;
        room -= task.n_ordered;
        go_on(&task, task.n_ordered);
    }
    batch->n_wanted = task.n_contacts;
    return i;
}
