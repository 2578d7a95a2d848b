/* What the files of the kernel share, and nobody else needs. */
#ifndef VARISHOLD_INNER_H
#define VARISHOLD_INNER_H

#include <stddef.h>

/*
 * Takes the next piece of a work space: `*used` goes on by n items of so many bytes, to a multiple of eight. With
 * work = NULL the pieces are only counted, so that one function both divides a work space and tells its size.
 */
static inline void *vh_take(void *work, size_t *used, size_t n, size_t bytes)
{
    void *piece = work ? (char *)work + *used : 0;
    *used += (n * bytes + 7) / 8 * 8;
    return piece;
}

#endif
