/* What compiled kernels ask of numba's runtime, over malloc and without Python: arrays that they
   make for themselves or give back, and lists. The head of a block is as numba knows it (its references come
   first; counting them is part of the kernels): its words, like all that kernels count in, have 64
   bits on every machine. */

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define HIDDEN __attribute__((visibility("hidden")))
#define EXPORTED __attribute__((visibility("default")))

typedef struct {
    uint64_t references;
    void (*destroy)(void *data, uint64_t size, void *info);
    void *info;
    void *data;
    uint64_t size;
    void *external;
} Block;

HIDDEN void *NRT_Allocate(uint64_t size) {
    return size > SIZE_MAX ? NULL : malloc(size ? size : 1);
}

HIDDEN void NRT_Free(void *data) { free(data); }

HIDDEN void *NRT_MemInfo_alloc_aligned(uint64_t size, uint32_t align) {
    if (size > SIZE_MAX - sizeof(Block) - align)
        return NULL;
    Block *block = malloc(sizeof(Block) + size + align);
    if (!block)
        return NULL;
    uintptr_t data = (uintptr_t)(block + 1);
    if (align)
        data = (data + align - 1) / align * align;
    *block = (Block){.references = 1, .data = (void *)data, .size = size};
    return block;
}

static void destroy_list(void *data, uint64_t size, void *info) {
    (void)size;
    if (info)
        ((void (*)(void *))info)(data); /* lets go of what the list holds */
    free(data);
}

/* A list: its elements stand in a block of their own. */
HIDDEN void *NRT_MemInfo_new_varsize_dtor(uint64_t size, void *info) {
    Block *block = malloc(sizeof(Block));
    void *data = NRT_Allocate(size);
    if (!block || !data) {
        free(block);
        free(data);
        return NULL;
    }
    *block = (Block){
        .references = 1, .destroy = destroy_list, .info = info, .data = data, .size = size};
    return block;
}

HIDDEN void NRT_MemInfo_call_dtor(Block *block) {
    if (block->destroy)
        block->destroy(block->data, block->size, block->info);
    free(block);
}

/* Let go of an array that a kernel has given back. */
EXPORTED void paint3d_release(Block *block) {
    if (block && __atomic_sub_fetch(&block->references, 1, __ATOMIC_ACQ_REL) == 0)
        NRT_MemInfo_call_dtor(block);
}

HIDDEN double numba_ldexp(double x, int exponent) { return ldexp(x, exponent); }

/* Strides for a new shape of as many elements; kernels reshape C-contiguous arrays only. */
HIDDEN int numba_attempt_nocopy_reshape(int64_t n, const int64_t *shape, const int64_t *strides,
                                        int64_t new_n, const int64_t *new_shape,
                                        int64_t *new_strides, int64_t item, int fortran) {
    (void)n, (void)shape, (void)strides;
    if (fortran)
        return 0;
    for (int64_t k = new_n - 1; k >= 0; k--) {
        new_strides[k] = item;
        item *= new_shape[k];
    }
    return 1;
}
