/* What the files of the kernel share, and nobody else needs. */
#ifndef VARISHOLD_INNER_H
#define VARISHOLD_INNER_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "varishold.h"

/* Levels that are worked on side by side, one vector instruction for all; one where there are no vectors. */
#ifndef VH_LANES
#define VH_LANES 4
#endif

/* Before a short loop: it is what a compiler is to make vectors of, not the loop around it. */
#if defined(__GNUC__) && !defined(__clang__)
#define VH_SIDE_BY_SIDE _Pragma("GCC unroll 1")
#else
#define VH_SIDE_BY_SIDE
#endif
/* Before a loop that seldom runs: on a controller it is to be small. */
#ifdef VH_SMALL
#define VH_ONE_BY_ONE VH_SIDE_BY_SIDE
#else
#define VH_ONE_BY_ONE
#endif

/* Asks for what stands at a place before it is read, where the compiler can. */
#if defined(__GNUC__)
#define VH_FETCH(place) __builtin_prefetch(place)
#else
#define VH_FETCH(place) ((void)(place))
#endif
#define VH_CACHE_LINE 64

/* Functions of libm take the type of a number: as <tgmath.h> does, which not every library for controllers has whole. */
#ifdef VH_SINGLE
#define cos(x) cosf((vh_real)(x))
#define exp(x) expf((vh_real)(x))
#define expm1(x) expm1f((vh_real)(x))
#define fabs(x) fabsf((vh_real)(x))
#define frexp(x, e) frexpf((vh_real)(x), e)
#define ldexp(x, e) ldexpf((vh_real)(x), e)
#define log(x) logf((vh_real)(x))
#define log1p(x) log1pf((vh_real)(x))
#define pow(x, y) powf((vh_real)(x), (vh_real)(y))
#define sin(x) sinf((vh_real)(x))
#define sqrt(x) sqrtf((vh_real)(x))
#endif

/* The least normal number, the least floor and the most that a reading may be, with squares within what numbers hold, and
 * how close a number can come to another, relative to it, when it is computed. */
#ifdef VH_SINGLE
#define VH_LEAST_NORMAL FLT_MIN
#define VH_LEAST_FLOOR FLT_MIN
#define VH_MOST_READ FLT_MAX
#define VH_CLOSE 1e-5
#else
#define VH_LEAST_NORMAL DBL_MIN
#define VH_LEAST_FLOOR 1e-150
#define VH_MOST_READ 1e100
#define VH_CLOSE 1e-9
#endif

/*
 * What lies closer together than this share of itself, or of a contact's peak, is equal: so close rounding brings numbers
 * in single precision. Both precisions take it, so that both say the same of readings that are equal, or stand to each
 * other as a constant here says; such constants are told a little beside the share of whole counts that they mean.
 */
#define VH_SAME 1e-5

#define PI 3.14159265358979323846

/* The least floor of a contact, as a share of its peak, where time has not told the noise: of one precision everywhere,
 * so that a floor that was set by it is no lower than it. */
#define VH_FLOOR_OF_PEAK ((vh_real)0.05)

/* Brings n numbers near that will be read or written soon; a processor without vectors hardly has a cache. */
static inline void vh_fetch(const vh_real *numbers, size_t n)
{
    for (size_t i = 0; VH_LANES > 1 && i < n; i += VH_CACHE_LINE / sizeof *numbers)
        VH_FETCH(numbers + i);
}

/* Where there is no taxel. */
#define VH_NOTHING (-INFINITY)

/* Columns of the sums at each threshold: the integrals of 1, x, y, x^2, x y and y^2, and the outline's length. */
enum { VH_S_AREA, VH_S_X, VH_S_Y, VH_S_XX, VH_S_XY, VH_S_YY, VH_S_LENGTH, VH_N_SUMS };
/* Of those, what a covered cell has. */
#define VH_N_WHOLE 6

static inline vh_real vh_least(vh_real a, vh_real b) { return b < a ? b : a; }
static inline vh_real vh_most(vh_real a, vh_real b) { return b > a ? b : a; }
static inline size_t vh_most_bytes(size_t a, size_t b) { return b > a ? b : a; }
static inline int vh_min(int a, int b) { return b < a ? b : a; }
static inline int vh_max(int a, int b) { return b > a ? b : a; }

/* Bytes of a vector of numbers, eight at least: pieces of a work space begin at multiples of it, as the whole does. */
#define VH_PIECE (VH_LANES * sizeof(vh_real) > 8 ? VH_LANES * sizeof(vh_real) : 8)

/*
 * Takes the next piece of a work space: `*used` goes on by n items of so many bytes, to a multiple of VH_PIECE. With
 * work = NULL the pieces are only counted, so that one function both divides a work space and tells its size.
 */
static inline void *vh_take(void *work, size_t *used, size_t n, size_t bytes)
{
    void *piece = work ? (char *)work + *used : 0;
    *used += (n * bytes + VH_PIECE - 1) / VH_PIECE * VH_PIECE;
    return piece;
}

/* counts.c: whether all of n count; the lowest and highest of n values where they do, and how many; a sensor's least step. */
int vh_all_count(const uint8_t *counts, int n);
int vh_range(const vh_real *values, const uint8_t *counts, int n, vh_real *lowest, vh_real *highest);
vh_real vh_count_of(const vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real enough);

/* sorting.c: sorts `order` so that value[order] falls; equal values keep their order. `other` is room for n. */
void vh_sort_falling(const vh_real *value, int32_t *order, int n, int32_t *other);
vh_real vh_order_statistic(vh_real *values, int n, int rank);

/* merge_tree.c: the contacts of a padded frame, and the topological events within each. */
struct vh_tree {
    /* Each contact's highest taxel, and where it ends: the floor, or its saddle if it was split. */
    int32_t *peak_at;
    vh_real *ends;
    int n_contacts;
    /* At thresholds below event_value the contact around the taxel event_at has so many parts and holes more. */
    int32_t *event_at;
    vh_real *event_value;
    int8_t *event_parts, *event_holes;
    int n_events;
};
/* Where `whole` is not NULL, what is marked in it is not split. */
void vh_merge_tree(
    const vh_real *v, int width, int height, vh_real floor, vh_real noise, const uint8_t *whole, int32_t *label,
    struct vh_tree *tree, void *work);
size_t vh_merge_tree_work(int width, int height);
/* Divides the room that a tree keeps, and tells how many bytes it takes. */
size_t vh_tree_room(int width, int height, struct vh_tree *tree, void *kept);

/* faces.c: marks the taxels of flat faces whose corners were split from them; returns whether there are any. */
int vh_find_faces(
    const vh_real *v, int width, int height, vh_real floor, const struct vh_tree *tree, uint8_t *face, void *work);
size_t vh_faces_work(int width, int height);

/* A contact's window of a padded frame, and the thresholds that cut it. */
struct vh_window {
    /* The padded frame, and for each of its taxels in the window the first threshold at which it is in (`end`: never). */
    const vh_real *v;
    const int32_t *enters;
    int width, height;
    int top, bottom, left, right;
    /* Positions of the padded frame's columns and rows, and of the point that sums refer to. */
    const vh_real *xs, *ys;
    vh_real x, y;
    /* Falling thresholds, and VH_LANES times -inf behind them. */
    const vh_real *t;
    int end;
};

/* The sums at each threshold, whole vectors of them also behind the last; and what is added at one and at all after it. */
struct vh_sums {
    vh_real *sum[VH_N_SUMS];
    vh_real (*whole)[VH_N_WHOLE];
};

/* cells.c */
void vh_add_cells(const struct vh_window *w, const struct vh_sums *sums);

/* border.c */
void vh_add_border_cells(
    const struct vh_window *w, const struct vh_sums *sums, vh_real (*support)[2 * VH_N_DIRECTIONS]);
int vh_gap_events(
    const vh_real *v, int width, int height, const int32_t *label, int32_t *contact, vh_real *value, void *work);
size_t vh_gap_events_work(int width, int height);

/* widths.c: support[i][d], max of x cos + y sin in 32 directions around the circle; `reach` has room for so many numbers. */
void vh_add_supports(
    const struct vh_window *w, vh_real (*support)[2 * VH_N_DIRECTIONS], vh_real *reach, int32_t *earliest);
size_t vh_reach_room(int n_levels);
void vh_reach(vh_real support[2 * VH_N_DIRECTIONS], vh_real x, vh_real y);
extern const vh_real vh_cos[2 * VH_N_DIRECTIONS], vh_sin[2 * VH_N_DIRECTIONS];

/* padding.c: a frame looked at, and surrounded by a rim of nothing. */
struct vh_checked {
    int n_inside, n_usable;
    vh_real peak;
};
enum vh_fault vh_check_frame(
    const vh_real *frame, const uint8_t *field, const uint8_t *valid, size_t size, vh_real *flat, uint8_t *inside,
    uint8_t *usable, struct vh_checked *found);
void vh_add_rim(vh_real *padded, int rows, int cols);
void vh_positions(int count, vh_real pitch, vh_real *at);
/* The rim with its neighbours' values and contacts, and as it was. */
void vh_fill_rim(vh_real *v, int32_t *label, int width, int height);
void vh_clear_rim(vh_real *v, int32_t *label, int width, int height);

/* order.c: puts measured contacts in order, without those that noise makes; keeps so many contacts at most of those that
 * are not measured yet, the first in that order. */
void vh_order(struct vh_frame *task, vh_real *key, int32_t *other);
void vh_keep(struct vh_frame *task, struct vh_tree *tree, int most, void *work);
size_t vh_keep_work(int rows, int cols);

/* sections.c: every contact's sections, at the thresholds `levels` or at each contact's own. */
void vh_measure(struct vh_frame *task, const struct vh_tree *tree, const vh_real *levels, void *work);
void vh_measure_section(struct vh_frame *task, const struct vh_tree *tree, vh_real level, void *work);
size_t vh_measure_work(int rows, int cols, int n_levels);

#endif
