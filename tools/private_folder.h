// A folder of this user's alone among the temporary files; removed with the object.
//
// Thread: one. Bound: what is in the folder. Error: none can be made.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <memory>
#include <string>

#include "rt/base/result.h"

namespace tactus {

class PrivateFolder {
 public:
  static Result<std::unique_ptr<PrivateFolder>> make() {
    std::error_code error;
    std::string path = (std::filesystem::temp_directory_path(error) / "tactus-XXXXXX").string();
    if (error || ::mkdtemp(path.data()) == nullptr)
      return Status::error("no folder for temporary files; accepted: TMPDIR that can be written");
    return std::unique_ptr<PrivateFolder>(new PrivateFolder(path));
  }
  ~PrivateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  explicit PrivateFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace tactus
