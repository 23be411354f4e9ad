// The tape: a file of records, each with its own checksum, after a header that identifies which program can replay it.
//
//   header  magic "TACTAPE\0" | version u32 | text length u32 | ISA tag char[24] | text | crc u32 of all before
//   record  kind u32 | size u32 | crc u32 of kind, size and payload | payload
//
// Little endian, no alignment. The writers define the meaning of records (the recorder's kinds) and of the text: what
// was run, with which settings. A tape that ends inside a record, as after a power failure, is readable up to there;
// one with a damaged record, before and after it. The reader accepts any bytes: it never crashes, and reports each kind
// of damage in one line.
// Thread: normal-priority threads only ([setup]): files block. Bound: kMaxTapeRecord, kMaxTapeText; larger ones are
// rejected.
#pragma once

#include <array>
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

inline constexpr std::array<char, 8> kTapeMagic{'T', 'A', 'C', 'T', 'A', 'P', 'E', '\0'};
inline constexpr std::uint32_t kTapeVersion = 21;           // 21: outside bodies' motion in the snapshot
inline constexpr std::uint32_t kMaxTapeRecord = 64u << 20;  // bytes of payload
inline constexpr std::uint32_t kMaxTapeText = 8u << 20;     // bytes: a scene with its meshes, and settings

// Kinds from here on are reserved for the tape itself.
inline constexpr std::uint32_t kTapeKinds = 0xffffff00u;
// Payload u64: number of records missing here because the ring was full. Replay continues at the next keyframe.
inline constexpr std::uint32_t kTapeGap = 0xffffff01u;

// Instruction set and SIMD width of this program: replay is bit-identical only with the same tag.
std::string_view tape_isa_tag() noexcept;

class TapeWriter {
 public:
  // Replaces a tape, or an empty file. Error: it cannot be written, another run writes it, or it is no tape.
  static Result<std::unique_ptr<TapeWriter>> create(const std::string& path, std::string_view text);
  ~TapeWriter();
  TapeWriter(const TapeWriter&) = delete;
  TapeWriter& operator=(const TapeWriter&) = delete;

  // Buffered. The first error is final: nothing is written after it, and every later call returns it. It says how many
  // records are whole in the file.
  Status write(std::uint32_t kind, std::span<const std::byte> payload);
  // Writes the buffer and waits for the disk.
  Status close();

  std::uint64_t bytes() const noexcept { return bytes_; }
  // Bytes already in the file; the rest is in the buffer or was lost with the first error.
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
  std::vector<std::uint64_t> ends_;  // of the records that end in the buffer: bytes from the file's start
  std::uint64_t bytes_{0}, written_{0}, records_{0};
  Status status_{Status::good()};
};

struct TapeRecord {
  std::uint32_t kind{0};
  std::uint64_t index{0};              // from 0
  std::uint64_t offset{0};             // bytes: of its first byte in the file
  std::span<const std::byte> payload;  // valid until the next next()
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

  // After kDamaged: damage() describes the damage and its position, all records before it are good, and reading
  // continues only after skip_damage().
  TapeRead next(TapeRecord& record);
  const Status& damage() const noexcept { return damage_; }
  // Continues at a record that next() has returned before, by its offset and index. False: the file cannot be rewound.
  bool go_to(std::uint64_t offset, std::uint64_t index);

  // After kDamaged: finds the next intact record of one of these kinds, at which next() continues, or the end of the
  // file. Returns the lost bytes, counted from the start of the damaged record. Bound: reads at most 16 times the
  // file's size, then skips to its end.
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
