/*
 * Flat faces that press hardest at their rims, as on a bare elastic body: their corners stand so high above the rest of
 * them that each looks like a contact.
 *
 * Of two things that touch, each is highest within. A face stands higher along the whole of its rim than in its middle, has
 * no bays and is no heap of a few taxels: what is so is one contact, however low the saddles between its peaks.
 */
#include "inner.h"

/* A face of fewer taxels, or less deep, has no middle. */
#define FEWEST_TAXELS 20
#define LEAST_DEPTH 2
#define FEWEST_INNER 2
/* So much of its rim (with the taxels beside it) stands so many times as high as the inner half of its depth. */
#define RIM_SHARE 0.900001
#define RIM_HIGHER 1.200001
/* No taxel of that inner half stands so high, as a share of the rim's mean: two faces that touch have a rim within. */
#define MOST_WITHIN 0.799999
/* Of its area, as a share of the ellipse that has its second moments: a square has .955, two circles that touch .894. */
#define LEAST_SOLID 0.925001
/* Farther than any taxel is from what is not pressed. */
#define FAR 0x3fffffff
#define TURN 6.283185307179586

struct room {
    int32_t *queue, *depth;
};

static size_t divide(void *work, int width, int height, struct room *room)
{
    const size_t size = (size_t)width * height;
    size_t used = 0;
    room->queue = vh_take(work, &used, size, sizeof(int32_t));
    room->depth = vh_take(work, &used, size, sizeof(int32_t));
    return used;
}

size_t vh_faces_work(int width, int height)
{
    struct room room;
    return divide(0, width, height, &room);
}

/* What hangs together: its taxels in the queue, the window that holds them, its sums. */
struct patch {
    int n, top, bottom, left, right;
    vh_real x, y, xx, xy, yy;
};

/* Collect what hangs together with a taxel above the floor; all of it gets the depth FAR, which was 0. */
static struct patch collect(const vh_real *v, int width, int first, vh_real floor, const struct room *room)
{
    struct patch of = {0, first / width, first / width, first % width, first % width, 0.0, 0.0, 0.0, 0.0, 0.0};
    room->queue[of.n++] = first;
    room->depth[first] = FAR;
    VH_ONE_BY_ONE
    for (int i = 0; i < of.n; i++) {
        const int p = room->queue[i], r = p / width, c = p % width;
        const vh_real x = c - first % width, y = r - first / width;
        of.top = r < of.top ? r : of.top;
        of.bottom = r > of.bottom ? r : of.bottom;
        of.left = c < of.left ? c : of.left;
        of.right = c > of.right ? c : of.right;
        of.x += x;
        of.y += y;
        of.xx += x * x;
        of.xy += x * y;
        of.yy += y * y;
        VH_ONE_BY_ONE
        for (int dr = -1; dr <= 1; dr++) {
            VH_ONE_BY_ONE
            for (int dc = -1; dc <= 1; dc++) {
                const int q = p + dr * width + dc;
                if (room->depth[q] == 0 && v[q] > floor) {
                    room->depth[q] = FAR;
                    room->queue[of.n++] = q;
                }
            }
        }
    }
    return of;
}

static int is_solid(const struct patch *of)
{
    const vh_real n = of->n, x = of->x / n, y = of->y / n;
    const vh_real xx = of->xx / n - x * x, xy = of->xy / n - x * y, yy = of->yy / n - y * y;
    const vh_real ellipse = 2.0 * TURN * sqrt(vh_most(xx * yy - xy * xy, 0.0));
    return n >= LEAST_SOLID * ellipse;
}

/* One more than the least depth of four neighbours; of what lies beyond the pad nothing is known. */
static int32_t deeper(const vh_real *v, const int32_t *depth, int32_t own, int p, int a, int b, int c, int d)
{
    const int at[4] = {p + a, p + b, p + c, p + d};
    VH_ONE_BY_ONE
    for (int j = 0; j < 4; j++) {
        const int32_t other = v[at[j]] == VH_NOTHING ? FAR : depth[at[j]];
        own = other < own ? other + 1 : own;
    }
    return own;
}

/* Write how deep within the patch each taxel of it lies, 1 at the rim, in king's moves; returns the greatest. */
static int32_t write_depths(const vh_real *v, int width, const struct patch *of, int32_t *depth)
{
    int32_t deepest = 0;
    VH_ONE_BY_ONE
    for (int r = of->top; r <= of->bottom; r++)
        VH_ONE_BY_ONE
        for (int p = r * width + of->left; p <= r * width + of->right; p++)
            if (depth[p])
                depth[p] = deeper(v, depth, depth[p], p, -width - 1, -width, -width + 1, -1);
    VH_ONE_BY_ONE
    for (int r = of->bottom; r >= of->top; r--) {
        VH_ONE_BY_ONE
        for (int p = r * width + of->right; p >= r * width + of->left; p--) {
            if (!depth[p])
                continue;
            depth[p] = deeper(v, depth, depth[p], p, width + 1, width, width - 1, 1);
            deepest = depth[p] > deepest ? depth[p] : deepest;
        }
    }
    return deepest;
}

/* The highest of a taxel and those around it. */
static vh_real highest_around(const vh_real *v, int width, int p)
{
    vh_real highest = v[p];
    VH_ONE_BY_ONE
    for (int dr = -1; dr <= 1; dr++)
        VH_ONE_BY_ONE
        for (int dc = -1; dc <= 1; dc++)
            highest = vh_most(highest, v[p + dr * width + dc]);
    return highest;
}

/* Whether a patch stands higher all along its rim than in the inner half of its depth. */
static int is_bowl(const vh_real *v, int width, const struct patch *of, const struct room *room)
{
    const int32_t deepest = write_depths(v, width, of, room->depth);
    vh_real inner = 0.0, within = 0.0, rim = 0.0;
    int n_inner = 0, n_rim = 0, n_higher = 0;
    if (deepest < LEAST_DEPTH || deepest >= FAR)
        return 0;
    VH_ONE_BY_ONE
    for (int i = 0; i < of->n; i++) {
        const int p = room->queue[i];
        if (2 * room->depth[p] > deepest && room->depth[p] > 1) {
            inner += v[p];
            within = vh_most(within, v[p]);
            n_inner++;
        }
    }
    if (n_inner < FEWEST_INNER)
        return 0;
    inner /= n_inner;
    VH_ONE_BY_ONE
    for (int i = 0; i < of->n; i++) {
        const int p = room->queue[i];
        if (room->depth[p] == 1) {
            const vh_real highest = highest_around(v, width, p);
            rim += highest;
            n_rim++;
            n_higher += highest >= RIM_HIGHER * inner;
        }
    }
    return n_higher >= RIM_SHARE * n_rim && within * n_rim <= MOST_WITHIN * rim;
}

int vh_find_faces(
    const vh_real *v, int width, int height, vh_real floor, const struct vh_tree *tree, uint8_t *face, void *work)
{
    struct room room;
    int found = 0;
    divide(work, width, height, &room);
    memset(room.depth, 0, (size_t)width * height * sizeof *room.depth);
    memset(face, 0, (size_t)width * height);
    VH_ONE_BY_ONE
    for (int k = 0; k < tree->n_contacts; k++) {
        /* What goes down to the floor was not split; what has a depth was looked at. */
        if (!(tree->ends[k] > floor) || room.depth[tree->peak_at[k]])
            continue;
        const struct patch of = collect(v, width, tree->peak_at[k], floor, &room);
        if (of.n < FEWEST_TAXELS || !is_solid(&of) || !is_bowl(v, width, &of, &room))
            continue;
        VH_ONE_BY_ONE
        for (int i = 0; i < of.n; i++)
            face[room.queue[i]] = 1;
        found = 1;
    }
    return found;
}
