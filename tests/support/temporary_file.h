// A file of its own name in the temporary folder, gone at the end of the test.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace tactus::test {

using Bytes = std::vector<std::byte>;

class TemporaryFile {
 public:
  TemporaryFile() {
    const char* folder = std::getenv("TMPDIR");
    path_ = std::string(folder != nullptr ? folder : "/tmp") + "/tactus-test-XXXXXX";
    const int file = mkstemp(path_.data());
    if (file >= 0) ::close(file);
  }
  ~TemporaryFile() { unlink(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::string& path() const { return path_; }

  Bytes read() const {
    Bytes bytes;
    if (std::FILE* file = std::fopen(path_.c_str(), "rb")) {
      std::byte part[4096];
      for (std::size_t got; (got = std::fread(part, 1, sizeof part, file)) > 0;)
        bytes.insert(bytes.end(), part, part + got);
      std::fclose(file);
    }
    return bytes;
  }
  void write(const Bytes& bytes) const {
    if (std::FILE* file = std::fopen(path_.c_str(), "wb")) {
      if (!bytes.empty()) std::fwrite(bytes.data(), 1, bytes.size(), file);
      std::fclose(file);
    }
  }

 private:
  std::string path_;
};

}  // namespace tactus::test
