#include "sim/loader/body_label.h"

#include <fmt/format.h>

#include "rt/text/toml.h"
#include "sim/loader/scene_load.h"

namespace tactus::sim {

std::string body_label(const Scene& scene, BodyId id) {
  const std::string number = fmt::format("body {}", id);
  text::Diagnostics ignored;
  text::TomlNode root;
  if (!text::read_toml(scene.source, root, ignored)) return number;
  const text::TomlNode *proxy = root.find("proxy"), *bodies = root.find("body"), *generated = root.find("generate");
  // Ids: the proxies, then the bodies in the order of the file, then the generated bodies.
  if (id < scene.hands()) {
    const std::string label = scene.hands() == 1 ? "the proxy" : fmt::format("the proxy of hand {}", id + 1);
    if (proxy != nullptr && proxy->kind == text::TomlKind::kArray)
      proxy = id < proxy->items.size() ? &proxy->items[id] : nullptr;
    return proxy == nullptr ? label : fmt::format("{} (line {})", label, proxy->line);
  }
  const std::size_t index = id - scene.hands();
  if (bodies != nullptr && index < bodies->items.size()) {
    const text::TomlNode& body = bodies->items[index];
    const text::TomlNode* name = body.find("name");
    return fmt::format("{} (line {})", name == nullptr ? number : "'" + name->text + "'", body.line);
  }
  for (std::size_t part = 0; part < scene.generated.size() && generated != nullptr; ++part) {
    const GeneratedPart& made = scene.generated[part];
    if (id >= made.first && id - made.first < made.count && part < generated->items.size())
      return fmt::format("{} (of the [[generate]] of line {})", number, generated->items[part].line);
  }
  return number;
}

}  // namespace tactus::sim
