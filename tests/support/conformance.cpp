#include "tests/support/conformance.h"

#include <cstdio>
#include <sstream>

#include "firmware/service.h"
#include "tests/support/bench_config.h"

namespace tactus::test {
namespace {

using namespace firmware;

template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

}  // namespace

std::vector<std::byte> bytes_of(const std::string& hex) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

std::string hex_of(std::span<const std::byte> bytes) {
  std::string hex;
  for (const std::byte b : bytes) hex += text("%02x", std::to_integer<unsigned>(b));
  return hex;
}

std::string says(const StateFrame& f) {
  const char* const states[] = {"RESET", "IDLE", "FORCE", "BRAKE"};
  return text("%s, sequence %u, time %llu us, fault %u, limits 0x%04x, buttons %u, missed %u, echo %u",
              states[static_cast<unsigned>(f.state)], f.sequence, static_cast<unsigned long long>(f.time_us),
              unsigned{f.fault}, unsigned{f.limits}, unsigned{f.buttons}, unsigned{f.missed_commands},
              f.echoed_sequence);
}

std::string ConformanceDevice::answer(const std::string& line) {
  std::istringstream words(line);
  std::string word, hex;
  words >> word;
  if (word == "case") restart();
  if (word == "counts")
    for (auto& count : inputs_.counts) words >> count;
  if (word == "e-stop") words >> inputs_.emergency_stop;
  if (word == "supply") words >> inputs_.motor_bus_ok;
  if (word == "in") words >> hex, device_->hear(bytes_of(hex));
  if (word == "period") period();
  if (word == "request") {
    ServiceMessage message;
    std::array<std::byte, kServiceFrameSize> reply{};
    words >> hex;
    reply_ = "nothing";
    if (decode_service(bytes_of(hex), ServiceDirection::kRequest, message) == DecodeError::kNone) {
      encode_service(device_->serve(message), ServiceDirection::kReply, reply);
      reply_ = hex_of(reply);
    }
  }
  if (word == "split-command" || word == "split-state") words >> hex, split(word, bytes_of(hex));
  if (word == "fragment") {
    unsigned function = 0;
    words >> function >> hex;
    join(function, bytes_of(hex));
  }

  StateFrame frame;
  if (word == "out") return "out " + hex_of(outputs_.state_frame);
  if (word == "says" && decode_state(outputs_.state_frame, frame) == DecodeError::kNone) return "says " + says(frame);
  if (word == "reply") return "reply " + reply_;
  if (word == "fragments") return "fragments" + fragments_;
  if (word == "joined") return "joined " + joined_;
  if (word != "motors") return line;
  std::string efforts;
  for (const float e : outputs_.effort) efforts += text(" %.9g", static_cast<double>(e));
  return outputs_.brake ? "motors short" : "motors" + efforts;
}

void ConformanceDevice::restart() {
  device_.emplace(bench_config(), make_identity(MechanismClass::kUnknown, "T0042"));
  inputs_ = {};
  outputs_ = {};
  splitter_ = {};
  commands_ = {};
  states_.emplace(1000);
}

void ConformanceDevice::period() {
  inputs_.time_us += 1000;
  outputs_ = device_->step(inputs_, {});
}

void ConformanceDevice::split(const std::string& what, const std::vector<std::byte>& bytes) {
  std::array<CanFragment, kStateFragments + 1> out{};
  unsigned count = 0;
  CommandFrame command;
  StateFrame state;
  if (what == "split-command" && decode_command(bytes, command) == DecodeError::kNone) {
    const auto pair = split_command(command);
    out[0] = pair[0];
    out[1] = pair[1];
    count = kCommandFragments;
  } else if (what == "split-state" && decode_state(bytes, state) == DecodeError::kNone) {
    count = splitter_.split(state, out);
  }
  fragments_.clear();
  for (unsigned i = 0; i < count; ++i)
    fragments_ += text(" %u:", static_cast<unsigned>(out[i].function)) + hex_of(out[i].data);
}

void ConformanceDevice::join(unsigned function, const std::vector<std::byte>& bytes) {
  joined_ = "nothing";
  const auto of = static_cast<CanFunction>(function);
  if (of == CanFunction::kCommand0 || of == CanFunction::kCommand1) {
    CommandFrame frame;
    std::array<std::byte, kCommandFrameSize> whole{};
    if (!commands_.accept(of, bytes, frame)) return;
    encode_command(frame, whole);
    joined_ = hex_of(whole);
  } else {
    StateFrame frame;
    std::array<std::byte, kStateFrameSize> whole{};
    states_->look();
    if (!states_->accept(of, bytes, frame)) return;
    encode_state(frame, whole);
    joined_ = hex_of(whole);
  }
}

}  // namespace tactus::test
