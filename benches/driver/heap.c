/* The C library's allocator with a counter in front; libraries loaded later find these first. */
#define _GNU_SOURCE
#include "heap.h"

#include <errno.h>
#include <malloc.h>
#include <stddef.h>

Heap heap;

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
extern void __libc_free(void *);

static void *counted(void *p) {
    heap.calls++;
    heap.bytes += p ? (long)malloc_usable_size(p) : 0;
    return p;
}

void *malloc(size_t size) {
    return counted(__libc_malloc(size));
}

void *calloc(size_t n, size_t size) {
    return counted(__libc_calloc(n, size));
}

void *realloc(void *p, size_t size) {
    heap.bytes -= p ? (long)malloc_usable_size(p) : 0;
    return counted(__libc_realloc(p, size));
}

void *aligned_alloc(size_t alignment, size_t size) {
    return counted(__libc_memalign(alignment, size));
}

int posix_memalign(void **p, size_t alignment, size_t size) {
    *p = counted(__libc_memalign(alignment, size));
    return *p ? 0 : ENOMEM;
}

void free(void *p) {
    heap.bytes -= p ? (long)malloc_usable_size(p) : 0;
    __libc_free(p);
}
