// Results of a part of an experiment as bytes, from one process to another of the same build.
//
// A type whose bytes are its value is copied; a string or vector is its length and its elements; any other type has a
// function fields(io, value) beside it that passes all its members to io, by a structured binding, so that a member
// that is forgotten does not compile. Thread: one.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "rt/base/result.h"

namespace tactus::experiment {

class PartWriter {
 public:
  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }
  std::string take() { return std::move(bytes_); }

 private:
  void put_bytes(const void* from, std::size_t size) { bytes_.append(static_cast<const char*>(from), size); }
  void put(std::string& text) {
    std::uint64_t size = text.size();
    put(size);
    put_bytes(text.data(), text.size());
  }
  template <class T>
  void put(std::vector<T>& list) {
    std::uint64_t size = list.size();
    put(size);
    for (T& value : list) put(value);
  }
  template <class T>
  void put(T& value) {
    if constexpr (std::is_trivially_copyable_v<T>)
      put_bytes(&value, sizeof value);
    else
      fields(*this, value);
  }

  std::string bytes_;
};

// Reads what PartWriter wrote; ok() is false if the bytes end early, and then nothing more is read.
class PartReader {
 public:
  explicit PartReader(const std::string& bytes) : at_(bytes.data()), left_(bytes.size()) {}
  bool ok() const { return ok_; }
  bool at_end() const { return left_ == 0; }

  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }

 private:
  bool get_bytes(void* to, std::size_t size) {
    ok_ = ok_ && size <= left_;
    if (!ok_) return false;
    if (size > 0) std::memcpy(to, at_, size);
    at_ += size;
    left_ -= size;
    return true;
  }
  // A length of elements of at least a byte each.
  std::uint64_t length() {
    std::uint64_t size = 0;
    get(size);
    ok_ = ok_ && size <= left_;
    return ok_ ? size : 0;
  }
  void get(std::string& text) {
    text.resize(length());
    get_bytes(text.data(), text.size());
  }
  template <class T>
  void get(std::vector<T>& list) {
    list.clear();
    for (std::uint64_t left = length(); left > 0 && ok_; --left) get(list.emplace_back());
  }
  template <class T>
  void get(T& value) {
    if constexpr (std::is_trivially_copyable_v<T>)
      get_bytes(static_cast<void*>(&value), sizeof value);
    else
      fields(*this, value);
  }

  const char* at_;
  std::size_t left_;
  bool ok_{true};
};

template <class T>
std::string to_part_bytes(T value) {
  PartWriter writer;
  writer(value);
  return writer.take();
}

// Error, one line: not what to_part_bytes wrote.
template <class T>
Result<T> from_part_bytes(const std::string& bytes) {
  PartReader reader(bytes);
  T value;
  reader(value);
  if (!reader.ok() || !reader.at_end()) return Status::error("a part's result is cut off, or of another build");
  return value;
}

}  // namespace tactus::experiment
