/* Begins on a bare Cortex-M4F: copies data, switches the floating-point unit on, calls main, ends the emulator. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t _data_from[], _data[], _data_end[], _bss[], _bss_end[], _stack[];
extern void initialise_monitor_handles(void);
int main(void);

void reset(void)
{
    uint32_t *from = _data_from;

    for (uint32_t *to = _data; to < _data_end; to++)
        *to = *from++;
    for (uint32_t *to = _bss; to < _bss_end; to++)
        *to = 0;
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20;
    __asm__ volatile("dsb\nisb");
    initialise_monitor_handles();
    exit(main());
}

/* The C library asks for these where nothing is to be done before and after main. */
void _init(void)
{
}

void _fini(void)
{
}

static void fault(void)
{
    exit(70);
}

__attribute__((section(".vectors"), used)) static void *const vectors[] = {
    _stack, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};
