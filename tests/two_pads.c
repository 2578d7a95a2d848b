/* Reads what two pads say of one thing, a line a press; says the name, and the probability of every class by both. */
#include <stdio.h>
#include "varishold.h"

#define MOST_READINGS 2304
#define MOST_CLASSES 255

extern const struct vh_pad thumb, palm;
static const struct vh_pad *const pads[] = {&thumb, &palm};
static double work[20000];

/* Multiplies what a pad says into p; returns 1 where it says that it is none of the classes. */
static int weigh(const struct vh_pad *pad, const vh_real *readings, double *p)
{
    struct vh_touch touches[8];
    int n_classes = pad->parameters->kinds - 1;
    const vh_real *said;

    if (vh_feel(pad, readings, touches, work) < 1 || touches[0].answer.name < 0)
        return 0;
    said = vh_kind_probability(pad, work);
    for (int k = 0; k < n_classes; k++)
        p[k] *= (double)said[k];
    return touches[0].answer.name == n_classes;
}

int main(void)
{
    vh_real readings[MOST_READINGS];

    for (;;) {
        double p[MOST_CLASSES], sum = 0;
        int n_classes = thumb.parameters->kinds - 1, strange = 0, best = 0;
        for (int k = 0; k < n_classes; k++)
            p[k] = 1;
        for (int i = 0; i < 2; i++) {
            for (int j = 0; j < pads[i]->rows * pads[i]->cols; j++) {
                double value;
                if (scanf("%lf", &value) != 1)
                    return 0;
                readings[j] = (vh_real)value;
            }
            strange |= weigh(pads[i], readings, p);
        }
        for (int k = 0; k < n_classes; k++) {
            sum += p[k];
            best = p[k] > p[best] ? k : best;
        }
        printf("%d", strange ? n_classes : best);
        for (int k = 0; k < n_classes; k++)
            printf(" %.6f", p[k] / sum);
        printf("\n");
    }
}
