// A file that an export writes, buffered. Where the export fails, what was written of it is removed.
//
// Thread: any normal one. Bound: a buffer of 1 MB. Errors: one line with the path; the first is final.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "rt/base/result.h"

namespace tactus::exporting {

// Error: the file exists, and `overwrite` is false. Other files than regular ones, such as a pipe, may exist.
Status check_output(const std::string& path, bool overwrite);

// What writes over a file only if it wrote such a file before: by how the file begins.
enum class OutputKind { kTape, kCsv, kHdf5, kSvg, kPage, kTrace, kBudget, kJunit };

// Error: the folder is not there or cannot be written, the path is a folder, or a file of another kind is there, such
// as the scene itself. An empty file, and what is no regular file, may be written.
Status check_replaced(const std::string& path, OutputKind kind);

class OutputFile {
 public:
  static Result<std::unique_ptr<OutputFile>> create(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view bytes);
  // Writes the buffer and closes the file; the status is that of all writes.
  Status finish();

  std::uint64_t bytes() const noexcept { return bytes_; }
  const Status& status() const noexcept { return status_; }

 private:
  OutputFile(int file, std::string path) : file_(file), path_(std::move(path)) { buffer_.reserve(kBuffer); }
  void flush();

  static constexpr std::size_t kBuffer = 1u << 20;
  int file_;
  std::string path_;
  std::string buffer_;
  std::uint64_t bytes_{0};
  Status status_{Status::good()};
  bool finished_{false};
};

// Removes the file if it is a regular one.
void remove_output(const std::string& path);

}  // namespace tactus::exporting
