/* A small network of weights: from whitened inputs to the log-odds of every kind, and how far off all that is known. */
#include <string.h>
#include "touch.h"

/* Log-odds of a stranger for each unit of distance beyond the farthest that is known. */
#define PER_DISTANCE 0.3f
/* The greatest whole number that an input of coarse weights becomes, and the greatest sum that may come of it. */
#define MOST_WHOLE 32767
#define MOST_SUM 2147483647.0f
#define MOST_COARSE 127

int vh_widest(const struct vh_parameters *parameters)
{
    int most = parameters->inputs > parameters->whiten.outputs ? parameters->inputs : parameters->whiten.outputs;

    for (int i = 0; i < parameters->n_layers; i++)
        most = most > parameters->layers[i].outputs ? most : parameters->layers[i].outputs;
    return most;
}

size_t vh_kind_logits_work(const struct vh_parameters *parameters)
{
    return (size_t)vh_widest(parameters) * (2 * sizeof(float) + 3 * sizeof(int32_t));
}

struct vh_scratch vh_laid_out(const struct vh_parameters *parameters, void *work)
{
    int n = vh_widest(parameters);
    struct vh_scratch s;

    s.from = work;
    s.to = s.from + n;
    s.at = (int32_t *)(s.to + n);
    s.sums = s.at + n;
    s.whole = s.sums + n;
    return s;
}

/* Adds eight inputs' shares to all sums, in the inputs' order: the sums are read and written once for all. */
static void add_eight(const float *restrict weight, const int32_t *at, const float *x, int n, float *restrict out)
{
    const float *restrict a = weight + at[0] * n, *restrict b = weight + at[1] * n;
    const float *restrict c = weight + at[2] * n, *restrict d = weight + at[3] * n;
    const float *restrict e = weight + at[4] * n, *restrict f = weight + at[5] * n;
    const float *restrict g = weight + at[6] * n, *restrict h = weight + at[7] * n;
    float p = x[at[0]], q = x[at[1]], r = x[at[2]], s = x[at[3]], t = x[at[4]], u = x[at[5]], v = x[at[6]], w = x[at[7]];

    for (int j = 0; j < n; j++) {
        float sum = (((out[j] + p * a[j]) + q * b[j]) + r * c[j]) + s * d[j];
        out[j] = (((sum + t * e[j]) + u * f[j]) + v * g[j]) + w * h[j];
    }
}

/* The same of four. */
static void add_four(const float *restrict weight, const int32_t *at, const float *x, int n, float *restrict out)
{
    const float *restrict a = weight + at[0] * n, *restrict b = weight + at[1] * n;
    const float *restrict c = weight + at[2] * n, *restrict d = weight + at[3] * n;
    float p = x[at[0]], q = x[at[1]], r = x[at[2]], s = x[at[3]];

    for (int j = 0; j < n; j++)
        out[j] = (((out[j] + p * a[j]) + q * b[j]) + r * c[j]) + s * d[j];
}

/* The same of one. */
static void add_one(const float *restrict weight, float x, int n, float *restrict out)
{
    for (int j = 0; j < n; j++)
        out[j] += x * weight[j];
}

void vh_add_listed(const struct vh_layer *layer, const float *x, float *out, const int32_t *at, int count)
{
    int n = layer->outputs, k = 0;

    for (; k + 8 <= count; k += 8)
        add_eight(layer->weight, at + k, x, n, out);
    for (; k + 4 <= count; k += 4)
        add_four(layer->weight, at + k, x, n, out);
    for (; k < count; k++)
        add_one(layer->weight + at[k] * n, x[at[k]], n, out);
}

/* Adds x weight to out; inputs that are 0, as half of a hidden layer's are, cost nothing. */
static void add_fine(const struct vh_layer *layer, const float *x, float *out, int32_t *at)
{
    int count = 0;

    for (int i = 0; i < layer->inputs; i++) {
        uint32_t bits;
        /* Written always and kept only if it counts: no branch for the processor to guess. All bits but the sign are 0
         * in a zero: one comparison, where one of floats takes two. */
        memcpy(&bits, x + i, sizeof bits);
        at[count] = i;
        count += bits << 1 != 0;
    }
    vh_add_listed(layer, x, out, at, count);
}

static void add_four_coarse(const int8_t *restrict weight, const int32_t *at, const int32_t *x, int n,
                            int32_t *restrict out)
{
    const int8_t *restrict a = weight + at[0] * n, *restrict b = weight + at[1] * n;
    const int8_t *restrict c = weight + at[2] * n, *restrict d = weight + at[3] * n;
    int32_t p = x[at[0]], q = x[at[1]], r = x[at[2]], s = x[at[3]];
    int j = 0;

    /* Two at a time: a controller spends a quarter of its time on the loop otherwise. */
    for (; j + 2 <= n; j += 2) {
        int32_t one = out[j] + p * a[j], two = out[j + 1] + p * a[j + 1];
        one += q * b[j];
        two += q * b[j + 1];
        one += r * c[j];
        two += r * c[j + 1];
        out[j] = one + s * d[j];
        out[j + 1] = two + s * d[j + 1];
    }
    for (; j < n; j++)
        out[j] += p * a[j] + q * b[j] + r * c[j] + s * d[j];
}

/* Turns inputs into whole numbers that no sum of them by coarse weights overflows; returns what one is worth. */
static float whole_inputs(const float *x, int n, int32_t *whole)
{
    float largest = 0, most = MOST_SUM / (float)(MOST_COARSE * (n + 1));

    most = most < MOST_WHOLE ? most : MOST_WHOLE;
    for (int i = 0; i < n; i++)
        largest = fabs(x[i]) > largest ? fabs(x[i]) : largest;
    if (!(largest > 0))
        largest = 1;
    for (int i = 0; i < n; i++) {
        float v = x[i] * (most / largest);
        whole[i] = (int32_t)(v < 0 ? v - 0.5f : v + 0.5f);
    }
    return largest / most;
}

/* As add_fine, with coarse weights. */
static void add_coarse(const struct vh_layer *layer, const float *x, float *out, const struct vh_scratch *s)
{
    int n = layer->outputs, count = 0, k = 0;
    float worth = whole_inputs(x, layer->inputs, s->whole);

    memset(s->sums, 0, (size_t)n * sizeof *s->sums);
    for (int i = 0; i < layer->inputs; i++) {
        s->at[count] = i;
        count += s->whole[i] != 0;
    }
    for (; k + 4 <= count; k += 4)
        add_four_coarse(layer->coarse, s->at + k, s->whole, n, s->sums);
    for (; k < count; k++)
        for (int j = 0; j < n; j++)
            s->sums[j] += s->whole[s->at[k]] * layer->coarse[s->at[k] * n + j];
    for (int j = 0; j < n; j++)
        out[j] += (float)s->sums[j] * (worth * layer->scale[j]);
}

void vh_add_layer(const struct vh_layer *layer, const float *x, float *out, const struct vh_scratch *s)
{
    if (layer->coarse)
        add_coarse(layer, x, out, s);
    else
        add_fine(layer, x, out, s->at);
}

/* Returns how far a hidden layer lies from the nearest kind, in the kinds' own scatter. */
static float distance(const struct vh_parameters *parameters, const float *hidden, float *y, const struct vh_scratch *s)
{
    int n = parameters->whiten.outputs;
    float nearest = INFINITY;

    memset(y, 0, (size_t)n * sizeof *y);
    vh_add_layer(&parameters->whiten, hidden, y, s);
    /* Four means side by side: each one's sum waits for itself alone. */
    for (int k = 0; k < parameters->n_means; k += 4) {
        const float *mean[4];
        float total[4] = {0, 0, 0, 0};
        for (int m = 0; m < 4; m++)
            mean[m] = parameters->means + (k + m < parameters->n_means ? k + m : k) * n;
        for (int j = 0; j < n; j++)
            for (int m = 0; m < 4; m++)
                total[m] += (y[j] - mean[m][j]) * (y[j] - mean[m][j]);
        for (int m = 0; m < 4; m++)
            nearest = total[m] < nearest ? total[m] : nearest;
    }
    return sqrt(nearest);
}

void vh_bend(float *x, int n, int smooth)
{
    if (smooth)
        for (int i = 0; i < n; i++)
            x[i] = tanhf(x[i]);
    else
        for (int i = 0; i < n; i++)
            x[i] = x[i] > 0 ? x[i] : 0;
}

static void logits_of(const struct vh_parameters *parameters, const float *last, const float *hidden, float *y,
                  vh_real *logits, const struct vh_scratch *s)
{
    float beyond = 0;

    for (int k = 0; k < parameters->kinds; k++)
        logits[k] = last[k];
    if (hidden && parameters->n_means > 0)
        beyond = distance(parameters, hidden, y, s) - parameters->farthest;
    if (beyond > 0)
        logits[parameters->stranger] += PER_DISTANCE * beyond;
}

void vh_logits_after_first(const struct vh_parameters *parameters, struct vh_scratch s, int strangers, vh_real *logits)
{
    float *hidden = s.to, *out = s.from, *free;

    for (int layer = 1; layer < parameters->n_layers; layer++) {
        const struct vh_layer *next = &parameters->layers[layer];
        vh_bend(hidden, next->inputs, parameters->smooth);
        memcpy(out, next->bias, (size_t)next->outputs * sizeof *out);
        vh_add_layer(next, hidden, out, &s);
        free = hidden;
        hidden = out;
        out = free;
    }
    /* The layer before the last is still in `out`; the last one's numbers are no longer needed once they are read. */
    logits_of(parameters, hidden, strangers ? out : NULL, hidden, logits, &s);
}

void vh_whiten(const struct vh_parameters *parameters, const vh_real *numbers, vh_real *inputs)
{
    vh_real clip = parameters->clip;

    for (int i = 0; i < parameters->inputs; i++) {
        vh_real v = (numbers[i] - parameters->shift[i]) * parameters->scale[i];
        inputs[i] = v < -clip ? -clip : v > clip ? clip : v;
    }
}

void vh_kind_logits(const struct vh_parameters *parameters, const vh_real *inputs, vh_real *logits, void *work)
{
    struct vh_scratch s = vh_laid_out(parameters, work);
    const struct vh_layer *first = &parameters->layers[0];

    for (int i = 0; i < first->inputs; i++)
        s.from[i] = (float)inputs[i];
    memcpy(s.to, first->bias, (size_t)first->outputs * sizeof *s.to);
    vh_add_layer(first, s.from, s.to, &s);
    vh_logits_after_first(parameters, s, 1, logits);
}
