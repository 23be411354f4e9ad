// The exceptions of the Python module: tactus.Error and below it FileError, OptionError, MachineError, UseError, by the
// kind of the library's Error. Thread: with the GIL held.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "rt/base/result.h"
#include "tactus/error.h"

namespace tactus::python {

void add_errors(pybind11::module_& module);

[[noreturn]] void raise(Error::Kind kind, const std::string& message);
// A value for a message: its repr, short and in one line.
std::string shown(const pybind11::handle& value);
// A file's path from str, bytes or os.PathLike; raises OptionError for anything else. `call`: for the message.
std::filesystem::path path_of(const pybind11::handle& value, const char* call);
// Nothing on success.
void raise_if(const Error& error);

// Base of classes whose objects Python can make without __init__, by Class.__new__(Class). The memory of such an object
// is zero, so its pointers are null, and each of its methods calls made(), which raises.
class ZeroedByPython {
 public:
  static void* operator new(std::size_t bytes);
  static void* operator new(std::size_t, void* at) noexcept { return at; }
  static void operator delete(void* memory) noexcept;

 protected:
  // Raises UseError where __init__ was not called.
  void made(const char* name) const;

 private:
  std::uint32_t mark_{kMade};
  static constexpr std::uint32_t kMade = 0x6d616465;
};

}  // namespace tactus::python
