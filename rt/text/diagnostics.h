// What is wrong with a text that a user wrote: a list of mistakes, each with its place and what is accepted there.
//
// Thread: [setup]. Bound: kMaxReportedMistakes; more are counted, not listed.
#pragma once

#include <string>
#include <vector>

namespace tactus::text {

inline constexpr std::size_t kMaxReportedMistakes = 100;

struct Mistake {
  unsigned line{0}, column{0};  // from 1; 0 if it has no position in the text
  std::string where;            // "[body.3] mass_kg": tables of an array count from 1, in the order of the file
  std::string what;             // what was found
  std::string accepted;         // what is accepted
};

// A key that a reader requested from a table, present or not: from these the scene language is documented.
struct AskedKey {
  enum class Type { kUnknown, kNumber, kCount, kSeed, kFlag, kText, kWord, kVector, kTable, kArray };
  std::string table{};  // "[simulation]", "[[body]]", "[hand] path"; empty: the file's own keys
  std::string key{};    // "mass_kg"
  Type type{Type::kUnknown};
  std::string fallback{};  // the default, in the file's syntax; empty: none
  double low{0}, high{0};  // range of a number, a count, each component of a vector; high: entries of an array
  std::vector<std::string> words{};  // accepted words
  bool required{false};
};

struct Diagnostics {
  std::string name;                       // of the file, as given
  std::vector<Mistake> mistakes;          // in the order of reading
  std::vector<Mistake> warnings;          // same
  std::size_t left_out{0};                // mistakes beyond kMaxReportedMistakes
  std::vector<AskedKey>* asked{nullptr};  // receives the requested keys; null: not recorded

  bool ok() const noexcept { return mistakes.empty(); }
  bool full() const noexcept { return mistakes.size() >= kMaxReportedMistakes; }
  void add(Mistake mistake);  // only counted when full()
  void sort_by_place();       // by line and column
  // One line each, by line and column: "scenes/x.toml:12:3: [body.3] mass_kg: -1 is not a mass; accepted: a number >=
  // 1e-06 and <= 1e+06".
  std::string message() const;
  std::string warning_message() const;
};

}  // namespace tactus::text
