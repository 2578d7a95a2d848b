/* From a measured contact to its name. */
#include "touch.h"

/* A rest that was taken off and is so many times as high as what stands on it may be a plane that is pressed, with
 * what the last press left on it: these are its log-odds, log(0.55 / 0.45). Sensors keep up to 40 % of a press, and
 * hardly ever less than 8 %: what is higher yet is an offset. */
#define HIGH_REST 2.5
#define HIGHEST_REST 12.5
#define PLANE_ODDS 0.20067069546215122
/* Log-odds that outweigh whatever a table says. */
#define CERTAIN 1e3
#define ALL_SIDES 15
/* Of the contacts that names were learned from. */
#define MOST_SIDE 48

/* Tells whether the rest that was taken off is much higher than the contact that stands on it. */
static int stands_on_a_rest(const struct vh_contact *contact, const vh_real *rest)
{
    vh_real middle_col = 0.5 * (vh_real)(contact->width - 3), middle_row = 0.5 * (vh_real)(contact->height - 3);

    vh_real height = rest[0] + rest[1] * middle_col + rest[2] * middle_row;

    return height > HIGH_REST * contact->peak && height < HIGHEST_REST * contact->peak;
}

/* Tells whether every taxel of the field has the contact's peak value: nothing but a plane does that, and there is no
 * outline to tell. */
static int fills_evenly(const struct vh_contact *contact)
{
    if (contact->place[VH_BORDERS] != ALL_SIDES)
        return 0;
    for (int r = 1; r < contact->height - 1; r++)
        for (int c = 1; c < contact->width - 1; c++) {
            int p = r * contact->width + c;
            if (contact->padded[p] == -INFINITY)
                continue;
            if (contact->label[p] != contact->index || contact->padded[p] != contact->peak)
                return 0;
        }
    return 1;
}

/* The logarithm of the sum of all kinds' odds but those of one. */
static vh_real log_sum_without(const vh_real *logits, int n, int without)
{
    vh_real top = -INFINITY, sum = 0;

    for (int k = 0; k < n; k++)
        top = k != without && logits[k] > top ? logits[k] : top;
    for (int k = 0; k < n; k++)
        sum += k != without ? exp(logits[k] - top) : 0;
    return top + log(sum);
}

/* What the frame tells beside the table: of planes, and of kinds that cannot occur. */
static void adjust(const struct vh_contact *contact, const struct vh_parameters *parameters,
                   const struct vh_hints *hints, vh_real *logits)
{
    int plane = parameters->plane, n = parameters->kinds;

    if (plane >= 0 && stands_on_a_rest(contact, hints->rest))
        logits[plane] = vh_most(logits[plane], log_sum_without(logits, n, plane) + PLANE_ODDS);
    if (plane >= 0 && fills_evenly(contact))
        logits[plane] += CERTAIN;
    for (int k = 0; k < n && hints->allowed; k++)
        if (!hints->allowed[k])
            logits[k] = -INFINITY;
}

/* Turns log-odds into probabilities that sum to 1. */
static void normalize(vh_real *p, int n)
{
    vh_real top = p[0], sum = 0;

    for (int k = 1; k < n; k++)
        top = vh_most(top, p[k]);
    for (int k = 0; k < n; k++) {
        p[k] = exp(p[k] - top);
        sum += p[k];
    }
    for (int k = 0; k < n; k++)
        p[k] /= sum;
}

/* Returns the likeliest name, the likeliest kind of that name, and the name's probability: the sum of its kinds'. */
static struct vh_answer likeliest(const struct vh_parameters *parameters, const vh_real *p)
{
    struct vh_answer best = {0, 0, -1};

    for (int name = 0; name < parameters->names; name++) {
        vh_real total = 0, most = -1;
        int kind = 0;
        for (int k = 0; k < parameters->kinds; k++) {
            if (parameters->name_of[k] != name)
                continue;
            total += p[k];
            if (p[k] > most) {
                most = p[k];
                kind = k;
            }
        }
        if (total > best.probability) {
            best.name = name;
            best.kind = kind;
            best.probability = total;
        }
    }
    return best;
}

void vh_decide(const struct vh_contact *contact, const struct vh_parameters *parameters, const struct vh_hints *hints,
               vh_real *logits, struct vh_answer *answer)
{
    adjust(contact, parameters, hints, logits);
    normalize(logits, parameters->kinds);
    *answer = likeliest(parameters, logits);
}

int vh_is_as_learned(const struct vh_contact *contact)
{
    const vh_int *place = contact->place;

    return contact->floor >= VH_FLOOR_OF_PEAK * contact->peak && place[VH_BOTTOM] - place[VH_TOP] < MOST_SIDE
           && place[VH_RIGHT] - place[VH_LEFT] < MOST_SIDE;
}

int vh_recognize(const struct vh_contact *contact, const struct vh_parameters *parameters, const struct vh_hints *hints,
                 vh_real *inputs, vh_real *probability, struct vh_answer *answer, void *work)
{
    if (!hints->early && !vh_is_as_learned(contact))
        return 0;
    vh_signature(contact, inputs);
    vh_whiten(parameters, inputs, inputs);
    vh_kind_logits(parameters, inputs, probability, work);
    vh_decide(contact, parameters, hints, probability, answer);
    return 1;
}
