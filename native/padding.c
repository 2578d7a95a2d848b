/* A frame looked at, and given a rim: one taxel more on every side, which stands on the pad's border. */
#include "inner.h"

/* Whether all values can be measured: NaN cannot. */
static int all_measurable(const vh_real *values, size_t size)
{
    int strange = 0;
    for (size_t i = 0; i < size; i++)
        strange |= !(fabs(values[i]) <= VH_MOST_READ);
    return !strange;
}

/* A frame of which every taxel is there and works. */
static void check_whole(
    const vh_real *frame, size_t size, vh_real *flat, uint8_t *inside, uint8_t *usable, struct vh_checked *found)
{
    vh_real lowest, highest;
    memcpy(flat, frame, size * sizeof *flat);
    memset(inside, 1, size);
    memset(usable, 1, size);
    found->n_inside = found->n_usable = vh_range(frame, usable, (int)size, &lowest, &highest);
    found->peak = vh_most(0.0, highest);
}

/*
 * Copy a frame; VH_NOTHING where there is no taxel, for which NaN stands as well. `inside` and `usable` are written: where
 * there is a taxel, and where it works.
 */
enum vh_fault vh_check_frame(
    const vh_real *frame, const uint8_t *field, const uint8_t *valid, size_t size, vh_real *flat, uint8_t *inside,
    uint8_t *usable, struct vh_checked *found)
{
    int n_inside = 0, n_usable = 0, infinite = 0;
    vh_real peak = 0.0;
    if (!field && !valid && all_measurable(frame, size)) {
        check_whole(frame, size, flat, inside, usable, found);
        return VH_FINE;
    }
    for (size_t i = 0; i < size; i++) {
        const vh_real value = frame[i];
        int there = field ? field[i] : 1, works = valid ? valid[i] : 1;
        there &= !(works & (value != value));
        works &= there;
        inside[i] = (uint8_t)there;
        usable[i] = (uint8_t)works;
        n_inside += there;
        n_usable += works;
        infinite |= works & (fabs(value) > VH_MOST_READ);
        peak = works && value > peak ? value : peak;
        flat[i] = there ? value : VH_NOTHING;
    }
    found->n_inside = n_inside;
    found->n_usable = n_usable;
    found->peak = peak;
    if (infinite)
        return VH_INFINITE;
    return n_inside > 0 && n_usable == 0 ? VH_ALL_BROKEN : VH_FINE;
}

/* Spread a frame that stands at the start of `padded` over it, the last row first, and surround it by VH_NOTHING. */
void vh_add_rim(vh_real *padded, int rows, int cols)
{
    const size_t width = (size_t)cols + 2;
    for (int r = rows - 1; r >= 0; r--) {
        vh_real *row = padded + (r + 1) * width;
        memmove(row + 1, padded + (size_t)r * cols, (size_t)cols * sizeof *row);
        row[0] = row[width - 1] = VH_NOTHING;
    }
    for (size_t c = 0; c < width; c++)
        padded[c] = padded[(rows + 1) * width + c] = VH_NOTHING;
}

/* The positions of a padded frame's columns or rows from the pad's centre: the outermost on the pad's border. */
void vh_positions(int count, vh_real pitch, vh_real *at)
{
    for (int i = 0; i < count + 2; i++)
        at[i] = (i - 0.5 * (count + 1)) * pitch;
    at[0] = -0.5 * count * pitch;
    at[count + 1] = 0.5 * count * pitch;
}

/* Give the rim its neighbours' values and contacts: V is constant over the outer half taxels. */
void vh_fill_rim(vh_real *v, int32_t *label, int width, int height)
{
    for (int r = 1; r < height - 1; r++) {
        const int p = r * width, q = (r + 1) * width - 1;
        v[p] = v[p + 1];
        label[p] = label[p + 1];
        v[q] = v[q - 1];
        label[q] = label[q - 1];
    }
    const size_t last = (size_t)(height - 1) * width;
    memcpy(v, v + width, (size_t)width * sizeof *v);
    memcpy(label, label + width, (size_t)width * sizeof *label);
    memcpy(v + last, v + last - width, (size_t)width * sizeof *v);
    memcpy(label + last, label + last - width, (size_t)width * sizeof *label);
}

void vh_clear_rim(vh_real *v, int32_t *label, int width, int height)
{
    for (int p = 0; p < width * height; p++) {
        const int r = p / width, c = p % width;
        if (r > 0 && r < height - 1 && c > 0 && c < width - 1)
            continue;
        v[p] = VH_NOTHING;
        label[p] = -1;
    }
}
