// Registers by name, and the questions to a device: the firmware in this process.
#include "tools/device/ask.h"

#include <bit>
#include <catch2/catch.hpp>

#include "tools/hil/simulated_bench.h"

using namespace tactus;
using namespace tactus::device;
using Catch::Matchers::Contains;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

struct OneDevice {
  const hal::DeviceProfile& profile = *hal::find_profile("virtuose6d");
  hal::AnyLink link{std::make_unique<hil::SimulatedBench>(profile, kPeriod_ns)};

  hil::SimulatedBench& bench() { return *link.as<hil::SimulatedBench>(); }
  void run(unsigned periods) {
    std::array<std::byte, firmware::kMaxFrameSize> frame;
    while (periods-- > 0) (void)link.receive(frame);
  }
};

RegisterName named(const char* text) {
  const auto name = find_by_name(text);
  REQUIRE(name.ok());
  return name.value();
}

}  // namespace

TEST_CASE("a register is found by its name, one of a family by its index, and by its number") {
  CHECK(named("quantum").count == 6);
  CHECK(named("max_effort[2]").number(0) == 0x0112);
  CHECK(named("0x0112").number(0) == 0x0112);
  CHECK(name_of(*named("0x0112").row, 2) == "max_effort[2]");
  CHECK(name_of(*named("period").row, 0) == "period");
}

TEST_CASE("an unknown register is refused with the nearest name and the accepted ones") {
  CHECK_THAT(find_by_name("max_efort").message(), Contains("did you mean max_effort?"));
  CHECK_THAT(find_by_name("max_effort[6]").message(), Contains("max_effort[0] to max_effort[5]"));
  CHECK_THAT(find_by_name("max_effort[1").message(), Contains("accepted"));
  CHECK_THAT(find_by_name("0x0107").message(), Contains("no such register"));
  CHECK_THAT(find_by_name("0x10100").message(), Contains("no such register"));
}

TEST_CASE("a value is read in its register's type and range") {
  CHECK(parse_value(*named("max_effort").row, "3.5").value() == std::bit_cast<std::uint32_t>(3.5f));
  CHECK(parse_value(*named("offset").row, "-12").value() == std::bit_cast<std::uint32_t>(-12));
  CHECK(parse_value(*named("index_axes").row, "0x3f").value() == 63);
  for (const char* wrong : {"-1", "fast", "nan", "1e9", "3.5x", ""})
    CHECK_FALSE(parse_value(*named("max_effort").row, wrong).ok());
  CHECK_THAT(parse_value(*named("fade_frames").row, "255").message(), Contains("accepted: 1 to 254 periods"));
}

TEST_CASE("all registers of a device are read, each once") {
  OneDevice one;
  const auto all = read_all(one.link);
  REQUIRE(all.ok());
  std::size_t expected = 0;
  for (const firmware::Register& row : firmware::all_registers())
    if (row.access != firmware::Access::kCommand && row.number != firmware::number::kFaultLog) expected += row.count;
  CHECK(all.value().size() == expected);
}

TEST_CASE("a register that was written reads back, and one that may not be written says why") {
  OneDevice one;
  const auto wrote = write_register(one.link, named("max_effort[1]"), std::bit_cast<std::uint32_t>(2.25f));
  REQUIRE(wrote.ok());
  CHECK(wrote.value() == std::bit_cast<std::uint32_t>(2.25f));
  one.run(2);
  CHECK(read_registers(one.link, named("max_effort[1]")).value()[0].bits == wrote.value());
  CHECK_THAT(write_register(one.link, named("period"), 500).message(), Contains("period: refused: it is read only"));
  CHECK_THAT(write_register(one.link, named("brake_frames"), 2).message(),
             Contains("does not go with another register"));
}

TEST_CASE("the registers that a description needs: those of its device do, others are written") {
  OneDevice one;
  const auto needed = needed_registers(one.profile, 1000);
  const auto differing = [&] {
    unsigned count = 0;
    for (const NeededRegister& each : needed) {
      const auto told = read_registers(one.link, {each.value.row, each.value.index, 1});
      REQUIRE(told.ok());
      count += satisfies(each, told.value()[0].bits) ? 0 : 1;
    }
    return count;
  };
  CHECK(needed.size() == 3 * 6 + 2 + 3);
  CHECK(differing() == 0);
  for (const char* name : {"quantum[0]", "max_effort[2]", "max_force"}) {
    const auto now = read_registers(one.link, named(name)).value()[0].bits;
    const float twice = 2 * std::bit_cast<float>(now);
    REQUIRE(write_register(one.link, named(name), std::bit_cast<std::uint32_t>(twice)).ok());
    one.run(2);
  }
  CHECK(differing() == 3);
  CHECK(write_needed(one.link, needed).value() == 3);
  one.run(2);
  CHECK(differing() == 0);
  CHECK(write_needed(one.link, needed).value() == 0);
}

TEST_CASE("the fault log is told in words, and an empty one as empty") {
  OneDevice one;
  CHECK(read_fault_log(one.link).value().empty());
  one.bench().emergency_stop.store(true);
  one.run(3);
  const auto entries = read_fault_log(one.link);
  REQUIRE(entries.ok());
  REQUIRE(entries.value().size() == 1);
  CHECK_THAT(entries.value()[0], Contains("emergency stop") && Contains("fault 2"));
}

TEST_CASE("a device that does not answer ends the question with its register's name") {
  OneDevice one;
  one.bench().unplugged.store(true);
  one.run(1);
  const auto all = read_all(one.link);
  REQUIRE_FALSE(all.ok());
  CHECK_THAT(all.message(), Contains("protocol_version"));
}
