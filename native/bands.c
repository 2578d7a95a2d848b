/* What a contact's sections say, gathered in bands of relative depth.
 *
 * Relative depth is q = (theta_1 - theta) / (theta_1 - delta), so that any schedule of thresholds gives the same
 * numbers. Every length is measured against the lowest section, so that neither the pitch nor the unit matters.
 */
#include "touch.h"

#include <string.h>

enum { THRESHOLD = 0, AREA = 1, PERIMETER = 2, CENTROID = 3, COVARIANCE = 5, EXTENT = 9 };

/* Added to axes, so that a section of no breadth has ratios too. */
#define LEAST_AXIS 1e-6
#define LEAST_AREA 1e-9
#define MOST_HOLES 3
#define MOST_PARTS 4
/* A sliver's ratio may be anything; what lies beyond a few units says no more. */
#define MOST 4.0

/* sin and cos of an eighth and of three eighths of a right angle's double, and of half a right angle. */
#define COS_1 0.92387953251128675613
#define COS_2 0.70710678118654752440
#define COS_3 0.38268343236508977173

struct widths {
    vh_real second, fourth, phase, sixth, box;
};

/* Returns the square roots of the moments about the principal axes, the larger first, in taxels. */
static void axes(const vh_real *covariance, vh_real unit, vh_real *major, vh_real *minor)
{
    vh_real half = 0.5 * (covariance[0] + covariance[3]), difference = 0.5 * (covariance[0] - covariance[3]);
    vh_real root = sqrt(difference * difference + covariance[1] * covariance[1]);
    vh_real low = half - root;

    *major = sqrt(half + root) / unit + LEAST_AXIS;
    *minor = sqrt(low < 0 ? 0.0 : low) / unit + LEAST_AXIS;
}

struct vh_base vh_lowest_section(const struct vh_contact *contact, vh_real unit)
{
    int n = contact->levels, last = n - 1;
    const vh_real *m = contact->measures, *area = m + AREA * n, *centroid = m + CENTROID * n;
    struct vh_base base;

    while (last > 0 && !(area[last] > 0))
        last--;
    base.unit = unit;
    base.area = vh_most(area[last] / (unit * unit), LEAST_AREA);
    base.root_area = sqrt(base.area);
    base.perimeter = vh_most(m[PERIMETER * n + last] / unit, LEAST_AREA);
    axes(m + COVARIANCE * n + 4 * last, unit, &base.major, &base.minor);
    base.x = centroid[2 * last];
    base.y = centroid[2 * last + 1];
    return base;
}

/* What the widths w in 16 directions say: their second, fourth (and along the elongation) and sixth harmonic as
 * shares of the mean width, and the least product of two widths at right angles.
 *
 * Direction k + 8 is at right angles to k: the second and the sixth harmonic change their sign there, the fourth
 * does not, and it changes its sign a quarter further. So sums and differences of widths at right angles suffice. */
static struct widths widths(const vh_real *extent, vh_real unit)
{
    vh_real d[8], f[4], sum = 0, box = 1e30, over = 1 / unit, square, re, im, c2, s2, c4, s4, c6, s6;
    struct widths out;
    int k;

    for (k = 0; k < 8; k++) {
        vh_real w = extent[k] * over, v = extent[k + 8] * over, product = w * v;
        sum += w + v;
        d[k] = w - v;
        box = product < box ? product : box;
    }
    for (k = 0; k < 4; k++)
        f[k] = (extent[k] + extent[k + 8] - extent[k + 4] - extent[k + 12]) * over;
    c2 = d[0] + COS_1 * (d[1] - d[7]) + COS_2 * (d[2] - d[6]) + COS_3 * (d[3] - d[5]);
    s2 = d[4] + COS_3 * (d[1] + d[7]) + COS_2 * (d[2] + d[6]) + COS_1 * (d[3] + d[5]);
    c6 = d[0] + COS_3 * (d[1] - d[7]) - COS_2 * (d[2] - d[6]) - COS_1 * (d[3] - d[5]);
    s6 = COS_1 * (d[1] + d[7]) + COS_2 * (d[2] + d[6]) - COS_3 * (d[3] + d[5]) - d[4];
    c4 = f[0] + COS_2 * (f[1] - f[3]);
    s4 = f[2] + COS_2 * (f[1] + f[3]);
    sum = vh_most(sum, LEAST_AREA);
    out.second = sqrt(c2 * c2 + s2 * s2);
    /* The fourth harmonic along the elongation's own axis: its sign tells a rectangle from an ellipse. What is as good as
     * round has no axis, but one that rounding makes. */
    square = c2 * c2 + s2 * s2 + VH_SAME * VH_SAME * sum * sum;
    re = (c2 * c2 - s2 * s2) / square;
    im = 2 * c2 * s2 / square;
    out.phase = (c4 * re + s4 * im) / sum;
    out.second /= sum;
    out.fourth = sqrt(c4 * c4 + s4 * s4) / sum;
    out.sixth = sqrt(c6 * c6 + s6 * s6) / sum;
    out.box = vh_most(box, LEAST_AREA);
    return out;
}

/* Adds the numbers of section i to its band, in the order of PER_BAND; `area` is in taxels. */
static void add_section(const struct vh_contact *contact, int i, vh_real area, const struct vh_base *base, vh_real *band)
{
    int n = contact->levels;
    const vh_real *m = contact->measures, *centroid = m + CENTROID * n + 2 * i;
    vh_real perimeter = m[PERIMETER * n + i] / base->unit;
    vh_real x = centroid[0] - base->x, y = centroid[1] - base->y, major, minor;
    struct widths w = widths(m + EXTENT * n + 16 * i, base->unit);
    vh_int parts = contact->counts[i], holes = contact->counts[n + i];

    axes(m + COVARIANCE * n + 4 * i, base->unit, &major, &minor);
    band[0 * VH_BANDS] += sqrt(area) / base->root_area;
    band[1 * VH_BANDS] += minor / base->minor;
    band[2 * VH_BANDS] += major / base->major;
    band[3 * VH_BANDS] += perimeter / base->perimeter;
    band[4 * VH_BANDS] += perimeter * perimeter / (4 * PI * area);
    band[5 * VH_BANDS] += minor / major;
    band[6 * VH_BANDS] += 4 * PI * major * minor / area;
    band[7 * VH_BANDS] += area / w.box;
    band[8 * VH_BANDS] += w.second;
    band[9 * VH_BANDS] += w.fourth;
    band[10 * VH_BANDS] += w.phase;
    band[11 * VH_BANDS] += w.sixth;
    band[12 * VH_BANDS] += sqrt(x * x + y * y) / base->unit / base->root_area;
    band[13 * VH_BANDS] += holes < MOST_HOLES ? (vh_real)holes : (vh_real)MOST_HOLES;
    band[14 * VH_BANDS] += parts < MOST_PARTS ? (vh_real)parts : (vh_real)MOST_PARTS;
}

/* Gives a band without a section what the one above it has; those above all sections, what the first has. */
static void fill_empty(vh_real *out, const int *count)
{
    int band, j, from = 0;

    while (from < VH_BANDS && count[from] == 0)
        from++;
    if (from == VH_BANDS)
        return;
    for (band = 0; band < VH_BANDS; band++) {
        if (count[band] > 0)
            from = band;
        else
            for (j = 0; j < VH_PER_BAND; j++)
                out[j * VH_BANDS + band] = out[j * VH_BANDS + from];
    }
}

void vh_section_bands(const struct vh_contact *contact, const struct vh_base *base, vh_real *out)
{
    int n = contact->levels, count[VH_BANDS] = {0}, i, j, band;
    const vh_real *threshold = contact->measures, *areas = threshold + AREA * n;

    memset(out, 0, VH_PER_BAND * VH_BANDS * sizeof *out);
    for (i = 0; i < n; i++) {
        vh_real area = areas[i] / (base->unit * base->unit), q;
        if (!(area > LEAST_AREA))
            continue;
        q = (contact->peak - threshold[i]) / vh_span(contact) * (VH_BANDS * (1 + VH_SAME));
        band = q < 0 ? 0 : q < VH_BANDS - 1 ? (int)q : VH_BANDS - 1;
        add_section(contact, i, area, base, out + band);
        count[band]++;
    }
    for (band = 0; band < VH_BANDS; band++)
        for (j = 0; j < VH_PER_BAND && count[band] > 0; j++) {
            vh_real v = out[j * VH_BANDS + band] / (vh_real)count[band];
            out[j * VH_BANDS + band] = v < MOST ? v : MOST + log(v / MOST);
        }
    fill_empty(out, count);
}
