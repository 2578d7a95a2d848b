/* The apex exponent k of A ~ (theta_1 - theta)^k. */
#include "touch.h"

/* Sections below this many taxels, and the lowest ones, near the noise, say nothing of the apex. */
#define LEAST_AREA 4.0
#define DEEPEST 0.85
#define FEWEST 4
#define LEAST_SPAN VH_LEAST_NORMAL

/* How far above the highest taxel the true apex may lie, as shares of the contact's span: taxels average tips away. */
static const vh_real ABOVE[] = {0.0, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2};

enum { TRIES = sizeof ABOVE / sizeof *ABOVE };

/* Sums over points (x, y) of which a line y = k x + c is fitted. */
struct sums {
    vh_real x, y, xx, xy, yy;
};

static void add_section(vh_real depth, vh_real area, struct sums *tries)
{
    vh_real y = log(area);

    for (int i = 0; i < TRIES; i++) {
        vh_real x = log(depth + ABOVE[i]);
        tries[i].x += x;
        tries[i].y += y;
        tries[i].xx += x * x;
        tries[i].xy += x * y;
        tries[i].yy += y * y;
    }
}

/* Returns the slope of the line that leaves least; NaN where there is none. */
static vh_real best_slope(const struct sums *tries, vh_real n)
{
    vh_real best = NAN, least = INFINITY;

    for (int i = 0; i < TRIES; i++) {
        const struct sums *s = &tries[i];
        vh_real spread = s->xx - s->x * s->x / n, together = s->xy - s->x * s->y / n, k = together / spread;
        vh_real error = s->yy - s->y * s->y / n - k * together;
        if (spread > 0 && error < least) {
            least = error;
            best = k;
        }
    }
    return best;
}

vh_real vh_apex_exponent(const vh_real *threshold, const vh_real *area, int n, vh_real peak, vh_real floor,
                         vh_real taxel_area)
{
    struct sums tries[TRIES] = {{0}};
    int usable = 0;

    for (int i = 0; i < n; i++) {
        vh_real depth = (peak - threshold[i]) / vh_most(peak - floor, LEAST_SPAN);
        if (!(area[i] >= LEAST_AREA * taxel_area && depth > 0 && depth <= DEEPEST))
            continue;
        add_section(depth, area[i], tries);
        usable++;
    }
    return usable < FEWEST ? NAN : best_slope(tries, usable);
}
