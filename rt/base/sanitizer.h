// Which sanitizer this is built for: TACTUS_ADDRESS_SANITIZER and TACTUS_THREAD_SANITIZER are 1 or 0, with gcc and
// clang. Thread: [any]; constants of the preprocessor.
#pragma once

#if defined(__has_feature)
#define TACTUS_HAS_FEATURE(feature) __has_feature(feature)
#else
#define TACTUS_HAS_FEATURE(feature) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || TACTUS_HAS_FEATURE(address_sanitizer)
#define TACTUS_ADDRESS_SANITIZER 1
#else
#define TACTUS_ADDRESS_SANITIZER 0
#endif

#if defined(__SANITIZE_THREAD__) || TACTUS_HAS_FEATURE(thread_sanitizer)
#define TACTUS_THREAD_SANITIZER 1
#else
#define TACTUS_THREAD_SANITIZER 0
#endif
