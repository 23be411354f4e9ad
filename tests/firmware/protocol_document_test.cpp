// PROTOCOL.md against the code: its register table, its numbers, its example bytes, its section on CAN. Where the
// sources are not at hand (on a target), there is nothing to compare.
#ifdef TACTUS_SOURCE_DIR

#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/boards/cortex_m/cobs.h"
#include "firmware/boards/cortex_m/configuration.h"
#include "firmware/homing.h"
#include "firmware/registers.h"
#include "firmware/self_test.h"
#include "firmware/service.h"
#include "firmware/usb_interface.h"

using namespace tactus::firmware;

namespace {

std::vector<std::string> lines_of(const std::string& file) {
  std::ifstream stream(std::string(TACTUS_SOURCE_DIR) + "/firmware/" + file);
  REQUIRE(stream.good());
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

std::string value_text(const Register& row, std::uint32_t bits) {
  if (row.type == RegisterType::kF32) return text("%g", static_cast<double>(std::bit_cast<float>(bits)));
  if (row.type == RegisterType::kI32) return text("%d", static_cast<std::int32_t>(bits));
  return text("%u", bits);
}

std::string states_text(std::uint8_t states) {
  std::string all;
  const char* const names[] = {"R", "I", "F", "B"};
  for (unsigned s = 0; s < kStates; ++s)
    if (((states >> s) & 1u) != 0) all += names[s];
  return all;
}

// The row as PROTOCOL.md prints it, up to its meaning.
std::string row_text(const Register& row) {
  const char* const types[] = {"u32", "i32", "f32"};
  const char* const accesses[] = {"r", "rw", "x"};
  const std::string numbers = row.count == 1
                                  ? text("0x%04x", unsigned{row.number})
                                  : text("0x%04x to 0x%04x", unsigned{row.number}, row.number + row.count - 1u);
  const bool ranged = row.access != Access::kRead;
  return "| " + numbers + " | " + row.name + " | " + types[static_cast<unsigned>(row.type)] + " | " +
         accesses[static_cast<unsigned>(row.access)] + " | " + states_text(row.states) + " | " + row.unit + " | " +
         (ranged ? value_text(row, row.low) : "") + " | " + (ranged ? value_text(row, row.high) : "") + " | ";
}

// The lines of a section, from its heading to the next.
std::vector<std::string> section(const std::string& heading) {
  std::vector<std::string> found;
  bool inside = false;
  for (const std::string& line : lines_of("PROTOCOL.md")) {
    if (line.rfind("## ", 0) == 0) inside = line == "## " + heading;
    if (inside) found.push_back(line);
  }
  REQUIRE(found.size() > 1);
  return found;
}

// The first column of a section's tables, where it is a number.
std::map<unsigned, unsigned> numbers_in(const std::string& heading) {
  std::map<unsigned, unsigned> count;
  for (const std::string& line : section(heading)) {
    unsigned first = 0, last = 0;
    const int fields = std::sscanf(line.c_str(), "| %u to %u", &first, &last);
    if (fields < 1) continue;
    for (unsigned n = first; n <= (fields == 2 ? last : first); ++n) ++count[n];
  }
  return count;
}

std::string axes_text(const AxisValues& values) {
  std::string all;
  for (const float v : values) all += text(" %g", static_cast<double>(v));
  return all;
}

const char* state_name(State state) {
  const char* const names[] = {"RESET", "IDLE", "FORCE", "BRAKE"};
  return names[static_cast<unsigned>(state)];
}

std::string describe(const std::string& kind, const std::vector<std::byte>& bytes) {
  if (kind == "command") {
    CommandFrame f;
    if (decode_command(bytes, f) != DecodeError::kNone) return "no command";
    return text("command: wanted %s, re-arm %d, sequence %u, efforts", state_name(f.wanted), f.rearm ? 1 : 0,
                f.sequence) +
           axes_text(f.effort);
  }
  if (kind == "state") {
    StateFrame f;
    if (decode_state(bytes, f) != DecodeError::kNone) return "no state";
    std::string counts;
    for (const std::int32_t c : f.counts) counts += text(" %d", c);
    return text("state: %s, sequence %u, time %llu us, counts", state_name(f.state), f.sequence,
                static_cast<unsigned long long>(f.time_us)) +
           counts +
           text(", echo %u, fault %u, limits 0x%04x, buttons %u, missed %u", f.echoed_sequence, unsigned{f.fault},
                unsigned{f.limits}, unsigned{f.buttons}, unsigned{f.missed_commands});
  }
  ServiceMessage m;
  const auto direction = kind == "request" ? ServiceDirection::kRequest : ServiceDirection::kReply;
  if (decode_service(bytes, direction, m) != DecodeError::kNone) return "no service message";
  return kind + text(": operation %u, status %u, tag %u, register 0x%04x, value 0x%08x",
                     static_cast<unsigned>(m.operation), static_cast<unsigned>(m.status), unsigned{m.tag},
                     unsigned{m.address}, m.value);
}

}  // namespace

TEST_CASE("the document's register table is the device's, row by row") {
  std::vector<std::string> printed;
  for (const std::string& line : section("Registers"))
    if (line.rfind("| 0x", 0) == 0) printed.push_back(line);
  REQUIRE(printed.size() == all_registers().size());
  for (std::size_t i = 0; i < printed.size(); ++i) {
    const std::string expected = row_text(all_registers()[i]);
    CHECK(printed[i].substr(0, expected.size()) == expected);
    CHECK(printed[i].size() > expected.size() + 5);  // its meaning
  }
}

TEST_CASE("the document names the revision of the register table that it prints") {
  std::string all;
  for (const std::string& line : section("Registers")) all += line + "\n";
  CHECK(all.find(text("This page is register_revision %u.", unsigned{kRegisterRevision})) != std::string::npos);
}

TEST_CASE("the document has every state, fault, limit, status and self-test bit, once") {
  const auto has = [](const std::string& heading, unsigned first, unsigned last) {
    const auto numbers = numbers_in(heading);
    CAPTURE(heading);
    CHECK(numbers.size() == last - first + 1);
    for (unsigned n = first; n <= last; ++n) CHECK(numbers.count(n) == 1);
    for (const auto& [number, times] : numbers) CHECK(times == 1);
  };
  has("States", 0, 3);
  has("Faults", 1, static_cast<unsigned>(Fault::kSelfTest));
  has("Limits", kFirstLimit, static_cast<unsigned>(Limit::kIdleFirst));
  has("Service messages", 0, static_cast<unsigned>(ServiceStatus::kBusy));
  has("Self-test", 0, 5);
}

TEST_CASE("the document's example bytes decode to the values beside them") {
  unsigned examples = 0;
  std::map<std::string, unsigned> kinds;
  const auto lines = section("An exchange, byte by byte");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string kind = lines[i].substr(0, lines[i].find(':'));
    if (kind != "command" && kind != "state" && kind != "request" && kind != "reply") continue;
    std::vector<std::byte> bytes;
    for (std::size_t k = i + 1; k < lines.size() && lines[k].rfind("  ", 0) == 0; ++k) {
      std::istringstream hex(lines[k]);
      for (unsigned value = 0; hex >> std::hex >> value;) bytes.push_back(static_cast<std::byte>(value));
    }
    CHECK(describe(kind, bytes) == lines[i]);
    ++examples;
    ++kinds[kind];
  }
  CHECK(examples >= 8);
  CHECK(kinds.size() == 4);
}

TEST_CASE("the document and the code agree about USB") {
  std::string all;
  for (const std::string& line : section("USB")) all += line + "\n";
  for (const std::string& figure :
       {text("0x%04x", unsigned{kUsbVendor}), text("0x%04x", unsigned{kUsbProduct}),
        text("0x%02x", unsigned{kUsbStateEndpoint}), text("0x%02x", unsigned{kUsbCommandEndpoint}),
        text("%u bytes", unsigned{kUsbPacketSize}), text("0x%02x", unsigned{kUsbRequestOut}),
        text("0x%02x", unsigned{kUsbRequestIn}), text("vendor code 0x%02x", unsigned{kUsbMicrosoftVendorCode}),
        std::string(kUsbInterfaceGuid), text("subclass 0x%02x", unsigned{kUsbInterfaceSubclass}),
        std::string("WINUSB")}) {
    CAPTURE(figure);
    CHECK(all.find(figure) != std::string::npos);
  }
}

TEST_CASE("the document's serial line is that of the code: rate, bits of a period, an example") {
  std::string all;
  std::vector<std::vector<std::byte>> examples;
  for (const std::string& line : section("Serial line")) {
    all += line + "\n";
    if (line.rfind("  ", 0) != 0) continue;
    std::istringstream hex(line);
    examples.emplace_back();
    for (unsigned value = 0; hex >> std::hex >> value;) examples.back().push_back(static_cast<std::byte>(value));
  }
  const auto bits = [](std::size_t frame) { return static_cast<unsigned>(10 * (frame + 2)); };
  for (const std::string& figure :
       {text("%u bit/s", unsigned{cortex_m::kSerialBitRate_Hz}), text("than %u bytes", unsigned{kStateFrameSize}),
        text("state takes %u bits of a period's %u", bits(kStateFrameSize),
             unsigned{cortex_m::kSerialBitRate_Hz / 1000}),
        text("reply %u more", bits(kServiceFrameSize)), text("command takes %u the", bits(kCommandFrameSize))}) {
    CAPTURE(figure);
    CHECK(all.find(figure) != std::string::npos);
  }
  REQUIRE(examples.size() == 2);
  ServiceMessage message;
  CHECK(decode_service(examples[0], ServiceDirection::kRequest, message) == DecodeError::kNone);
  std::array<std::byte, kMaxStuffedSize> line{};
  const std::size_t size = stuff(examples[0], line);
  CHECK(std::vector<std::byte>(line.begin(), line.begin() + static_cast<long>(size)) == examples[1]);
}

TEST_CASE("the document's section on CAN and the CAN codec agree") {
  std::vector<std::string> said;
  for (const std::string& line : lines_of("can_codec.h")) {
    if (line.rfind("//", 0) != 0 || line.rfind("// Bus load", 0) == 0) break;
    said.push_back(line.size() > 3 ? line.substr(3) : "");
  }
  std::string document;
  for (const std::string& line : section("CAN")) document += line + "\n";
  for (const std::string& line : said) {
    CAPTURE(line);
    CHECK(document.find(line) != std::string::npos);
  }
  CHECK(said.size() > 10);
}

#endif
