/* The fit of a section to the parts of a hand, which are capsules, one turn after another. */
#include <string.h>
#include <math.h>

#include "varishold.h"

/* What is known before: the middle near the palm's axis, the size within a hand's reach, growth of a slender cone. */
#define USUAL_SIZE_M 0.08
#define FIXED 1e12
static const double SPREAD[] = {0.06, 0.06, 0.08, 0.5, 0.6}, BALL_SPREAD[] = {0.06, 0.06, 0.02, 0.08};
/* A part that is farther off than so many standard deviations touches something else and counts less. */
#define BOUND 4.0
/* The same of a part that touches something for certain, but perhaps not the object. */
#define LOOSE_BOUND 1.0
/* From either side of most objects, so that a finger on the wrong side of a corner finds over. */
static const double FIRST_SIZES_M[] = {0.045, 0.09};
/* Parts that are so near each other touch. */
#define NEAR_M 0.0015
/* No section of size 1 reaches farther than 1 from its middle; beyond it by so much a part cannot touch. */
#define CLEAR_M 0.005
#define LEAST_SIZE_M 0.005
#define MOST_SIZE_M 0.5
/* No step may carry the section past the hand; a step of less is the last. */
#define LONGEST_STEP_M 0.015
#define ENOUGH_M 2e-6
/* How far a unit of each unknown moves the section: a radian half a hand's breadth; growth does not count. */
static const double METRES[] = {1, 1, 1, 0.05, 0}, BALL_METRES[] = {1, 1, 1, 1};

enum { MOST_STEPS = 15, FIRST_SIZES = 2, MOST_UNKNOWNS = 5 };

struct point {
    double x, y;
};

/* How far a line is from a polygon, negative inside, and the nearest points of both. */
struct meeting {
    double distance;
    struct point corner, line;
};

/* What the fit minimizes, at one place: its value, its curvature (n x n) and the way down. */
struct normal {
    int n;
    double cost, information[MOST_UNKNOWNS * MOST_UNKNOWNS], toward[MOST_UNKNOWNS];
};

static double square(double v)
{
    return v * v;
}

static double within(double v, double least, double most)
{
    return v < least ? least : v > most ? most : v;
}

static struct point nearest_on_line(struct point p, struct point a, struct point b)
{
    double dx = b.x - a.x, dy = b.y - a.y, along = dx * dx + dy * dy;
    double t = along == 0 ? 0 : within(((p.x - a.x) * dx + (p.y - a.y) * dy) / along, 0, 1);
    struct point q = {a.x + t * dx, a.y + t * dy};

    return q;
}

static double apart_2(struct point p, struct point q)
{
    return square(p.x - q.x) + square(p.y - q.y);
}

static struct point corner_of(const double *corners, int k, struct point c)
{
    struct point p = {c.x + corners[2 * k], c.y + corners[2 * k + 1]};

    return p;
}

/* Tells whether a point, from the polygon's middle, lies on the inner side of all edges. */
static int is_inside(const double *corners, int n, double x, double y)
{
    if (n < 3)
        return 0;
    for (int k = 0; k < n; k++) {
        const double *v = corners + 2 * k, *w = corners + 2 * ((k + 1) % n);
        if ((w[0] - v[0]) * (y - v[1]) - (w[1] - v[1]) * (x - v[0]) < 0)
            return 0;
    }
    return 1;
}

/* Compares a line from a to b with a polygon about c. */
static struct meeting closest(struct point a, struct point b, const double *corners, int n, struct point c)
{
    struct meeting best = {INFINITY, {0, 0}, {0, 0}};

    for (int k = 0; k < n; k++) {
        struct point v = corner_of(corners, k, c), w = corner_of(corners, (k + 1) % n, c), q;
        q = nearest_on_line(v, a, b);
        if (apart_2(q, v) < best.distance) {
            best.distance = apart_2(q, v);
            best.corner = v;
            best.line = q;
        }
        for (int end = 0; end < 2 && n > 1; end++) {
            struct point e = end == 0 ? a : b;
            q = nearest_on_line(e, v, w);
            if (apart_2(q, e) < best.distance) {
                best.distance = apart_2(q, e);
                best.corner = q;
                best.line = e;
            }
        }
    }
    best.distance = sqrt(best.distance);
    if (is_inside(corners, n, best.line.x - c.x, best.line.y - c.y))
        best.distance = -best.distance;
    return best;
}

/* Factors a small symmetric positive system by Cholesky's method, in place. */
static void factor(double *matrix, int n)
{
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < j; k++)
            matrix[j * n + j] -= square(matrix[j * n + k]);
        matrix[j * n + j] = sqrt(fmax(matrix[j * n + j], 1e-300));
        for (int i = j + 1; i < n; i++) {
            for (int k = 0; k < j; k++)
                matrix[i * n + j] -= matrix[i * n + k] * matrix[j * n + k];
            matrix[i * n + j] /= matrix[j * n + j];
        }
    }
}

/* Solves a small symmetric positive system; the right side becomes the solution. */
static void solve(const double *matrix, double *right, int n)
{
    double lower[MOST_UNKNOWNS * MOST_UNKNOWNS];

    memcpy(lower, matrix, (size_t)(n * n) * sizeof *lower);
    factor(lower, n);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            right[i] -= lower[i * n + k] * right[k];
        right[i] /= lower[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            right[i] -= lower[k * n + i] * right[k];
        right[i] /= lower[i * n + i];
    }
}

/* Begins with what is known before. */
static void begin(struct normal *normal, const double *x, const double *usual, const double *weight, int n)
{
    memset(normal, 0, sizeof *normal);
    normal->n = n;
    for (int j = 0; j < n; j++) {
        normal->information[j * n + j] = weight[j];
        normal->toward[j] = weight[j] * (usual[j] - x[j]);
        normal->cost += 0.5 * weight[j] * square(usual[j] - x[j]);
    }
}

/* Adds a part that is `off` from where it should be, by Cauchy's bounded influence; row is the slope of `off`. */
static void add_part(struct normal *normal, const double *row, double off, int touch, double sigma)
{
    double bound = off > 0 && touch == 1 ? LOOSE_BOUND : BOUND, beyond = square(off / (bound * sigma));
    double w = 1 / (1 + beyond) / square(sigma);
    int n = normal->n;

    normal->cost += 0.5 * square(bound) * log(1 + beyond);
    for (int j = 0; j < n; j++) {
        normal->toward[j] -= w * row[j] * off;
        for (int k = 0; k < n; k++)
            normal->information[j * n + k] += w * row[j] * row[k];
    }
}

/* The polygon turned by x[3] and scaled to `size`. */
static void scale_corners(const struct vh_section *section, double turn, double size, double *scaled)
{
    double c = cos(turn), s = sin(turn);

    for (int k = 0; k < section->n_corners; k++) {
        const double *corner = section->corners + 2 * k;
        scaled[2 * k] = size * (c * corner[0] - s * corner[1]);
        scaled[2 * k + 1] = size * (s * corner[0] + c * corner[1]);
    }
}

static struct point flat(const double *p)
{
    struct point q = {p[0], p[1]};

    return q;
}

/* Adds part i to what the fit of a section minimizes; returns how far it is off where it should be. */
static double add_section_part(const struct vh_parts *parts, int i, const struct vh_section *section, const double *x,
                               double *scaled, struct normal *normal)
{
    const double *start = parts->start + 3 * i, *end = parts->end + 3 * i;
    double z = (start[2] + end[2]) / 2, size = fmax(0.004, x[2] + x[4] * z), row[MOST_UNKNOWNS], off, length, ux, uy;
    struct point a = flat(start), b = flat(end), c = {x[0], x[1]};
    struct meeting m;

    if (parts->touch[i] == 0
        && sqrt(apart_2(nearest_on_line(c, a, b), c)) > size + parts->radius[i] + CLEAR_M)
        return CLEAR_M;
    scale_corners(section, x[3], size, scaled);
    m = closest(a, b, scaled, section->n_corners, c);
    off = m.distance - section->rounding * size - parts->radius[i];
    if (off >= 0 && parts->touch[i] == 0)
        return off;
    length = fmax(fabs(m.distance), 1e-9) * (m.distance < 0 ? -1 : 1);
    ux = (m.line.x - m.corner.x) / length;
    uy = (m.line.y - m.corner.y) / length;
    row[0] = -ux;
    row[1] = -uy;
    row[2] = -(ux * (m.corner.x - x[0]) + uy * (m.corner.y - x[1])) / size - section->rounding;
    row[3] = ux * (m.corner.y - x[1]) - uy * (m.corner.x - x[0]);
    row[4] = row[2] * z;
    add_part(normal, row, off, (int)parts->touch[i], parts->sigma);
    return off;
}

/* Goes a step down from x, whose unknown number `size` is the size; returns how far the whole step was, in metres. */
static double step_down(struct normal *normal, double *x, const double *metres, int size)
{
    double *move = normal->toward, largest = 0, share;

    solve(normal->information, move, normal->n);
    for (int j = 0; j < normal->n; j++)
        largest = fmax(largest, fabs(move[j]) * metres[j]);
    share = fmin(1, LONGEST_STEP_M / fmax(largest, 1e-12));
    for (int j = 0; j < normal->n; j++)
        x[j] += share * move[j];
    x[size] = within(x[size], LEAST_SIZE_M, MOST_SIZE_M);
    return largest;
}

/* Goes from x to where the section fits best; returns the cost there. */
static double descend(const struct vh_parts *parts, const struct vh_section *section, const double *usual,
                      const double *weight, double *x, double *off, double *scaled, struct normal *normal)
{
    for (int step = 0; step <= MOST_STEPS; step++) {
        begin(normal, x, usual, weight, 5);
        for (int i = 0; i < parts->n; i++)
            off[i] = add_section_part(parts, i, section, x, scaled, normal);
        if (step == MOST_STEPS || step_down(normal, x, METRES, 2) < ENOUGH_M)
            break;
    }
    return normal->cost;
}

/* The variance of the size: an entry of the curvature's inverse. */
static double size_variance(const struct normal *normal)
{
    double unit[MOST_UNKNOWNS] = {0, 0, 1, 0, 0};

    solve(normal->information, unit, 5);
    return unit[2];
}

size_t vh_fit_turns_work(const struct vh_parts *parts, const struct vh_section *section)
{
    return ((size_t)parts->n + 2 * (size_t)section->n_corners) * sizeof(double);
}

void vh_fit_turns(const struct vh_parts *parts, const struct vh_section *section, const double *turns, int n_turns,
                  double *found, double *off, double *cost, double *variance, void *work)
{
    double weight[MOST_UNKNOWNS], usual[MOST_UNKNOWNS] = {USUAL_SIZE_M / 2, 0, USUAL_SIZE_M, 0, 0};
    double *off_now = work, *scaled = off_now + parts->n;

    for (int j = 0; j < 5; j++)
        weight[j] = 1 / square(SPREAD[j]);
    /* What is not asked for stays as it is. */
    if (section->n_corners < 2)
        weight[3] = FIXED;
    if (!section->grows)
        weight[4] = FIXED;
    for (int t = 0; t < n_turns; t++) {
        usual[3] = turns[t];
        cost[t] = INFINITY;
        for (int first = 0; first < FIRST_SIZES; first++) {
            double x[MOST_UNKNOWNS] = {usual[0], usual[1], FIRST_SIZES_M[first], usual[3], usual[4]}, now;
            struct normal normal;
            now = descend(parts, section, usual, weight, x, off_now, scaled, &normal);
            if (!(now < cost[t]))
                continue;
            cost[t] = now;
            memcpy(found + 5 * t, x, sizeof x);
            memcpy(off + (size_t)t * (size_t)parts->n, off_now, (size_t)parts->n * sizeof *off);
            variance[t] = size_variance(&normal);
        }
    }
}

void vh_meeting(const struct vh_parts *parts, const double *half_height, const int64_t *digit, uint8_t *out)
{
    struct point origin = {0, 0};

    memset(out, 0, (size_t)parts->n);
    for (int i = 0; i < parts->n; i++)
        for (int k = 0; k < parts->n; k++) {
            const double *a = parts->start + 3 * i, *b = parts->end + 3 * i;
            const double *c = parts->start + 3 * k, *d = parts->end + 3 * k;
            double line[4] = {c[0], c[1], d[0], d[1]};
            if (digit[i] == digit[k] || fabs(a[2] + b[2] - c[2] - d[2]) / 2 > half_height[i] + half_height[k])
                continue;
            if (fabs(closest(flat(a), flat(b), line, 2, origin).distance)
                < parts->radius[i] + parts->radius[k] + NEAR_M)
                out[i] = 1;
        }
}

/* Adds part i to what the fit of a ball minimizes. */
static void add_ball_part(const struct vh_parts *parts, int i, const double *x, struct normal *normal)
{
    const double *start = parts->start + 3 * i, *end = parts->end + 3 * i;
    double along_2 = 0, to = 0, apart[3], d = 0, off, row[MOST_UNKNOWNS], share;

    for (int k = 0; k < 3; k++) {
        along_2 += square(end[k] - start[k]);
        to += (x[k] - start[k]) * (end[k] - start[k]);
    }
    share = along_2 == 0 ? 0 : within(to / along_2, 0, 1);
    for (int k = 0; k < 3; k++) {
        apart[k] = start[k] + share * (end[k] - start[k]) - x[k];
        d += square(apart[k]);
    }
    d = sqrt(d) + 1e-12;
    off = d - x[3] / 2 - parts->radius[i];
    if (off >= 0 && parts->touch[i] == 0)
        return;
    for (int k = 0; k < 3; k++)
        row[k] = -apart[k] / d;
    row[3] = -0.5;
    add_part(normal, row, off, (int)parts->touch[i], parts->sigma);
}

double vh_fit_ball(const struct vh_parts *parts, double *found)
{
    double weight[4], usual[4] = {USUAL_SIZE_M / 2, 0, 0, USUAL_SIZE_M}, least = INFINITY;

    for (int j = 0; j < 4; j++)
        weight[j] = 1 / square(BALL_SPREAD[j]);
    memcpy(found, usual, sizeof usual);
    for (int first = 0; first < FIRST_SIZES; first++) {
        double x[4] = {usual[0], usual[1], usual[2], FIRST_SIZES_M[first]};
        struct normal normal;
        for (int step = 0; step <= MOST_STEPS; step++) {
            begin(&normal, x, usual, weight, 4);
            for (int i = 0; i < parts->n; i++)
                add_ball_part(parts, i, x, &normal);
            if (step == MOST_STEPS || step_down(&normal, x, BALL_METRES, 3) < ENOUGH_M)
                break;
        }
        if (normal.cost < least) {
            least = normal.cost;
            memcpy(found, x, sizeof x);
        }
    }
    return least;
}
