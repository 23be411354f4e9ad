#include "tools/export/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace tactus::exporting {

Status check_output(const std::string& path, bool overwrite) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return Status::error(fmt::format("{}: is a folder; accepted: a file", path));
  if (!overwrite && std::filesystem::is_regular_file(path, ignored))
    return Status::error(fmt::format("{}: exists; accepted: another name, or --overwrite", path));
  return Status::good();
}

void remove_output(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) std::filesystem::remove(path, ignored);
}

Result<std::unique_ptr<OutputFile>> OutputFile::create(const std::string& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0)
    return Status::error(fmt::format("{}: cannot be written: {}; accepted: a file in a folder that exists", path,
                                     strerrordesc_np(errno)));
  return std::unique_ptr<OutputFile>(new OutputFile(file, path));
}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
  if (!finished_) remove_output(path_);
}

void OutputFile::write(std::string_view bytes) {
  bytes_ += bytes.size();
  buffer_.append(bytes);
  if (buffer_.size() >= kBuffer) flush();
}

void OutputFile::flush() {
  for (std::string_view left = buffer_; !left.empty() && status_.ok();) {
    const ssize_t wrote = ::write(file_, left.data(), left.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0)
      status_ = Status::error(fmt::format("{}: cannot be written: {}", path_, strerrordesc_np(errno)));
    else
      left.remove_prefix(static_cast<std::size_t>(wrote));
  }
  buffer_.clear();
}

Status OutputFile::finish() {
  flush();
  const int file = file_;
  file_ = -1;
  if (::close(file) != 0 && status_.ok())
    status_ = Status::error(fmt::format("{}: cannot be written: {}", path_, strerrordesc_np(errno)));
  finished_ = status_.ok();
  return status_;
}

}  // namespace tactus::exporting
