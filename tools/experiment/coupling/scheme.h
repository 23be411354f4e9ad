// A coupling scheme with its border and ratio, as an experiment runs it. Thread: [any].
#pragma once

#include <string_view>
#include <vector>

#include "sim/model/choice_names.h"
#include "tools/session/run_options.h"

namespace tactus::experiment {

struct Scheme {
  haptics::CouplingScheme coupling{haptics::CouplingScheme::kSubWorld};
  physics::BorderMode border{physics::kDefaultBorder};  // if the coupling has one
  unsigned ratio{8};                                    // ticks per global step

  constexpr haptics::CouplingTraits traits() const noexcept { return traits_of(coupling); }
  constexpr bool direct() const noexcept { return !traits().global_world; }
  friend constexpr bool operator==(const Scheme&, const Scheme&) noexcept = default;
  void set(session::RunOptions& options) const {
    options.coupling = coupling;
    options.border = border;
    options.ratio = ratio;
  }
};

// The reference scheme.
inline constexpr Scheme kDirectScheme{.coupling = haptics::CouplingScheme::kDirect, .ratio = 1};

// Every coupling with its default border, the direct one first; the sub-world with every border.
inline std::vector<Scheme> every_coupling() {
  std::vector<Scheme> schemes{kDirectScheme};
  for (const auto coupling : haptics::kCouplingSchemes)
    if (coupling != kDirectScheme.coupling) schemes.push_back({.coupling = coupling});
  return schemes;
}
inline std::vector<Scheme> every_border() {
  std::vector<Scheme> schemes;
  for (const auto border : physics::kBorderModes) schemes.push_back({.border = border});
  return schemes;
}

// "-" if the coupling has no border.
inline std::string_view name_of_border(const Scheme& scheme) {
  return scheme.traits().border ? sim::name_of(scheme.border) : "-";
}

}  // namespace tactus::experiment
