// The device's image in a QEMU of its own: its serial line, and the memory that is its mechanics.
//
// Thread: one, the test's. Every wait ends: Failure is thrown if the device sends nothing for twenty seconds, or if a
// condition does not hold within some thousand frames. StoodStill is thrown if the device's time stamps show that the
// emulator did not run for five periods or more: the result of such a run is not valid.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>

#include "firmware/boards/cortex_m/board_registers.h"
#include "firmware/boards/cortex_m/cobs.h"
#include "firmware/controller.h"
#include "firmware/service.h"

namespace tactus::firmware::cortex_m {

struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct StoodStill {};

inline void require(bool good, const char* otherwise) {
  if (!good) throw Failure(otherwise);
}

// Symbols whose addresses the caller must supply.
enum class Symbol : std::size_t { kBoardRegisters = 0, kStackLimit = 1, kStackTop = 2, kPeriodClock = 3 };
inline constexpr std::array<const char*, 4> kSymbols{"board_registers", "stack_limit", "stack_top", "period_clock"};

class EmulatedDevice {
 public:
  EmulatedDevice(const char* image, const char* memory_file, std::span<char*> symbols);
  ~EmulatedDevice();
  EmulatedDevice(const EmulatedDevice&) = delete;
  EmulatedDevice& operator=(const EmulatedDevice&) = delete;

  BoardRegisters& registers() { return *reinterpret_cast<BoardRegisters*>(at(Symbol::kBoardRegisters)); }
  std::uint32_t volatile& word(Symbol symbol) { return *reinterpret_cast<std::uint32_t volatile*>(at(symbol)); }
  std::size_t stack_size() const;
  std::size_t stack_high_water() const;  // bytes, since the newest start

  void send_bytes(std::span<const std::byte> bytes);
  // Waits for the next state frame.
  StateFrame next_state();
  // Same; then sends a command, if the device has taken the one before.
  StateFrame turn(State wanted, const AxisValues& effort, bool rearm = false);
  std::uint32_t commands_sent() const { return sequence_; }
  bool command_was_taken() const { return echoed_ == sequence_; }
  void await(const std::function<bool(const StateFrame&)>& holds, const char* otherwise);
  // Drops state frames that were received and not read.
  void forget_waiting();
  // Waits until the device has written the place of a fault.
  void await_fault();
  // Waits until the device sends frames again.
  void await_restart();
  // True if one of the next frames shows that the emulator stood still. The memory is ahead of the frames, so a wrong
  // value in it may come from such a stop.
  bool stands_still_soon();
  ServiceMessage ask(Operation operation, std::uint16_t address, std::uint32_t value = 0);

 private:
  std::byte* at(Symbol symbol) const;
  void send_frame(std::span<const std::byte> frame);
  bool read_frame(int timeout_ms);
  StateFrame read_state();

  std::byte* memory_{nullptr};
  std::array<std::uint32_t, kSymbols.size()> addresses_{};
  int line_{-1};
  pid_t emulator_{-1};
  FrameReader reader_;
  std::array<std::byte, 4096> incoming_{};
  std::size_t begin_{0}, end_{0};
  std::uint32_t sequence_{0}, echoed_{0}, state_sequence_{0};
  int states_since_command_{0};
  std::uint64_t time_us_{0};
  ServiceMessage reply_;
  bool replied_{false};
  std::uint8_t tag_{0};
};

}  // namespace tactus::firmware::cortex_m
