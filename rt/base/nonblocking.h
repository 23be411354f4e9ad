// Marks a function that the haptic thread calls in every tick: it must not allocate, lock, throw or block.
//
// Clang 20 and later enforce it: -fsanitize=realtime (TACTUS_SANITIZE=realtime) stops at a violating call,
// -Wfunction-effects reports some at compile time. For other compilers it is documentation; their checks are in
// tests/system/haptic_thread and tests/support/rt_guard.h. Placed after noexcept. Thread: [any]. Source: Clang,
// RealtimeSanitizer and Function Effect Analysis.
#pragma once

#ifdef __has_cpp_attribute
#if __has_cpp_attribute(clang::nonblocking)
#define TACTUS_NONBLOCKING [[clang::nonblocking]]
#endif
#endif
#ifndef TACTUS_NONBLOCKING
#define TACTUS_NONBLOCKING
#endif
