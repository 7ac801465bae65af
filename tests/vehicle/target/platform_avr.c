/* ATmega with the serial port 0, timer 1 and paint on the stack; for simavr, which ends at `cli; sleep`. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#include "platform.h"

#define PAINT 0xA5

extern uint8_t _end;
static volatile uint16_t overflows;

ISR(TIMER1_OVF_vect)
{
    overflows++;
}

void platform_start(void)
{
    volatile uint8_t *place = &_end;
    while ((uintptr_t)place < (uintptr_t)SP - 8u) *place++ = PAINT;
    UBRR0 = 0;
    UCSR0B = 1 << TXEN0;
    TCCR1B = 1 << CS10; /* a tick a cycle */
    TIMSK1 = 1 << TOIE1;
    sei();
}

uint32_t platform_cycles(void)
{
    uint16_t high, low;
    uint8_t flags = SREG;
    cli();
    low = TCNT1;
    high = overflows;
    if ((TIFR1 & (1 << TOV1)) && low < 32768u) high++;
    SREG = flags;
    return (uint32_t)high << 16 | low;
}

void platform_print(const char *text)
{
    while (*text) {
        while (!(UCSR0A & (1 << UDRE0))) {}
        UDR0 = (uint8_t)*text++;
    }
}

uint32_t platform_stack(void)
{
    const volatile uint8_t *place = &_end;
    while (*place == PAINT) place++;
    return (uint32_t)(RAMEND - (uintptr_t)place + 1u);
}

void platform_end(void)
{
    platform_print("\n");
    while (!(UCSR0A & (1 << TXC0))) {}
    cli();
    sleep_enable();
    sleep_cpu();
}
