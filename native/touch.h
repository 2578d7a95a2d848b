/* What the sources of touch share; not for users. */
#ifndef VH_TOUCH_H
#define VH_TOUCH_H

#include "inner.h"

/* Numbers of a signature: so many of each band, of each weight of the taxels, by themselves, and of the state. */
enum { VH_BANDS = 8, VH_PER_BAND = 15, VH_WEIGHTS = 3, VH_PER_WEIGHT = 6, VH_SINGLE_NUMBERS = 12, VH_STATE = 23 };

/* The lowest section, against which all others are measured: lengths in `unit`, the root of a taxel's area; the centre
 * in the profile's unit. */
struct vh_base {
    vh_real unit, area, root_area, perimeter, major, minor, x, y;
};

/* What the taxels say as a whole: the sum and the centre of each of their weights, the sum of their heights, the mean
 * height around the first centre, the highest taxel. Positions in taxels of area 1. */
struct vh_taxels {
    vh_real step_x, step_y, total[VH_WEIGHTS], x[VH_WEIGHTS], y[VH_WEIGHTS], heights, at_centre, highest_x, highest_y;
};

/* How far a contact stands above its floor. */
static inline vh_real vh_span(const struct vh_contact *contact)
{
    return contact->peak > contact->floor ? contact->peak - contact->floor : 1;
}

struct vh_base vh_lowest_section(const struct vh_contact *contact, vh_real unit);
void vh_section_bands(const struct vh_contact *contact, const struct vh_base *base, vh_real *out);
struct vh_taxels vh_taxel_moments(const struct vh_contact *contact, const struct vh_base *base, vh_real reach,
                                  vh_real *out);
void vh_state(const struct vh_contact *contact, vh_real *out);

/* What is worked with: two layers' numbers, which of the inputs are not 0, sums of whole numbers, inputs as such. */
struct vh_scratch {
    float *from, *to;
    int32_t *at, *sums, *whole;
};

/* The most numbers that a layer takes or gives. */
int vh_widest(const struct vh_parameters *parameters);
/* Work space of vh_kind_logits_work as such. */
struct vh_scratch vh_laid_out(const struct vh_parameters *parameters, void *work);
/* Adds x weight to out. */
void vh_add_layer(const struct vh_layer *layer, const float *x, float *out, const struct vh_scratch *s);
/* Adds only the listed inputs' shares; the layer's weights are fine ones. */
void vh_add_listed(const struct vh_layer *layer, const float *x, float *out, const int32_t *at, int count);
/* Goes on from what the first layer gives, before it is bent, in s.to; overwrites it and s.from. Where strangers do not
 * matter, how far off all that is known it is need not be told. */
void vh_logits_after_first(const struct vh_parameters *parameters, struct vh_scratch s, int strangers, vh_real *logits);

#endif
