// The columns of an export: every number that the records of a tick have, with its unit, frame and meaning.
//
// A column is a place in the record, so a value is what the tape holds, bit by bit. Names carry the unit.
// Thread: any normal one. Bound: the table is fixed; reading a value copies 4 or 8 bytes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rt/base/result.h"
#include "rt/loop/flight_recorder.h"

namespace tactus::exporting {

enum class ColumnType : std::uint32_t {
  kReal = 0,    // double
  kCount = 1,   // unsigned, 64 bits
  kNumber = 2,  // unsigned, 32 bits
  kTime = 3,    // double, s: computed from the tick's number
};

struct Column {
  std::string name;     // with the unit: force_x_N
  std::string group;    // a word that selects it with its neighbours: force
  std::string unit;     // "1" for a pure number; empty for a count, a code or bits
  std::string frame;    // of a vector's component or a rotation; empty otherwise
  std::string meaning;  // one sentence
  ColumnType type{ColumnType::kReal};
  std::size_t offset{0};  // bytes, in the row

  bool is_real() const noexcept { return type == ColumnType::kReal || type == ColumnType::kTime; }
};

// What a tape has of a tick. Without times on the tape, as in virtual time, they are 0.
struct Row {
  loop::TickRecord tick;
  loop::TickTimesRecord times;
};

struct Value {
  double real{0};          // of a real column
  std::uint64_t count{0};  // of any other
};

// `period_s`: of the tape. The time of a tick is that of its end, (tick + 1) periods.
Value value_of(const Column& column, const Row& row, double period_s) noexcept;
double time_of(std::uint64_t tick, double period_s) noexcept;

// All columns, in the order of the record.
const std::vector<Column>& all_columns();

// Selects the columns that `words` name, each a column or a group, in the table's order; all, if there are no words.
// Tick and time are always included. Error, one line: a word that is neither a column nor a group.
Result<std::vector<Column>> select_columns(std::span<const std::string> words);

// The groups' names, in the table's order.
std::vector<std::string> group_names();

}  // namespace tactus::exporting
