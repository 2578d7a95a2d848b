/*
 * Which taxels hang together at which threshold: the merge tree of superlevel sets, and contacts cut from it.
 *
 * As the threshold falls, the section {V > theta} changes its topology only at critical points: a maximum opens a part, a
 * saddle joins two parts or closes a ring around a hole, a minimum fills a hole. A taxel is critical or not by its eight
 * neighbours alone (how many pieces of its neighbourhood stand above it), so only those few are sorted and joined, in
 * falling order, by union-find.
 *
 * Two taxels hang together along a row or a column, and along a diagonal where marching squares joins the two corners of
 * a saddle cell: where the mean of the cell's four values is above the threshold. Equal values are ordered by their
 * index, so a plateau is a maximum once.
 *
 * Frames here are padded by one taxel on every side; -inf is where there is no taxel.
 */
#include "inner.h"

#define MINIMUM (-1)

/* What a peak's contact is as the threshold falls: whole; ended; or split, and going on as the stem of both. */
enum { WHOLE, FINISHED, SPLIT };

/*
 * What a pattern of higher neighbours says as far as it can without their values. Its bits are left, up, right, down,
 * then the diagonals after each of them.
 */
struct neighbourhood {
    /* The number of pieces above, or MINIMUM; and of cells wholly above. */
    int pieces, around;
    /* Saddle cells whose mean must be asked: 0 to 3 those whose sides are above, 4 to 7 whose diagonal alone is. */
    int ask;
    /* A higher neighbour to climb to: 1 to 4 in the same order, the two with a lower index first; 0 for none. */
    int climb;
};

/* Of four bits: how many are set, and the number of the first. */
static const uint8_t n_bits[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
static const uint8_t first_bit[16] = {0, 1, 2, 1, 3, 1, 2, 1, 4, 1, 2, 1, 3, 1, 2, 1};

static struct neighbourhood read_pattern(int pattern)
{
    const int side = pattern & 15, diagonal = pattern >> 4, next = (side >> 1) | (side & 1) << 3;
    const int both = side & next, above = both & diagonal, alone = diagonal & ~side & ~next & 15;
    struct neighbourhood found;
    found.pieces = above == 15 ? MINIMUM : n_bits[side] - n_bits[above];
    found.around = n_bits[above];
    found.ask = (both & ~above) | alone << 4;
    found.climb = first_bit[side];
    return found;
}

static int root_of(int32_t *parent, int p)
{
    while (parent[p] != p) {
        parent[p] = parent[parent[p]];
        p = parent[p];
    }
    return p;
}

/* The two sides, the diagonal and the first corner of the j-th cell around p, clockwise from left. */
struct around {
    int one, two, diagonal, corner;
};

static struct around cell_at(int p, int width, int j)
{
    switch (j) {
    case 0:
        return (struct around){p - 1, p - width, p - width - 1, p - width - 1};
    case 1:
        return (struct around){p - width, p + 1, p - width + 1, p - width};
    case 2:
        return (struct around){p + 1, p + width, p + width + 1, p};
    default:
        return (struct around){p + width, p - 1, p + width - 1, p - 1};
    }
}

/* Four times the mean of a cell, always summed in one order. */
static vh_real cell_sum(const vh_real *v, int corner, int width)
{
    return (v[corner] + v[corner + 1]) + (v[corner + width] + v[corner + width + 1]);
}

static int higher(const vh_real *v, int q, int p) { return v[q] > v[p] || (v[q] == v[p] && q < p); }

/* Whether p hangs together with the higher diagonal of a cell whose other two corners are lower. */
static int joins_diagonally(const vh_real *v, int p, const struct around *cell, int width)
{
    if (cell_sum(v, cell->corner, width) > 4.0 * v[p])
        return 1;
    /* Across the corner that a cell lacks runs a triangle's side. */
    return (v[cell->one] == VH_NOTHING) != (v[cell->two] == VH_NOTHING);
}

/* Write which neighbours of n taxels are higher; of equal values the one before is. By itself: it runs in vectors. */
static void write_patterns(const vh_real *here, int width, int n, int64_t *patterns)
{
    const vh_real *up = here - width, *down = here + width;
    for (int c = 0; c < n; c++) {
        const vh_real u = here[c];
        int64_t pattern = here[c - 1] >= u ? 1 : 0;
        pattern |= up[c] >= u ? 2 : 0;
        pattern |= here[c + 1] > u ? 4 : 0;
        pattern |= down[c] > u ? 8 : 0;
        pattern |= up[c - 1] >= u ? 16 : 0;
        pattern |= up[c + 1] >= u ? 32 : 0;
        pattern |= down[c + 1] > u ? 64 : 0;
        pattern |= down[c - 1] > u ? 128 : 0;
        patterns[c] = pattern;
    }
}

/* Critical taxels, and saddle cells whose diagonal joins at the cell's mean. */
struct critical {
    int32_t *parent;
    int32_t *at;
    int8_t *kind;
    int32_t *joint_at, *joint_to;
    vh_real *joint_value;
    int n, n_joints;
};

/* Ask the saddle cells around p, and note where a diagonal joins later. */
static void ask_cells(
    const vh_real *v, int width, int p, vh_real floor, struct neighbourhood *seen, int *above, struct critical *found)
{
    for (int j = 0; j < 4; j++) {
        if (!(seen->ask >> j & 17))
            continue;
        const struct around cell = cell_at(p, width, j);
        if (seen->ask >> j & 1) {
            if (v[cell.diagonal] == VH_NOTHING || cell_sum(v, cell.corner, width) > 4.0 * v[p]) {
                seen->around++;
                seen->pieces--;
            }
        } else if (joins_diagonally(v, p, &cell, width)) {
            seen->pieces++;
            if (*above == p)
                *above = cell.diagonal;
        } else {
            const vh_real sum = cell_sum(v, cell.corner, width);
            if (sum > 4.0 * vh_most(v[cell.one], v[cell.two]) && sum > 4.0 * floor) {
                found->joint_at[found->n_joints] = p;
                found->joint_to[found->n_joints] = cell.diagonal;
                found->joint_value[found->n_joints++] = 0.25 * sum;
            }
        }
    }
    if (seen->around == 4)
        seen->pieces = MINIMUM;
}

/* Find the critical taxels above the floor and point every other one at a higher neighbour. */
static void classify(const vh_real *v, int width, int height, vh_real floor, struct critical *found, int64_t *patterns)
{
    const int step[5] = {0, -1, -width, 1, width};
    for (int r = 1; r < height - 1; r++) {
        int first = r * width + 1, stop = (r + 1) * width - 1;
        while (first < stop && !(v[first] > floor))
            first++;
        while (first < stop && !(v[stop - 1] > floor))
            stop--;
        write_patterns(v + first, width, stop - first, patterns);
        for (int p = first; p < stop; p++) {
            if (!(v[p] > floor))
                continue;
            struct neighbourhood seen = read_pattern((int)patterns[p - first]);
            int above = p + step[seen.climb];
            if (seen.ask)
                ask_cells(v, width, p, floor, &seen, &above, found);
            found->parent[p] = above < p ? found->parent[above] : above;
            if (seen.pieces != 1) {
                found->at[found->n] = p;
                found->kind[found->n++] = (int8_t)seen.pieces;
            }
        }
    }
}

/* Peaks: which hang together, and the peak whose contact a peak belongs to, -1 for none. */
struct peaks {
    vh_real *height, *ends;
    int32_t *summit, *group, *owner;
    int8_t *state;
    int n;
    vh_real noise;
};

/* Whether two peaks are two contacts: the saddle lies well below the lower, and the noise does not make it. */
static int is_split(const struct peaks *peaks, int lower, vh_real saddle)
{
    return saddle < VH_SPLIT_RATIO * peaks->height[lower] && peaks->height[lower] - saddle > peaks->noise;
}

/* Join the parts of two peaks at a saddle and return the peak that stays. */
static int join(struct peaks *peaks, int x, int y, vh_real saddle)
{
    if (peaks->height[y] > peaks->height[x] || (peaks->height[y] == peaks->height[x] && y < x)) {
        const int lower = x;
        x = y;
        y = lower;
    }
    peaks->group[y] = x;
    if (peaks->state[x] == WHOLE && peaks->state[y] == WHOLE) {
        if (is_split(peaks, y, saddle)) {
            peaks->ends[x] = peaks->ends[y] = saddle;
            peaks->state[x] = SPLIT;
            peaks->state[y] = FINISHED;
        } else {
            peaks->owner[y] = x;
        }
    } else if (peaks->state[x] == WHOLE || peaks->state[y] == WHOLE) {
        const int whole = peaks->state[x] == WHOLE ? x : y;
        if (is_split(peaks, whole, saddle))
            peaks->ends[whole] = saddle;
        else
            /* A bump on the skirt of contacts that have ended above it belongs to none of them. */
            peaks->owner[whole] = -1;
        peaks->state[whole] = FINISHED;
        peaks->state[x] = SPLIT;
    }
    return x;
}

/* Write a taxel of each piece above the saddle p, and return how many. */
static int pieces_above(const vh_real *v, int width, int p, int around[4])
{
    int near = 0;
    for (int j = 0; j < 4; j++) {
        const struct around cell = cell_at(p, width, j);
        if (higher(v, cell.one, p))
            around[near++] = cell.one;
        else if (higher(v, cell.diagonal, p) && !higher(v, cell.two, p) && joins_diagonally(v, p, &cell, width))
            around[near++] = cell.diagonal;
    }
    return near;
}

/* Number the contacts in the order of their peaks' indices, and write which one each peak belongs to. */
static void number_contacts(const struct peaks *peaks, struct vh_tree *tree, int32_t *contact)
{
    tree->n_contacts = 0;
    for (int i = 0; i < peaks->n; i++)
        if (peaks->owner[i] == i)
            contact[i] = tree->n_contacts++;
    for (int i = 0; i < peaks->n; i++) {
        int j = i;
        while (j >= 0 && peaks->owner[j] != j)
            j = peaks->owner[j];
        if (j < 0) {
            contact[i] = -1;
        } else if (j == i) {
            tree->peak_at[contact[i]] = peaks->summit[i];
            tree->ends[contact[i]] = peaks->ends[i];
        } else {
            contact[i] = contact[j];
        }
    }
}

/* All that a merge tree needs room for. */
struct room {
    struct critical critical;
    struct peaks peaks;
    int32_t *number, *order, *other, *contact;
    int64_t *patterns;
};

/* So many peaks and events there can be at most: no two peaks are neighbours in a row, and a saddle cell joins once. */
static size_t most_peaks(int width, int height) { return (size_t)((width - 1) / 2) * (height - 2); }
static size_t most_joints(int width, int height) { return (size_t)(width - 1) * (height - 1); }

size_t vh_tree_room(int width, int height, struct vh_tree *tree, void *kept)
{
    const size_t n_peaks = most_peaks(width, height);
    const size_t n_events = (size_t)(width - 2) * (height - 2) + most_joints(width, height);
    size_t used = 0;
    tree->peak_at = vh_take(kept, &used, n_peaks, sizeof *tree->peak_at);
    tree->ends = vh_take(kept, &used, n_peaks, sizeof *tree->ends);
    tree->event_at = vh_take(kept, &used, n_events, sizeof *tree->event_at);
    tree->event_value = vh_take(kept, &used, n_events, sizeof *tree->event_value);
    tree->event_parts = vh_take(kept, &used, n_events, 1);
    tree->event_holes = vh_take(kept, &used, n_events, 1);
    return used;
}

static size_t divide(void *work, int width, int height, struct room *room)
{
    const size_t size = (size_t)width * height, inside = (size_t)(width - 2) * (height - 2);
    const size_t cells = most_joints(width, height), n_peaks = most_peaks(width, height);
    size_t used = 0;
    room->critical.parent = vh_take(work, &used, size, sizeof(int32_t));
    room->critical.kind = vh_take(work, &used, inside, 1);
    room->critical.joint_at = vh_take(work, &used, cells, sizeof(int32_t));
    room->critical.joint_to = vh_take(work, &used, cells, sizeof(int32_t));
    room->critical.joint_value = vh_take(work, &used, cells, sizeof(vh_real));
    room->critical.n = room->critical.n_joints = 0;
    room->peaks.height = vh_take(work, &used, n_peaks, sizeof(vh_real));
    room->peaks.ends = vh_take(work, &used, n_peaks, sizeof(vh_real));
    room->peaks.summit = vh_take(work, &used, n_peaks, sizeof(int32_t));
    room->peaks.group = vh_take(work, &used, n_peaks, sizeof(int32_t));
    room->peaks.owner = vh_take(work, &used, n_peaks, sizeof(int32_t));
    room->peaks.state = vh_take(work, &used, n_peaks, 1);
    room->contact = vh_take(work, &used, n_peaks, sizeof(int32_t));
    room->number = vh_take(work, &used, size, sizeof(int32_t));
    room->order = vh_take(work, &used, inside + cells, sizeof(int32_t));
    room->other = vh_take(work, &used, inside + cells, sizeof(int32_t));
    room->patterns = vh_take(work, &used, (size_t)width, sizeof(int64_t));
    return used;
}

size_t vh_merge_tree_work(int width, int height)
{
    struct room room;
    return divide(0, width, height, &room);
}

/* Write the events' places and values, open a part for each peak and close a hole for each minimum. */
static int begin_events(const vh_real *v, vh_real floor, struct room *room, struct vh_tree *tree)
{
    struct critical *found = &room->critical;
    struct peaks *peaks = &room->peaks;
    int n_saddles = 0;
    tree->n_events = found->n + found->n_joints;
    for (int e = 0; e < tree->n_events; e++) {
        const int kind = e < found->n ? found->kind[e] : 1, j = e - found->n;
        tree->event_at[e] = e < found->n ? found->at[e] : found->joint_at[j];
        tree->event_value[e] = e < found->n ? v[found->at[e]] : found->joint_value[j];
        tree->event_parts[e] = (int8_t)(kind == 0);
        tree->event_holes[e] = (int8_t)(kind == MINIMUM ? -1 : 0);
        if (kind == 0) {
            const int i = peaks->n++;
            room->number[found->at[e]] = i;
            peaks->height[i] = tree->event_value[e];
            peaks->summit[i] = tree->event_at[e];
            peaks->group[i] = peaks->owner[i] = i;
            peaks->state[i] = WHOLE;
            peaks->ends[i] = floor;
        } else if (kind != MINIMUM) {
            room->order[n_saddles++] = e;
        }
    }
    return n_saddles;
}

/* Put the peak of a piece among those that meet at a saddle, each once: whole ones first, then higher ones first. */
static int put_in(const struct peaks *peaks, int met[4], int n, int other)
{
    int at = n;
    for (int j = 0; j < n; j++)
        if (met[j] == other)
            return n;
    for (; at > 0; at--) {
        const int before = met[at - 1], whole = peaks->state[before] == WHOLE;
        if (whole == (peaks->state[other] == WHOLE) ? peaks->height[before] >= peaks->height[other] : whole)
            break;
        met[at] = before;
    }
    met[at] = other;
    return n + 1;
}

/* Join what meets at a saddle, or at a cell's mean, in an order that is the same however the frame is turned. */
static void join_event(const vh_real *v, int width, int e, struct room *room, struct vh_tree *tree)
{
    const struct critical *found = &room->critical;
    const int p = tree->event_at[e];
    int around[4], met[4], near = 2, links = 1, n = 0, top;
    if (e >= found->n) {
        around[0] = p;
        around[1] = found->joint_to[e - found->n];
    } else {
        links = found->kind[e] - 1;
        near = pieces_above(v, width, p, around);
    }
    for (int j = 0; j < near; j++) {
        const int other = root_of(room->peaks.group, room->number[root_of(found->parent, around[j])]);
        n = put_in(&room->peaks, met, n, other);
    }
    top = met[0];
    for (int j = 1; j < n; j++)
        top = join(&room->peaks, top, met[j], tree->event_value[e]);
    tree->event_parts[e] -= (int8_t)(n - 1);
    tree->event_holes[e] = (int8_t)(links + tree->event_parts[e]);
}

void vh_merge_tree(
    const vh_real *v, int width, int height, vh_real floor, vh_real noise, int32_t *label, struct vh_tree *tree, void *work)
{
    struct room room;
    divide(work, width, height, &room);
    /* Critical taxels are the first of the events already; joints follow them. */
    room.critical.at = tree->event_at;
    room.peaks.n = 0;
    room.peaks.noise = noise;
    for (int p = 0; p < width * height; p++)
        label[p] = -1;
    classify(v, width, height, floor, &room.critical, room.patterns);
    const int n_saddles = begin_events(v, floor, &room, tree);
    vh_sort_falling(tree->event_value, room.order, n_saddles, room.other);
    for (int s = 0; s < n_saddles; s++)
        join_event(v, width, room.order[s], &room, tree);
    number_contacts(&room.peaks, tree, room.contact);
    /* Backward: most taxels point at one behind them, which has found its root then. */
    for (int r = height - 2; r > 0; r--) {
        for (int p = (r + 1) * width - 2; p > r * width; p--) {
            if (!(v[p] > floor))
                continue;
            const int k = room.contact[room.number[root_of(room.critical.parent, p)]];
            if (k >= 0 && v[p] > tree->ends[k])
                label[p] = k;
        }
    }
}
