/* What a sensor's readings stand for: its rest, response, gains, dead band, crosstalk and blur undone. */
#include <string.h>

#include "touch.h"

/* A taxel of less than this share of the usual gain says too little to be restored: it is broken. */
#define LEAST_GAIN 0.02

/* Straight lines between points, the last of them going on. */
static vh_real between(const struct vh_sensor *sensor, vh_real at)
{
    const vh_real *x = sensor->points_reading, *y = sensor->points_stress;
    int i = 1;

    while (i < sensor->n_points - 1 && at > x[i])
        i++;
    return y[i - 1] + (y[i] - y[i - 1]) * ((at - x[i - 1]) / (x[i] - x[i - 1]));
}

/* The stress, as a share of full scale, that a reading stands for; the response is odd. */
static vh_real stress_of(const struct vh_sensor *sensor, vh_real reading)
{
    vh_real size = fabs(reading), stress = size;

    if (sensor->response == VH_POWER)
        stress = pow(size, 1 / sensor->constant);
    else if (sensor->response == VH_LOGARITHMIC)
        stress = expm1(size * log1p(sensor->constant)) / sensor->constant;
    else if (sensor->response == VH_TABLE)
        stress = between(sensor, size);
    return reading < 0 ? -stress : stress;
}

/* Writes out = a b, of (n x m) and (m x k), or with a turned over (m x n). */
static void multiply(const vh_real *a, int turned, const vh_real *b, int n, int m, int k, vh_real *out)
{
    for (int i = 0; i < n; i++) {
        vh_real *row = out + i * k;
        memset(row, 0, (size_t)k * sizeof *row);
        for (int l = 0; l < m; l++) {
            vh_real v = turned ? a[l * n + i] : a[i * m + l];
            for (int j = 0; j < k; j++)
                row[j] += v * b[l * k + j];
        }
    }
}

/* Divides each pattern of the grid by its share: frame = down' ((down frame across') inverse) across. The patterns of a
 * line are cosines. */
static void undo_spread(const struct vh_sensor *sensor, int rows, int cols, vh_real *frame, vh_real *other)
{
    multiply(sensor->down, 0, frame, rows, rows, cols, other);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < cols; j++) {
            vh_real total = 0;
            for (int l = 0; l < cols; l++)
                total += other[i * cols + l] * sensor->across[j * cols + l];
            frame[i * cols + j] = total * sensor->inverse[i * cols + j];
        }
    multiply(sensor->down, 1, frame, rows, rows, cols, other);
    multiply(other, 0, sensor->across, rows, cols, cols, frame);
}

void vh_undo(const struct vh_sensor *sensor, const vh_real *readings, int rows, int cols, vh_real *frame,
             uint8_t *valid, void *work)
{
    int n_broken = 0;

    for (int i = 0; i < rows * cols; i++) {
        vh_real rest = sensor->rest ? sensor->rest[i] : sensor->rest_of_all;
        vh_real share = (readings[i] - rest) * sensor->over_span, gain = sensor->gains ? sensor->gains[i] : 1;
        int is_read = share == share;
        int works = (is_read && gain >= LEAST_GAIN) || (sensor->field && !sensor->field[i]);
        share = share > sensor->saturation ? sensor->saturation : is_read ? share : 0;
        frame[i] = stress_of(sensor, share) / (gain >= LEAST_GAIN ? gain : 1) * sensor->scale;
        valid[i] = (uint8_t)works;
        n_broken += !works;
    }
    if (!sensor->inverse)
        return;
    if (n_broken) {
        uint8_t *all = work;
        memset(all, 1, (size_t)(rows * cols));
        vh_fill(frame, valid, all, rows, cols, (char *)work + (rows * cols + 7) / 8 * 8);
    }
    undo_spread(sensor, rows, cols, frame, work);
}

size_t vh_undo_work(int rows, int cols)
{
    size_t other = (size_t)(rows * cols) * sizeof(vh_real);
    size_t fill = (size_t)((rows * cols + 7) / 8 * 8) + vh_fill_work(rows, cols);

    return vh_most_bytes(fill, other);
}
