// A maker's library that the user has installed: found by name, loaded by dlopen, its functions taken by name.
//
// tactus contains nothing of a maker. The library stays loaded when the object is destroyed, because its threads may
// still run.
// Thread: [setup].
#pragma once

#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include "rt/base/result.h"

namespace tactus::hal {

struct LibrarySearch {
  std::string whose;                   // for messages: "Force Dimension's library"
  std::vector<std::string> names;      // how the files' names begin, the best first: "libdrd.so.3"
  std::vector<std::string> below;      // where a maker's archive has them, below its folder
  std::vector<std::string> variables;  // of the environment, each the path of such a folder
  std::string accepted;                // for the error: "dhd:FOLDER with the maker's SDK, or $FDSDK"
};

class SharedLibrary {
 public:
  // `given`: a folder, or a library; empty: the variables, then where the system looks. Error, one line: why it cannot
  // be opened.
  static Result<SharedLibrary> open(const LibrarySearch& search, const std::filesystem::path& given);
  SharedLibrary(SharedLibrary&& other) noexcept;
  SharedLibrary& operator=(SharedLibrary&&) = delete;
  ~SharedLibrary();

  const std::string& path() const noexcept { return path_; }
  // Takes a function by its name; null where the library has none.
  template <class Function>
  void find(Function*& function, const char* name, bool optional = false) {
    function = reinterpret_cast<Function*>(symbol(name));
    if (function == nullptr && !optional && missing_ == nullptr) missing_ = name;
  }
  // The first function that find() missed; null: none.
  const char* missing() const noexcept { return missing_; }

 private:
  SharedLibrary(void* handle, std::string path) : handle_(handle), path_(std::move(path)) {}
  void* symbol(const char* name) const noexcept;

  void* handle_;
  std::string path_;
  const char* missing_{nullptr};
};

}  // namespace tactus::hal
