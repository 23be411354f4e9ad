// Instructions by callgrind: it runs this program again, and counts what lies between two calls there. Thread: one.
#pragma once

#include <string>

namespace tactus::experiment {

// Valgrind is installed, and was when this was built.
bool can_count_instructions();

// In the run that is counted; nothing outside of valgrind. A few instructions of these calls are counted too.
void start_counting() noexcept;
void stop_counting() noexcept;

// `program`: this program's own path; `arguments`: of the run that is counted. 0: it could not be counted.
double counted_instructions(const std::string& program, const std::string& arguments);

}  // namespace tactus::experiment
