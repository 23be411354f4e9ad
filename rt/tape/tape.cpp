#include "rt/tape/tape.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "rt/base/crc32.h"

namespace tactus::loop {
namespace {

struct HeaderStart {
  std::array<char, 8> magic{kTapeMagic};
  std::uint32_t version{kTapeVersion};
  std::uint32_t text_size{0};
  std::array<char, 24> isa_tag{};
};
static_assert(sizeof(HeaderStart) == 40, "no padding: it goes to the file as it is");

struct RecordStart {
  std::uint32_t kind{0}, size{0}, crc{0};
};
static_assert(sizeof(RecordStart) == 12, "no padding: it goes to the file as it is");

template <class T>
std::span<const std::byte> bytes_of(const T& value) noexcept {
  return std::as_bytes(std::span<const T, 1>(&value, 1));
}

std::uint32_t crc_of(std::span<const std::byte> a, std::span<const std::byte> b) noexcept {
  Crc32 crc;
  crc.add_bytes(a);
  crc.add_bytes(b);
  return crc.value();
}

// The checksum covers kind and size, so a flipped bit in them is detected as well.
std::uint32_t crc_of_record(const RecordStart& start, std::span<const std::byte> payload) noexcept {
  return crc_of(bytes_of(start).first(8), payload);
}

// Bound of the search in a damaged tape with many false record starts: this many times the file's size.
constexpr std::uint64_t kSearchReads = 16;

std::string named(const std::string& path) { return "tape '" + path + "': "; }

}  // namespace

std::string_view tape_isa_tag() noexcept {
#if defined(__AVX512F__)
  return "x86-64-v4 le";
#elif defined(__AVX2__)
  return "x86-64-v3 le";
#elif defined(__x86_64__)
  return "x86-64 le";
#elif defined(__aarch64__)
  return "aarch64 le";
#else
#error "name this instruction set"
#endif
}

// --- writer

namespace {

// True if a regular file has content that does not begin with the tape's magic. It may be a user's file, such as a
// scene, and must not be overwritten; an empty file may.
bool is_other_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  std::array<char, kTapeMagic.size()> found{};
  const ssize_t size = ::read(file, found.data(), found.size());
  ::close(file);
  return size > 0 && !std::equal(found.begin(), found.begin() + size, kTapeMagic.begin());
}

// Locks a regular file until it is closed, and empties it. False: another writer has the lock. On a file system without
// locks no writer is refused.
bool take_for_writing(int file) {
  struct stat status {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return true;
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
  (void)!::ftruncate(file, 0);  // unchecked: the first write reports a file that is not writable
  return true;
}

}  // namespace

Result<std::unique_ptr<TapeWriter>> TapeWriter::create(const std::string& path, std::string_view text) {
  if (text.size() > kMaxTapeText) {
    return Status::error(named(path) + "a header text of " + std::to_string(text.size()) + " bytes; at most " +
                         std::to_string(kMaxTapeText) + " fit");
  }
  if (is_other_file(path)) return Status::error(named(path) + "is there and is no tape; accepted: another name");
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) return Status::error(named(path) + "cannot be written: " + strerrordesc_np(errno));
  std::unique_ptr<TapeWriter> writer(new TapeWriter(file, path));
  if (!take_for_writing(file))
    return Status::error(named(path) + "another run is writing this tape; accepted: another name");
  HeaderStart start;
  start.text_size = static_cast<std::uint32_t>(text.size());
  const std::string_view tag = tape_isa_tag();
  std::copy_n(tag.begin(), std::min(tag.size(), start.isa_tag.size()), start.isa_tag.begin());
  const auto text_bytes = std::as_bytes(std::span(text.data(), text.size()));
  writer->put(bytes_of(start));
  writer->put(text_bytes);
  writer->put(bytes_of(crc_of(bytes_of(start), text_bytes)));
  writer->flush();  // reports a full disk now, not after the run
  if (!writer->status_.ok()) return writer->status_;
  return writer;
}

TapeWriter::~TapeWriter() { (void)close(); }

Status TapeWriter::write(std::uint32_t kind, std::span<const std::byte> payload) {
  if (file_ < 0 && status_.ok()) return Status::error(named(path_) + "is closed");
  if (!status_.ok()) return status_;
  if (payload.size() > kMaxTapeRecord) {
    return Status::error(named(path_) + "a record of " + std::to_string(payload.size()) + " bytes; at most " +
                         std::to_string(kMaxTapeRecord) + " fit");
  }
  RecordStart start{kind, static_cast<std::uint32_t>(payload.size()), 0};
  start.crc = crc_of_record(start, payload);
  put(bytes_of(start));
  put(payload);
  if (status_.ok()) {
    ++records_;
    ends_.push_back(bytes_);
  }
  return status_;
}

Status TapeWriter::close() {
  if (file_ < 0) return status_;
  flush();
  // A pipe or /dev/null has no disk to wait for.
  if (status_.ok() && fsync(file_) != 0 && errno != EINVAL && errno != EROFS) fail("not safe on the disk", errno);
  const int file = file_;
  file_ = -1;
  if (::close(file) != 0 && status_.ok()) fail("not closed", errno);
  return status_;
}

void TapeWriter::put(std::span<const std::byte> bytes) {
  bytes_ += bytes.size();
  while (!bytes.empty() && status_.ok()) {
    const std::size_t part = std::min(bytes.size(), kBuffer - buffer_.size());
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(part));
    bytes = bytes.subspan(part);
    if (buffer_.size() == kBuffer) flush();
  }
}

void TapeWriter::flush() {
  std::span<const std::byte> left(buffer_);
  while (!left.empty() && status_.ok()) {
    const ssize_t written = ::write(file_, left.data(), left.size());
    if (written > 0) {
      left = left.subspan(static_cast<std::size_t>(written));
      written_ += static_cast<std::uint64_t>(written);
    } else if (written == 0 || errno != EINTR) {
      fail("cannot be written", written == 0 ? ENOSPC : errno);
    }
  }
  buffer_.clear();
  ends_.clear();
}

void TapeWriter::fail(const char* what, int error) {
  const auto lost = std::count_if(ends_.begin(), ends_.end(), [this](std::uint64_t end) { return end > written_; });
  const std::uint64_t whole = records_ - static_cast<std::uint64_t>(lost);
  status_ = Status::error(named(path_) + what + " (" + strerrordesc_np(error) + "): it has " +
                          (whole == 0 ? "no record" : "the first " + std::to_string(whole) + " records"));
}

// --- reader

Result<std::unique_ptr<TapeReader>> TapeReader::open(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rbe");
  if (file == nullptr) return Status::error(named(path) + "cannot be read: " + strerrordesc_np(errno));
  std::unique_ptr<TapeReader> reader(new TapeReader(file, path));
  if (Status status = reader->read_header(); !status.ok()) return status;
  return reader;
}

TapeReader::~TapeReader() { std::fclose(file_); }

std::size_t TapeReader::read_up_to(void* to, std::size_t size) {
  const std::size_t got = size == 0 ? 0 : std::fread(to, 1, size, file_);
  offset_ += got;
  return got;
}

Status TapeReader::read_header() {
  HeaderStart start;
  start.magic = {};
  const std::size_t got = read_up_to(&start, sizeof start);
  if (std::ferror(file_) != 0) return Status::error(named(path_) + "cannot be read: is it a file?");
  const std::size_t magic_size = std::min(got, kTapeMagic.size());
  if (got == 0 || !std::equal(kTapeMagic.begin(), kTapeMagic.begin() + static_cast<std::ptrdiff_t>(magic_size),
                              start.magic.begin())) {
    return Status::error(named(path_) + "is not a tape: it does not begin as one");
  }
  if (got < sizeof start) return cut_off_in_header();
  if (start.version != kTapeVersion) {
    return Status::error(named(path_) + "version " + std::to_string(start.version) + "; this program reads version " +
                         std::to_string(kTapeVersion));
  }
  if (start.text_size > kMaxTapeText) {
    return Status::error(named(path_) + "damaged header: a text of " + std::to_string(start.text_size) + " bytes");
  }
  text_.resize(start.text_size);
  std::uint32_t crc = 0;
  if (read_up_to(text_.data(), text_.size()) < text_.size() || read_up_to(&crc, sizeof crc) < sizeof crc) {
    return cut_off_in_header();
  }
  if (crc != crc_of(bytes_of(start), std::as_bytes(std::span(text_.data(), text_.size())))) {
    return Status::error(named(path_) + "damaged header: its checksum does not match");
  }
  isa_tag_.assign(start.isa_tag.begin(), std::find(start.isa_tag.begin(), start.isa_tag.end(), '\0'));
  return Status::good();
}

TapeRead TapeReader::next(TapeRecord& record) {
  if (ended_) return damage_.ok() ? TapeRead::kEnd : TapeRead::kDamaged;
  record_begin_ = offset_;
  RecordStart start;
  const std::size_t got = read_up_to(&start, sizeof start);
  if (got == 0 && std::ferror(file_) == 0) {
    ended_ = true;
    return TapeRead::kEnd;
  }
  if (got < sizeof start) return damaged(cut_off());
  if (start.size > kMaxTapeRecord) {
    return damaged(Status::error(named(path_) + "record " + std::to_string(records_) + " at byte " +
                                 std::to_string(record_begin_) + " is damaged: it claims " +
                                 std::to_string(start.size) + " bytes"));
  }
  // In pieces: a damaged size must not allocate more memory than the file has data.
  constexpr std::size_t kPiece = 1u << 20;
  payload_.clear();
  while (payload_.size() < start.size) {
    const std::size_t have = payload_.size(), piece = std::min<std::size_t>(kPiece, start.size - have);
    payload_.resize(have + piece);
    if (read_up_to(payload_.data() + have, piece) < piece) return damaged(cut_off());
  }
  if (start.crc != crc_of_record(start, payload_)) {
    return damaged(Status::error(named(path_) + "record " + std::to_string(records_) + " at byte " +
                                 std::to_string(record_begin_) + " is damaged: its checksum does not match"));
  }
  record = {.kind = start.kind, .index = records_++, .offset = record_begin_, .payload = payload_};
  return TapeRead::kRecord;
}

bool TapeReader::go_to(std::uint64_t offset, std::uint64_t index) {
  if (std::fseek(file_, static_cast<long>(offset), SEEK_SET) != 0) return false;
  offset_ = offset;
  records_ = index;
  damage_ = Status::good();
  ended_ = false;
  return true;
}

std::uint64_t TapeReader::skip_damage(std::span<const std::uint32_t> kinds) {
  const std::uint64_t damaged = record_begin_;
  if (std::fseek(file_, 0, SEEK_END) != 0) return offset_ - damaged;  // a pipe: data already read is lost
  const auto file_size = static_cast<std::uint64_t>(std::ftell(file_));
  std::uint64_t may_read = kSearchReads * file_size, at = damaged + 1;
  std::vector<std::byte> window;
  constexpr std::size_t kWindow = 1u << 16;
  for (std::uint64_t begin = at; at + sizeof(RecordStart) <= file_size && may_read > 0; begin = at) {
    window.resize(std::min<std::uint64_t>(kWindow, file_size - begin));
    if (std::fseek(file_, static_cast<long>(begin), SEEK_SET) != 0 ||
        std::fread(window.data(), 1, window.size(), file_) < window.size())
      break;
    for (; at + sizeof(RecordStart) <= begin + window.size() && may_read > 0; ++at) {
      std::uint32_t kind = 0;
      std::memcpy(&kind, window.data() + (at - begin), sizeof kind);
      if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end() || !is_whole_record(at, file_size, may_read))
        continue;
      std::fseek(file_, static_cast<long>(at), SEEK_SET);
      offset_ = at;
      ended_ = false;
      damage_ = Status::good();
      return at - damaged;
    }
  }
  offset_ = file_size;
  ended_ = true;
  damage_ = Status::good();
  return file_size - damaged;
}

// `may_read` [bytes]: reduced by the bytes that the check reads.
bool TapeReader::is_whole_record(std::uint64_t at, std::uint64_t file_size, std::uint64_t& may_read) {
  RecordStart start;
  if (std::fseek(file_, static_cast<long>(at), SEEK_SET) != 0 || std::fread(&start, sizeof start, 1, file_) != 1)
    return false;
  if (start.size > kMaxTapeRecord || at + sizeof start + start.size > file_size) return false;
  payload_.resize(start.size);
  may_read -= std::min<std::uint64_t>(may_read, start.size);
  return std::fread(payload_.data(), 1, payload_.size(), file_) == payload_.size() &&
         start.crc == crc_of_record(start, payload_);
}

Status TapeReader::cut_off_in_header() const {
  return Status::error(named(path_) + "cut off at byte " + std::to_string(offset_) +
                       ", inside its header: nothing to read");
}

Status TapeReader::cut_off() const {
  if (std::ferror(file_) != 0) {
    return Status::error(named(path_) + "the disk cannot read on at byte " + std::to_string(offset_));
  }
  return Status::error(named(path_) + "cut off at byte " + std::to_string(offset_) + ", inside record " +
                       std::to_string(records_) + ": readable up to byte " + std::to_string(record_begin_));
}

TapeRead TapeReader::damaged(Status why) {
  damage_ = std::move(why);
  ended_ = true;
  return TapeRead::kDamaged;
}

}  // namespace tactus::loop
