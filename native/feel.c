/* From a pad's readings to what touches it: all that a controller has to call. */
#include <string.h>

#include "touch.h"

/* In single precision the square of a larger reading is none. */
#define MOST_READ 1e18

/* Pieces of the work space; the last is used by each step in turn. */
struct room {
    vh_real *frame, *inputs, *probability;
    uint8_t *valid;
    void *shared;
    size_t bytes;
};

static struct room laid_out(const struct vh_pad *pad, struct vh_frame *task, void *work)
{
    size_t taxels = (size_t)pad->rows * (size_t)pad->cols, padded = (size_t)(pad->rows + 2) * (size_t)(pad->cols + 2);
    size_t most = (size_t)pad->contacts, levels = (size_t)pad->levels, used = 0, shared;
    struct room room;

    room.frame = vh_take(work, &used, taxels, sizeof(vh_real));
    room.valid = vh_take(work, &used, taxels, 1);
    task->padded = vh_take(work, &used, padded, sizeof(vh_real));
    task->label = vh_take(work, &used, padded, sizeof(int32_t));
    task->dead = vh_take(work, &used, taxels, 1);
    task->places = vh_take(work, &used, most * VH_N_PLACES, sizeof(vh_int));
    task->values = vh_take(work, &used, most * 2, sizeof(vh_real));
    task->measures = vh_take(work, &used, most * VH_N_COLUMNS * levels, sizeof(vh_real));
    task->counts = vh_take(work, &used, most * 2 * levels, sizeof(vh_int));
    task->order = vh_take(work, &used, most, sizeof(int32_t));
    room.inputs = vh_take(work, &used, (size_t)pad->parameters->inputs, sizeof(vh_real));
    room.probability = vh_take(work, &used, (size_t)pad->parameters->kinds, sizeof(vh_real));
    shared = vh_most_bytes(vh_contacts_work(pad->rows, pad->cols, pad->levels), vh_kind_logits_work(pad->parameters));
    room.shared = task->work = vh_take(work, &used, vh_most_bytes(shared, vh_undo_work(pad->rows, pad->cols)), 1);
    room.bytes = used;
    return room;
}

size_t vh_feel_work(const struct vh_pad *pad)
{
    struct vh_frame task;

    return laid_out(pad, &task, NULL).bytes;
}

const vh_real *vh_kind_probability(const struct vh_pad *pad, void *work)
{
    struct vh_frame task;

    return laid_out(pad, &task, work).probability;
}

static struct vh_contact contact_of(const struct vh_pad *pad, const struct vh_frame *task, int k)
{
    struct vh_contact contact;

    contact.padded = task->padded;
    contact.label = task->label;
    contact.place = task->places + k * VH_N_PLACES;
    contact.measures = task->measures + k * VH_N_COLUMNS * pad->levels;
    contact.counts = task->counts + 2 * k * pad->levels;
    contact.height = pad->rows + 2;
    contact.width = pad->cols + 2;
    contact.index = k;
    contact.levels = pad->levels;
    contact.row_pitch = task->row_pitch;
    contact.col_pitch = task->col_pitch;
    contact.peak = task->values[2 * k];
    contact.floor = task->values[2 * k + 1];
    contact.sigma = task->sigma;
    return contact;
}

static void say(const struct vh_pad *pad, const struct vh_frame *task, const struct room *room, int k,
                struct vh_touch *touch)
{
    struct vh_contact contact = contact_of(pad, task, k);
    int lowest = pad->levels - 1;
    const vh_real *area = contact.measures + VH_AREA * pad->levels;
    struct vh_hints hints = {{task->rest[0], task->rest[1], task->rest[2]}, NULL, 0};

    memset(touch, 0, sizeof *touch);
    while (lowest > 0 && !(area[lowest] > 0))
        lowest--;
    touch->area = area[lowest];
    touch->x = contact.measures[VH_CENTROID * pad->levels + 2 * lowest];
    touch->y = contact.measures[VH_CENTROID * pad->levels + 2 * lowest + 1];
    touch->peak = contact.peak;
    touch->answer.name = -1;
    memset(room->probability, 0, (size_t)pad->parameters->kinds * sizeof *room->probability);
    vh_recognize(&contact, pad->parameters, &hints, room->inputs, room->probability, &touch->answer, room->shared);
}

/* Writes which taxels work, where NaN is read from one that does not; returns how many do not, or -1 where a reading is
 * none of a sensor's. What is read where there is no taxel does not matter. */
static int broken(const struct vh_pad *pad, const vh_real *readings, uint8_t *valid)
{
    const uint8_t *field = pad->sensor ? pad->sensor->field : NULL;
    const int size = pad->rows * pad->cols;
    int n = 0;

    memset(valid, 1, (size_t)size);
    for (int i = 0; i < size; i++) {
        if (fabs(readings[i]) <= MOST_READ || (field && !field[i]))
            continue;
        if (readings[i] == readings[i])
            return -1;
        valid[i] = 0;
        n++;
    }
    return n;
}

int vh_feel(const struct vh_pad *pad, const vh_real *readings, struct vh_touch *touches, void *work)
{
    struct vh_frame task;
    struct room room;
    int n_broken;

    memset(&task, 0, sizeof task);
    room = laid_out(pad, &task, work);
    n_broken = broken(pad, readings, room.valid);
    if (n_broken < 0)
        return -1;
    task.frame = readings;
    task.valid = n_broken > 0 ? room.valid : NULL;
    if (pad->sensor) {
        vh_undo(pad->sensor, readings, pad->rows, pad->cols, room.frame, room.valid, room.shared);
        task.frame = room.frame;
        task.valid = room.valid;
        task.field = pad->sensor->field;
    }
    task.row_pitch = pad->row_pitch;
    task.col_pitch = pad->col_pitch;
    task.floor = task.timed_sigma = -1;
    task.rows = pad->rows;
    task.cols = pad->cols;
    task.n_levels = pad->levels;
    if (vh_find_contacts(&task) != VH_FINE)
        return -1;
    vh_keep_largest(&task, pad->contacts);
    vh_measure_contacts(&task);
    memset(room.probability, 0, (size_t)pad->parameters->kinds * sizeof *room.probability);
    /* The largest is the last: its probabilities stay. */
    for (int i = task.n_ordered - 1; i >= 0; i--)
        say(pad, &task, &room, task.order[i], &touches[i]);
    return task.n_ordered;
}
