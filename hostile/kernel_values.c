/*
 * What a compiled kernel finds on drawn frames, number by number: a platform's are compared with another's.
 *
 *     kernel_values LIBRARY NUMBER
 *
 * The frames are drawn by arithmetic that every platform has alike; the library is opened as Python does it.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "varishold.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FUNCTION(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FUNCTION(library, name) dlsym(library, name)
#endif

enum { N_LEVELS = 12, MOST = 24, MOST_CONTACTS = (MOST + 2) * (MOST + 2) };

static int (*has_avx2)(void), (*has_avx512)(void);
static size_t (*contacts_work)(int, int, int);
static int (*find)(struct vh_frame *);
static void (*measure)(struct vh_frame *);
static void (*signature)(const struct vh_contact *, double *);

/* A function of the library, into a pointer to it. */
static void take(void *library, const char *name, void *into)
{
    void *found = FUNCTION(library, name);
    if (!found) {
        fprintf(stderr, "no function %s\n", name);
        exit(2);
    }
    memcpy(into, &found, sizeof found);
}

static uint64_t state;

static double uniform(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) / 9007199254740992.0;
}

/* Bumps on noise. */
static void draw(double *frame, int rows, int cols)
{
    const int n = 1 + (int)(3 * uniform());
    for (int i = 0; i < rows * cols; i++)
        frame[i] = 0.01 * uniform();
    for (int k = 0; k < n; k++) {
        const double x = cols * uniform(), y = rows * uniform(), height = 0.3 + uniform(), radius = 1 + 5 * uniform();
        for (int i = 0; i < rows * cols; i++) {
            const double dx = (i % cols - x) / radius, dy = (i / cols - y) / radius, away = 1 - dx * dx - dy * dy;
            frame[i] += away > 0 ? height * away : 0;
        }
    }
}

static void print(const char *what, const double *values, size_t n)
{
    printf("%s", what);
    for (size_t i = 0; i < n; i++)
        printf(" %.17g", values[i]);
    printf("\n");
}

static void feel(int rows, int cols)
{
    static double frame[MOST * MOST], padded[MOST_CONTACTS], values[2 * MOST_CONTACTS], found[VH_SIGNATURE];
    static double measures[MOST_CONTACTS * VH_N_COLUMNS * N_LEVELS];
    static int64_t places[MOST_CONTACTS * VH_N_PLACES], counts[2 * MOST_CONTACTS * N_LEVELS];
    static int32_t label[MOST_CONTACTS], order[MOST_CONTACTS];
    static uint8_t dead[MOST * MOST];
    struct vh_frame f;
    draw(frame, rows, cols);
    memset(&f, 0, sizeof f);
    f.frame = frame;
    f.row_pitch = 0.5;
    f.col_pitch = 1.0;
    f.floor = f.timed_sigma = -1.0;
    f.rows = rows;
    f.cols = cols;
    f.n_levels = N_LEVELS;
    f.padded = padded;
    f.label = label;
    f.dead = dead;
    f.places = places;
    f.values = values;
    f.measures = measures;
    f.counts = counts;
    f.order = order;
    f.work = malloc(contacts_work(rows, cols, N_LEVELS));
    if (!f.work || find(&f) != VH_FINE)
        exit(3);
    measure(&f);
    print("noise", &f.sigma, 1);
    for (int i = 0; i < f.n_ordered; i++) {
        const int k = order[i];
        const size_t own = (size_t)k * VH_N_COLUMNS * N_LEVELS;
        const struct vh_contact contact = {
            padded, label, places + (size_t)k * VH_N_PLACES, measures + own, counts + 2 * (size_t)k * N_LEVELS, rows + 2,
            cols + 2, k, N_LEVELS, f.row_pitch, f.col_pitch, values[2 * k], values[2 * k + 1], f.sigma};
        print("levels", measures + own, VH_N_COLUMNS * N_LEVELS);
        signature(&contact, found);
        print("signature", found, VH_SIGNATURE);
    }
    free(f.work);
}

int main(int argc, char **argv)
{
    void *library = argc == 3 ? OPEN(argv[1]) : NULL;
    if (!library) {
        fprintf(stderr, "kernel_values LIBRARY NUMBER: the library cannot be opened\n");
        return 2;
    }
    take(library, "vh_cpu_has_avx2", &has_avx2);
    take(library, "vh_cpu_has_avx512", &has_avx512);
    take(library, "vh_contacts_work", &contacts_work);
    take(library, "vh_find_contacts", &find);
    take(library, "vh_measure_contacts", &measure);
    take(library, "vh_signature", &signature);
    printf("has%s%s\n", has_avx2() ? " avx2" : "", has_avx512() ? " avx512" : "");
    for (int k = 0; k < atoi(argv[2]); k++) {
        state = 0x9e3779b97f4a7c15u * (uint64_t)(2 * k + 1);
        for (int i = 0; i < 8; i++)
            uniform();
        feel(4 + k % (MOST - 3), 4 + k * 7 % (MOST - 3));
    }
    return 0;
}
