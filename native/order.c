/*
 * Which contacts of a frame count, and in which order: by falling area of the lowest section, then by falling number of
 * taxels, without what noise alone makes.
 */
#include "inner.h"

/*
 * A contact of fewer taxels, or of a smaller share of the largest one's, that rises no higher above its floor than noise
 * does is a speck on a skirt.
 */
#define SPECK_TAXELS 12
#define SPECK_SHARE 0.050001
/* With so many squares of 2 x 2 taxels above half of the frame's height it is neither. */
#define BROAD_SQUARES 2
/*
 * A rest that scatters so many times as widely as the noise is uneven, where at least such a share of the taxels lies below
 * it: what its unevenness reaches is no contact beside another. It counts to this share of the highest contact.
 */
#define UNEVEN 1.5
#define FEWEST_BELOW 0.1
#define MOST_UNEVEN 0.03
/* Mean of |z| for a standard normal z. */
#define MEAN_ABS_NORMAL 0.7978845608028654
/*
 * Areas are compared in steps, at most so many for a doubling: of equal contacts at two places rounding makes neither the
 * larger. No area of whole counts is likely to stand where one step ends.
 */
#define AREA_STEPS 16180.34

/* The key of a contact by its area. */
static vh_real area_key(const struct vh_frame *task, vh_real area)
{
    int exponent;
    const vh_real share = frexp(area / (task->row_pitch * task->col_pitch), &exponent);

    return ldexp((vh_real)(int32_t)(share * (vh_real)AREA_STEPS), exponent);
}

/* Of how many taxels a contact is at least that is no speck, where the largest has so many. */
static vh_int fewest_taxels(vh_int most)
{
    const vh_int share = (vh_int)(SPECK_SHARE * most);

    return share > SPECK_TAXELS ? share : SPECK_TAXELS;
}

/*
 * Count of each contact its squares of 2 x 2 taxels that stand above half of the frame's height, as far as matters.
 * Noise that differs from taxel to taxel lifts two of them in one frame of a thousand; a contact lifts them where most of
 * a pad's few taxels are its rim, and that is taken for noise.
 */
static void count_squares(const struct vh_frame *task, vh_real peak, int32_t *squares)
{
    const int width = task->cols + 2;
    memset(squares, 0, (size_t)task->n_contacts * sizeof *squares);
    for (int r = 1; r < task->rows; r++) {
        for (int c = 1; c < task->cols; c++) {
            const int first = r * width + c, corners[] = {first, first + 1, first + width, first + width + 1};
            const int32_t k = task->label[first];
            int above = k >= 0 && squares[k] < BROAD_SQUARES;
            for (int j = 0; j < 4 && above; j++)
                above = task->label[corners[j]] == k && task->padded[corners[j]] > 0.5 * peak;
            if (above)
                squares[k]++;
        }
    }
}

/* Add up what of n values lies below the rest, and how many do; no taxel does. */
static void add_below(const vh_real *v, int n, vh_real *sum, vh_real *below)
{
    vh_real part[VH_LANES] = {0.0}, number[VH_LANES] = {0.0};
    int i = 0;
    for (; i + VH_LANES <= n; i += VH_LANES) {
        VH_SIDE_BY_SIDE
        for (int k = 0; k < VH_LANES; k++) {
            const int low = (v[i + k] < 0.0) & (v[i + k] > VH_NOTHING);
            part[k] -= low ? v[i + k] : 0.0;
            number[k] += low ? 1.0 : 0.0;
        }
    }
    for (; i < n; i++) {
        const int low = (v[i] < 0.0) & (v[i] > VH_NOTHING);
        part[0] -= low ? v[i] : 0.0;
        number[0] += low;
    }
    for (int k = 0; k < VH_LANES; k++) {
        *sum += part[k];
        *below += number[k];
    }
}

/*
 * The contacts of a frame among which noise is looked for; their squares are counted, and the rest is looked at, when one
 * of them is in doubt. `most` is as far as noise and an uneven rest can reach, `reach` as far as they do, -1 before that
 * is known.
 */
struct sorted_out {
    const struct vh_frame *task;
    vh_real highest, most, reach;
    vh_int few;
    int32_t *squares;
    int counted;
};

static struct sorted_out begin(const struct vh_frame *task, int n_contacts, vh_real highest, vh_int few, int32_t *squares)
{
    struct sorted_out all = {task, highest, task->reach, -1.0, few, squares, 0};
    if (n_contacts > 1 && task->floor < 0.0)
        all.most = vh_most(task->reach, vh_noise_reach(MOST_UNEVEN * highest, task->rows * task->cols));
    return all;
}

/* What noise, or the unevenness of a rest, reaches; the rest is zero, and what lies below it shows how it scatters. */
static vh_real reach_of(const struct sorted_out *all)
{
    const struct vh_frame *task = all->task;
    const int n = task->rows * task->cols;
    vh_real sum = 0.0, below = 0.0;
    if (!(all->most > task->reach))
        return task->reach;
    for (int r = 1; r <= task->rows; r++)
        add_below(task->padded + (size_t)r * (task->cols + 2) + 1, task->cols, &sum, &below);
    const vh_real scatter = below > FEWEST_BELOW * n ? sum / (MEAN_ABS_NORMAL * below) : 0.0;
    if (!(scatter > UNEVEN * vh_most(task->sigma, task->timed_sigma)))
        return task->reach;
    return vh_most(task->reach, vh_noise_reach(vh_least(scatter, MOST_UNEVEN * all->highest), n));
}

/* Whether a contact is no higher than something reaches, or a speck that it makes on a skirt. */
static int is_within(const struct sorted_out *all, vh_real reach, vh_real peak, vh_real end, vh_int taxels)
{
    return reach > 0.0 && (!(peak > reach) || (taxels < all->few && peak - end <= reach));
}

/* Whether a contact is no more than noise or an uneven rest makes, and is not broad. */
static int is_noise(struct sorted_out *all, int k, vh_real peak, vh_real end, vh_int taxels)
{
    if (!is_within(all, all->most, peak, end, taxels))
        return 0;
    /* What noise reaches is within: how the rest scatters need not be known. */
    if (!is_within(all, all->task->reach, peak, end, taxels)) {
        if (all->reach < 0.0)
            all->reach = reach_of(all);
        if (!is_within(all, all->reach, peak, end, taxels))
            return 0;
    }
    /* What is no higher than half of the frame has no square above it. */
    if (!(peak > 0.5 * all->highest))
        return 1;
    if (!all->counted)
        count_squares(all->task, all->highest, all->squares);
    all->counted = 1;
    return all->squares[k] < BROAD_SQUARES;
}

void vh_order(struct vh_frame *task, vh_real *key, int32_t *other)
{
    const int n = task->n_contacts;
    vh_int most = 0;
    vh_real highest = 0.0;
    int kept = 0;
    for (int k = 0; k < n; k++) {
        const vh_int taxels = task->places[k * VH_N_PLACES + VH_N_TAXELS];
        task->order[k] = k;
        key[k] = (vh_real)taxels;
        most = taxels > most ? taxels : most;
        highest = vh_most(highest, task->values[2 * k]);
    }
    /* Stable, so that the last sort goes first. */
    vh_sort_falling(key, task->order, n, other);
    for (int k = 0; k < n; k++) {
        const vh_int end = task->places[k * VH_N_PLACES + VH_N_MEASURED];
        const vh_real *measures = task->measures + (size_t)k * VH_N_COLUMNS * task->n_levels;
        key[k] = end > 0 ? area_key(task, measures[VH_AREA * task->n_levels + end - 1]) : 0.0;
    }
    vh_sort_falling(key, task->order, n, other);
    struct sorted_out all = begin(task, n, highest, fewest_taxels(most), other);
    for (int i = 0; i < n; i++) {
        const int k = task->order[i];
        if (!is_noise(&all, k, task->values[2 * k], task->values[2 * k + 1], task->places[k * VH_N_PLACES + VH_N_TAXELS]))
            task->order[kept++] = k;
    }
    task->n_ordered = kept;
}

/* Room of vh_keep: of each contact its taxels and a key, and what sorts them; of each taxel whether it is in. */
struct room {
    int32_t *taxels, *order, *other, *enters;
    vh_real *key, *xs, *ys;
};

static size_t divide(void *work, int rows, int cols, struct room *room)
{
    const size_t width = (size_t)cols + 2, height = (size_t)rows + 2, most = (size_t)((cols + 1) / 2) * rows;
    size_t used = 0;
    room->taxels = vh_take(work, &used, most, sizeof(int32_t));
    room->order = vh_take(work, &used, most, sizeof(int32_t));
    room->other = vh_take(work, &used, most, sizeof(int32_t));
    room->enters = vh_take(work, &used, width * height, sizeof(int32_t));
    room->key = vh_take(work, &used, most, sizeof(vh_real));
    room->xs = vh_take(work, &used, width, sizeof(vh_real));
    room->ys = vh_take(work, &used, height, sizeof(vh_real));
    return used;
}

size_t vh_keep_work(int rows, int cols)
{
    struct room room;
    return divide(0, rows, cols, &room);
}

/* The area of a contact's section at one threshold, of a frame whose rim has its neighbours' values. */
static vh_real area_at(const struct vh_frame *task, const struct room *room, int k, vh_real level)
{
    const int width = task->cols + 2, height = task->rows + 2;
    vh_real t[3 * VH_LANES], sum[VH_N_SUMS][1 + VH_LANES] = {{0.0}}, whole[2][VH_N_WHOLE] = {{0.0}};
    vh_real support[1][2 * VH_N_DIRECTIONS] = {{0.0}};
    struct vh_sums sums = {.whole = whole};
    struct vh_window w = {
        .v = task->padded, .enters = room->enters, .width = width, .height = height, .top = height, .left = width,
        .xs = room->xs, .ys = room->ys, .t = t + VH_LANES, .end = 1,
    };
    for (int j = 0; j < VH_N_SUMS; j++)
        sums.sum[j] = sum[j];
    for (int i = 0; i < 3 * VH_LANES; i++)
        t[i] = i == VH_LANES ? level : -INFINITY;
    for (int p = 0; p < width * height; p++) {
        const int r = p / width, c = p % width;
        room->enters[p] = task->label[p] != k || !(task->padded[p] > level);
        if (task->label[p] != k)
            continue;
        w.top = vh_min(w.top, vh_max(r - 1, 0));
        w.bottom = vh_min(r + 1, height - 1);
        w.left = vh_min(w.left, vh_max(c - 1, 0));
        w.right = vh_max(w.right, vh_min(c + 1, width - 1));
    }
    vh_add_cells(&w, &sums);
    if (task->has_gaps)
        vh_add_border_cells(&w, &sums, support);
    return sum[VH_S_AREA][0] + whole[0][VH_S_AREA];
}

/* Sort contacts as vh_order does, by sections that nothing else is measured of yet. */
static void sort_unmeasured(struct vh_frame *task, const struct vh_tree *tree, const struct room *room, int n)
{
    const int width = task->cols + 2, height = task->rows + 2;
    vh_positions(task->cols, task->col_pitch, room->xs);
    vh_positions(task->rows, task->row_pitch, room->ys);
    if (!task->has_gaps)
        vh_fill_rim(task->padded, task->label, width, height);
    for (int i = 0; i < n; i++)
        room->key[room->order[i]] = (vh_real)room->taxels[room->order[i]];
    vh_sort_falling(room->key, room->order, n, room->other);
    for (int i = 0; i < n; i++) {
        const int k = room->order[i];
        const vh_real peak = task->padded[tree->peak_at[k]], step = (peak - tree->ends[k]) / task->n_levels;
        const vh_real lowest = peak - (task->n_levels - 0.5) * step;
        room->key[k] = area_key(task, area_at(task, room, k, lowest));
    }
    vh_sort_falling(room->key, room->order, n, room->other);
    if (!task->has_gaps)
        vh_clear_rim(task->padded, task->label, width, height);
}

void vh_keep(struct vh_frame *task, struct vh_tree *tree, int most, void *work)
{
    const int size = (task->rows + 2) * (task->cols + 2), n = tree->n_contacts;
    int32_t most_taxels = 0, *number;
    vh_real highest = 0.0;
    struct room room;
    int kept = 0;
    divide(work, task->rows, task->cols, &room);
    memset(room.taxels, 0, (size_t)n * sizeof *room.taxels);
    for (int p = 0; p < size; p++)
        if (task->label[p] >= 0)
            most_taxels = vh_max(most_taxels, ++room.taxels[task->label[p]]);
    for (int k = 0; k < n; k++)
        highest = vh_most(highest, task->padded[tree->peak_at[k]]);
    struct sorted_out all = begin(task, n, highest, fewest_taxels(most_taxels), room.other);
    for (int k = 0; k < n; k++)
        if (!is_noise(&all, k, task->padded[tree->peak_at[k]], tree->ends[k], room.taxels[k]))
            room.order[kept++] = k;
    if (kept > most) {
        sort_unmeasured(task, tree, &room, kept);
        kept = most;
    }
    number = room.other;
    for (int k = 0; k < n; k++)
        number[k] = -1;
    for (int i = 0; i < kept; i++)
        number[room.order[i]] = 0;
    tree->n_contacts = task->n_contacts = 0;
    for (int k = 0; k < n; k++) {
        if (number[k] < 0)
            continue;
        number[k] = tree->n_contacts++;
        tree->peak_at[number[k]] = tree->peak_at[k];
        tree->ends[number[k]] = tree->ends[k];
    }
    task->n_contacts = tree->n_contacts;
    for (int p = 0; p < size; p++)
        if (task->label[p] >= 0)
            task->label[p] = number[task->label[p]];
}
