// SPDX-License-Identifier: Apache-2.0
// BRUME_ASAN, BRUME_TSAN: 1 where the address or thread sanitizer watches, else 0. GCC says it by
// macros, clang by features.
#pragma once

#ifdef __has_feature
#define BRUME_HAS_FEATURE(x) __has_feature(x)
#else
#define BRUME_HAS_FEATURE(x) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || BRUME_HAS_FEATURE(address_sanitizer)
#define BRUME_ASAN 1
#else
#define BRUME_ASAN 0
#endif

#if defined(__SANITIZE_THREAD__) || BRUME_HAS_FEATURE(thread_sanitizer)
#define BRUME_TSAN 1
#else
#define BRUME_TSAN 0
#endif

#undef BRUME_HAS_FEATURE
