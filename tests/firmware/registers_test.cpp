#include "firmware/registers.h"

#include <limits>
#include <random>
#include <set>
#include <string>

#include "firmware/can_codec.h"
#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

namespace {

// A value in the row's range, its ends included.
std::uint32_t random_value(const Register& row, std::mt19937_64& random) {
  if (random() % 4 == 0) return row.low;
  if (random() % 4 == 0) return row.high;
  if (row.type == RegisterType::kF32) {
    const auto low = static_cast<double>(std::bit_cast<float>(row.low));
    const auto high = static_cast<double>(std::bit_cast<float>(row.high));
    return std::bit_cast<std::uint32_t>(
        static_cast<float>(low + (high - low) * static_cast<double>(random() % 1000) / 1000));
  }
  const auto low = row.type == RegisterType::kI32 ? std::int64_t{static_cast<std::int32_t>(row.low)} : row.low;
  const auto high = row.type == RegisterType::kI32 ? std::int64_t{static_cast<std::int32_t>(row.high)} : row.high;
  return static_cast<std::uint32_t>(low +
                                    static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1)));
}

}  // namespace

TEST_CASE("every number belongs to one register or to none, and names are unique") {
  std::set<unsigned> numbers;
  std::set<std::string> names;
  for (const Register& row : all_registers()) {
    CHECK(names.insert(row.name).second);
    for (unsigned i = 0; i < row.count; ++i) {
      CHECK(numbers.insert(row.number + i).second);
      REQUIRE(find_register(static_cast<std::uint16_t>(row.number + i)) == &row);
    }
  }
  for (unsigned n = 0; n <= 0xffff; ++n)
    if (numbers.count(n) == 0) REQUIRE(find_register(static_cast<std::uint16_t>(n)) == nullptr);
  CHECK(all_registers().size() <= kMaxRegisterCount);
}

TEST_CASE("what is written into a field is read from it, and from no other") {
  std::mt19937_64 random(1);
  DeviceConfig config;
  std::vector<std::tuple<const Register*, unsigned, std::uint32_t>> written;
  for (const Register& row : all_registers())
    for (unsigned i = 0; row.section != Section::kNone && i < row.count; ++i)
      written.emplace_back(&row, i, row.width == 1 ? random() % 256 : random_value(row, random));
  for (const auto& [row, i, value] : written) write_field(*row, i, value, config);
  for (const auto& [row, i, value] : written) REQUIRE(read_field(*row, i, config.view()) == value);
}

TEST_CASE("every field of the configuration has its register") {
  std::size_t bytes = 0;
  for (const Register& row : all_registers())
    if (row.section != Section::kNone) bytes += std::size_t{row.count} * row.width;
  // Config: 4 arrays less one, two norms, two thresholds; the period is shown, not written.
  const std::size_t control = 3 * sizeof(AxisValues) + 2 * sizeof(float) + 2;
  CHECK(bytes == control + sizeof(EncoderConfig) + sizeof(ThermalConfig) + sizeof(GravityConfig) + sizeof(BusConfig));
}

TEST_CASE("ranges hold their ends and nothing beyond, and no NaN") {
  for (const Register& row : all_registers()) {
    if (row.access != Access::kReadWrite) continue;
    CAPTURE(row.name);
    CHECK(is_in_range(row, row.low));
    CHECK(is_in_range(row, row.high));
    if (row.type == RegisterType::kF32) {
      const float low = std::bit_cast<float>(row.low), high = std::bit_cast<float>(row.high);
      const float infinity = std::numeric_limits<float>::infinity();
      CHECK_FALSE(is_in_range(row, std::bit_cast<std::uint32_t>(std::nextafter(low, -infinity))));
      CHECK_FALSE(is_in_range(row, std::bit_cast<std::uint32_t>(std::nextafter(high, infinity))));
      CHECK_FALSE(is_in_range(row, std::bit_cast<std::uint32_t>(std::numeric_limits<float>::quiet_NaN())));
      CHECK_FALSE(is_in_range(row, std::bit_cast<std::uint32_t>(infinity)));
    } else {
      if (row.low != 0) CHECK_FALSE(is_in_range(row, row.low - 1));
      CHECK_FALSE(is_in_range(row, row.high + 1));
    }
  }
}

TEST_CASE("the node id's range is the bus's") {
  const Register& row = *find_register(number::kCanNodeId);
  CHECK(row.low == 1);
  CHECK(row.high == kMaxCanNode);
}

TEST_CASE("a device answers random requests with a status, and its configuration stays valid") {
  std::mt19937_64 random(2);
  DeviceBench b;
  b.nothing();
  for (int i = 0; i < 50000; ++i) {
    ServiceMessage request;
    request.operation = static_cast<Operation>(random() % 5);
    request.tag = static_cast<std::uint8_t>(random());
    const Register& row = all_registers()[random() % all_registers().size()];
    request.address = static_cast<std::uint16_t>(row.number + random() % (row.count + 1u));
    request.value = random() % 2 == 0 ? static_cast<std::uint32_t>(random()) : random_value(row, random);
    const ServiceMessage reply = b.device.serve(request);
    REQUIRE(reply.tag == request.tag);
    REQUIRE(reply.address == request.address);
    REQUIRE(reply.operation == request.operation);
    REQUIRE(is_valid(b.device.config()));
    const bool refused = reply.status != ServiceStatus::kGood;
    if (!refused && request.operation == Operation::kWrite) REQUIRE(reply.value == request.value);
    if (i % 3 == 0) b.nothing();
    for (const float e : b.outputs.effort) REQUIRE(std::abs(e) <= 1e6f);
  }
}
