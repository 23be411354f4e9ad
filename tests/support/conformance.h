// Runs firmware/conformance.txt on a device. Returns the input lines, with answer lines replaced by the device's
// answers. Thread: one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/can_codec.h"
#include "firmware/device.h"

namespace tactus::test {

std::vector<std::byte> bytes_of(const std::string& hex);
std::string hex_of(std::span<const std::byte> bytes);

// "IDLE, sequence 2, time 2000 us, fault 0, limits 0x0000, buttons 0, missed 0, echo 41".
std::string says(const firmware::StateFrame& frame);

class ConformanceDevice {
 public:
  // Call for each line of the file, in order.
  std::string answer(const std::string& line);

 private:
  void restart();
  void period();
  void split(const std::string& what, const std::vector<std::byte>& bytes);
  void join(unsigned function, const std::vector<std::byte>& bytes);

  std::optional<firmware::Device> device_;
  firmware::ControllerInputs inputs_;
  firmware::ControllerOutputs outputs_;
  firmware::StateSplitter splitter_;
  firmware::CommandAssembler commands_;
  std::optional<firmware::StateAssembler> states_;
  std::string reply_, fragments_, joined_;
};

}  // namespace tactus::test
