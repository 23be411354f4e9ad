// The tape: a file of records, each with its own checksum, behind a header that says what may replay it.
//
//   header  magic "TACTAPE\0" | version u32 | text length u32 | ISA tag char[24] | text | crc u32 of all before
//   record  kind u32 | size u32 | crc u32 of kind, size and payload | payload
//
// All little endian, no alignment. What the records mean is their writers' matter (the recorder's kinds); the text is
// theirs too: what was run, with which settings. A tape that ends in the middle of a record, as after a power cut, is
// readable up to there; one with a damaged record, before and behind it. The reader takes any bytes: it never crashes,
// and names each kind of damage in one line.
// Thread: normal-priority threads only ([setup]): files block. Bound: kMaxTapeRecord, kMaxTapeText; more is refused.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rt/base/result.h"

namespace tactus::loop {

static_assert(std::endian::native == std::endian::little, "the tape's numbers are written as they are in memory");

inline constexpr std::uint32_t kTapeVersion = 12;           // 12: the sub-world's state in parts
inline constexpr std::uint32_t kMaxTapeRecord = 64u << 20;  // bytes of payload
inline constexpr std::uint32_t kMaxTapeText = 8u << 20;     // bytes: a scene with its meshes, and settings

// Kinds from here on belong to the tape itself.
inline constexpr std::uint32_t kTapeKinds = 0xffffff00u;
// Payload u64: how many records are missing here because the ring was full. Replay goes on at the next keyframe.
inline constexpr std::uint32_t kTapeGap = 0xffffff01u;

// Instruction set and SIMD width of this program: the same bits are promised only where it is the same.
std::string_view tape_isa_tag() noexcept;

class TapeWriter {
 public:
  // Replaces a file of that name.
  static Result<std::unique_ptr<TapeWriter>> create(const std::string& path, std::string_view text);
  ~TapeWriter();
  TapeWriter(const TapeWriter&) = delete;
  TapeWriter& operator=(const TapeWriter&) = delete;

  // Buffered. The first error stays: nothing is written after it, and every later call returns it.
  Status write(std::uint32_t kind, std::span<const std::byte> payload);
  // Writes out what is buffered and waits for the disk.
  Status close();

  std::uint64_t bytes() const noexcept { return bytes_; }
  // Of those, what is in the file by now: the rest waits in the buffer, or was lost with the first error.
  std::uint64_t bytes_written() const noexcept { return written_; }
  std::uint64_t records() const noexcept { return records_; }
  const std::string& path() const noexcept { return path_; }

 private:
  TapeWriter(int file, std::string path) : file_(file), path_(std::move(path)) { buffer_.reserve(kBuffer); }
  void put(std::span<const std::byte> bytes);
  void flush();
  void fail(const char* what, int error);

  static constexpr std::size_t kBuffer = 1u << 20;
  int file_;
  std::string path_;
  std::vector<std::byte> buffer_;
  std::uint64_t bytes_{0}, written_{0}, records_{0};
  Status status_{Status::good()};
};

struct TapeRecord {
  std::uint32_t kind{0};
  std::uint64_t index{0};              // from 0
  std::uint64_t offset{0};             // of its first byte in the file
  std::span<const std::byte> payload;  // valid until the next call of next()
};

enum class TapeRead : std::uint32_t { kRecord = 0, kEnd = 1, kDamaged = 2 };

class TapeReader {
 public:
  static Result<std::unique_ptr<TapeReader>> open(const std::string& path);
  ~TapeReader();
  TapeReader(const TapeReader&) = delete;
  TapeReader& operator=(const TapeReader&) = delete;

  const std::string& text() const noexcept { return text_; }
  const std::string& isa_tag() const noexcept { return isa_tag_; }  // of the program that wrote it

  // After kDamaged damage() says what and where, all records before are good, and there is nothing more to read but
  // behind skip_damage().
  TapeRead next(TapeRecord& record);
  const Status& damage() const noexcept { return damage_; }

  // After kDamaged: finds the next whole record of one of these kinds, where next() then goes on; at the end of the
  // file if there is none. Gives the bytes that are lost, from the damaged record's first on. Bound: reads at most 16
  // times the file, then gives the rest up.
  std::uint64_t skip_damage(std::span<const std::uint32_t> kinds);

 private:
  TapeReader(std::FILE* file, std::string path) : file_(file), path_(std::move(path)) {}
  Status read_header();
  std::size_t read_up_to(void* to, std::size_t size);
  Status cut_off_in_header() const;
  Status cut_off() const;
  bool is_whole_record(std::uint64_t at, std::uint64_t file_size, std::uint64_t& may_read);
  TapeRead damaged(Status why);

  std::FILE* file_;
  std::string path_;
  std::string text_, isa_tag_;
  std::uint64_t offset_{0}, records_{0};
  std::uint64_t record_begin_{0};
  std::vector<std::byte> payload_;
  Status damage_{Status::good()};
  bool ended_{false};
};

}  // namespace tactus::loop
