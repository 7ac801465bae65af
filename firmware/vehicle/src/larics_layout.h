/* Where the fields of a message are, on the wire and in its structure, private to the library. */
#ifndef LARICS_LAYOUT_H
#define LARICS_LAYOUT_H

#include "larics.h"

typedef struct {
    uint8_t type;
    uint8_t first; /* of its fields */
    uint8_t count;
    uint8_t size; /* of the payload */
} larics_layout;

/* The layout of a type into *found; 0 when there is none. */
int larics_layout_find(uint8_t type, larics_layout *found);

/* From the wire to the structure at `to`; 0 when a value is out of its range. */
int larics_unpack(const larics_layout *type, const uint8_t *wire, uint8_t *to);

/* From the structure at `from` to the wire; 0 when a value is out of its range. */
int larics_pack(const larics_layout *type, const uint8_t *from, uint8_t *wire);

/* Little-endian. */
void larics_put32(uint8_t *bytes, uint32_t value);

#endif
