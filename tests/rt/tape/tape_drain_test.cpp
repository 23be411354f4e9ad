#include "rt/tape/tape_drain.h"

#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

#include "tests/support/temporary_file.h"

using namespace tactus;
using namespace tactus::loop;
using test::Bytes;
using test::TemporaryFile;

namespace {

constexpr std::uint32_t kKeyframe = 1, kTick = 2;

struct Record {
  std::uint32_t kind;
  Bytes payload;
  friend bool operator==(const Record&, const Record&) = default;
};

std::vector<Record> records_of(const std::string& path) {
  std::vector<Record> records;
  auto reader = TapeReader::open(path);
  REQUIRE(reader.ok());
  TapeRecord record;
  while (reader.value()->next(record) == TapeRead::kRecord) {
    records.push_back({record.kind, Bytes(record.payload.begin(), record.payload.end())});
  }
  REQUIRE(reader.value()->damage().ok());
  return records;
}

std::vector<Record> records_of(const TapeHistory& history) {
  std::vector<Record> records;
  history.for_each([&](std::uint32_t kind, std::span<const std::byte> payload) {
    records.push_back({kind, Bytes(payload.begin(), payload.end())});
  });
  return records;
}

// A keyframe, then ticks, then a keyframe ...
std::vector<Record> some_records(std::uint32_t seed, std::size_t count, std::size_t interval) {
  std::mt19937 random(seed);
  std::vector<Record> records(count);
  for (std::size_t i = 0; i < count; ++i) {
    records[i].kind = i % interval == 0 ? kKeyframe : kTick;
    records[i].payload.resize(i % interval == 0 ? 100 : random() % 40);
    for (auto& b : records[i].payload) b = static_cast<std::byte>(random());
  }
  return records;
}

std::unique_ptr<TapeWriter> tape_at(const std::string& path) {
  auto tape = TapeWriter::create(path, "test");
  REQUIRE(tape.ok());
  return std::move(tape).value();
}

DrainSettings settings_of(std::size_t history_bytes) {
  DrainSettings settings;
  settings.history_bytes = history_bytes;
  settings.keyframe_kind = kKeyframe;
  settings.interval = std::chrono::milliseconds(1);
  return settings;
}

}  // namespace

TEST_CASE("the history is the newest records, complete from a keyframe on, within its bytes", "[loop]") {
  for (const std::size_t capacity : {500u, 1000u, 3001u}) {
    TapeHistory history(capacity, kKeyframe);
    const auto all = some_records(1, 500, 10);
    for (std::size_t i = 0; i < all.size(); ++i) {
      history.push(all[i].kind, all[i].payload);
      REQUIRE(history.bytes() <= capacity);
      const auto kept = records_of(history);
      if (kept.empty()) continue;
      REQUIRE(kept.size() <= i + 1);
      REQUIRE(kept.front().kind == kKeyframe);
      REQUIRE(std::equal(kept.begin(), kept.end(), all.begin() + static_cast<std::ptrdiff_t>(i + 1 - kept.size())));
    }
  }
}

TEST_CASE("a history of three keyframe intervals never holds less than two of them", "[loop]") {
  constexpr std::size_t kInterval = 10, kPayload = 20;
  TapeHistory history(3 * kInterval * (8 + kPayload), kKeyframe);
  for (std::size_t i = 0; i < 1000; ++i) {
    history.push(i % kInterval == 0 ? kKeyframe : kTick, Bytes(kPayload));
    REQUIRE(records_of(history).size() >= std::min(i + 1, 2 * kInterval));
  }
}

TEST_CASE("what has no keyframe before it, or is larger than the history, is not kept but counted", "[loop]") {
  TapeHistory history(200, kKeyframe);
  history.push(kTick, Bytes(10));
  CHECK(history.empty());
  CHECK(history.not_kept() == 1);
  history.push(kKeyframe, Bytes(10));
  history.push(kTick, Bytes(300));
  CHECK(history.empty());
  CHECK(history.not_kept() == 2);
  history.push(kTick, Bytes(10));
  CHECK(history.not_kept() == 3);
  TapeHistory none(0, kKeyframe);
  none.push(kKeyframe, {});
  CHECK(none.empty());
}

TEST_CASE("the drain writes to the tape what was pushed, in order", "[loop]") {
  const TemporaryFile file;
  Ring ring(1 << 14);
  TapeDrain drain(ring, settings_of(1 << 12), tape_at(file.path()));
  const auto all = some_records(2, 1000, 20);
  for (const Record& record : all) {
    while (!ring.try_push(record.kind, record.payload)) drain.drain();
  }
  REQUIRE(drain.stop().ok());
  // Refused records were pushed again: the tape has a gap mark for each, and nothing else more.
  auto on_tape = records_of(file.path());
  std::erase_if(on_tape, [](const Record& record) { return record.kind == kTapeGap; });
  CHECK(on_tape == all);
  CHECK(drain.counts().records == all.size());
}

TEST_CASE("every lost record is marked on the tape, at its place, and at the end too", "[loop]") {
  const TemporaryFile file;
  Ring ring(64);
  TapeDrain drain(ring, settings_of(1000), tape_at(file.path()));
  const Bytes payload(48);
  REQUIRE(ring.try_push(kKeyframe, payload));
  for (int i = 0; i < 3; ++i) REQUIRE(!ring.try_push(kTick, payload));
  drain.drain();
  REQUIRE(ring.try_push(kKeyframe, payload));
  for (int i = 0; i < 2; ++i) REQUIRE(!ring.try_push(kTick, payload));
  REQUIRE(drain.stop().ok());
  const auto on_tape = records_of(file.path());
  REQUIRE(on_tape.size() == 4);
  const auto lost = [&](std::size_t i) {
    std::uint64_t number = 0;
    REQUIRE(on_tape[i].kind == kTapeGap);
    REQUIRE(on_tape[i].payload.size() == sizeof number);
    std::memcpy(&number, on_tape[i].payload.data(), sizeof number);
    return number;
  };
  CHECK(on_tape[0].kind == kKeyframe);
  CHECK(lost(1) == 3);
  CHECK(on_tape[2].kind == kKeyframe);
  CHECK(lost(3) == 2);
  CHECK(drain.counts().lost == 5);
}

TEST_CASE("a dump is a tape of the history, what the ring still holds included, as often as wanted", "[loop]") {
  const TemporaryFile file;
  Ring ring(1 << 12);
  TapeDrain drain(ring, settings_of(1 << 16));
  CHECK(!drain.dump(file.path(), "fault").ok());  // nothing yet
  const auto all = some_records(3, 30, 10);
  for (std::size_t i = 0; i < all.size(); ++i) REQUIRE(ring.try_push(all[i].kind, all[i].payload));
  for (int round = 0; round < 2; ++round) {
    REQUIRE(drain.dump(file.path(), "fault").ok());
    CHECK(records_of(file.path()) == all);
  }
  auto reader = TapeReader::open(file.path());
  REQUIRE(reader.ok());
  CHECK(reader.value()->text() == "fault");
  CHECK(!drain.dump("/nonexistent/x.tape", "fault").ok());
}

TEST_CASE("an error of the tape is the status at the end, and the history goes on", "[loop]") {
  const TemporaryFile file;
  auto tape = tape_at(file.path());
  REQUIRE(tape->close().ok());  // stands for a disk that takes no more
  Ring ring(1 << 12);
  TapeDrain drain(ring, settings_of(1 << 12), std::move(tape));
  REQUIRE(ring.try_push(kKeyframe, Bytes(8)));
  drain.drain();
  const TemporaryFile dump;
  REQUIRE(drain.dump(dump.path(), "").ok());
  CHECK(records_of(dump.path()).size() == 1);
  CHECK(!drain.stop().ok());
}

TEST_CASE("a disk that takes no more ends the tape alone, and the ticks that are not on it are counted", "[loop]") {
  const TemporaryFile file;
  const auto all = some_records(5, 6000, 50);
  const auto is_tick = [](const Record& record) { return record.kind == kTick; };
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);  // as the program does: the write fails instead
  const rlimit small{50'000, before.rlim_max};
  Ring ring(1 << 14);
  DrainSettings settings = settings_of(1 << 12);
  settings.tick_kind = kTick;
  TapeDrain drain(ring, settings, tape_at(file.path()));
  setrlimit(RLIMIT_FSIZE, &small);
  for (const Record& record : all) {
    REQUIRE(ring.try_push(record.kind, record.payload));
    drain.drain();
  }
  const Status status = drain.stop();
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  REQUIRE(!status.ok());
  CHECK_THAT(status.message(), Catch::Matchers::Contains(file.path()) && Catch::Matchers::Contains("File too large"));
  auto reader = TapeReader::open(file.path());
  REQUIRE(reader.ok());
  TapeRecord record;
  std::uint64_t written = 0;
  while (reader.value()->next(record) == TapeRead::kRecord) written += record.kind == kTick ? 1u : 0u;
  CHECK(written > 0);
  const auto ticks = static_cast<std::uint64_t>(std::count_if(all.begin(), all.end(), is_tick));
  CHECK(drain.counts().ticks_not_written == ticks - written);
  CHECK(drain.counts().records == all.size());
}

TEST_CASE("the drain's own thread takes everything while the producer runs, and dumps meanwhile are whole",
          "[loop][threads]") {
  const TemporaryFile file, dump;
  Ring ring(1 << 16);
  TapeDrain drain(ring, settings_of(1 << 14), tape_at(file.path()));
  REQUIRE(drain.start().ok());
  CHECK(!drain.start().ok());
  const auto all = some_records(4, 20'000, 50);
  std::uint64_t dropped = 0;
  std::thread producer([&] {
    for (const Record& record : all) {
      while (!ring.try_push(record.kind, record.payload)) {
        ++dropped;
        std::this_thread::yield();
      }
    }
  });
  for (int i = 0; i < 5; ++i) {
    if (drain.dump(dump.path(), "").ok()) CHECK(records_of(dump.path()).front().kind == kKeyframe);
  }
  producer.join();
  REQUIRE(drain.stop().ok());
  auto on_tape = records_of(file.path());
  std::erase_if(on_tape, [](const Record& record) { return record.kind == kTapeGap; });
  CHECK(on_tape == all);
  CHECK(drain.counts().lost == dropped);
  CHECK(drain.stop().ok());  // again does no harm
}
