/* The standard plane delta: how high above nothing a touch begins, and what above it is still noise. */
#include "inner.h"

/*
 * The standard plane stands clear of the noise (one taxel in 30,000 exceeds 4 sigma by chance) and of the faint skirt
 * that skins and cross-talk put around a contact.
 */
#define FLOOR_SIGMAS 4.0
/*
 * What changes from taxel to taxel in one frame is noise or the taxels' own unevenness, which nothing tells apart: it
 * lifts the plane so far, and no form is swallowed. What noise passes is sorted out afterwards.
 */
#define MOST_OF_PEAK 0.10
/* Where time has told the noise from the unevenness, fainter skirts are seen. */
#define LEAST_OF_PEAK 0.02
/* One frame in a hundred has a taxel beyond the reach of its noise. */
#define ONE_IN 100.0

vh_real vh_default_floor(vh_real sigma, vh_real peak)
{
    vh_real noise = vh_least(FLOOR_SIGMAS * sigma, MOST_OF_PEAK * peak);
    return vh_most(vh_most(noise, VH_FLOOR_OF_PEAK * peak), VH_LEAST_FLOOR);
}

vh_real vh_timed_floor(vh_real sigma, vh_real peak)
{
    return vh_most(vh_most(FLOOR_SIGMAS * sigma, LEAST_OF_PEAK * peak), VH_LEAST_FLOOR);
}

vh_real vh_noise_reach(vh_real sigma, int n_taxels)
{
    /* n (1 - Phi(k)) is n exp(-k^2 / 2) / (k sqrt(2 pi)); for the k in question the divisor is about 10. */
    return sigma * sqrt(2.0 * log(vh_most(0.1 * ONE_IN * n_taxels, 1.0)));
}
