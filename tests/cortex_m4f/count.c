/* Runs the recognizer on its vectors and prints names, instructions and stack: on an emulator that counts an instruction
 * as a nanosecond (qemu -icount shift=0), of which the board's system timer counts forty as one. */
#include <stdint.h>
#include <stdio.h>

#include "vectors.h"

#define SYST_CSR (*(volatile uint32_t *)0xE000E010)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018)
#define A_TICK 40
#define PAINTED 4096
#define PAINT 0xA5A5A5A5u

static double work[(PAD_WORK_BYTES + sizeof(double) - 1) / sizeof(double)];
static struct vh_touch touches[PAD_CONTACTS];

/* Paints the stack below, and tells later how deep it was used. */
static __attribute__((noinline)) unsigned stack(int paint)
{
    volatile uint32_t room[PAINTED];
    unsigned clean = 0;

    if (paint)
        for (int i = 0; i < PAINTED; i++)
            room[i] = PAINT;
    while (clean < PAINTED && room[clean] == PAINT)
        clean++;
    return 4 * (PAINTED - clean);
}

int main(void)
{
    uint32_t total = 0, most = 0;
    unsigned deepest;
    int other = 0;

    SYST_RVR = 0xFFFFFF;
    SYST_CVR = 0;
    SYST_CSR = 5;
    stack(1);
    for (int i = 0; i < vectors_count; i++) {
        uint32_t begun = SYST_CVR, taken;
        int n = vh_feel(&pad, vectors_readings(i), touches, work);
        taken = (begun - SYST_CVR) & 0xFFFFFF;
        total += taken;
        most = taken > most ? taken : most;
        other += vectors[i].name != (n > 0 ? touches[0].answer.name : -1);
    }
    deepest = stack(0);
    printf("{\"vectors\": %d, \"other_names\": %d, \"mean_instructions\": %lu, \"most_instructions\": %lu, "
           "\"stack_bytes\": %u, \"work_bytes\": %u}\n",
           vectors_count, other, (unsigned long)(A_TICK * (total / (uint32_t)vectors_count)),
           (unsigned long)(A_TICK * most), deepest, (unsigned)vh_feel_work(&pad));
    return 0;
}
