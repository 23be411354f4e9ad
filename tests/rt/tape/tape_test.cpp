#include "rt/tape/tape.h"

#include <sys/resource.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <random>
#include <vector>

#include "tests/support/skip.h"
#include "tests/support/temporary_file.h"

using namespace tactus;
using namespace tactus::loop;
using test::Bytes;
using test::TemporaryFile;

namespace {

struct Record {
  std::uint32_t kind;
  Bytes payload;
};

const char* const kText = "scene=wall\nrate_Hz=1000";

std::vector<Record> some_records(std::uint32_t seed, std::size_t count, std::size_t largest) {
  std::mt19937 random(seed);
  std::vector<Record> records(count);
  for (auto& record : records) {
    record.kind = static_cast<std::uint32_t>(random());
    record.payload.resize(random() % (largest + 1));
    for (auto& b : record.payload) b = static_cast<std::byte>(random());
  }
  return records;
}

void write_tape(const std::string& path, const std::vector<Record>& records) {
  auto writer = TapeWriter::create(path, kText);
  REQUIRE(writer.ok());
  for (const Record& record : records) REQUIRE(writer.value()->write(record.kind, record.payload).ok());
  REQUIRE(writer.value()->close().ok());
}

struct ReadBack {
  std::string open_error;
  std::vector<Record> records;
  std::vector<std::uint64_t> offsets;
  std::string damage;
};

ReadBack read_tape(const std::string& path) {
  ReadBack back;
  auto reader = TapeReader::open(path);
  if (!reader.ok()) {
    back.open_error = reader.message();
    return back;
  }
  TapeRecord record;
  TapeRead read;
  while ((read = reader.value()->next(record)) == TapeRead::kRecord) {
    REQUIRE(record.index == back.records.size());
    back.records.push_back({record.kind, Bytes(record.payload.begin(), record.payload.end())});
    back.offsets.push_back(record.offset);
  }
  back.damage = reader.value()->damage().message();
  REQUIRE((read == TapeRead::kDamaged) == !back.damage.empty());
  REQUIRE(reader.value()->next(record) == read);  // and it stays so
  return back;
}

bool same(const Record& a, const Record& b) { return a.kind == b.kind && a.payload == b.payload; }

bool begins_as(const std::vector<Record>& read, const std::vector<Record>& written) {
  return read.size() <= written.size() && std::equal(read.begin(), read.end(), written.begin(), same);
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool one_line(const std::string& text) { return !text.empty() && !contains(text, "\n"); }

}  // namespace

TEST_CASE("a tape returns its text, its ISA tag and its records, empty and large ones too", "[loop]") {
  const TemporaryFile file;
  auto records = some_records(1, 200, 5000);
  records.push_back({7, Bytes(3u << 20, std::byte{9})});  // larger than any buffer
  records.push_back({8, {}});
  write_tape(file.path(), records);
  auto reader = TapeReader::open(file.path());
  REQUIRE(reader.ok());
  CHECK(reader.value()->text() == kText);
  CHECK(reader.value()->isa_tag() == tape_isa_tag());
  const ReadBack back = read_tape(file.path());
  CHECK(back.damage.empty());
  CHECK(back.records.size() == records.size());
  CHECK(begins_as(back.records, records));
}

TEST_CASE("the writer counts what is in the file", "[loop]") {
  const TemporaryFile file;
  auto writer = TapeWriter::create(file.path(), kText);
  REQUIRE(writer.ok());
  const Bytes payload(10);
  REQUIRE(writer.value()->write(1, payload).ok());
  REQUIRE(writer.value()->close().ok());
  CHECK(writer.value()->records() == 1);
  // Header 40 + text + 4; record 12 + payload.
  CHECK(writer.value()->bytes() == 40 + std::string(kText).size() + 4 + 12 + 10);
  CHECK(file.read().size() == writer.value()->bytes());
  CHECK(!writer.value()->write(1, payload).ok());  // closed
}

TEST_CASE("a tape cut off at any byte gives all records before the cut, and says where it is", "[loop]") {
  const TemporaryFile file;
  const auto records = some_records(2, 6, 30);
  write_tape(file.path(), records);
  const Bytes whole = file.read();
  const std::size_t header = 40 + std::string(kText).size() + 4;
  std::vector<std::size_t> ends{header};
  for (const Record& record : records) ends.push_back(ends.back() + 12 + record.payload.size());
  REQUIRE(ends.back() == whole.size());
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    file.write(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    const ReadBack back = read_tape(file.path());
    INFO("cut to " << size << " bytes: " << back.open_error << back.damage);
    if (size < header) {
      REQUIRE(one_line(back.open_error));
      if (size > 0) REQUIRE(contains(back.open_error, "byte " + std::to_string(size) + ","));
      continue;
    }
    REQUIRE(back.open_error.empty());
    const auto complete = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), size) - ends.begin() - 1);
    REQUIRE(back.records.size() == complete);
    REQUIRE(begins_as(back.records, records));
    REQUIRE(back.damage.empty() == (ends[complete] == size));
    if (!back.damage.empty()) {
      REQUIRE(one_line(back.damage));
      REQUIRE(contains(back.damage, "cut off at byte " + std::to_string(size) + ","));
      REQUIRE(contains(back.damage, "record " + std::to_string(complete)));
      REQUIRE(contains(back.damage, "up to byte " + std::to_string(ends[complete])));
    }
  }
}

TEST_CASE("any flipped bit is detected, and the records before it are read", "[loop]") {
  const TemporaryFile file;
  const auto records = some_records(3, 4, 20);
  write_tape(file.path(), records);
  const Bytes whole = file.read();
  const ReadBack good = read_tape(file.path());
  REQUIRE(good.records.size() == records.size());
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    Bytes damaged = whole;
    damaged[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    file.write(damaged);
    const ReadBack back = read_tape(file.path());
    INFO("bit " << bit << ": " << back.open_error << back.damage);
    if (bit / 8 < good.offsets[0]) {
      REQUIRE(one_line(back.open_error));
      continue;
    }
    REQUIRE(back.open_error.empty());
    const auto hit = static_cast<std::size_t>(std::upper_bound(good.offsets.begin(), good.offsets.end(), bit / 8) -
                                              good.offsets.begin() - 1);
    REQUIRE(one_line(back.damage));
    REQUIRE(back.records.size() == hit);
    REQUIRE(begins_as(back.records, records));
    REQUIRE(contains(back.damage, "record " + std::to_string(hit)));
  }
}

TEST_CASE("each kind of damage has its own line", "[loop]") {
  const TemporaryFile file;
  write_tape(file.path(), some_records(4, 2, 20));
  const Bytes whole = file.read();
  const std::size_t first = 40 + std::string(kText).size() + 4;
  const auto changed = [&](std::size_t at, std::initializer_list<unsigned> bytes) {
    Bytes other = whole;
    for (const unsigned b : bytes) other[at++] = static_cast<std::byte>(b);
    file.write(other);
    return read_tape(file.path());
  };
  CHECK(contains(changed(0, {'P', 'K'}).open_error, "is not a tape"));
  CHECK(contains(
      changed(8, {kTapeVersion + 1, 0, 0, 0}).open_error,
      "version " + std::to_string(kTapeVersion + 1) + "; this program reads version " + std::to_string(kTapeVersion)));
  CHECK(contains(changed(12, {0xff, 0xff, 0xff, 0x7f}).open_error, "damaged header"));
  CHECK(contains(changed(41, {'x'}).open_error, "checksum"));
  CHECK(contains(changed(first + 4, {0xff, 0xff, 0xff, 0xff}).damage, "claims 4294967295 bytes"));
  CHECK(contains(changed(first + 8, {0, 0, 0, 0}).damage, "record 0 at byte " + std::to_string(first)));
  file.write({});
  CHECK(contains(read_tape(file.path()).open_error, "is not a tape"));
  CHECK(contains(read_tape("/nonexistent/x.tape").open_error, "cannot be read"));
  CHECK(contains(read_tape("/tmp").open_error, "cannot be read"));
}

TEST_CASE("after a damaged record the reader continues at the next one, and reports how many bytes are lost",
          "[loop]") {
  const TemporaryFile file;
  auto records = some_records(7, 6, 300);
  for (std::size_t i = 0; i < records.size(); ++i) records[i].kind = 1 + static_cast<std::uint32_t>(i % 3);
  write_tape(file.path(), records);
  const Bytes whole = file.read();
  std::vector<std::uint64_t> offsets = read_tape(file.path()).offsets;
  offsets.push_back(whole.size());
  constexpr std::uint32_t kKinds[] = {1, 2, 3};
  for (std::size_t hit = 0; hit < records.size(); ++hit) {
    for (std::uint64_t at = offsets[hit]; at < offsets[hit + 1]; ++at) {  // its kind, size, checksum and payload
      Bytes damaged = whole;
      damaged[at] ^= std::byte{0x55};
      file.write(damaged);
      auto reader = TapeReader::open(file.path());
      REQUIRE(reader.ok());
      TapeRecord record;
      for (std::size_t i = 0; i < hit; ++i) REQUIRE(reader.value()->next(record) == TapeRead::kRecord);
      REQUIRE(reader.value()->next(record) == TapeRead::kDamaged);
      REQUIRE(reader.value()->skip_damage(kKinds) == offsets[hit + 1] - offsets[hit]);
      for (std::size_t i = hit + 1; i < records.size(); ++i) {
        REQUIRE(reader.value()->next(record) == TapeRead::kRecord);
        REQUIRE(same({record.kind, Bytes(record.payload.begin(), record.payload.end())}, records[i]));
      }
      REQUIRE(reader.value()->next(record) == TapeRead::kEnd);
    }
  }
}

TEST_CASE("a search behind damage ends, whatever the bytes", "[loop]") {
  const TemporaryFile file;
  write_tape(file.path(), {{1, {}}});
  Bytes bytes = file.read();
  const std::size_t header = bytes.size() - 12;
  // Each place of it claims to be a record of a megabyte.
  for (int i = 0; i < 300'000; ++i)
    for (const unsigned b : {0u, 0u, 16u, 0u}) bytes.push_back(static_cast<std::byte>(b));
  bytes[header] ^= std::byte{0x10};
  file.write(bytes);
  auto reader = TapeReader::open(file.path());
  REQUIRE(reader.ok());
  TapeRecord record;
  REQUIRE(reader.value()->next(record) == TapeRead::kDamaged);
  constexpr std::uint32_t kKinds[] = {1u << 20};
  CHECK(reader.value()->skip_damage(kKinds) == bytes.size() - header);
  CHECK(reader.value()->next(record) == TapeRead::kEnd);
}

TEST_CASE("the reader takes any bytes: noise, and tapes with noise in them", "[loop]") {
  const TemporaryFile file;
  std::mt19937 random(5);
  const auto records = some_records(6, 5, 40);
  write_tape(file.path(), records);
  const Bytes whole = file.read();
  for (int round = 0; round < 500; ++round) {
    Bytes bytes = whole;
    const std::size_t from = round % 2 == 0 ? 0 : 44 + std::string(kText).size();  // with a good header, or without
    for (std::size_t i = random() % 8; i > 0; --i)
      bytes[from + random() % (bytes.size() - from)] = static_cast<std::byte>(random());
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    file.write(bytes);
    const ReadBack back = read_tape(file.path());
    if (back.open_error.empty()) REQUIRE(begins_as(back.records, records));
  }
}

TEST_CASE("a size that the file does not have costs no memory of that size", "[loop]") {
  const TemporaryFile file;
  write_tape(file.path(), {{1, Bytes(4)}});
  Bytes bytes = file.read();
  const std::uint32_t claim = kMaxTapeRecord;
  std::memcpy(bytes.data() + 44 + std::string(kText).size() + 4, &claim, sizeof claim);
  file.write(bytes);
  const ReadBack back = read_tape(file.path());
  CHECK(back.records.empty());
  CHECK(contains(back.damage, "cut off"));
}

TEST_CASE("a failed write is reported with the name of the tape", "[loop]") {
  const auto nowhere = TapeWriter::create("/nonexistent/x.tape", kText);
  REQUIRE(!nowhere.ok());
  CHECK(contains(nowhere.message(), "/nonexistent/x.tape"));
  CHECK(one_line(nowhere.message()));

  const TemporaryFile file;
  CHECK(!TapeWriter::create(file.path(), std::string(kMaxTapeText + 1, 'x')).ok());
  auto writer = TapeWriter::create(file.path(), kText);
  REQUIRE(writer.ok());
  CHECK(!writer.value()->write(1, Bytes(std::size_t{kMaxTapeRecord} + 1)).ok());
  REQUIRE(writer.value()->write(2, Bytes(3)).ok());  // one that is refused does no harm
  REQUIRE(writer.value()->close().ok());
  CHECK(read_tape(file.path()).records.size() == 1);
}

TEST_CASE("a file that is no tape is not written over, a tape and an empty file are", "[loop]") {
  const TemporaryFile file;
  const std::string scene = "[proxy]\nshape = \"sphere\"\n";
  std::ofstream(file.path()) << scene;
  const auto refused = TapeWriter::create(file.path(), kText);
  REQUIRE(!refused.ok());
  CHECK(contains(refused.message(), "is there and is no tape; accepted: another name"));
  std::ifstream left(file.path());
  CHECK(std::string(std::istreambuf_iterator<char>(left), {}) == scene);
  std::ofstream(file.path(), std::ios::trunc);
  for (int i = 0; i < 2; ++i) {
    auto writer = TapeWriter::create(file.path(), kText);
    REQUIRE(writer.ok());
    REQUIRE(writer.value()->close().ok());
  }
}

TEST_CASE("a full disk is reported when the tape is created, and stays reported", "[loop]") {
  TACTUS_NEEDS(access("/dev/full", W_OK) == 0, "there is no /dev/full");
  const auto full = TapeWriter::create("/dev/full", kText);
  REQUIRE(!full.ok());
  CHECK(contains(full.message(), "(No space left on device): it has no record"));
}

namespace {

// Until destroyed no file of this process grows beyond so many bytes.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    before_ = std::signal(SIGXFSZ, SIG_IGN);
    REQUIRE(getrlimit(RLIMIT_FSIZE, &limit_) == 0);
    const rlimit lower{.rlim_cur = bytes, .rlim_max = limit_.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &lower) == 0);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &limit_);
    std::signal(SIGXFSZ, before_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit limit_{};
  void (*before_)(int){nullptr};
};

}  // namespace

TEST_CASE("a tape that cannot grow reports how many records it has, and has them", "[loop]") {
  // Ends in the second buffer, within a record; at a record's last byte; in the first buffer.
  REQUIRE(std::strlen(kText) == 23);
  constexpr std::size_t kPayload = 1000, kRecord = kPayload + 12, kHeader = 40 + 23 + 4;
  for (const std::size_t limit : {std::size_t{1'500'000}, kHeader + 1400 * kRecord, kHeader + 3 * kRecord + 1}) {
    TemporaryFile file;
    std::string said;
    {
      auto made = TapeWriter::create(file.path(), kText);
      REQUIRE(made.ok());
      TapeWriter& writer = *made.value();
      const FileSizeLimit until(limit);
      for (int i = 0; i < 3000 && writer.write(1, Bytes(kPayload)).ok(); ++i) {}
      said = writer.close().message();
    }
    const std::size_t whole = (limit - kHeader) / kRecord;
    INFO(said);
    CHECK(contains(said, ": it has the first " + std::to_string(whole) + " records"));
    CHECK(read_tape(file.path()).records.size() == whole);
  }
}
