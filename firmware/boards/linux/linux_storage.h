// Stores a Linux board's configuration in one file that is replaced as a whole: a power cut leaves the old or the new
// one.
//
// Thread: open(), load(), close() [setup]; store() [rt], the control period's: it copies, then the storage's own thread
// writes. Bound: one block at a time; while it is being written, store() refuses the next. Every error: one line.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "firmware/board.h"
#include "firmware/boards/linux/board_thread.h"

namespace tactus::firmware {

class FileStorage {
 public:
  FileStorage() = default;
  ~FileStorage() { close(); }
  FileStorage(const FileStorage&) = delete;
  FileStorage& operator=(const FileStorage&) = delete;

  // Empty path: stores nothing, store() refuses. Returns the error; empty: none.
  std::string open(const std::string& path);
  void close() noexcept;  // writes an accepted block first

  std::size_t load(std::span<std::byte> buffer);
  bool store(std::span<const std::byte> block) noexcept;
  std::uint64_t failures() const noexcept { return failures_.load(std::memory_order_relaxed); }  // files not written

 private:
  static void run_thread(void* self) noexcept { static_cast<FileStorage*>(self)->run(); }
  void run() noexcept;
  bool write_file() noexcept;

  std::string path_, next_;  // next_: temporary file, renamed to path_
  std::array<std::byte, kConfigBlockSize> block_{};
  std::size_t size_{0};
  std::atomic<bool> waits_{false};       // true: the thread owns block_
  std::atomic<std::uint32_t> asked_{0};  // the thread waits for its change
  std::atomic<std::uint64_t> failures_{0};
  BoardThread thread_;
};

static_assert(Storage<FileStorage>);

}  // namespace tactus::firmware
