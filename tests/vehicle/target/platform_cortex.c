/* Any Cortex-M under qemu: semihosting for output, SysTick for the instructions (with -icount shift=0 one lasts
 * 1 ns; SYSTICK_NS of them are a tick), paint on the stack. */
#include "platform.h"

#define PAINT 0xA5A5A5A5u
#define CSR (*(volatile uint32_t *)0xE000E010u)
#define RVR (*(volatile uint32_t *)0xE000E014u)
#define CVR (*(volatile uint32_t *)0xE000E018u)

extern uint32_t _end, _stack, _data, _edata, _data_in_flash, _bss;
int main(void);
void start(void);

static uint32_t call(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void start(void)
{
    uint32_t *from = &_data_in_flash, *to = &_data;
    while (to < &_edata) *to++ = *from++;
    for (to = &_bss; to < &_end; to++) *to = 0;
    main();
    for (;;) {}
}

__attribute__((section(".vectors"), used)) static const void *const vectors[2] = {&_stack, (const void *)start};

void platform_start(void)
{
    volatile uint32_t *place = &_end, here;
    while ((uintptr_t)place < (uintptr_t)&here - 64u) *place++ = PAINT;
    RVR = 0xFFFFFFu;
    CVR = 0;
    CSR = 5;
}

uint32_t platform_cycles(void)
{
    return (0xFFFFFFu - CVR) * SYSTICK_NS;
}

void platform_print(const char *text)
{
    call(4, text);
}

uint32_t platform_stack(void)
{
    const volatile uint32_t *place = &_end;
    while (*place == PAINT) place++;
    return (uint32_t)((uintptr_t)&_stack - (uintptr_t)place);
}

void platform_end(void)
{
    call(0x18, (const void *)0x20026u); /* ADP_Stopped_ApplicationExit */
}
