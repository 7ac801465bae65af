#include <stdio.h>

#include "platform.h"

void platform_start(void) {}

uint32_t platform_cycles(void)
{
    return 0;
}

void platform_print(const char *text)
{
    fputs(text, stdout);
}

uint32_t platform_stack(void)
{
    return 0;
}

void platform_end(void) {}
