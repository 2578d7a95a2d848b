/*
 * Hot taxels of one frame: those that stick high within a contact, found where the evidence is strong.
 *
 * However sharp a body is, what is felt of it falls ever faster, in ratio, on the way down from its peak: a cone and a
 * Gaussian do, a point load nearly so. Along every way the first taxel is then no lower than the geometric mean of the
 * peak and the second. A hot taxel stands far above neighbours that hardly fall among themselves.
 */
#include "inner.h"

/* It stands so many times as high as the highest of its neighbours, and higher than that by this share of the frame's
 * next highest reading and by so many sigma. */
#define TIMES 1.250001
#define LIFT_SHARE 0.350001
#define SIGMAS 8.0
/* A neighbour is pressed that stands at this share of the highest of them; so many are. */
#define PRESSED_SHARE 0.300001
#define FEWEST_PRESSED 3
/* Along so many ways the first taxel's square is less than a share of the product of the peak and the second. Where one
 * way may be otherwise the share is the first of these, where two or three may, the next. */
#define FEWEST_WAYS 3
#define MOST_OTHERWISE 3
static const vh_real LEAST_STEEP[MOST_OTHERWISE] = {0.749999, 0.599999, 0.399999};
/* A first taxel of less than this share of the second is a valley between two bodies, which says nothing. */
#define VALLEY 0.499999
/* More taxels than these, or than this share of the pad, are no faults but a form. */
#define MOST 2
#define MOST_SHARE 0.030001

/* A frame, and what counts as clear of the noise and as a lift above the neighbours. */
struct readings {
    const vh_real *frame;
    const uint8_t *usable;
    int rows, cols;
    vh_real clear, lift;
};

/* The eight neighbours of a taxel. */
static const int WAYS[8][2] = {{-1, -1}, {-1, 0}, {-1, 1}, {0, -1}, {0, 1}, {1, -1}, {1, 0}, {1, 1}};

/* Where the taxel lies that is so many steps along a way; -1 where there is none that can be used. */
static int along(const struct readings *f, int r, int c, const int way[2], int steps)
{
    r += steps * way[0];
    c += steps * way[1];
    if (r < 0 || c < 0 || r >= f->rows || c >= f->cols)
        return -1;
    const int at = r * f->cols + c;
    return f->usable[at] ? at : -1;
}

static vh_real highest_beside(const struct readings *f, int r, int c)
{
    vh_real highest = 0.0;
    for (int k = 0; k < 8; k++) {
        const int at = along(f, r, c, WAYS[k], 1);
        highest = at < 0 ? highest : vh_most(highest, f->frame[at]);
    }
    return highest;
}

static int is_hot(const struct readings *f, int r, int c)
{
    const vh_real v = f->frame[r * f->cols + c];
    if (!f->usable[r * f->cols + c] || !(v > f->lift))
        return 0;
    const vh_real top = highest_beside(f, r, c), pressed = vh_most(PRESSED_SHARE * top, f->clear);
    int n_pressed = 0, n_known = 0, n_even[MOST_OTHERWISE] = {0}, hot = 0;
    if (!(v > TIMES * top && v - top > f->lift))
        return 0;
    for (int k = 0; k < 8; k++) {
        const int first = along(f, r, c, WAYS[k], 1), second = along(f, r, c, WAYS[k], 2);
        if (first < 0 || !(f->frame[first] > pressed))
            continue;
        n_pressed++;
        const vh_real near = f->frame[first], far = second < 0 ? INFINITY : f->frame[second];
        if (near < VALLEY * far)
            continue;
        n_known++;
        for (int j = 0; j < MOST_OTHERWISE; j++)
            n_even[j] += far > f->clear && near * near < LEAST_STEEP[j] * v * far;
    }
    for (int j = 0; j < MOST_OTHERWISE; j++)
        hot |= n_even[j] >= FEWEST_WAYS && n_known - n_even[j] <= j + 1;
    return hot && n_pressed >= FEWEST_PRESSED;
}

/* Whether a taxel of a row stands clear of the noise and far above those beside it in the row. */
static int may_be_hot(const struct readings *f, const vh_real *here)
{
    const int last = f->cols - 1;
    vh_int found = 0;
    for (int c = 1; c < last; c++)
        found |= (here[c] > f->clear) & (here[c] > (vh_real)TIMES * vh_most(here[c - 1], here[c + 1]));
    if (last > 0) {
        found |= (here[0] > f->clear) & (here[0] > (vh_real)TIMES * here[1]);
        found |= (here[last] > f->clear) & (here[last] > (vh_real)TIMES * here[last - 1]);
    }
    return found != 0;
}

/* The second highest reading. */
static vh_real next_highest(const struct readings *f)
{
    vh_real highest = 0.0, next = 0.0;
    for (int i = 0; i < f->rows * f->cols; i++) {
        const vh_real v = f->usable[i] ? f->frame[i] : 0.0;
        next = vh_most(next, vh_least(highest, v));
        highest = vh_most(highest, v);
    }
    return next;
}

int vh_find_hot(const vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, uint8_t *hot)
{
    struct readings f = {frame, usable, rows, cols, SIGMAS * sigma, -1.0};
    int n = 0;
    for (int r = 0; r < rows; r++) {
        if (!may_be_hot(&f, frame + (size_t)r * cols))
            continue;
        if (f.lift < 0.0) {
            f.lift = vh_most(LIFT_SHARE * next_highest(&f), f.clear);
            memset(hot, 0, (size_t)rows * cols);
        }
        for (int c = 0; c < cols; c++) {
            hot[r * cols + c] = (uint8_t)is_hot(&f, r, c);
            n += hot[r * cols + c];
        }
    }
    return n <= vh_max(MOST, (int)(MOST_SHARE * rows * cols)) ? n : 0;
}
