/* Why a decision fell: what its log-odds lose where a group of inputs is what it usually is for the rival. */
#include <string.h>
#include "touch.h"

/* A group is told by a byte. */
#define MOST_GROUPS 256

size_t vh_evidence_work(const struct vh_parameters *parameters)
{
    return vh_kind_logits_work(parameters) + 2 * (size_t)vh_widest(parameters) * sizeof(float);
}

/* Lists the inputs group by group, those of one in their order; those of group g begin at begin[g]. */
static void list_groups(const uint8_t *group_of, int inputs, int groups, int32_t begin[MOST_GROUPS + 1], int32_t *listed)
{
    memset(begin, 0, ((size_t)groups + 1) * sizeof *begin);
    for (int i = 0; i < inputs; i++)
        begin[group_of[i] + 1]++;
    for (int g = 0; g < groups; g++)
        begin[g + 1] += begin[g];
    for (int i = 0; i < inputs; i++)
        listed[begin[group_of[i]]++] = i;
    /* Where a group began, the one before it has ended now. */
    memmove(begin + 1, begin, (size_t)groups * sizeof *begin);
    begin[0] = 0;
}

void vh_evidence(const struct vh_parameters *parameters, const vh_real *inputs, const vh_real *usual,
                 const uint8_t *group_of, int groups, int kind, int rival, vh_real *logits, vh_real *nats, void *work)
{
    struct vh_scratch s = vh_laid_out(parameters, work);
    const struct vh_layer *first = &parameters->layers[0];
    int strangers = kind == parameters->stranger || rival == parameters->stranger;
    float *whole = (float *)(s.whole + vh_widest(parameters)), *change = whole + vh_widest(parameters);
    int32_t begin[MOST_GROUPS + 1], *listed = s.whole;
    vh_real odds = 0;

    for (int i = 0; i < first->inputs; i++) {
        s.from[i] = (float)inputs[i];
        change[i] = (float)(usual[i] - inputs[i]);
    }
    list_groups(group_of, first->inputs, groups, begin, listed);
    memcpy(whole, first->bias, (size_t)first->outputs * sizeof *whole);
    vh_add_layer(first, s.from, whole, &s);
    /* The decision as it is, then without each group. The first layer is linear, so that what a group's inputs change
     * there is added to what all of them gave. */
    for (int group = -1; group < groups; group++) {
        memcpy(s.to, whole, (size_t)first->outputs * sizeof *whole);
        if (group >= 0)
            vh_add_listed(first, change, s.to, listed + begin[group], begin[group + 1] - begin[group]);
        vh_logits_after_first(parameters, s, strangers, logits);
        if (group < 0)
            odds = logits[kind] - logits[rival];
        else
            nats[group] = odds - (logits[kind] - logits[rival]);
    }
}
