#include "firmware/boards/linux/linux_program.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>
#include <vector>

#include "firmware/boards/linux/linux_storage.h"
#include "firmware/boards/linux/mailbox.h"

using namespace tactus::firmware;

namespace {

struct Parsed {
  ParsedArguments result;
  ProgramOptions options;
  std::string serial;
};

Parsed parse(std::vector<const char*> arguments) {
  Parsed parsed;
  arguments.insert(arguments.begin(), "/usr/bin/board");
  const BoardOption own[] = {{"serial", "TEXT", "whose", &parsed.serial}};
  parsed.result =
      parse_arguments(static_cast<int>(arguments.size()), arguments.data(), "A board.", own, parsed.options);
  return parsed;
}

std::vector<std::byte> block_of(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> block(size);
  for (std::byte& byte : block) byte = static_cast<std::byte>(random());
  return block;
}

}  // namespace

TEST_CASE("Linux program: its options and the board's are taken", "[firmware]") {
  const Parsed parsed = parse({"--mechanics", "m.txt", "--period-us", "500", "--priority", "0", "--cpu", "3",
                               "--periods", "7", "--serial", "A 1", "--state", "s"});
  REQUIRE(parsed.result.run);
  CHECK(parsed.options.mechanics == "m.txt");
  CHECK(parsed.options.period_us == 500);
  CHECK(parsed.options.priority == 0);
  CHECK(parsed.options.cpu == 3);
  CHECK(parsed.options.periods == 7);
  CHECK(parsed.options.state == "s");
  CHECK(parsed.serial == "A 1");
}

TEST_CASE("Linux program: wrong arguments give one line with the accepted ones, help lists all", "[firmware]") {
  const auto text = [](std::vector<const char*> arguments) {
    const Parsed parsed = parse(std::move(arguments));
    CHECK_FALSE(parsed.result.run);
    CHECK(parsed.result.status == 2);
    CHECK(parsed.result.text.find('\n') == std::string::npos);
    return parsed.result.text;
  };
  CHECK(text({}).find("board: --mechanics FILE is missing") == 0);
  CHECK(text({"--mechanics", "m", "--period-us", "49"}).find("'49'; accepted: 50 to 1000000") != std::string::npos);
  CHECK(text({"--mechanics", "m", "--period-us", "1e3"}).find("accepted") != std::string::npos);
  CHECK(text({"--mechanics", "m", "--priority", "100"}).find("0 to 99") != std::string::npos);
  CHECK(text({"--mechanics"}).find("needs a value") != std::string::npos);
  CHECK(text({"--speed", "1"}).find("unknown option '--speed'") != std::string::npos);
  CHECK(text({"mechanics"}).find("is no option") != std::string::npos);
  const Parsed help = parse({"--help"});
  CHECK(help.result.status == 0);
  for (const char* option : {"--mechanics", "--serial", "--period-us", "--priority", "--cpu", "--periods", "--state"})
    CHECK(help.result.text.find(option) != std::string::npos);
}

TEST_CASE("Linux program: the control loop runs the requested number of periods, and stops on request", "[firmware]") {
  std::atomic<bool> stop{false};
  int periods = 0;
  CHECK(run_paced(50, 20, stop, [&]() noexcept { ++periods; }).periods == 20);
  CHECK(periods == 20);
  periods = 0;
  run_paced(50, 0, stop, [&]() noexcept { stop = ++periods == 5; });
  CHECK(periods == 5);
}

TEST_CASE("Linux program: deadlines that passed are counted as skipped, none is made up for", "[firmware]") {
  constexpr std::int64_t kPeriod_ns = 200'000;
  const std::int64_t begin = now_ns();
  Pace pace(200);
  for (int i = 1; i <= 12; ++i) {
    const std::uint64_t skipped_before = pace.counters().skipped;
    pace.wait();
    const PaceCounters& counters = pace.counters();
    CHECK(now_ns() - begin >= static_cast<std::int64_t>(counters.periods + counters.skipped) * kPeriod_ns);
    if (i % 4 == 1 && i > 1) CHECK(counters.skipped >= skipped_before + 3);
    if (i % 4 == 0) std::this_thread::sleep_for(std::chrono::nanoseconds(3 * kPeriod_ns));  // three deadlines pass
  }
  CHECK(pace.counters().periods == 12);
}

TEST_CASE("mailbox: the newest frame is returned once, and the frame that it replaced is reported", "[firmware]") {
  Mailbox mailbox;
  std::array<std::byte, kMaxFrameSize> out{};
  CHECK(mailbox.take(out) == 0);
  for (unsigned n = 1; n < 50; ++n) {
    const auto older = block_of(n, n), newer = block_of(n + 3, 100 + n);
    CHECK_FALSE(mailbox.write(older));
    CHECK(mailbox.write(newer));
    REQUIRE(mailbox.take(out) == newer.size());
    CHECK(std::equal(newer.begin(), newer.end(), out.begin()));
    CHECK(mailbox.take(out) == 0);
  }
  mailbox.write(block_of(200, 1));  // longer than the wire has
  CHECK(mailbox.take(out) == kMaxFrameSize);
}

TEST_CASE("command queue: frames come once and in order, of more than it holds the newest", "[firmware]") {
  CommandQueue queue;
  std::array<std::byte, kMaxFrameSize> out{};
  CHECK(queue.take(out) == 0);
  constexpr auto kCapacity = static_cast<unsigned>(CommandQueue::kCapacity);
  unsigned written = 0, next = 0;
  for (const unsigned burst : {1u, 3u, 16u, 17u, 2u, 40u, 1u, 5u}) {
    for (unsigned i = 0; i < burst; ++i) CHECK(queue.write(block_of(10, written++)) == (i > 0));
    if (burst > kCapacity) next += burst - kCapacity;
    while (next < written) {
      REQUIRE(queue.take(out) == 10);
      const auto expected = block_of(10, next++);
      CHECK(std::equal(expected.begin(), expected.end(), out.begin()));
    }
    CHECK(queue.take(out) == 0);
  }
  // One that comes while others are being taken waits behind them.
  queue.write(block_of(10, 1));
  queue.write(block_of(11, 2));
  CHECK(queue.take(out) == 10);
  queue.write(block_of(12, 3));
  CHECK(queue.take(out) == 11);
  CHECK(queue.take(out) == 12);
  CHECK(queue.take(out) == 0);
}

TEST_CASE("storage: what was stored last is loaded by the next start, and nothing where there is no file",
          "[firmware][threads]") {
  namespace fs = std::filesystem;
  const std::string path = (fs::temp_directory_path() / ("tactus_storage_" + std::to_string(getpid()))).string();
  fs::remove(path);
  std::array<std::byte, kConfigBlockSize> buffer{};
  const auto first = block_of(kConfigBlockSize, 1), second = block_of(100, 2);
  for (const auto& block : {first, second}) {
    FileStorage storage;
    REQUIRE(storage.open(path) == "");
    if (&block == &first) CHECK(storage.load(buffer) == 0);
    CHECK(storage.store(block));
    storage.close();  // what was taken over is written
    REQUIRE(storage.open(path) == "");
    REQUIRE(storage.load(buffer) == block.size());
    CHECK(std::equal(block.begin(), block.end(), buffer.begin()));
    CHECK(storage.failures() == 0);
    CHECK_FALSE(fs::exists(path + ".new"));
  }
  fs::remove(path);
}

TEST_CASE("storage: without a file nothing is kept, and a folder that takes none is named", "[firmware]") {
  FileStorage storage;
  REQUIRE(storage.open("") == "");
  CHECK_FALSE(storage.store(block_of(10, 1)));
  CHECK(storage.open("/no-such-folder/state").find("/no-such-folder/") == 0);
}
