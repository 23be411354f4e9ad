#include "tools/python/options.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <vector>

#include "rt/text/nearest_word.h"
#include "tools/python/errors.h"

namespace py = pybind11;

namespace tactus::python {
namespace {

struct Entry {
  std::string_view name;
  std::string_view type;
  void (*set)(Options& options, const py::handle& value);
};

template <auto kMember>
void set(Options& options, const py::handle& value) {
  using T = std::remove_reference_t<decltype(options.*kMember)>;
  options.*kMember = py::cast<T>(value);
}

// A text, or one for each hand.
void set_inject(Options& options, const py::handle& value) {
  if (py::isinstance<py::str>(value)) {
    options.inject = py::cast<std::string>(value);
    return;
  }
  auto injects = py::cast<std::vector<std::string>>(value);
  if (injects.empty()) return;
  options.inject = std::move(injects.front());
  options.more_injects.assign(std::make_move_iterator(injects.begin() + 1), std::make_move_iterator(injects.end()));
}

// The options that apply to a session in virtual time.
constexpr Entry kEntries[] = {
    {"coupling", "text", &set<&Options::coupling>},
    {"border", "text", &set<&Options::border>},
    {"order", "text", &set<&Options::order>},
    {"reach", "text", &set<&Options::reach>},
    {"accuracy", "text", &set<&Options::accuracy>},
    {"world_precision", "text", &set<&Options::world_precision>},
    {"rate_Hz", "a number", &set<&Options::rate_Hz>},
    {"ratio", "a whole number", &set<&Options::ratio>},
    {"members", "a whole number", &set<&Options::members>},
    {"keep_gains", "True or False", &set<&Options::keep_gains>},
    {"late_s", "a number", &set<&Options::late_s>},
    {"world_threads", "a whole number", &set<&Options::world_threads>},
    {"world_cpus", "a list of whole numbers", &set<&Options::world_cpus>},
    {"arm_at_start", "True or False", &set<&Options::arm_at_start>},
    {"rearm", "True or False", &set<&Options::rearm>},
    {"inject", "text, or a list with one for each hand", &set_inject},
    {"seed", "a whole number", &set<&Options::seed>},
    {"history_ticks", "a whole number", &set<&Options::history_ticks>},
};

}  // namespace

Options options_of(const py::dict& given) {
  Options options;
  std::vector<std::string_view> names;
  for (const Entry& entry : kEntries) names.push_back(entry.name);
  for (const auto& [key, value] : given) {
    const auto name = py::cast<std::string>(key);
    const auto* entry = std::ranges::find(kEntries, name, &Entry::name);
    if (entry == std::end(kEntries)) {
      const auto nearest = text::nearest_word(name, names);
      raise(Error::Kind::kOption,
            fmt::format("Session: {}: no such option{}; accepted: {}", name,
                        nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest), fmt::join(names, ", ")));
    }
    try {
      entry->set(options, value);
    } catch (const py::cast_error&) {
      raise(Error::Kind::kOption,
            fmt::format("Session: {}: {} is not accepted; accepted: {}", name, shown(value), entry->type));
    }
  }
  return options;
}

}  // namespace tactus::python
