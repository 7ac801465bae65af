/* Constant tables in flash, private to the library. An AVR copies plain constants to RAM, of which an Uno
 * has 2,048 bytes; everywhere else a table is an ordinary constant. */
#ifndef LARICS_FLASH_H
#define LARICS_FLASH_H

#include <stdint.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
#define LARICS_IN_FLASH PROGMEM
#define larics_flash_u8(place) pgm_read_byte(place)
#define larics_flash_u16(place) pgm_read_word(place)
#define larics_flash_u32(place) pgm_read_dword(place)
#define larics_flash_i32(place) ((int32_t)pgm_read_dword(place))
#else
#define LARICS_IN_FLASH
#define larics_flash_u8(place) (*(place))
#define larics_flash_u16(place) (*(place))
#define larics_flash_u32(place) (*(place))
#define larics_flash_i32(place) (*(place))
#endif

#endif
