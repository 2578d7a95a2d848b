/* What the processor can do. */
#include "varishold.h"

#if defined(__x86_64__) || defined(_M_X64)
#include <cpuid.h>

/* Whether a processor with AVX and FMA has these extensions of leaf 7 (EBX and ECX), and the system keeps these of its wide
 * registers when it changes threads. */
static int has(unsigned wanted_b, unsigned wanted_c, unsigned kept)
{
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & (1u << 27)) || !(c & (1u << 28)) || !(c & (1u << 12)))
        return 0;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    (void)high;
    if ((low & kept) != kept || !__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return 0;
    return (b & wanted_b) == wanted_b && (c & wanted_c) == wanted_c;
}

int vh_cpu_has_avx2(void) { return has(1u << 5, 0, 0x06u); }

int vh_cpu_has_avx512(void)
{
    /* F, DQ, BW and VL; and VBMI2, which those have that do not slow down at registers of 512 bits. */
    return vh_cpu_has_avx2() && has(1u << 16 | 1u << 17 | 1u << 30 | 1u << 31, 1u << 6, 0xE6u);
}
#else
int vh_cpu_has_avx2(void) { return 0; }
int vh_cpu_has_avx512(void) { return 0; }
#endif
