/* From a measured contact to its name. */
#include "touch.h"

#include <stddef.h>

/* A rest that was taken off and is so many times as high as what stands on it may be a plane that is pressed, with
 * what the last press left on it: these are its log-odds, log(0.55 / 0.45). Sensors keep up to 40 % of a press, and
 * hardly ever less than 8 %: what is higher yet is an offset. */
#define HIGH_REST 2.5
#define HIGHEST_REST 12.5
#define PLANE_ODDS 0.20067069546215122
/* A hollow in a plane, in parts of how far taxels lie off the plane in all: those this near it are level with it, those
 * this far below it are deep. Shares of the taxels that are level at least, and higher at most. A hill stands on taxels
 * that may rest at values of their own. */
#define HOLLOW_LEVEL 0.1
#define HILL_LEVEL 0.25
#define PATCH_DEEP 0.4
#define MOST_LEVEL 0.399999
#define FEW_BEYOND 0.030001
#define FEWEST_DEEP 4
/* Of a field of fewer taxels, and where more than this share of them show exactly the highest value, as they do where a
 * sensor ends, nothing tells a plane from anything else that is larger than the field. */
#define FEWEST_OF_FORM 9
#define MOST_AT_TOP 0.5
/* What is so high everywhere is a plane more often than not: log(0.85 / 0.15), which is not sure. */
#define TOP_ODDS 1.7346010553881064
#define ALL_SIDES 15
#define LEFT_TO_RIGHT 3
#define TOP_TO_BOTTOM 12
/* Of a bar more than a third of which reads exactly the same where noise makes readings differ, and less than three
 * quarters, nobody knows whether it is a cylinder that lies, at the end of what the sensor can read: log(0.88 / 0.12).
 * Of a steep bar nearly all is so high. Noise of half a count makes readings differ. */
#define BAR_ODDS 1.9924301646902063
#define LEAST_AT_END 0.333333
#define MOST_AT_END 0.749999
#define OF_COUNT 0.5
/* Logarithms of .55 and .45: a square that lies across a pad may be a bar. */
#define LOG_SQUARE (-0.59783700075562041)
#define LOG_BAR (-0.79850769621777162)
/* Few taxels cannot exclude what has no name: on n of them, fewer than FEW, a stranger's probability counts (FEW / n)^2
 * times, at most MOST_TIMES. Only what is sure is taken back by it, down to NO_SURER. Chosen by `python -m benchmarks
 * touch_small_pads --seed 1`: 26.1 % of known forms are right with p > .9, which were 27.8, and 1.2 % of strange ones are
 * named so, which were 1.7; where one contact in five is strange 2.0 % of such names are wrong, which were 2.9. FEW 64
 * took .3 % more of the right ones for .1 % of the strange. */
#define FEW 48
#define MOST_TIMES 8
#define NO_SURER ((vh_real)0.85)
/* What was taken back to NO_SURER is that but for rounding. */
#define ROUNDED ((vh_real)0.0001)
/* Of the contacts that names were learned from. */
#define MOST_SIDE 48

/* Tells whether the rest that was taken off is much higher than the contact that stands on it. */
static int stands_on_a_rest(const struct vh_contact *contact, const vh_real *rest)
{
    vh_real middle_col = 0.5 * (vh_real)(contact->width - 3), middle_row = 0.5 * (vh_real)(contact->height - 3);

    vh_real height = rest[0] + rest[1] * middle_col + rest[2] * middle_row;

    return height > HIGH_REST * contact->peak && height < HIGHEST_REST * contact->peak;
}

/* How many taxels a field has, how many of them are the contact's, and how many show exactly its peak; all none where
 * the contact leaves a side free. */
struct filled {
    int taxels, touched, at_top;
};

static struct filled filled_by(const struct vh_contact *contact)
{
    struct filled of = {0, 0, 0};

    if (contact->place[VH_BORDERS] != ALL_SIDES)
        return of;
    for (int r = 1; r < contact->height - 1; r++)
        for (int c = 1; c < contact->width - 1; c++) {
            int p = r * contact->width + c, touched = contact->label[p] == contact->index;
            if (contact->padded[p] == -INFINITY)
                continue;
            of.taxels++;
            of.touched += touched;
            of.at_top += touched && contact->padded[p] >= (1 - VH_SAME) * contact->peak;
        }
    return of;
}

static int hides_form(struct filled of)
{
    return of.taxels > 0 && of.touched == of.taxels &&
           (of.taxels < FEWEST_OF_FORM || of.at_top > MOST_AT_TOP * of.taxels);
}

int vh_hides_form(const struct vh_contact *contact) { return hides_form(filled_by(contact)); }

/* The taxels of a field and a plane through its outermost ones. */
struct field {
    const vh_real *values;
    int width, rows, cols;
    vh_real at, by_col, by_row;
};

/* The mean of a row or column of taxels, a step apart. */
static vh_real mean_along(const vh_real *values, int count, int step)
{
    vh_real sum = 0;
    int n = 0;

    for (int k = 0; k < count; k++) {
        vh_real v = values[(ptrdiff_t)k * step];
        n += v > -INFINITY;
        sum += v > -INFINITY ? v : 0;
    }
    return n > 0 ? sum / n : 0;
}

static struct field field_of(const struct vh_contact *contact)
{
    int width = contact->width, rows = contact->height - 2, cols = width - 2;
    const vh_real *first = contact->padded + width + 1;
    vh_real top = mean_along(first, cols, 1), bottom = mean_along(first + (ptrdiff_t)(rows - 1) * width, cols, 1);
    vh_real left = mean_along(first, rows, width), right = mean_along(first + cols - 1, rows, width);
    struct field f = {first, width, rows, cols, 0.25 * (top + bottom + left + right), 0, 0};

    f.by_col = cols > 1 ? (right - left) / (cols - 1) : 0;
    f.by_row = rows > 1 ? (bottom - top) / (rows - 1) : 0;
    f.at -= 0.5 * (f.by_col * (cols - 1) + f.by_row * (rows - 1));
    return f;
}

/* How far a taxel lies above the plane; -inf where there is none. */
static vh_real above_plane(const struct field *f, int r, int c)
{
    return f->values[(ptrdiff_t)r * f->width + c] - (f->at + f->by_row * r + f->by_col * c);
}

/* A frame turned over has its hollows as hills: what is so far beyond the plane, of hills above it. */
static int is_beyond(const struct field *f, int r, int c, vh_real depth, int sign)
{
    vh_real above = r < f->rows && c < f->cols ? above_plane(f, r, c) : 0;

    return sign * above > depth && above > -INFINITY;
}

/* How many taxels a field has, and how many are level with its plane, lie on the other side of it, and deep; how many of
 * these are neighbours, and how many lie at the border. */
struct patch {
    int n, level, other, deep, pairs, at_border;
};

static struct patch patch_in(const struct field *f, int sign, vh_real near_plane)
{
    struct patch of = {0, 0, 0, 0, 0, 0};
    vh_real lowest = 0, highest = 0, range;

    for (int r = 0; r < f->rows; r++)
        for (int c = 0; c < f->cols; c++) {
            vh_real above = above_plane(f, r, c);
            lowest = above > -INFINITY ? vh_least(lowest, above) : lowest;
            highest = vh_most(highest, above);
        }
    range = highest - lowest;
    for (int r = 0; r < f->rows; r++)
        for (int c = 0; c < f->cols; c++) {
            vh_real above = above_plane(f, r, c);
            of.n += above > -INFINITY;
            of.level += fabs(above) <= near_plane * range;
            of.other += is_beyond(f, r, c, near_plane * range, -sign);
            if (!is_beyond(f, r, c, PATCH_DEEP * range, sign))
                continue;
            of.deep++;
            of.at_border += r == 0 || r == f->rows - 1 || c == 0 || c == f->cols - 1;
            of.pairs += is_beyond(f, r, c + 1, PATCH_DEEP * range, sign) +
                        is_beyond(f, r + 1, c, PATCH_DEEP * range, sign);
        }
    return of;
}

/* Most taxels lie in the plane of the outermost ones, hardly one on the other side of it, and those that lie deep are a
 * patch: dead taxels and lines have fewer neighbours of their kind than there are of them. */
static int is_patch(struct patch of)
{
    return of.deep >= FEWEST_DEEP && of.pairs >= of.deep && of.level >= MOST_LEVEL * of.n &&
           of.other <= FEW_BEYOND * of.n;
}

int vh_has_hollow(const struct vh_contact *contact)
{
    struct field f;
    struct patch of;

    if (contact->place[VH_BORDERS] != ALL_SIDES)
        return 0;
    f = field_of(contact);
    of = patch_in(&f, -1, HOLLOW_LEVEL);
    return of.at_border == 0 && is_patch(of);
}

static int has_hill(const struct vh_contact *contact, struct filled of)
{
    struct field f;

    if (of.taxels == 0 || of.touched < of.taxels)
        return 0;
    f = field_of(contact);
    return is_patch(patch_in(&f, 1, HILL_LEVEL));
}

int vh_has_hill(const struct vh_contact *contact) { return has_hill(contact, filled_by(contact)); }

/* Tells whether so much of a contact reads exactly the same, and most, where its noise would make readings differ. */
static int ends_at_once(const struct vh_contact *contact)
{
    const vh_int *place = contact->place;
    vh_real count = INFINITY;
    int at_top = 0;

    for (int r = (int)place[VH_TOP]; r <= place[VH_BOTTOM]; r++)
        for (int c = (int)place[VH_LEFT]; c <= place[VH_RIGHT]; c++) {
            int p = r * contact->width + c;
            if (contact->label[p] != contact->index)
                continue;
            at_top += contact->padded[p] >= (1 - VH_SAME) * contact->peak;
            for (int k = 0; k < 2; k++) {
                int next = p + (k ? contact->width : 1);
                vh_real step = fabs(contact->padded[next] - contact->padded[p]);
                if (contact->label[next] == contact->index && step > VH_SAME * contact->peak)
                    count = vh_least(count, step);
            }
        }
    return at_top > LEAST_AT_END * place[VH_N_TAXELS] && at_top < MOST_AT_END * place[VH_N_TAXELS] &&
           contact->sigma > OF_COUNT * count;
}

/* Tells whether a contact reaches from one border of its field to the opposite one. */
static int lies_across(const struct vh_contact *contact)
{
    int borders = (int)contact->place[VH_BORDERS];

    return (borders & LEFT_TO_RIGHT) == LEFT_TO_RIGHT || (borders & TOP_TO_BOTTOM) == TOP_TO_BOTTOM;
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

/* Tells whether no kind has larger odds; that is asked before what costs more. */
static int is_likeliest(const vh_real *logits, int n, int kind)
{
    for (int k = 0; k < n; k++)
        if (logits[k] > logits[kind])
            return 0;
    return 1;
}

/* Of bars, and of squares that may be longer than what the pad shows of them. */
static void adjust_bars(const struct vh_contact *contact, const struct vh_parameters *parameters, vh_real *logits)
{
    int bar = parameters->bar, square = parameters->square;

    if (bar >= 0 && is_likeliest(logits, parameters->kinds, bar) && ends_at_once(contact))
        logits[bar] = vh_least(logits[bar], log_sum_without(logits, parameters->kinds, bar) + BAR_ODDS);
    if (bar >= 0 && square >= 0 && lies_across(contact)) {
        vh_real top = vh_most(logits[bar], logits[square]);
        vh_real both = top + log(exp(logits[bar] - top) + exp(logits[square] - top));
        if (logits[square] > both + LOG_SQUARE) {
            logits[square] = both + LOG_SQUARE;
            logits[bar] = both + LOG_BAR;
        }
    }
}

/* What the frame tells beside the table: of planes, of bars, and of kinds that cannot occur. */
static void adjust(const struct vh_contact *contact, const struct vh_parameters *parameters,
                   const struct vh_hints *hints, vh_real *logits)
{
    int plane = parameters->plane, n = parameters->kinds;
    struct filled of = filled_by(contact);

    if (plane >= 0 && stands_on_a_rest(contact, hints->rest))
        logits[plane] = vh_most(logits[plane], log_sum_without(logits, n, plane) + PLANE_ODDS);
    if (plane >= 0 && (vh_has_hollow(contact) || has_hill(contact, of)))
        logits[plane] = vh_least(logits[plane], log_sum_without(logits, n, plane) + PLANE_ODDS);
    if (plane >= 0 && hides_form(of)) {
        vh_real most = log_sum_without(logits, n, plane) + (of.taxels < FEWEST_OF_FORM ? PLANE_ODDS : TOP_ODDS);
        /* Where all is at the top there is no outline to tell. */
        logits[plane] = of.at_top == of.taxels ? most : vh_least(logits[plane], most);
    }
    adjust_bars(contact, parameters, logits);
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

/* Returns the likeliest name, the likeliest kind of that name, and the name's probability: the sum of its kinds'.
 * `strange` is that of the name of what has none, of which -1 is no name; 0 where there is none. */
static struct vh_answer likeliest(const struct vh_parameters *parameters, const vh_real *p, int unknown,
                                  vh_real *strange)
{
    struct vh_answer best = {0, 0, -1};

    *strange = 0;
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
        if (name == unknown)
            *strange = total;
        if (total > best.probability) {
            best.name = name;
            best.kind = kind;
            best.probability = total;
        }
    }
    return best;
}

/* How many times what has no name counts beside a name that is sure. */
static vh_real times_strange(const struct vh_contact *contact)
{
    vh_real n = (vh_real)contact->place[VH_N_TAXELS];

    return n >= FEW ? 1 : n * n * MOST_TIMES <= FEW * FEW ? MOST_TIMES : FEW * FEW / (n * n);
}

int vh_may_be_strange(const struct vh_contact *contact, vh_real probability)
{
    return times_strange(contact) > 1 && probability > NO_SURER - ROUNDED;
}

/* Makes a name that is sure less so where few taxels touch, by what a stranger has; the name stays the likeliest. */
static void weigh_strangers(const struct vh_parameters *parameters, vh_real times, int unknown, vh_real strange,
                            vh_real *p, struct vh_answer *answer)
{
    /* What has a name shares what is left, as before. */
    vh_real keep = vh_most((1 - times * strange) / (1 - strange), NO_SURER / answer->probability);
    vh_real gain = (1 - keep * (1 - strange)) / strange;

    for (int k = 0; k < parameters->kinds; k++)
        p[k] *= parameters->name_of[k] == unknown ? gain : keep;
    answer->probability *= keep;
}

void vh_decide(const struct vh_contact *contact, const struct vh_parameters *parameters, const struct vh_hints *hints,
               vh_real *logits, struct vh_answer *answer)
{
    /* Things that were learned on the pad itself are no forms: their learning has met what few taxels show. How many
     * taxels touch is not known before the threshold has fallen. */
    int forms = parameters->stranger >= 0 && parameters->plane >= 0 && !hints->early;
    int unknown = forms ? parameters->name_of[parameters->stranger] : -1;
    vh_real times = times_strange(contact), strange;

    adjust(contact, parameters, hints, logits);
    normalize(logits, parameters->kinds);
    *answer = likeliest(parameters, logits, unknown, &strange);
    if (times > 1 && strange > 0 && answer->name != unknown && answer->probability > NO_SURER)
        weigh_strangers(parameters, times, unknown, strange, logits, answer);
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
