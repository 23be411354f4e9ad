// Copies to and from memory that another process reads or writes at the same time: every word is an atomic access, so
// there is no data race; whether a copy is whole is decided by the sequence around it.
//
// The writer releases each word after it stored the odd sequence, so a reader that acquires a new word sees that
// sequence, or a later one, when it looks again. Source: Boehm, "Can seqlocks get along with programming language
// memory models?", MSPC 2012.
// Thread: one writer; any number of readers. Bound: linear in the bytes, which are a multiple of 8, as are addresses.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace tactus::publication {

static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free);

inline void store_word(std::byte* to, std::uint64_t word) noexcept {
  std::atomic_ref<std::uint64_t>(*reinterpret_cast<std::uint64_t*>(to)).store(word, std::memory_order_release);
}

// The memory may be mapped read-only: the access is a plain load.
inline std::uint64_t load_word(const std::byte* from) noexcept {
  auto* word = reinterpret_cast<std::uint64_t*>(const_cast<std::byte*>(from));
  return std::atomic_ref<std::uint64_t>(*word).load(std::memory_order_acquire);
}

inline void store_words(std::byte* to, const void* from, std::size_t bytes) noexcept {
  const auto* source = static_cast<const std::byte*>(from);
  for (std::size_t at = 0; at < bytes; at += sizeof(std::uint64_t)) {
    std::uint64_t word;
    std::memcpy(&word, source + at, sizeof word);
    store_word(to + at, word);
  }
}

inline void load_words(void* to, const std::byte* from, std::size_t bytes) noexcept {
  auto* target = static_cast<std::byte*>(to);
  for (std::size_t at = 0; at < bytes; at += sizeof(std::uint64_t)) {
    const std::uint64_t word = load_word(from + at);
    std::memcpy(target + at, &word, sizeof word);
  }
}

}  // namespace tactus::publication
