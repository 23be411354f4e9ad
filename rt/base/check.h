// An assertion that is active in every build: for our own bugs only, never for data from a user or a device. It carries
// numbers, not text. The handler runs on the failing thread: the program's handler zeroes the force (sends a brake
// frame) and ends the process; the default handler prints to stderr and aborts. Thread: [any].
#pragma once

namespace tactus {

struct CheckFailure {
  const char* expression;
  const char* file;
  int line;
  double a, b;  // the two numbers that explain the failure, 0 if none
};

using CheckHandler = void (*)(const CheckFailure&) noexcept;

// [setup] Replaces the handler and returns the one before.
CheckHandler set_check_handler(CheckHandler handler) noexcept;

[[noreturn]] void check_failed(const CheckFailure& failure) noexcept;

}  // namespace tactus

#define TACTUS_CHECK(condition, a, b) \
  (static_cast<bool>(condition)       \
       ? void(0)                      \
       : ::tactus::check_failed({#condition, __FILE__, __LINE__, static_cast<double>(a), static_cast<double>(b)}))
