// The concepts that a board implements, and the control period that every board runs.
//
// A board supplies mechanics (encoders, motors, the e-stop line) and a link to the host; Device, between them, is the
// same on all boards. The board's timer calls `run_period` once per control period. New hardware needs one class for
// each of the two concepts. Thread: the control period's, [rt]: nothing here waits, allocates or throws; the two
// classes may not either. Bound: per period at most one service request and kMaxCommands commands.
#pragma once

#include <concepts>

#include "firmware/device.h"

namespace tactus::firmware {

// Most command frames read in one period; further frames wait for the next.
inline constexpr unsigned kMaxCommands = 128;

// Encoders and motors. sample() fills counts, time, buttons, e-stop and supply; drive() applies the outputs until the
// next call.
template <class M>
concept Mechanics = requires(M mechanics, ControllerInputs& inputs, const ControllerOutputs& outputs) {
  { mechanics.sample(inputs) }
  noexcept->std::same_as<void>;
  { mechanics.drive(outputs) }
  noexcept->std::same_as<void>;
};

// The device's end of a link.
template <class L>
concept DeviceLink = requires(L link, std::span<std::byte, kMaxFrameSize> buffer, std::span<const std::byte> frame,
                              ServiceMessage& message) {
  // Copies the next received command frame, oldest first, into `buffer` and returns its size; 0: no more. The period
  // reads them all, because the controller decides which one counts. A link with limited storage keeps the newest.
  { link.receive_command(buffer) }
  noexcept->std::same_as<std::size_t>;
  { link.send_state(frame) }
  noexcept->std::same_as<void>;
  // Takes a waiting service request; false if there is none. reply_service() replies to the last one taken.
  { link.receive_service(message) }
  noexcept->std::same_as<bool>;
  { link.reply_service(message) }
  noexcept->std::same_as<void>;
};

// Non-volatile memory for the configuration. load() [setup]: copies the last stored block into `buffer` and returns its
// size; 0 if there is none. store() accepts a block; false if it cannot. A board that writes slowly copies the block
// and writes it in the background.
template <class S>
concept Storage = requires(S storage, std::span<std::byte> buffer, std::span<const std::byte> block) {
  { storage.load(buffer) } -> std::same_as<std::size_t>;
  { storage.store(block) }
  noexcept->std::same_as<bool>;
};

// For a board without non-volatile memory: store() reports failure.
struct NoStorage {
  std::size_t load(std::span<std::byte>) noexcept { return 0; }
  bool store(std::span<const std::byte>) noexcept { return false; }
};

// [setup] Before the first period. False: the stored block is invalid, and the factory configuration stays active.
template <Storage S>
bool restore_configuration(Device& device, S& storage) {
  std::array<std::byte, kConfigBlockSize> buffer;
  const std::size_t size = storage.load(buffer);
  return size == 0 || (size <= buffer.size() && device.restore(std::span<const std::byte>(buffer).first(size)));
}

template <Mechanics M, DeviceLink L, Storage S>
void run_period(Device& device, M& mechanics, L& link, S& storage) noexcept {
  ServiceMessage message;
  if constexpr (TellsBusErrors<L>) device.note_bus_errors(link.bus_errors());
  if (link.receive_service(message)) link.reply_service(device.serve(message));

  ControllerInputs inputs;
  mechanics.sample(inputs);
  std::array<std::byte, kMaxFrameSize> buffer;
  for (unsigned i = 0; i < kMaxCommands; ++i) {
    const std::size_t size = link.receive_command(buffer);
    if (size == 0) break;
    device.hear(std::span<const std::byte>(buffer).first(size));
  }
  const ControllerOutputs outputs = device.step(inputs, {});
  mechanics.drive(outputs);
  link.send_state(outputs.state_frame);

  if (const std::span<const std::byte> block = device.block_to_store(); !block.empty())
    device.stored(storage.store(block));
}

template <Mechanics M, DeviceLink L>
void run_period(Device& device, M& mechanics, L& link) noexcept {
  NoStorage none;
  run_period(device, mechanics, link, none);
}

}  // namespace tactus::firmware
