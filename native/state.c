/* The state of the sensor under a contact: what its taxels tell of themselves rather than of the form.
 *
 * Saturated and equal readings, roughness inside the contact and outside it, ghosts along rows and columns, how much
 * stands close beside it and how much higher, the sides at which the pad ends it, how steep its border is at three
 * heights, how a face leans.
 */
#include "touch.h"

#include <string.h>

/* Shares of the way from the floor to the peak at which borders are looked at. */
#define LOW 0.200004
#define HALF 0.500004
#define HIGH 0.800004
/* Readings this near the peak may be saturated. */
#define TOP 0.979996
#define NEAR_TOP 0.929996
#define FEWEST 4
/* What stands so near to a contact, in parts of the root of its taxels, may belong to it; farther off are other things. */
#define BESIDE 0.250004
/* Columns of the frame that are looked at together outside the contact. */
#define STRIP 128

/* A contact, and the heights at which it is looked at. */
struct view {
    const struct vh_contact *contact;
    vh_real span, levels[3], near_top, topmost, same, middle_x, middle_y;
};

/* A taxel's value and its neighbours', -inf where there is none. */
struct cross {
    vh_real v, up, down, before, after;
};

/* What is counted and summed over the contact's taxels. */
struct inside {
    vh_int near_top, topmost, exact, pairs, equal, cut[3], edges[3], rough_taxels, mixed_taxels;
    vh_real edge[3], rough, rough_2, mixed, second;
};

/* A face: the taxels that stand above half height with all their neighbours, x and y from the window's middle and v
 * from the peak, in spans; and those above half height that do not. */
struct face {
    vh_int n, rim;
    vh_real x, y, v, xx, xy, yy, xv, yv, vv, rim_v;
};

/* What is counted and summed over the taxels outside the contact. */
struct outside {
    vh_int n, pairs, cross, others, field, at_lowest;
    vh_real sum, steps, cross_sum, highest;
};

/* Adds the step between two taxels to each level that lies between them. */
static void add_edge(const struct view *view, vh_real v, vh_real w, struct inside *in)
{
    vh_real most = v > w ? v : w, least = v > w ? w : v;
    int k;

    for (k = 0; k < 3; k++)
        if (most > view->levels[k] && least <= view->levels[k]) {
            in->edge[k] += most - least;
            in->edges[k]++;
        }
}

/* Looks at the differences to a taxel's neighbours; p is its place in the frame. */
static void add_pairs(const struct view *view, const struct cross *t, vh_int p, struct inside *in)
{
    const struct vh_contact *contact = view->contact;
    const int32_t *label = contact->label + p;

    if (t->down != -INFINITY) {
        if (label[contact->width] == contact->index) {
            in->pairs++;
            in->equal += fabs(t->v - t->down) <= view->same && t->v < contact->peak - view->same;
        }
        add_edge(view, t->v, t->down, in);
    }
    if (t->after != -INFINITY) {
        if (label[1] == contact->index) {
            in->pairs++;
            in->equal += fabs(t->v - t->after) <= view->same && t->v < contact->peak - view->same;
        }
        add_edge(view, t->v, t->after, in);
    }
    /* A neighbour above or before that is outside the contact is met from this side only. */
    if (t->up != -INFINITY && label[-contact->width] != contact->index)
        add_edge(view, t->v, t->up, in);
    if (t->before != -INFINITY && label[-1] != contact->index)
        add_edge(view, t->v, t->before, in);
}

/* Adds how far a taxel within the contact, at `value`, stands off the mean of its neighbours, and its mixed differences. */
static void add_roughness(const struct view *view, const struct cross *t, const vh_real *value, struct inside *in)
{
    vh_real residual = fabs(t->v - 0.25 * (t->up + t->down + t->before + t->after));
    int dx, dy;

    in->rough += residual;
    in->rough_2 += residual * residual;
    in->rough_taxels++;
    for (dy = -1; dy <= 1; dy += 2)
        for (dx = -1; dx <= 1; dx += 2) {
            /* All four neighbours are in the field: its rim, which may hold its border's values, is not met. */
            vh_real across = value[dy * view->contact->width + dx];
            if (across == -INFINITY)
                continue;
            in->mixed += fabs(t->v - (dy < 0 ? t->up : t->down) - (dx < 0 ? t->before : t->after) + across);
            in->mixed_taxels++;
        }
}

static int all_above(const struct cross *t, vh_real level)
{
    return t->up > level && t->down > level && t->before > level && t->after > level;
}

static void add_to_face(const struct view *view, const struct cross *t, vh_int r, vh_int c, struct face *face)
{
    vh_real x = (vh_real)c - view->middle_x, y = (vh_real)r - view->middle_y;
    /* From the peak down: a face that is cut off there is even to the last bit. */
    vh_real v = (t->v - view->contact->peak) / view->span;

    if (!all_above(t, view->levels[1])) {
        face->rim++;
        face->rim_v += v;
        return;
    }
    face->n++;
    face->x += x;
    face->y += y;
    face->v += v;
    face->xx += x * x;
    face->xy += x * y;
    face->yy += y * y;
    face->xv += x * v;
    face->yv += y * v;
    face->vv += v * v;
}

static void add_taxel(const struct view *view, vh_int r, vh_int c, struct inside *in, struct face *face)
{
    const struct vh_contact *contact = view->contact;
    vh_int p = r * contact->width + c;
    const vh_real *value = contact->padded + p;
    struct cross t;
    int at_border, k;

    t.v = *value;
    t.up = r > 1 ? value[-contact->width] : -INFINITY;
    t.down = r < contact->height - 2 ? value[contact->width] : -INFINITY;
    t.before = c > 1 ? value[-1] : -INFINITY;
    t.after = c < contact->width - 2 ? value[1] : -INFINITY;
    at_border = t.up == -INFINITY || t.down == -INFINITY || t.before == -INFINITY || t.after == -INFINITY;
    in->near_top += t.v >= view->near_top;
    in->topmost += t.v >= view->topmost;
    in->exact += t.v >= contact->peak - view->same;
    if (t.v > in->second && t.v < contact->peak - view->same)
        in->second = t.v;
    if (at_border)
        for (k = 0; k < 3; k++)
            in->cut[k] += t.v > view->levels[k];
    add_pairs(view, &t, p, in);
    if (t.v <= view->levels[0] || at_border)
        return;
    if (all_above(&t, view->levels[0]))
        add_roughness(view, &t, value, in);
    if (t.v > view->levels[1])
        add_to_face(view, &t, r, c, face);
}

/* Adds the step from a free taxel to the one at p, where that is free as well. */
static void add_step(const struct vh_contact *contact, vh_real v, vh_int p, struct outside *out)
{
    vh_real other = contact->padded[p];

    if (other == -INFINITY || contact->label[p] == contact->index)
        return;
    out->steps += fabs(v - vh_least(other, contact->floor));
    out->pairs++;
}

/* Adds a free taxel: what stands above the floor beside the contact counts only so far. */
static void add_free(const struct vh_contact *contact, vh_int r, vh_int c, int crossed, struct outside *out)
{
    vh_int p = r * contact->width + c;
    vh_real v = vh_least(contact->padded[p], contact->floor);

    out->n++;
    out->sum += v;
    /* The rim of a field without gaps holds its border's values. */
    if (r < contact->height - 2)
        add_step(contact, v, p + contact->width, out);
    if (c < contact->width - 2)
        add_step(contact, v, p + 1, out);
    if (crossed) {
        out->cross_sum += v;
        out->cross++;
    }
}

/* Tells which of the columns from `first` to before `stop` hold taxels of the contact. */
static void columns_of(const struct vh_contact *contact, vh_int first, vh_int stop, unsigned char *in_col)
{
    vh_int from = contact->place[VH_LEFT], end = contact->place[VH_RIGHT] + 1, r, c;

    memset(in_col, 0, STRIP);
    from = from > first ? from : first;
    end = end < stop ? end : stop;
    for (r = contact->place[VH_TOP]; r <= contact->place[VH_BOTTOM]; r++)
        for (c = from; c < end; c++)
            in_col[c - first] |= contact->label[r * contact->width + c] == contact->index;
}

static int row_holds(const struct vh_contact *contact, vh_int r)
{
    const int32_t *label = contact->label + r * contact->width;
    vh_int c;

    if (r < contact->place[VH_TOP] || r > contact->place[VH_BOTTOM])
        return 0;
    for (c = contact->place[VH_LEFT]; c <= contact->place[VH_RIGHT]; c++)
        if (label[c] == contact->index)
            return 1;
    return 0;
}

/* The lowest value of the field. */
static vh_real lowest_of(const struct vh_contact *contact)
{
    vh_real lowest = INFINITY;

    for (vh_int r = 1; r < contact->height - 1; r++)
        for (vh_int c = 1; c < contact->width - 1; c++) {
            vh_real v = contact->padded[r * contact->width + c];
            lowest = v < lowest && v > -INFINITY ? v : lowest;
        }
    return lowest;
}

/* Looks at what stands close beside the contact: how much of it, and how high. */
static void look_beside(const struct vh_contact *contact, struct outside *out)
{
    const vh_int *place = contact->place;
    const vh_int near = (vh_int)(BESIDE * sqrt((vh_real)place[VH_N_TAXELS]));
    const vh_int top = vh_max(place[VH_TOP] - near, 1), bottom = vh_min(place[VH_BOTTOM] + near, contact->height - 2);
    const vh_int left = vh_max(place[VH_LEFT] - near, 1), right = vh_min(place[VH_RIGHT] + near, contact->width - 2);

    for (vh_int r = top; r <= bottom; r++)
        for (vh_int c = left; c <= right; c++) {
            const vh_int p = r * contact->width + c;
            const vh_real v = contact->padded[p];
            out->highest = vh_most(out->highest, v);
            out->others += contact->label[p] != contact->index && v > contact->floor * (1 + VH_SAME);
        }
}

/* Looks at the frame outside the contact, in strips so that its columns fit into a small array. */
static void look_outside(const struct vh_contact *contact, vh_real same, struct outside *out)
{
    unsigned char in_col[STRIP];
    vh_int cols = contact->width - 1, rows = contact->height - 1, first, stop, r, c;
    vh_real lowest = lowest_of(contact) + same;

    for (first = 1; first < cols; first = stop) {
        stop = first + STRIP < cols ? first + STRIP : cols;
        columns_of(contact, first, stop, in_col);
        for (r = 1; r < rows; r++) {
            int in_row = row_holds(contact, r);
            for (c = first; c < stop; c++) {
                vh_real v = contact->padded[r * contact->width + c];
                if (v == -INFINITY)
                    continue;
                out->field++;
                out->at_lowest += v <= lowest;
                if (contact->label[r * contact->width + c] != contact->index)
                    add_free(contact, r, c, in_row != in_col[c - first], out);
            }
        }
    }
}

static vh_real mean(vh_real sum, vh_int n)
{
    return sum / (vh_real)(n > 0 ? n : 1);
}

/* Writes how the face leans, how uneven it is, and how far its middle stands above its rim. */
static void write_face(const struct face *f, vh_real breadth, vh_real *out)
{
    vh_real n = (vh_real)f->n, vxx, vyy, vxy, vxv, vyv, vvv, determinant, gx, gy, left;

    if (f->n > 0 && f->rim > 0)
        out[2] = f->v / n - f->rim_v / (vh_real)f->rim;
    if (f->n < FEWEST)
        return;
    vxx = f->xx - f->x * f->x / n;
    vyy = f->yy - f->y * f->y / n;
    vxy = f->xy - f->x * f->y / n;
    vxv = f->xv - f->x * f->v / n;
    vyv = f->yv - f->y * f->v / n;
    vvv = f->vv - f->v * f->v / n;
    determinant = vxx * vyy - vxy * vxy;
    if (determinant <= 1e-9)
        return;
    gx = (vxv * vyy - vyv * vxy) / determinant;
    gy = (vyv * vxx - vxv * vxy) / determinant;
    left = vvv - gx * vxv - gy * vyv;
    out[0] = sqrt(gx * gx + gy * gy) * breadth;
    out[1] = sqrt(vh_most(left, 0) / n);
}

/* Writes what the taxels of the contact tell: saturation, steps, roughness, where the pad ends it. */
static void write_inside(const struct inside *in, vh_real n, const struct view *view, vh_real *out)
{
    vh_real span = view->span, root = sqrt(n), rough = mean(in->rough, in->rough_taxels) / span;
    int k;

    out[0] = (vh_real)in->topmost / n;
    out[1] = (vh_real)in->near_top / n;
    out[2] = log((vh_real)(in->exact > 1 ? in->exact : 1));
    out[3] = in->second > -INFINITY ? (view->contact->peak - in->second) / span : 0.0;
    out[4] = mean((vh_real)in->equal, in->pairs);
    out[6] = log(rough + 1e-3);
    out[7] = sqrt(mean(in->rough_2, in->rough_taxels)) / span / (rough + 1e-3);
    out[8] = log(0.5 * mean(in->mixed, in->mixed_taxels) / span + 1e-3);
    for (k = 0; k < 3; k++) {
        out[14 + k] = (vh_real)in->cut[k] / root;
        out[17 + k] = mean(in->edge[k], in->edges[k]) / span;
    }
}

static void write_outside(const struct outside *o, vh_real n, const struct view *view, vh_real *out)
{
    vh_real span = view->span, level = mean(o->sum, o->n) / span;
    vh_int beside = o->n - o->cross;

    out[5] = mean((vh_real)o->at_lowest, o->field);
    out[9] = log(mean(o->steps, o->pairs) / span + 1e-3);
    out[10] = level < -1 ? -1.0 : level > 1 ? 1.0 : level;
    out[11] = 0;
    if (o->cross >= FEWEST && beside >= FEWEST)
        out[11] = (mean(o->cross_sum, o->cross) - mean(o->sum - o->cross_sum, beside)) / span;
    out[12] = log(1 + (vh_real)o->others / n);
    out[13] = o->highest > 0 ? view->contact->peak / o->highest : 1.0;
}

void vh_state(const struct vh_contact *contact, vh_real *out)
{
    const vh_int *place = contact->place;
    struct inside in = {0};
    struct face face = {0};
    struct outside outside = {0};
    struct view view;
    vh_real floor = contact->floor, n = (vh_real)(place[VH_N_TAXELS] > 1 ? place[VH_N_TAXELS] : 1);
    vh_int r, c;

    view.contact = contact;
    view.span = vh_span(contact);
    view.levels[0] = floor + LOW * view.span;
    view.levels[1] = floor + HALF * view.span;
    view.levels[2] = floor + HIGH * view.span;
    view.near_top = floor + NEAR_TOP * view.span;
    view.topmost = floor + TOP * view.span;
    view.same = VH_SAME * contact->peak;
    view.middle_x = 0.5 * (vh_real)(place[VH_LEFT] + place[VH_RIGHT]);
    view.middle_y = 0.5 * (vh_real)(place[VH_TOP] + place[VH_BOTTOM]);
    in.second = outside.highest = -INFINITY;
    memset(out, 0, VH_STATE * sizeof *out);
    for (r = place[VH_TOP]; r <= place[VH_BOTTOM]; r++)
        for (c = place[VH_LEFT]; c <= place[VH_RIGHT]; c++)
            if (contact->label[r * contact->width + c] == contact->index)
                add_taxel(&view, r, c, &in, &face);
    look_beside(contact, &outside);
    look_outside(contact, view.same, &outside);
    write_inside(&in, n, &view, out);
    write_outside(&outside, n, &view, out);
    write_face(&face, 2 * sqrt(n / PI), out + 20);
}
