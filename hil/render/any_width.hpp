#pragma once

/// Before a function of plain loops: compiled for wide registers, too, and chosen when the program starts. Without fused
/// operations (-ffp-contract=off) both give the same numbers. Not with AddressSanitizer, which is not ready when the loader
/// chooses.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define RELNAV_ANY_WIDTH [[gnu::target_clones("avx2", "default")]]
#else
#define RELNAV_ANY_WIDTH
#endif
