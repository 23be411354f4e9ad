// Says of a function that the haptic thread calls it every tick, so that it may not allocate, lock, throw or block.
//
// Clang 20 and later hold it to that: -fsanitize=realtime (TACTUS_SANITIZE=realtime) stops at the call that breaks it,
// -Wfunction-effects tells some at compile time. For other compilers it is a word to the reader; what is checked with
// them is in tests/system/haptic_thread and tests/support/rt_guard.h. Stands where noexcept does, behind it.
// Thread: [any]. Source: Clang, RealtimeSanitizer and Function Effect Analysis.
#pragma once

#ifdef __has_cpp_attribute
#if __has_cpp_attribute(clang::nonblocking)
#define TACTUS_NONBLOCKING [[clang::nonblocking]]
#endif
#endif
#ifndef TACTUS_NONBLOCKING
#define TACTUS_NONBLOCKING
#endif
