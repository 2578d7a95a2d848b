/* Why a decision fell: what its log-odds lose where a group of inputs is what it usually is for the rival. */
#include <string.h>
#include "touch.h"

/* So many rows of inputs go through a layer at once. */
#define ROWS 4

size_t vh_evidence_work(const struct vh_parameters *parameters)
{
    return vh_kind_logits_work(parameters) + (size_t)(2 + 2 * ROWS) * (size_t)vh_widest(parameters) * sizeof(float);
}

/* Adds two inputs' shares to all sums of all rows, in the inputs' order: what is read of the weights serves every row. */
static void add_two(const float *restrict a, const float *restrict b, const float *x, const float *y, int stride, int n,
                    float *out)
{
    float *restrict o0 = out, *restrict o1 = out + stride, *restrict o2 = o1 + stride, *restrict o3 = o2 + stride;
    float x0 = x[0], x1 = x[stride], x2 = x[2 * stride], x3 = x[3 * stride];
    float y0 = y[0], y1 = y[stride], y2 = y[2 * stride], y3 = y[3 * stride];

    for (int j = 0; j < n; j++) {
        o0[j] = (o0[j] + x0 * a[j]) + y0 * b[j];
        o1[j] = (o1[j] + x1 * a[j]) + y1 * b[j];
        o2[j] = (o2[j] + x2 * a[j]) + y2 * b[j];
        o3[j] = (o3[j] + x3 * a[j]) + y3 * b[j];
    }
}

/* Writes which inputs are not 0 in some row, and returns how many; `used` is written over. */
static int used_inputs(const float *x, int inputs, int stride, float *restrict used, int32_t *at)
{
    const float *x1 = x + stride, *x2 = x1 + stride, *x3 = x2 + stride;
    int count = 0;

    for (int i = 0; i < inputs; i++)
        used[i] = (x[i] != 0) | (x1[i] != 0) | (x2[i] != 0) | (x3[i] != 0);
    for (int i = 0; i < inputs; i++) {
        at[count] = i;
        count += used[i] != 0;
    }
    return count;
}

/* Adds x weight to out for all rows. */
static void add_layer_to_rows(const struct vh_layer *layer, const float *x, float *out, int stride,
                              const struct vh_scratch *s)
{
    int n = layer->outputs, count, k = 0;

    count = used_inputs(x, layer->inputs, stride, s->from, s->at);
    for (; k + 2 <= count; k += 2)
        add_two(layer->weight + s->at[k] * n, layer->weight + s->at[k + 1] * n, x + s->at[k], x + s->at[k + 1], stride, n,
                out);
    for (; k < count; k++)
        for (int r = 0; r < ROWS; r++)
            for (int j = 0; j < n; j++)
                out[r * stride + j] += x[r * stride + s->at[k]] * layer->weight[s->at[k] * n + j];
}

/* Takes all rows from what the first layer sums, in `*hidden`, to what the last one gives; the layer before it is left
 * in `*before`. */
static void rows_after_first(const struct vh_parameters *parameters, float **hidden, float **before, int stride,
                             const struct vh_scratch *s)
{
    for (int layer = 1; layer < parameters->n_layers; layer++) {
        const struct vh_layer *next = &parameters->layers[layer];
        float *out = *before;
        for (int r = 0; r < ROWS; r++) {
            vh_bend(*hidden + r * stride, next->inputs, parameters->smooth);
            memcpy(out + r * stride, next->bias, (size_t)next->outputs * sizeof *out);
        }
        add_layer_to_rows(next, *hidden, out, stride, s);
        *before = *hidden;
        *hidden = out;
    }
}

/* Writes what the first layer sums where a group's inputs are the rival's usual ones; it is linear, so that what they
 * change, `change`, is added to what all gave. */
static void sum_without(const struct vh_layer *first, const float *change, const uint8_t *group_of, int group,
                        const float *whole, float *out, int32_t *at)
{
    int count = 0;

    for (int i = 0; i < first->inputs; i++) {
        at[count] = i;
        count += group_of[i] == group;
    }
    memcpy(out, whole, (size_t)first->outputs * sizeof *out);
    vh_add_listed(first, change, out, at, count);
}

void vh_evidence(const struct vh_parameters *parameters, const vh_real *inputs, const vh_real *usual,
                 const uint8_t *group_of, int groups, int kind, int rival, vh_real *logits, vh_real *nats, void *work)
{
    struct vh_scratch s = vh_laid_out(parameters, work);
    const struct vh_layer *first = &parameters->layers[0];
    int stride = vh_widest(parameters);
    int strangers = kind == parameters->stranger || rival == parameters->stranger;
    float *whole = (float *)(s.whole + stride), *change = whole + stride;
    float *hidden = change + stride, *before = hidden + ROWS * stride;
    vh_real odds = 0;

    for (int i = 0; i < first->inputs; i++) {
        s.from[i] = (float)inputs[i];
        change[i] = (float)(usual[i] - inputs[i]);
    }
    memcpy(whole, first->bias, (size_t)first->outputs * sizeof *whole);
    vh_add_layer(first, s.from, whole, &s);
    /* The first of all rows is the decision as it is, before the groups'. */
    for (int row = 0; row <= groups; row += ROWS) {
        for (int r = 0; r < ROWS; r++)
            sum_without(first, change, group_of, row + r - 1, whole, hidden + r * stride, s.at);
        rows_after_first(parameters, &hidden, &before, stride, &s);
        for (int r = 0; r < ROWS && row + r <= groups; r++) {
            float *last = hidden + r * stride;
            vh_logits_of(parameters, last, strangers ? before + r * stride : NULL, last, logits, &s);
            if (row + r == 0)
                odds = logits[kind] - logits[rival];
            else
                nats[row + r - 1] = odds - (logits[kind] - logits[rival]);
        }
    }
}
