#include "tools/tactus/run_figures.h"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

namespace tactus::tools {
namespace {

void taken(void* context, std::uint32_t kind, std::span<const std::byte> payload) noexcept {
  loop::TickRecord tick;
  if (kind != loop::kTickRecord || payload.size() != sizeof tick) return;
  std::memcpy(&tick, payload.data(), sizeof tick);
  static_cast<exporting::Figures*>(context)->take(tick);
}

}  // namespace

Result<std::unique_ptr<exporting::Figures>> take_figures(session::Session& session,
                                                         const std::vector<std::string>& words) {
  std::unique_ptr<exporting::Figures> figures;
  if (words.empty()) return figures;
  auto parsed = exporting::parse_figures(words);
  if (!parsed.ok()) return Status::error("--figures: " + parsed.message());
  figures = std::make_unique<exporting::Figures>(std::move(parsed).value(), session.options.period_s());
  session.shown.tap = {&taken, figures.get()};
  return figures;
}

void add_figures(nlohmann::json& object, const exporting::Figures* figures) {
  if (figures == nullptr) return;
  for (const auto& [name, value] : figures->values()) object["figures"][name] = value;
}

void print_figures(const exporting::Figures* figures) {
  if (figures == nullptr) return;
  for (const auto& [name, value] : figures->values()) fmt::print("  {:<20} {:g}\n", name, value);
}

}  // namespace tactus::tools
