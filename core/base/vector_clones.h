// SKYQUILT_VECTOR_CLONES before a function: it is compiled for AVX2 too, and the program takes what the
// machine has. For plain loops over numbers. The results are the same bits either way: nothing is fused or
// reordered by it.
#pragma once

// Sanitizers run too late for the choice, which is made while the program is loaded.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define SKYQUILT_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define SKYQUILT_VECTOR_CLONES
#endif
