/* Why a decision fell: what its log-odds lose where a group of inputs is what it usually is for the rival. */
#include <string.h>
#include "touch.h"

/* So many rows of inputs go through a layer at once, at most: its weights are read once for all of them. Two by two. */
#define ROWS 16

size_t vh_evidence_work(const struct vh_parameters *parameters)
{
    return vh_kind_logits_work(parameters) + (size_t)(2 + 2 * ROWS) * (size_t)vh_widest(parameters) * sizeof(float);
}

/* Numbers of several rows, which begin `stride` apart. */
struct rows {
    float *at;
    int count, stride;
};

/* Adds four inputs' shares to all sums of all rows, in the inputs' order. */
static void add_four(const float *weight, const int32_t *at, const struct rows *x, const struct rows *out, int n)
{
    const float *restrict a = weight + at[0] * n, *restrict b = weight + at[1] * n;
    const float *restrict c = weight + at[2] * n, *restrict d = weight + at[3] * n;

    for (int r = 0; r < x->count; r += 2) {
        const float *x0 = x->at + r * x->stride, *x1 = x0 + x->stride;
        float *restrict o0 = out->at + r * out->stride, *restrict o1 = o0 + out->stride;
        float p0 = x0[at[0]], q0 = x0[at[1]], s0 = x0[at[2]], t0 = x0[at[3]];
        float p1 = x1[at[0]], q1 = x1[at[1]], s1 = x1[at[2]], t1 = x1[at[3]];
        for (int j = 0; j < n; j++) {
            o0[j] = (((o0[j] + p0 * a[j]) + q0 * b[j]) + s0 * c[j]) + t0 * d[j];
            o1[j] = (((o1[j] + p1 * a[j]) + q1 * b[j]) + s1 * c[j]) + t1 * d[j];
        }
    }
}

/* Writes which inputs are not 0 in some row, and returns how many; `used` is written over. */
static int used_inputs(const struct rows *x, int inputs, int32_t *restrict used, int32_t *at)
{
    int count = 0;

    memset(used, 0, (size_t)inputs * sizeof *used);
    for (int r = 0; r < x->count; r++) {
        const float *row = x->at + r * x->stride;
        for (int i = 0; i < inputs; i++)
            used[i] |= row[i] != 0;
    }
    for (int i = 0; i < inputs; i++) {
        at[count] = i;
        count += used[i];
    }
    return count;
}

/* Adds x weight to out for all rows. */
static void add_layer_to_rows(const struct vh_layer *layer, const struct rows *x, const struct rows *out,
                              const struct vh_scratch *s)
{
    int n = layer->outputs, count = used_inputs(x, layer->inputs, s->sums, s->at), k = 0;

    for (; k + 4 <= count; k += 4)
        add_four(layer->weight, s->at + k, x, out, n);
    for (int r = 0; r < x->count; r++)
        vh_add_listed(layer, x->at + r * x->stride, out->at + r * out->stride, s->at + k, count - k);
}

/* Takes all rows from what the first layer sums, in `hidden`, to what the last one gives; the layer before it is left
 * in `before`. */
static void rows_after_first(const struct vh_parameters *parameters, struct rows *hidden, struct rows *before,
                             const struct vh_scratch *s)
{
    for (int layer = 1; layer < parameters->n_layers; layer++) {
        const struct vh_layer *next = &parameters->layers[layer];
        struct rows out = *before;
        for (int r = 0; r < hidden->count; r++) {
            vh_bend(hidden->at + r * hidden->stride, next->inputs, parameters->smooth);
            memcpy(out.at + r * out.stride, next->bias, (size_t)next->outputs * sizeof *out.at);
        }
        add_layer_to_rows(next, hidden, &out, s);
        *before = *hidden;
        *hidden = out;
    }
}

/* Lists the inputs group after group, those of one in their order; those of group g begin at begin[g]. */
static void list_groups(const uint8_t *group_of, int inputs, int32_t begin[257], int32_t *listed)
{
    memset(begin, 0, 257 * sizeof *begin);
    for (int i = 0; i < inputs; i++)
        begin[group_of[i] + 1]++;
    for (int g = 0; g < 256; g++)
        begin[g + 1] += begin[g];
    for (int i = 0; i < inputs; i++)
        listed[begin[group_of[i]]++] = i;
    /* Where a group began, the one before has ended now. */
    memmove(begin + 1, begin, 256 * sizeof *begin);
    begin[0] = 0;
}

void vh_evidence(const struct vh_parameters *parameters, const vh_real *inputs, const vh_real *usual,
                 const uint8_t *group_of, int groups, int kind, int rival, vh_real *logits, vh_real *nats, void *work)
{
    struct vh_scratch s = vh_laid_out(parameters, work);
    const struct vh_layer *first = &parameters->layers[0];
    int stride = vh_widest(parameters);
    int strangers = kind == parameters->stranger || rival == parameters->stranger;
    float *whole = (float *)(s.whole + stride), *change = whole + stride, *room = change + stride;
    int32_t begin[257], *listed = s.whole;
    vh_real odds = 0;

    for (int i = 0; i < first->inputs; i++) {
        s.from[i] = (float)inputs[i];
        change[i] = (float)(usual[i] - inputs[i]);
    }
    memcpy(whole, first->bias, (size_t)first->outputs * sizeof *whole);
    vh_add_layer(first, s.from, whole, &s);
    list_groups(group_of, first->inputs, begin, listed);
    /* The first of all rows is the decision as it is, before the groups'. */
    for (int row = 0; row <= groups; row += ROWS) {
        const int left = groups + 1 - row, count = left < ROWS ? left + left % 2 : ROWS;
        struct rows hidden = {room, count, stride}, before = {room + ROWS * stride, count, stride};
        for (int r = 0; r < count; r++) {
            const int group = row + r - 1, some = group >= 0 && group < groups;
            memcpy(hidden.at + r * stride, whole, (size_t)first->outputs * sizeof *whole);
            /* The first layer is linear: what a group's inputs change where they are the rival's usual ones is added. */
            if (some)
                vh_add_listed(first, change, hidden.at + r * stride, listed + begin[group], begin[group + 1] - begin[group]);
        }
        rows_after_first(parameters, &hidden, &before, &s);
        for (int r = 0; r < count && row + r <= groups; r++) {
            float *last = hidden.at + r * stride;
            vh_logits_of(parameters, last, strangers ? before.at + r * stride : NULL, last, logits, &s);
            if (row + r == 0)
                odds = logits[kind] - logits[rival];
            else
                nats[row + r - 1] = odds - (logits[kind] - logits[rival]);
        }
    }
}
