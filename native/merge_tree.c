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

/* What so many events later needs is brought near. */
#define AHEAD 8

/* A mean is above a taxel, of which this is four times, only clearly: whole counts that a sensor scales are often equal. */
#define FOUR (4.0 * (1.0 + VH_SAME))

/* What a peak's contact is as the threshold falls: whole; ended; or split, and going on as the stem of both. */
enum { WHOLE, FINISHED, SPLIT };

/* Of four bits: how many are set, and the number of the first. */
static const uint8_t n_bits[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
static const uint8_t first_bit[16] = {0, 1, 2, 1, 3, 1, 2, 1, 4, 1, 2, 1, 3, 1, 2, 1};

/*
 * What stands above a taxel around it, four bits each, of which the j-th stands for the j-th cell around it and that one's
 * first side: the pieces above, each at one side or at the diagonal that alone makes it (a cell has one of both); the
 * sides above; the cells whose higher diagonal alone is above, and hangs together with the taxel at its level, or not yet.
 * And whether the taxel is critical: there is not one piece.
 */
enum { PIECES = 0, SIDES = 4, JOINED = 8, APART = 12, CRITICAL = 16 };

static int bits_at(int pattern, int place) { return pattern >> place & 15; }

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

/*
 * Write the sums of the n cells from a corner on. A cell that lacks one corner hangs together across it, as a triangle
 * does: as if it were as high as can be.
 */
static void write_sums(const vh_real *restrict up, const vh_real *restrict down, int n, vh_real *restrict sums)
{
    for (int c = 0; c < n; c++) {
        const vh_real sum = (up[c] + up[c + 1]) + (down[c] + down[c + 1]);
        const int lacks_up = (up[c] == VH_NOTHING) + (up[c + 1] == VH_NOTHING);
        const int lacks_down = (down[c] == VH_NOTHING) + (down[c + 1] == VH_NOTHING);
        sums[c] = lacks_up + lacks_down == 1 ? INFINITY : sum;
    }
}

/* Tell what is above, from whether each side is higher, each diagonal after it, and the mean of the cell that they span. */
static inline vh_int pattern_of(vh_int side, vh_int diagonal, vh_int mean)
{
    const vh_int next = (side >> 1) | (side & 1) << 3;
    /* Two sides are one piece where their cell is wholly above, or its mean is. */
    const vh_int whole = side & next & (diagonal | mean), alone = diagonal & ~(side | next), joined = alone & mean;
    const vh_int pieces = (side & ~whole) | joined;
    const vh_int critical = pieces == 0 || (pieces & (pieces - 1)) != 0 ? 1 << CRITICAL : 0;
    return pieces | side << SIDES | joined << JOINED | (alone & ~mean) << APART | critical;
}

/*
 * Write the patterns of n taxels, of whose cells the sums are known: that of a taxel's upper left cell stands in its place
 * of `above`, that of its lower left one in `below`. Of equal values the one before is higher. By itself: it runs in
 * vectors.
 */
static void write_patterns(
    const vh_real *restrict here, int width, int n, const vh_real *restrict above, const vh_real *restrict below,
    vh_int *restrict patterns)
{
    const vh_real *up = here - width, *down = here + width;
    for (int c = 0; c < n; c++) {
        const vh_real u = here[c], four = FOUR * u;
        vh_int side = here[c - 1] >= u ? 1 : 0, diagonal = up[c - 1] >= u ? 1 : 0, mean = above[c] > four ? 1 : 0;
        side |= up[c] >= u ? 2 : 0;
        side |= here[c + 1] > u ? 4 : 0;
        side |= down[c] > u ? 8 : 0;
        diagonal |= up[c + 1] >= u ? 2 : 0;
        diagonal |= down[c + 1] > u ? 4 : 0;
        diagonal |= down[c - 1] > u ? 8 : 0;
        mean |= above[c + 1] > four ? 2 : 0;
        mean |= below[c + 1] > four ? 4 : 0;
        mean |= below[c] > four ? 8 : 0;
        patterns[c] = pattern_of(side, diagonal, mean);
    }
}

/* Critical taxels, and saddle cells whose diagonal joins at the cell's mean. */
struct critical {
    int32_t *parent;
    int32_t *at;
    /* Of each its pieces in the lower four bits, its sides above in the upper ones. */
    uint8_t *around;
    int32_t *joint_at, *joint_to;
    vh_real *joint_value;
    int n, n_joints;
};

/* The number of pieces above a critical taxel, or MINIMUM. */
static int kind_of(int around) { return around == 15 << 4 ? MINIMUM : n_bits[around & 15]; }

/* Note where the diagonals of cells around p that are apart join it later: at the cell's mean, above its other corners. */
static void note_joints(const vh_real *v, int width, int p, vh_real floor, int apart, struct critical *found)
{
    for (int j = 0; j < 4; j++) {
        if (!(apart >> j & 1))
            continue;
        const struct around cell = cell_at(p, width, j);
        const vh_real sum = cell_sum(v, cell.corner, width);
        if (sum > FOUR * vh_most(v[cell.one], v[cell.two]) && sum > FOUR * floor) {
            found->joint_at[found->n_joints] = p;
            found->joint_to[found->n_joints] = cell.diagonal;
            found->joint_value[found->n_joints++] = vh_least(0.25 * sum, v[p]);
        }
    }
}

/* Room for a row's patterns, for the taxels of it that are apart from a diagonal, and for the sums of the cells beside it. */
struct row_room {
    vh_int *patterns;
    int32_t *apart;
    vh_real *above, *below;
    /* Of each row, the first taxel above the floor and the one behind the last. */
    int32_t *first, *stop;
};

/* Find the critical taxels above the floor and point every other one at a higher neighbour. */
static void classify(const vh_real *v, int width, int height, vh_real floor, struct critical *found, struct row_room row)
{
    const int step[9] = {0, -1, -width, 1, width, -width - 1, -width + 1, width + 1, width - 1};
    int32_t *parent = found->parent;
    write_sums(v, v + width, width - 1, row.below);
    for (int r = 1; r < height - 1; r++) {
        int first = r * width + 1, stop = (r + 1) * width - 1, n_apart = 0, n = found->n;
        vh_real *const above = row.below;
        row.below = row.above;
        row.above = above;
        write_sums(v + r * width, v + (r + 1) * width, width - 1, row.below);
        while (first < stop && !(v[first] > floor))
            first++;
        while (first < stop && !(v[stop - 1] > floor))
            stop--;
        row.first[r] = first;
        row.stop[r] = stop;
        const int before = first - 1 - r * width;
        write_patterns(v + first, width, stop - first, row.above + before, row.below + before, row.patterns);
        for (int p = first; p < stop; p++) {
            if (!(v[p] > floor))
                continue;
            const int seen = (int)row.patterns[p - first], side = bits_at(seen, SIDES), joined = bits_at(seen, JOINED);
            const int climb = side ? first_bit[side] : joined ? 4 + first_bit[joined] : 0;
            const int higher = p + step[climb];
            parent[p] = higher < p ? parent[higher] : higher;
            /* Written always, and kept where it counts: no branch for the processor to guess. */
            found->at[n] = p;
            found->around[n] = (uint8_t)seen;
            n += seen >> CRITICAL;
            row.apart[n_apart] = p;
            n_apart += bits_at(seen, APART) != 0;
        }
        found->n = n;
        for (int i = 0; i < n_apart; i++) {
            const int p = row.apart[i];
            note_joints(v, width, p, floor, bits_at((int)row.patterns[p - first], APART), found);
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
    const uint8_t *whole;
};

/* Whether two peaks are two contacts: the saddle lies well below the lower, and neither noise nor a face's rim makes it. */
static int is_split(const struct peaks *peaks, int lower, vh_real saddle)
{
    return saddle < VH_SPLIT_RATIO * (1.0 - VH_SAME) * peaks->height[lower] &&
           peaks->height[lower] - saddle > peaks->noise && !(peaks->whole && peaks->whole[peaks->summit[lower]]);
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
static int pieces_above(int p, int width, int pieces, int around[4])
{
    int near = 0;
    for (int j = 0; j < 4; j++) {
        const struct around cell = cell_at(p, width, j);
        around[near] = pieces >> 4 >> j & 1 ? cell.one : cell.diagonal;
        near += pieces >> j & 1;
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
    struct row_room row;
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
    room->critical.around = vh_take(work, &used, inside, 1);
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
    room->row.patterns = vh_take(work, &used, (size_t)width, sizeof(vh_int));
    room->row.apart = vh_take(work, &used, (size_t)width, sizeof(int32_t));
    room->row.above = vh_take(work, &used, (size_t)width, sizeof(vh_real));
    room->row.below = vh_take(work, &used, (size_t)width, sizeof(vh_real));
    room->row.first = vh_take(work, &used, (size_t)height, sizeof(int32_t));
    room->row.stop = vh_take(work, &used, (size_t)height, sizeof(int32_t));
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
        const int kind = e < found->n ? kind_of(found->around[e]) : 2, j = e - found->n;
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

/* Give every taxel the number of the peak that it climbs to. Backward: most point at one behind them, which has found its. */
static void number_taxels(const vh_real *v, int height, vh_real floor, struct room *room)
{
    int32_t *parent = room->critical.parent;
    for (int r = height - 2; r > 0; r--) {
        for (int p = room->row.stop[r] - 1; p >= room->row.first[r]; p--) {
            if (!(v[p] > floor))
                continue;
            parent[p] = root_of(parent, p);
            room->number[p] = room->number[parent[p]];
        }
    }
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
static void join_event(int width, int e, struct room *room, struct vh_tree *tree)
{
    const struct critical *found = &room->critical;
    const int p = tree->event_at[e];
    int around[4], met[4], near = 2, links = 1, n = 0, top;
    if (e >= found->n) {
        around[0] = p;
        around[1] = found->joint_to[e - found->n];
    } else {
        near = pieces_above(p, width, found->around[e], around);
        links = near - 1;
    }
    for (int j = 0; j < near; j++)
        around[j] = root_of(room->peaks.group, room->number[around[j]]);
    met[0] = around[0];
    met[1] = around[1];
    /* Of two it makes no difference which is the first. */
    n = 1 + (met[1] != met[0]);
    if (near > 2)
        for (int j = n = 0; j < near; j++)
            n = put_in(&room->peaks, met, n, around[j]);
    top = met[0];
    for (int j = 1; j < n; j++)
        top = join(&room->peaks, top, met[j], tree->event_value[e]);
    tree->event_parts[e] -= (int8_t)(n - 1);
    tree->event_holes[e] = (int8_t)(links + tree->event_parts[e]);
}

/* Bring near what later events need, which lie all over a large frame: an event first, then the taxels around it. */
static void fetch_ahead(int width, const int32_t *order, const struct room *room, const struct vh_tree *tree)
{
    const int e = order[AHEAD], p = tree->event_at[e];
    VH_FETCH(tree->event_at + order[2 * AHEAD]);
    VH_FETCH(tree->event_parts + e);
    VH_FETCH(tree->event_holes + e);
    VH_FETCH(room->number + p - width);
    VH_FETCH(room->number + p);
    VH_FETCH(room->number + p + width);
}

void vh_merge_tree(
    const vh_real *v, int width, int height, vh_real floor, vh_real noise, const uint8_t *whole, int32_t *label,
    struct vh_tree *tree, void *work)
{
    struct room room;
    divide(work, width, height, &room);
    /* Critical taxels are the first of the events already; joints follow them. */
    room.critical.at = tree->event_at;
    room.peaks.n = 0;
    room.peaks.noise = noise;
    room.peaks.whole = whole;
    for (int p = 0; p < width * height; p++)
        label[p] = -1;
    classify(v, width, height, floor, &room.critical, room.row);
    const int n_saddles = begin_events(v, floor, &room, tree);
    number_taxels(v, height, floor, &room);
    vh_sort_falling(tree->event_value, room.order, n_saddles, room.other);
    for (int s = 0; s < n_saddles; s++) {
        if (s + 2 * AHEAD < n_saddles)
            fetch_ahead(width, room.order + s, &room, tree);
        join_event(width, room.order[s], &room, tree);
    }
    number_contacts(&room.peaks, tree, room.contact);
    for (int r = height - 2; r > 0; r--) {
        for (int p = room.row.stop[r] - 1; p >= room.row.first[r]; p--) {
            const int k = v[p] > floor ? room.contact[room.number[p]] : -1;
            if (k >= 0 && v[p] > tree->ends[k])
                label[p] = k;
        }
    }
}
