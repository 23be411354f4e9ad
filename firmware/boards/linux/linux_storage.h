// Where a Linux board keeps its configuration: one file, replaced as a whole, so that a power cut leaves the old one or
// the new one.
//
// Thread: open(), load(), close() [setup]; store() [rt], the control period's: one copy, then a thread of the storage's
// own writes. Bound: one block at a time; while it is being written, store() refuses the next. Every error: one line.
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

  // Empty: keeps nothing, store() refuses. The error; empty: none.
  std::string open(const std::string& path);
  void close() noexcept;  // what was taken over is written first

  std::size_t load(std::span<std::byte> room);
  bool store(std::span<const std::byte> block) noexcept;
  std::uint64_t failures() const noexcept { return failures_.load(std::memory_order_relaxed); }  // files not written

 private:
  static void run_thread(void* self) noexcept { static_cast<FileStorage*>(self)->run(); }
  void run() noexcept;
  bool write_file() noexcept;

  std::string path_, next_;  // next_: beside it, renamed over it
  std::array<std::byte, kConfigBlockSize> block_{};
  std::size_t size_{0};
  std::atomic<bool> waits_{false};       // block_ is the thread's while it is true
  std::atomic<std::uint32_t> asked_{0};  // the thread sleeps on it
  std::atomic<std::uint64_t> failures_{0};
  BoardThread thread_;
};

static_assert(Storage<FileStorage>);

}  // namespace tactus::firmware
