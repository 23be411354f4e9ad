#include "tools/export/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "rt/tape/tape.h"

namespace tactus::exporting {
namespace {

struct Kind {
  const char* words;
  std::array<std::string_view, 3> beginnings;  // empty ones are none; without any: a table's first line
};

Kind kind_of(OutputKind kind) {
  switch (kind) {
    case OutputKind::kTape:
      return {"tape", {std::string_view(loop::kTapeMagic.data(), loop::kTapeMagic.size() - 1)}};
    case OutputKind::kCsv:
      return {"CSV table", {}};
    case OutputKind::kHdf5:
      return {"HDF5 file", {"\x89HDF"}};
    case OutputKind::kSvg:
      return {"SVG picture", {"<svg"}};
    case OutputKind::kPage:
      return {"page", {"<!doctype html", "<!DOCTYPE html", "<html"}};
    case OutputKind::kTrace:
      return {"trace", {"{\"displayTimeUnit"}};
    case OutputKind::kBudget:
      return {"budget", {"{\n \"tactus\": \"budget\""}};
    case OutputKind::kJunit:
      return {"JUnit report", {"<?xml"}};
  }
  return {};
}

// The first line of a table has names, with units in brackets, and commas; that of a scene or a configuration does not.
bool begins_as_table(std::string_view text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  return line.find(',') != std::string_view::npos && !line.starts_with('[') &&
         line.find_first_of("={}<>#") == std::string_view::npos &&
         std::none_of(line.begin(), line.end(), [](char c) { return static_cast<signed char>(c) < 9 || c == 127; });
}

bool begins_as(const Kind& kind, std::string_view text) {
  if (kind.beginnings.front().empty()) return begins_as_table(text);
  return std::any_of(kind.beginnings.begin(), kind.beginnings.end(),
                     [&](std::string_view beginning) { return !beginning.empty() && text.starts_with(beginning); });
}

Status check_no_folder(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) return Status::good();
  return Status::error(fmt::format("{}: is a folder; accepted: a file", path));
}

Status cannot_be_made(const std::string& path, int error) {
  return Status::error(
      fmt::format("{}: cannot be written: {}; accepted: a file in a folder that exists", path, strerrordesc_np(error)));
}

}  // namespace

Status check_output(const std::string& path, bool overwrite) {
  std::error_code ignored;
  if (const Status status = check_no_folder(path); !status.ok()) return status;
  if (!overwrite && std::filesystem::is_regular_file(path, ignored))
    return Status::error(fmt::format("{}: exists; accepted: another name, or --overwrite", path));
  return Status::good();
}

Status check_replaced(const std::string& path, OutputKind kind) {
  std::error_code ignored;
  if (const Status status = check_no_folder(path); !status.ok()) return status;
  if (!std::filesystem::exists(path, ignored)) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    return ::access(folder.empty() ? "." : folder.c_str(), W_OK) == 0 ? Status::good() : cannot_be_made(path, errno);
  }
  if (::access(path.c_str(), W_OK) != 0)
    return Status::error(
        fmt::format("{}: cannot be written: {}; accepted: another name", path, strerrordesc_np(errno)));
  if (!std::filesystem::is_regular_file(path, ignored)) return Status::good();
  std::array<char, 256> first{};
  std::ifstream file(path, std::ios::binary);
  file.read(first.data(), first.size());
  const std::string_view text(first.data(), static_cast<std::size_t>(file.gcount()));
  const Kind wanted = kind_of(kind);
  if (text.empty() || begins_as(wanted, text)) return Status::good();
  return Status::error(
      fmt::format("{}: is there and is no {}; accepted: another name, or remove it", path, wanted.words));
}

void remove_output(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) std::filesystem::remove(path, ignored);
}

Result<std::unique_ptr<OutputFile>> OutputFile::create(const std::string& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return cannot_be_made(path, errno);
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
