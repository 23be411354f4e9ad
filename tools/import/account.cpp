#include "tools/import/account.h"

#include <fmt/format.h>

#include <algorithm>

namespace tactus::scene_import {

const std::vector<std::string>& droppable_kinds() {
  static const std::vector<std::string> kinds{"actuators",
                                              "animations",
                                              "armature",
                                              "composite",
                                              "damping",
                                              "flex",
                                              "fluids",
                                              "friction-loss",
                                              "gravity-compensation",
                                              "joint-equality",
                                              "limits",
                                              "masks",
                                              "mimic",
                                              "pairs",
                                              "plugins",
                                              "sdf",
                                              "shapeless",
                                              "springs",
                                              "tendons"};
  return kinds;
}

void drop(const std::vector<std::string>& kinds, Account& account) {
  std::vector<Refusal> kept;
  for (Refusal& refusal : account.refused) {
    if (std::find(kinds.begin(), kinds.end(), refusal.kind) == kinds.end()) {
      kept.push_back(std::move(refusal));
      continue;
    }
    std::string text = refusal.line > 0 ? fmt::format("{}, line {}: {}", refusal.kind, refusal.line, refusal.what)
                                        : fmt::format("{}: {}", refusal.kind, refusal.what);
    account.left_out.push_back(text);
    account.dropped.push_back(std::move(text));
  }
  account.refused = std::move(kept);
}

std::string lines_of(const std::vector<Refusal>& refused) {
  std::string text;
  for (const Refusal& r : refused) {
    if (!text.empty()) text += '\n';
    text += r.file;
    if (r.line > 0) text += fmt::format(":{}", r.line);
    text += fmt::format(": {}; accepted: {}", r.what, r.accepted);
    const auto& kinds = droppable_kinds();
    if (std::find(kinds.begin(), kinds.end(), r.kind) != kinds.end()) text += fmt::format(", or --drop {}", r.kind);
  }
  return text;
}

std::string text_of(const Account& account) {
  std::string text = fmt::format("{} bodies, {} joints", account.bodies, account.joints);
  const auto add = [&text](const char* head, const std::vector<std::string>& lines) {
    if (lines.empty()) return;
    text += fmt::format("\n{}:", head);
    for (const std::string& line : lines) text += fmt::format("\n  {}", line);
  };
  add("taken over", account.taken_over);
  add("changed", account.changed);
  add("left out", account.left_out);
  return text;
}

}  // namespace tactus::scene_import
