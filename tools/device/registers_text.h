// The registers of a device on tactus' wire as text: names with an index, values by their type, the fault log in words.
//
// Thread: normal; never the haptic thread. A name is that of firmware/registers.h; `max_effort[2]` is one register of a
// family, `0x0112` a number.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/registers.h"
#include "rt/base/result.h"

namespace tactus::device {

struct RegisterName {
  const firmware::Register* row{nullptr};
  unsigned first{0}, count{1};  // indices within the family

  std::uint16_t number(unsigned i) const noexcept { return static_cast<std::uint16_t>(row->number + first + i); }
};

// A family's name alone means all of it. Error: no such register, with the nearest name; an index beyond the family.
Result<RegisterName> find_by_name(const std::string& text);

// "max_effort[2]"; "period" where the family has one register.
std::string name_of(const firmware::Register& row, unsigned index);

// 3.5, -12, 0x00000041: by type; sets of bits and identities in hexadecimal.
std::string value_text(const firmware::Register& row, std::uint32_t bits);

// The bits of a number in the register's type. Error: not a number, or outside the register's range.
Result<std::uint32_t> parse_value(const firmware::Register& row, const std::string& text);

// One entry of the fault log, from its four words; empty: there is none.
std::string fault_entry_text(const std::uint32_t (&words)[firmware::kFaultLogWords]);

}  // namespace tactus::device
