/* What the processor can do. */
#include "varishold.h"

#if defined(__x86_64__) || defined(_M_X64)
#include <cpuid.h>

/* Returns the extensions of leaf 7 of a processor with AVX and FMA; 0 where the system does not keep these of its wide
 * registers when it changes threads. */
static unsigned extensions(unsigned kept)
{
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & (1u << 27)) || !(c & (1u << 28)) || !(c & (1u << 12)))
        return 0;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    (void)high;
    if ((low & kept) != kept || !__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return 0;
    return b;
}

int vh_cpu_has_avx2(void)
{
    return (extensions(0x06u) & (1u << 5)) != 0;
}

int vh_cpu_has_avx512(void)
{
    /* F, DQ, BW and VL. */
    unsigned wanted = 1u << 16 | 1u << 17 | 1u << 30 | 1u << 31;
    return vh_cpu_has_avx2() && (extensions(0xE6u) & wanted) == wanted;
}
#else
int vh_cpu_has_avx2(void) { return 0; }
int vh_cpu_has_avx512(void) { return 0; }
#endif
