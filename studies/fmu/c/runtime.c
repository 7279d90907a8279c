/* What the compiled march asks of its runtime: memory that is counted, as Numba lays it out, and no more.
   On Linux the functions of glibc are taken in their oldest version, so that the library loads on old systems. */

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    size_t references;
    void (*destructor)(void *data, size_t size, void *information);
    void *information;
    void *data;
    size_t size;
    void *allocator;
} Memory;

void *NRT_MemInfo_alloc_aligned(size_t size, unsigned alignment)
{
    Memory *memory = malloc(sizeof(Memory) + size + alignment);
    if (!memory)
        return NULL;
    uintptr_t first = (uintptr_t)(memory + 1);
    memset(memory, 0, sizeof(Memory));
    memory->references = 1;
    memory->data = (void *)((first + alignment - 1) / alignment * alignment);
    memory->size = size;
    return memory;
}

void NRT_MemInfo_call_dtor(Memory *memory)
{
    if (memory->destructor)
        memory->destructor(memory->data, memory->size, memory->information);
    free(memory);
}

#ifdef APESIM_OLD_GLIBC
#define OLD(name) __asm__(".symver old_" #name "," #name "@GLIBC_2.2.5")
OLD(exp);
OLD(log);
OLD(pow);
OLD(memcpy);
double old_exp(double);
double old_log(double);
double old_pow(double, double);
void *old_memcpy(void *, const void *, size_t);
double __wrap_exp(double x) { return old_exp(x); }
double __wrap_log(double x) { return old_log(x); }
double __wrap_pow(double x, double y) { return old_pow(x, y); }
void *__wrap_memcpy(void *target, const void *source, size_t size) { return old_memcpy(target, source, size); }
#endif
