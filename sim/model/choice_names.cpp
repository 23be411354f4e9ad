#include "sim/model/choice_names.h"

#include <array>
#include <utility>

namespace tactus::sim {
namespace {

using haptics::CouplingScheme;
using physics::BorderMode;
using physics::FrictionSweeps;
using physics::SweepPrecision;

template <class Choice, std::size_t kCount>
using Names = std::array<std::pair<Choice, std::string_view>, kCount>;

constexpr Names<CutOrder, 2> kCutOrders{
    {{CutOrder::kBestFirst, "best-first"}, {CutOrder::kBreadthFirst, "breadth-first"}}};
constexpr Names<SweepPrecision, 2> kPrecisions{{{SweepPrecision::kFull, "double"}, {SweepPrecision::kSingle, "mixed"}}};
constexpr Names<FrictionSweeps, 3> kFrictionSweeps{
    {{FrictionSweeps::kAuto, "auto"}, {FrictionSweeps::kRelax, "relax"}, {FrictionSweeps::kEvery, "every"}}};
constexpr Names<Reach, 2> kReaches{{{Reach::kTwoCycles, "two-cycles"}, {Reach::kPaper, "paper"}}};

std::string_view or_unknown(std::string_view name) noexcept { return name.empty() ? "unknown" : name; }

template <class Choice, std::size_t kCount>
std::string_view find_name(const Names<Choice, kCount>& names, Choice choice) noexcept {
  for (const auto& [value, name] : names)
    if (value == choice) return name;
  return "unknown";
}

template <class Choice, std::size_t kCount>
std::optional<Choice> find_choice(const Names<Choice, kCount>& names, std::string_view word) noexcept {
  for (const auto& [value, name] : names)
    if (name == word) return value;
  return std::nullopt;
}

template <class Choice, std::size_t kCount>
std::vector<std::string> names_of(const std::array<Choice, kCount>& list) {
  std::vector<std::string> names;
  for (const Choice choice : list) names.emplace_back(traits_of(choice).name);
  return names;
}

}  // namespace

std::string_view name_of(CouplingScheme scheme) noexcept { return or_unknown(traits_of(scheme).name); }
std::string_view name_of(BorderMode mode) noexcept { return or_unknown(traits_of(mode).name); }
std::string_view name_of(CutOrder order) noexcept { return find_name(kCutOrders, order); }
std::string_view name_of(Reach reach) noexcept { return find_name(kReaches, reach); }
std::string_view name_of(SweepPrecision precision) noexcept { return find_name(kPrecisions, precision); }
std::string_view name_of(FrictionSweeps sweeps) noexcept { return find_name(kFrictionSweeps, sweeps); }

std::vector<std::string> coupling_names() { return names_of(haptics::kCouplingSchemes); }
std::vector<std::string> border_names() { return names_of(physics::kBorderModes); }

std::optional<CouplingScheme> parse_coupling_scheme(std::string_view word) noexcept {
  return tactus::find_choice(haptics::kCouplingSchemes, word);
}
std::optional<BorderMode> parse_border_mode(std::string_view word) noexcept {
  return tactus::find_choice(physics::kBorderModes, word);
}
std::optional<CutOrder> parse_cut_order(std::string_view word) noexcept { return find_choice(kCutOrders, word); }
std::optional<Reach> parse_reach(std::string_view word) noexcept { return find_choice(kReaches, word); }
std::optional<SweepPrecision> parse_precision(std::string_view word) noexcept { return find_choice(kPrecisions, word); }
std::optional<FrictionSweeps> parse_friction_sweeps(std::string_view word) noexcept {
  return find_choice(kFrictionSweeps, word);
}

}  // namespace tactus::sim
