// Counts instructions with callgrind, which runs this program again and counts between two calls. Thread: one.
#pragma once

#include <string>

namespace tactus::experiment {

// True if valgrind is installed now and was at build time.
bool can_count_instructions();

// Called in the counted run; no effect outside valgrind. A few instructions of these calls are counted too.
void start_counting() noexcept;
void stop_counting() noexcept;

// `program`: path of this program; `arguments`: of the counted run. 0: counting failed.
double counted_instructions(const std::string& program, const std::string& arguments);

}  // namespace tactus::experiment
