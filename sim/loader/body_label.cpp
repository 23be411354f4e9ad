#include "sim/loader/body_label.h"

#include <fmt/format.h>

namespace tactus::sim {

std::string body_label(const Scene& scene, BodyId id) {
  const std::string number = fmt::format("body {}", id);
  if (id < scene.listed.size()) {
    const ListedBody& body = scene.listed[id];
    std::string label = body.name.empty() ? number : "'" + body.name + "'";
    if (id < scene.hands()) label = scene.hands() == 1 ? "the proxy" : fmt::format("the proxy of hand {}", id + 1);
    return fmt::format("{} (line {})", label, body.line);
  }
  for (const GeneratedPart& part : scene.generated)
    if (id >= part.first && id - part.first < part.count)
      return fmt::format("{} (of the [[generate]] of line {})", number, part.line);
  return number;
}

}  // namespace tactus::sim
