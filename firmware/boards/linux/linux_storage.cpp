#include "firmware/boards/linux/linux_storage.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace tactus::firmware {

std::string FileStorage::open(const std::string& path) {
  close();
  if (path.empty()) return "";
  const auto slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return folder + ": " + std::strerror(errno) + "; --state needs to write there";
  path_ = path;
  next_ = path + ".new";
  return thread_.start(&run_thread, this, 0);
}

void FileStorage::close() noexcept {
  thread_.request_stop();
  asked_.fetch_add(1, std::memory_order_release);
  asked_.notify_one();
  thread_.stop();
  path_.clear();
}

std::size_t FileStorage::load(std::span<std::byte> buffer) {
  const int file = path_.empty() ? -1 : ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t size = read(file, buffer.data(), buffer.size());
  ::close(file);
  return size > 0 ? static_cast<std::size_t>(size) : 0;
}

bool FileStorage::store(std::span<const std::byte> block) noexcept {
  if (path_.empty() || block.size() > block_.size() || waits_.load(std::memory_order_acquire)) return false;
  std::copy(block.begin(), block.end(), block_.begin());
  size_ = block.size();
  waits_.store(true, std::memory_order_release);
  asked_.fetch_add(1, std::memory_order_release);
  asked_.notify_one();
  return true;
}

void FileStorage::run() noexcept {
  for (;;) {
    const std::uint32_t before =
        asked_.load(std::memory_order_acquire);  // read before the checks, so that no request is missed
    if (waits_.load(std::memory_order_acquire)) {
      if (!write_file()) failures_.fetch_add(1, std::memory_order_relaxed);
      waits_.store(false, std::memory_order_release);
    } else if (thread_.stopping()) {
      return;
    } else {
      asked_.wait(before, std::memory_order_acquire);
    }
  }
}

bool FileStorage::write_file() noexcept {
  const int file = ::open(next_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return false;
  std::size_t written = 0;
  while (written < size_) {
    const ssize_t now = write(file, block_.data() + written, size_ - written);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) break;
    written += static_cast<std::size_t>(now);
  }
  const bool whole = written == size_ && fsync(file) == 0;
  ::close(file);
  return whole && std::rename(next_.c_str(), path_.c_str()) == 0;
}

}  // namespace tactus::firmware
