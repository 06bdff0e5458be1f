/* Counts what the process asks of the heap. */
#ifndef HEAP_H
#define HEAP_H

typedef struct {
    long calls; /* malloc, calloc, realloc and their aligned kin */
    long bytes; /* in use, as the C library rounds them */
} Heap;

extern Heap heap;

#endif
