#include "hal/fault_injection.h"

#include <catch2/catch.hpp>
#include <string>

using namespace tactus;
using namespace tactus::hal;

namespace {

std::string message(std::string_view text) {
  const Result<FaultScript> result = parse_fault_script(text);
  if (!result.ok()) CHECK(result.message().find('\n') == std::string::npos);
  return result.ok() ? std::string() : result.message();
}

}  // namespace

TEST_CASE("a script is read as it is written") {
  const auto result = parse_fault_script(
      "lost@1000+20, teleport@3000:-0.3 ,unplugged@5000+2000,late/command@7+100:2,corrupted/state@9:3,nan@1,estop@0");
  REQUIRE(result.ok());
  const FaultScript& s = result.value();
  REQUIRE(s.count == 7);
  const auto is = [&](unsigned i, FaultKind k, FaultDirection d, std::uint64_t tick, std::uint64_t ticks,
                      double amount) {
    const InjectedFault& f = s.faults[i];
    return f.kind == k && f.direction == d && f.tick == tick && f.ticks == ticks && f.amount == amount;
  };
  CHECK(is(0, FaultKind::kLost, FaultDirection::kBoth, 1000, 20, 0));
  CHECK(is(1, FaultKind::kTeleport, FaultDirection::kState, 3000, 1, -0.3));
  CHECK(is(2, FaultKind::kUnplugged, FaultDirection::kBoth, 5000, 2000, 0));
  CHECK(is(3, FaultKind::kLate, FaultDirection::kCommand, 7, 100, 2));
  CHECK(is(4, FaultKind::kCorrupted, FaultDirection::kState, 9, 1, 3));
  CHECK(is(5, FaultKind::kNan, FaultDirection::kState, 1, 1, 0));
  CHECK(is(6, FaultKind::kEmergencyStop, FaultDirection::kBoth, 0, 1, 0));
  CHECK(parse_fault_script("").value().count == 0);
  CHECK(parse_fault_script("corrupted@1").value().faults[0].amount == 1.0);
  for (const char* kind :
       {"lost", "late", "duplicated", "corrupted", "nan", "wild", "teleport", "frozen", "unplugged", "estop"}) {
    const bool has_amount = std::string(kind) == "late" || std::string(kind) == "teleport";
    CHECK(parse_fault_script(std::string(kind) + "@5+2" + (has_amount ? ":1" : "")).ok());
  }
}

TEST_CASE("each mistake is explained in one line that names the fault and what is accepted") {
  using Catch::Contains;
  CHECK_THAT(message("lots@5"),
             Contains("\"lots@5\"") && Contains("unknown kind") && Contains("lost") && Contains("estop"));
  CHECK_THAT(message("lost"), Contains("tick is missing") && Contains("lost@1000"));
  CHECK_THAT(message("lost@"), Contains("whole number from 0"));
  CHECK_THAT(message("lost@-5"), Contains("whole number from 0"));
  CHECK_THAT(message("lost@5.5"), Contains("whole number from 0"));
  CHECK_THAT(message("lost@99999999999999999999999"), Contains("whole number from 0"));
  CHECK_THAT(message("lost@5+0"), Contains("whole number from 1"));
  CHECK_THAT(message("lost@5+"), Contains("whole number from 1"));
  CHECK_THAT(message("lost@5+3:2"), Contains("no amount"));
  CHECK_THAT(message("late@5"), Contains("needs an amount") && Contains("late@1000:2"));
  CHECK_THAT(message("late@5:64"), Contains("whole number from 1 to 63"));
  CHECK_THAT(message("late@5:1.5"), Contains("whole number from 1 to 63"));
  CHECK_THAT(message("teleport@5:nan"), Contains("number from -10 to 10 (metres)"));
  CHECK_THAT(message("teleport@5:11"), Contains("metres"));
  CHECK_THAT(message("teleport@5:"), Contains("metres"));
  CHECK_THAT(message("corrupted@5:6"), Contains("from 1 to 5"));
  CHECK_THAT(message("lost/up@5"), Contains("state or command"));
  CHECK_THAT(message("frozen/state@5"), Contains("no direction"));
  CHECK_THAT(message("lost@5,"), Contains("missing beside a comma"));
  CHECK_THAT(message(",lost@5"), Contains("missing beside a comma"));
  CHECK_THAT(message("lost@5,,lost@6"), Contains("missing beside a comma"));
  std::string many = "lost@0";
  for (unsigned i = 1; i < kMaxFaults; ++i) many += ",lost@" + std::to_string(i);
  CHECK(message(many).empty());
  CHECK_THAT(message(many + ",lost@1"), Contains("more than 64"));
}

TEST_CASE("a fault acts in its ticks, in its direction, and not beside them") {
  const auto parsed = parse_fault_script("lost/state@10+5,late/command@12+2:3,lost@20");
  REQUIRE(parsed.ok());
  const FaultScript& s = parsed.value();
  for (std::uint64_t t = 0; t < 40; ++t) {
    CHECK((s.active(FaultKind::kLost, FaultDirection::kState, t) != nullptr) == ((t >= 10 && t < 15) || t == 20));
    CHECK((s.active(FaultKind::kLost, FaultDirection::kCommand, t) != nullptr) == (t == 20));
    CHECK((s.active(FaultKind::kLate, FaultDirection::kCommand, t) != nullptr) == (t == 12 || t == 13));
    CHECK(s.active(FaultKind::kNan, FaultDirection::kState, t) == nullptr);
  }
}
