/* What the processor can do. */
#include "varishold.h"

#if defined(__x86_64__) || defined(_M_X64)
#include <cpuid.h>

int vh_cpu_has_avx2(void)
{
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & (1u << 27)) || !(c & (1u << 28)) || !(c & (1u << 12)))
        return 0;
    /* The system keeps the wide registers when it changes threads. */
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    (void)high;
    if ((low & 6u) != 6u || !__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return 0;
    return (b & (1u << 5)) != 0;
}
#else
int vh_cpu_has_avx2(void) { return 0; }
#endif
