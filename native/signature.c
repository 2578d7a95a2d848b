/* A contact's signature: scale-free numbers that say how its sections nest and grow, and how its taxels lie. */
#include "touch.h"

/* Frames as good as free of noise, and those too small to tell, count as having this share of it. */
#define LEAST_NOISE 1.5e-3
/* What stands at the centre is a mean over this share of the lowest section's area and half a taxel. */
#define CENTRE_SHARE 0.02
#define CENTRE_TAXELS 0.5

/* Returns the share of `lines` whose first taxel is the contact's; gaps of the field are passed over. The first line
 * begins at p, the next `next` further; its taxels are `step` apart. */
static vh_real outermost_share(const struct vh_contact *contact, vh_int p, vh_int next, vh_int lines, vh_int step, vh_int n)
{
    vh_int taken = 0, there = 0, i, k, at;

    for (i = 0; i < lines; i++) {
        at = p + i * next;
        for (k = 0; k < n && contact->padded[at] == -INFINITY; k++)
            at += step;
        if (k < n) {
            there++;
            taken += contact->label[at] == contact->index;
        }
    }
    return (vh_real)taken / (vh_real)(there > 0 ? there : 1);
}

/* Writes how much of the field's upper, lower, left and right side the contact covers, each from 0 to 1. */
static void side_shares(const struct vh_contact *contact, vh_real *sides)
{
    vh_int rows = contact->height - 2, cols = contact->width - 2, w = contact->width, first = w + 1;

    sides[0] = outermost_share(contact, first, 1, cols, w, rows);
    sides[1] = outermost_share(contact, first + (rows - 1) * w, 1, cols, -w, rows);
    sides[2] = outermost_share(contact, first, w, rows, 1, cols);
    sides[3] = outermost_share(contact, first + cols - 1, w, rows, -1, cols);
}

static void sort_falling(vh_real *a, int n)
{
    int i, k;

    for (i = 1; i < n; i++)
        for (k = i; k > 0 && a[k] > a[k - 1]; k--) {
            vh_real v = a[k];
            a[k] = a[k - 1];
            a[k - 1] = v;
        }
}

void vh_signature(const struct vh_contact *contact, vh_real *out)
{
    vh_real unit = sqrt(contact->row_pitch * contact->col_pitch), span = vh_span(contact), sides[4], dx, dy;
    struct vh_base base = vh_lowest_section(contact, unit);
    vh_real reach = 2 * (CENTRE_SHARE * base.area + CENTRE_TAXELS);
    vh_int taxels = (contact->height - 2) * (contact->width - 2);
    vh_real *single = out + VH_PER_BAND * VH_BANDS + VH_WEIGHTS * VH_PER_WEIGHT;
    struct vh_taxels t;

    vh_section_bands(contact, &base, out);
    t = vh_taxel_moments(contact, &base, reach, out + VH_PER_BAND * VH_BANDS);
    side_shares(contact, sides);
    dx = t.highest_x - t.x[0];
    dy = t.highest_y - t.y[0];
    single[0] = t.heights / vh_most(base.area, 1);
    single[1] = t.at_centre;
    single[2] = sqrt(dx * dx + dy * dy) / base.root_area;
    single[3] = log(base.root_area);
    single[4] = log(base.minor);
    single[5] = log(vh_most(contact->sigma / span, LEAST_NOISE));
    single[6] = (vh_real)contact->place[VH_N_TAXELS] / (vh_real)taxels;
    single[11] = vh_most(vh_least(sides[0], sides[1]), vh_least(sides[2], sides[3]));
    sort_falling(sides, 4);
    single[7] = sides[0];
    single[8] = sides[1];
    single[9] = sides[2];
    single[10] = sides[3];
    vh_state(contact, single + 12);
}
