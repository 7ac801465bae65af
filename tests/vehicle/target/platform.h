/* What a target has to offer: a counter of cycles or instructions (0 where there is none), output, and the most
 * stack used (0 where it is not measured). */
#ifndef PLATFORM_H
#define PLATFORM_H

#include <stdint.h>

void platform_start(void);
uint32_t platform_cycles(void);
void platform_print(const char *text);
uint32_t platform_stack(void);
void platform_end(void);

#endif
