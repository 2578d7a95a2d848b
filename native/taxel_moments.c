/* How a contact's taxels lie about its centre, whatever its sections. */
#include "touch.h"

/* A taxel so many times its height above the floor counts whole in the base. */
#define BASE_GAIN 2.5
#define LEAST 1e-12

/* Sums of w |z|^n, and of w z^n with z = x + i y: how much the taxels look the same after an n-th of a turn. */
struct sums {
    vh_real r2, r3, r4, r6, re2, im2, re3, im3, re4, im4, re6, im6;
};

/* The weights of a taxel: its height, its square, or nearly all alike. */
static void weigh(vh_real height, vh_real *weight)
{
    weight[0] = height;
    weight[1] = height * height;
    weight[2] = BASE_GAIN * height < 1 ? BASE_GAIN * height : 1.0;
}

/* From 0 at the floor to 1. */
static vh_real height_of(const struct vh_contact *contact, vh_real value)
{
    vh_real above = (value - contact->floor) / vh_span(contact);
    return above > 0 ? above : 0.0;
}

static void add_moments(struct sums *s, vh_real w, vh_real u, vh_real v)
{
    vh_real square = u * u + v * v, zr = u * u - v * v, zi = 2 * u * v;
    vh_real fourth_r = zr * zr - zi * zi, fourth_i = 2 * zr * zi;

    s->r2 += w * square;
    s->r3 += w * square * sqrt(square);
    s->r4 += w * square * square;
    s->r6 += w * square * square * square;
    s->re2 += w * zr;
    s->im2 += w * zi;
    s->re3 += w * (zr * u - zi * v);
    s->im3 += w * (zr * v + zi * u);
    s->re4 += w * fourth_r;
    s->im4 += w * fourth_i;
    s->re6 += w * (fourth_r * zr - fourth_i * zi);
    s->im6 += w * (fourth_r * zi + fourth_i * zr);
}

static vh_real share(vh_real re, vh_real im, vh_real of)
{
    return sqrt(re * re + im * im) / vh_most(of, LEAST);
}

/* Writes the numbers of one weight, in the order of PER_WEIGHT. */
static void write_moments(const struct sums *s, vh_real total, vh_real area, vh_real *out)
{
    vh_real r2 = vh_most(s->r2, LEAST);

    out[0] = 2 * PI * r2 / total / area;
    out[1] = s->r4 * total / (r2 * r2) - 1;
    out[2] = share(s->re2, s->im2, r2);
    out[3] = share(s->re3, s->im3, s->r3);
    out[4] = share(s->re4, s->im4, s->r4);
    out[5] = share(s->re6, s->im6, s->r6);
}

/* Finds the centres of all weights, the sum of each and of all heights, and the highest taxel. */
static void centres(const struct vh_contact *contact, struct vh_taxels *t)
{
    vh_real mx[VH_WEIGHTS] = {0}, my[VH_WEIGHTS] = {0}, w[VH_WEIGHTS], highest = -1;
    vh_int r, c;
    int k;

    for (r = contact->place[VH_TOP]; r <= contact->place[VH_BOTTOM]; r++)
        for (c = contact->place[VH_LEFT]; c <= contact->place[VH_RIGHT]; c++) {
            vh_int p = r * contact->width + c;
            vh_real height, x = (vh_real)c * t->step_x, y = (vh_real)r * t->step_y;
            if (contact->label[p] != contact->index)
                continue;
            height = height_of(contact, contact->padded[p]);
            if (height > highest + VH_SAME) {
                highest = height;
                t->highest_x = x;
                t->highest_y = y;
            }
            weigh(height, w);
            for (k = 0; k < VH_WEIGHTS; k++) {
                t->total[k] += w[k];
                mx[k] += w[k] * x;
                my[k] += w[k] * y;
            }
        }
    t->heights = t->total[0];
    for (k = 0; k < VH_WEIGHTS; k++) {
        t->total[k] = vh_most(t->total[k], LEAST);
        t->x[k] = mx[k] / t->total[k];
        t->y[k] = my[k] / t->total[k];
    }
}

struct vh_taxels vh_taxel_moments(const struct vh_contact *contact, const struct vh_base *base, vh_real reach, vh_real *out)
{
    struct vh_taxels t = {0};
    struct sums sums[VH_WEIGHTS] = {{0}};
    vh_real w[VH_WEIGHTS], near = 0, weight = 0;
    vh_int r, c;
    int k;

    t.step_x = contact->col_pitch / base->unit;
    t.step_y = contact->row_pitch / base->unit;
    centres(contact, &t);
    for (r = contact->place[VH_TOP]; r <= contact->place[VH_BOTTOM]; r++)
        for (c = contact->place[VH_LEFT]; c <= contact->place[VH_RIGHT]; c++) {
            vh_int p = r * contact->width + c;
            vh_real height, g, x = (vh_real)c * t.step_x, y = (vh_real)r * t.step_y;
            if (contact->label[p] != contact->index)
                continue;
            height = height_of(contact, contact->padded[p]);
            weigh(height, w);
            for (k = 0; k < VH_WEIGHTS; k++)
                add_moments(&sums[k], w[k], x - t.x[k], y - t.y[k]);
            g = exp(-((x - t.x[0]) * (x - t.x[0]) + (y - t.y[0]) * (y - t.y[0])) / reach);
            near += g * height;
            weight += g;
        }
    for (k = 0; k < VH_WEIGHTS; k++)
        write_moments(&sums[k], t.total[k], base->area, out + k * VH_PER_WEIGHT);
    t.at_centre = weight > 0 ? near / weight : 0.0;
    return t;
}
