/*
 * Dead taxels and dead lines of one frame, found where the evidence is strong.
 *
 * A dead taxel reads the rest while everything around it is pressed; a dead line does so along a whole row or column.
 */
#include "inner.h"

/*
 * A dead taxel reads the rest, and noise: at most this share of the range above the lowest reading, or this many sigma
 * (the lowest of many readings lies some three sigma below the rest).
 */
#define REST_SHARE 0.040001
#define REST_SIGMAS 7.5
/* What surrounds it stands this much higher, and by so many counts of the sensor: rounded noise is one count. */
#define STEP_SHARE 0.100001
#define STEP_SIGMAS 6.0
#define STEP_COUNTS 2.5
/* Neighbours that a dead taxel needs: all five at a border of the pad, none of which may be at rest. */
#define FEWEST_AROUND 5
/*
 * The lowest of them stands at least this share as high as the highest; on a pad of a few taxels, where noise can be
 * told from form by nothing else, this share.
 */
#define LEAST_EVEN 0.149999
#define LEAST_EVEN_SMALL 0.349999
/* Pads with fewer rows or columns are of a few taxels; from so many on, islands may be of three. */
#define SMALL 10
#define LARGE 24
#define WIDEST 3
/* Taxels of a line that must be pressed on both sides of it. */
#define FEWEST_ALONG 2
/* More taxels than this share of the field are no faults but a form. */
#define MOST_DEAD 0.120001
#define FEWEST_USABLE 9

/* A frame, its lowest reading, and what counts as the rest and as a step up from it. */
struct readings {
    const vh_real *frame;
    const uint8_t *usable;
    int rows, cols;
    vh_real low, rest, step;
};

/* For each line along one way: whether a taxel of it is pressed, how many are read, and pressed on both its sides. */
struct line {
    int32_t alive, read, beside;
};

size_t vh_find_dead_work(int rows, int cols)
{
    return (size_t)vh_max(rows, cols) * sizeof(struct line) + (size_t)rows * cols + 16;
}

/* The most taxels of an island, on a pad of that size. */
static int widest_of(const struct readings *f)
{
    const int side = vh_min(f->rows, f->cols);
    return side < SMALL ? 1 : (side < LARGE ? 2 : WIDEST);
}

/* Whether a taxel of a row rests between two pressed neighbours: in the row, or above and below it. */
static int rests_between(const struct readings *f, const vh_real *up, const vh_real *here, const vh_real *down)
{
    const vh_real rest = f->rest, step = f->step;
    const int last = f->cols - 1;
    vh_int found = 0;
    for (int c = 1; c < last; c++) {
        const vh_real lift = here[c] + step;
        const vh_real along = vh_least(here[c - 1], here[c + 1]), across = vh_least(up[c], down[c]);
        found |= (here[c] <= rest) & (vh_most(along, across) > lift);
    }
    found |= (here[0] <= rest) & (vh_most(here[1], vh_least(up[0], down[0])) > here[0] + step);
    found |= (here[last] <= rest) & (vh_most(here[last - 1], vh_least(up[last], down[last])) > here[last] + step);
    return found != 0;
}

/* Whether n taxels rest, each so many behind the one before. */
static int all_rest(const struct readings *f, const vh_real *at, int n, int apart)
{
    for (int i = 0; i < n; i++)
        if (at[(size_t)i * apart] > f->rest)
            return 0;
    return 1;
}

/* Whether a resting taxel lies between two pressed ones, and all of its row or column rests; the outermost are no dead lines. */
static int may_lie_in_line(const struct readings *f, int r, int c)
{
    const vh_real *const row = f->frame + (size_t)r * f->cols, *const at = row + c, lift = *at + f->step;
    if (r > 0 && r + 1 < f->rows && vh_least(at[-f->cols], at[f->cols]) > lift && all_rest(f, row, f->cols, 1))
        return 1;
    return c > 0 && c + 1 < f->cols && vh_least(at[-1], at[1]) > lift && all_rest(f, f->frame + c, f->rows, f->cols);
}

/* Whether what surrounds a resting taxel is pressed, but for a few that rest as well, as around a dead island. */
static int may_lie_in_island(const struct readings *f, int r, int c)
{
    int resting = 0;
    for (int y = vh_max(r - 1, 0); y < vh_min(r + 2, f->rows); y++) {
        const vh_real *row = f->frame + (size_t)y * f->cols;
        for (int x = vh_max(c - 1, 0); x < vh_min(c + 2, f->cols); x++) {
            resting += row[x] <= f->rest;
            if (row[x] > f->rest && !(row[x] > f->low + f->step))
                return 0;
        }
    }
    return resting <= widest_of(f);
}

/*
 * What of a frame may be dead: a line, or an island, and in which row the first taxel of one lies. In each of them one
 * taxel at least rests between two opposite neighbours that are pressed, where what lies outside the pad counts as
 * pressed; three that rest in a corner, which no such taxel tells from a form that leaves the corner free, are none.
 */
struct suspects {
    int line, island, row;
};

static struct suspects look_for(const struct readings *f)
{
    struct suspects found = {0, 0, 0};
    for (int r = 0; r < f->rows && !(found.line && found.island); r++) {
        const vh_real *here = f->frame + (size_t)r * f->cols;
        const vh_real *up = r > 0 ? here - f->cols : here + f->cols, *down = r + 1 < f->rows ? here + f->cols : up;
        if (!rests_between(f, up, here, down))
            continue;
        for (int c = 0; c < f->cols; c++) {
            if (here[c] > f->rest)
                continue;
            found.line = found.line || may_lie_in_line(f, r, c);
            if (!found.island && may_lie_in_island(f, r, c)) {
                found.island = 1;
                found.row = r;
            }
        }
    }
    return found;
}

/* Find what is low and high in one pass, and what may be dead; 0 where nothing in the frame can be. */
static int set_rest(struct readings *f, vh_real sigma, int *n_usable, struct suspects *may)
{
    vh_real low, peak;
    const int n = *n_usable = vh_range(f->frame, f->usable, f->rows * f->cols, &low, &peak);
    vh_real span = peak - low;
    if (n < FEWEST_USABLE || !(span > 0.0))
        return 0;
    f->low = low;
    f->rest = low + vh_most(REST_SHARE * span, REST_SIGMAS * sigma);
    f->step = vh_most(STEP_SHARE * span, STEP_SIGMAS * sigma);
    /* In a frame with gaps, and on a single line, everything is looked at. */
    *may = (struct suspects){1, 1, 0};
    if (f->rest + f->step >= peak)
        return 0;
    if (n == f->rows * f->cols && f->rows > 1 && f->cols > 1)
        *may = look_for(f);
    if (!may->line && !may->island)
        return 0;
    f->step = vh_most(f->step, STEP_COUNTS * vh_count_of(f->frame, f->usable, f->rows, f->cols, f->step / STEP_COUNTS));
    return f->rest + f->step < peak;
}

static int is_dead(const struct line *line, int length)
{
    return !line->alive && 2 * line->read > length && line->beside >= FEWEST_ALONG;
}

/* Mark the rows that are at rest throughout while the rows beside them are pressed; returns how many. */
static int dead_rows(const struct readings *f, uint8_t *dead)
{
    int n = 0;
    for (int r = 1; r < f->rows - 1; r++) {
        const vh_real *here = f->frame + (size_t)r * f->cols;
        const uint8_t *usable = f->usable + (size_t)r * f->cols;
        struct line line = {0, 0, 0};
        for (int c = 0; c < f->cols && !line.alive; c++) {
            line.alive = usable[c] && here[c] > f->rest;
            line.read += usable[c];
            line.beside += usable[c] && vh_least(here[c - f->cols], here[c + f->cols]) > here[c] + f->step;
        }
        if (is_dead(&line, f->cols)) {
            memcpy(dead + (size_t)r * f->cols, usable, (size_t)f->cols);
            n++;
        }
    }
    return n;
}

/* The same for columns, row by row. */
static int dead_columns(const struct readings *f, uint8_t *dead, struct line *lines)
{
    int n = 0;
    memset(lines, 0, (size_t)f->cols * sizeof *lines);
    for (int r = 0; r < f->rows; r++) {
        const vh_real *here = f->frame + (size_t)r * f->cols;
        const uint8_t *usable = f->usable + (size_t)r * f->cols;
        for (int c = 1; c < f->cols - 1; c++) {
            lines[c].alive |= usable[c] & (here[c] > f->rest);
            lines[c].read += usable[c];
            lines[c].beside += usable[c] & (vh_least(here[c - 1], here[c + 1]) > here[c] + f->step);
        }
    }
    for (int c = 1; c < f->cols - 1; c++) {
        if (!is_dead(&lines[c], f->rows))
            continue;
        for (int r = 0; r < f->rows; r++)
            dead[(size_t)r * f->cols + c] = f->usable[(size_t)r * f->cols + c];
        n++;
    }
    return n;
}

/* Dead lines, whole; so many that they are a grating are none. Returns the number of taxels. */
static int dead_lines(const struct readings *f, uint8_t *dead, struct line *lines)
{
    int n = 0, found = dead_rows(f, dead) + dead_columns(f, dead, lines);
    if (found * 8 > f->rows + f->cols)
        memset(dead, 0, (size_t)f->rows * f->cols);
    else if (found)
        for (int i = 0; i < f->rows * f->cols; i++)
            n += dead[i];
    return n;
}

/*
 * Whether the island of at most `widest` resting taxels that (r, c) belongs to has a pressed shore all around; returns
 * its size, 0 where it has not, and its taxels.
 */
static int island_at(const struct readings *f, const uint8_t *dead, int r, int c, int widest, vh_real least_even, int *member)
{
    const vh_real base = f->frame[r * f->cols + c];
    vh_real lowest = INFINITY, highest = -INFINITY;
    int size = 1, around = 0;
    member[0] = r * f->cols + c;
    for (int k = 0; k < size; k++) {
        const int row = member[k] / f->cols, col = member[k] % f->cols;
        for (int y = vh_max(row - 1, 0); y < vh_min(row + 2, f->rows); y++) {
            for (int x = vh_max(col - 1, 0); x < vh_min(col + 2, f->cols); x++) {
                const int at = y * f->cols + x;
                int known = dead[at] || !f->usable[at];
                for (int j = 0; j < size; j++)
                    known |= member[j] == at;
                if (known)
                    continue;
                if (f->frame[at] <= f->rest) {
                    if (size == widest)
                        return 0;
                    member[size++] = at;
                } else if (f->frame[at] > base + f->step) {
                    around++;
                    lowest = vh_least(lowest, f->frame[at]);
                    highest = vh_most(highest, f->frame[at]);
                } else {
                    return 0;
                }
            }
        }
    }
    return around >= FEWEST_AROUND && lowest - base >= least_even * (highest - base) ? size : 0;
}

/* Dead islands of a few taxels, none of them above a row; returns their number of taxels. */
static int dead_islands(const struct readings *f, int top, uint8_t *dead, uint8_t *resting)
{
    const int rows = f->rows, cols = f->cols, widest = widest_of(f);
    const vh_real least_even = vh_min(rows, cols) < SMALL ? LEAST_EVEN_SMALL : LEAST_EVEN;
    int n = 0, member[WIDEST];
    for (int i = vh_max(top - 1, 0) * cols; i < rows * cols; i++)
        resting[i] = f->usable[i] & (dead[i] ^ 1) & (f->frame[i] <= f->rest);
    for (int r = top; r < rows; r++) {
        const uint8_t *here = resting + (size_t)r * cols;
        const uint8_t *above = r > 0 ? here - cols : here, *below = r + 1 < rows ? here + cols : here;
        for (int c = 0; c < cols; c++) {
            if (!here[c])
                continue;
            /* Most rest beside more resting taxels than an island has. */
            int left = c > 0 ? here[c - 1] : 0, right = c + 1 < cols ? here[c + 1] : 0;
            int beside = left + right + (r > 0 ? above[c] : 0) + (r + 1 < rows ? below[c] : 0);
            if (beside >= widest || dead[r * cols + c])
                continue;
            int size = island_at(f, dead, r, c, widest, least_even, member);
            for (int j = 0; j < size; j++)
                dead[member[j]] = 1;
            n += size;
        }
    }
    return n;
}

int vh_find_dead(
    const vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, uint8_t *dead, void *work)
{
    struct readings f = {frame, usable, rows, cols, 0.0, 0.0, 0.0};
    struct line *lines = work;
    struct suspects may;
    int n_usable;
    memset(dead, 0, (size_t)rows * cols);
    if (!set_rest(&f, sigma, &n_usable, &may))
        return 0;
    const int along = may.line ? dead_lines(&f, dead, lines) : 0;
    /* Beside a dead line an island is found by less. */
    const int top = along ? 0 : vh_max(may.row - WIDEST + 1, 0);
    int islands = along || may.island ? dead_islands(&f, top, dead, (uint8_t *)(lines + vh_max(rows, cols))) : 0;
    if (islands > (int)(MOST_DEAD * n_usable)) {
        memset(dead, 0, (size_t)rows * cols);
        return 0;
    }
    return along + islands;
}
