// The command line's names of couplings, borders and other choices: name_of and parse.
// Thread: [any]. name_of is never empty.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/haptics/coupling/coupling_scheme.h"
#include "rt/physics/border/border_contact.h"
#include "rt/physics/step.h"
#include "rt/physics/sweep_precision.h"
#include "sim/exchange/extraction.h"

namespace tactus::sim {

std::string_view name_of(haptics::CouplingScheme scheme) noexcept;
std::string_view name_of(physics::BorderMode mode) noexcept;
std::string_view name_of(CutOrder order) noexcept;
std::string_view name_of(Reach reach) noexcept;
std::string_view name_of(physics::SweepPrecision precision) noexcept;
std::string_view name_of(physics::FrictionSweeps sweeps) noexcept;

// All names, in the order of help texts.
std::vector<std::string> coupling_names();
std::vector<std::string> border_names();

// Empty for an unknown word.
std::optional<haptics::CouplingScheme> parse_coupling_scheme(std::string_view word) noexcept;
std::optional<physics::BorderMode> parse_border_mode(std::string_view word) noexcept;
std::optional<CutOrder> parse_cut_order(std::string_view word) noexcept;
std::optional<Reach> parse_reach(std::string_view word) noexcept;
std::optional<physics::SweepPrecision> parse_precision(std::string_view word) noexcept;
std::optional<physics::FrictionSweeps> parse_friction_sweeps(std::string_view word) noexcept;

}  // namespace tactus::sim
