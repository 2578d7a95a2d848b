/* The apex exponent k of A ~ (theta_1 - theta)^k. */
#include <tgmath.h>

#include "touch.h"

/* Sections below this many taxels, and the lowest ones, near the noise, say nothing of the apex. */
#define LEAST_AREA 4.0
#define DEEPEST 0.85
#define FEWEST 4
#define LEAST_SPAN 1e-300

/* How far above the highest taxel the true apex may lie, as shares of the contact's span: taxels average tips away. */
static const vh_real ABOVE[] = {0.0, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2};

/* A line through points: y = k x, and what it leaves. */
struct line {
    vh_real k, error;
};

/* A contact's sections. */
struct sections {
    const vh_real *threshold, *area;
    int n;
    vh_real peak, span, least_area;
};

/* Fits log A = k log(depth + above) over the usable sections; the error is infinite where nothing can be told. */
static struct line fit(const struct sections *s, vh_real above)
{
    vh_real sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, n = 0;
    struct line line = {NAN, INFINITY};

    for (int i = 0; i < s->n; i++) {
        vh_real depth = (s->peak - s->threshold[i]) / s->span, x, y;
        if (!(s->area[i] >= s->least_area && depth > 0 && depth <= DEEPEST))
            continue;
        x = log(depth + above);
        y = log(s->area[i]);
        n += 1;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        syy += y * y;
    }
    if (n < FEWEST || sxx - sx * sx / n <= 0)
        return line;
    line.k = (sxy - sx * sy / n) / (sxx - sx * sx / n);
    line.error = syy - sy * sy / n - line.k * (sxy - sx * sy / n);
    return line;
}

vh_real vh_apex_exponent(const vh_real *threshold, const vh_real *area, int n, vh_real peak, vh_real floor,
                         vh_real taxel_area)
{
    struct sections s = {threshold, area, n, peak, vh_most(peak - floor, LEAST_SPAN), LEAST_AREA * taxel_area};
    struct line best = {NAN, INFINITY};

    for (size_t i = 0; i < sizeof ABOVE / sizeof *ABOVE; i++) {
        struct line line = fit(&s, ABOVE[i]);
        if (line.error < best.error)
            best = line;
    }
    return best.k;
}
