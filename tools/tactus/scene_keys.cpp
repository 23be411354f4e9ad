// tactus scene keys: prints the scene language, generated from the loader's own list.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "sim/loader/scene_keys.h"
#include "tools/json_text.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/scene_schema.h"

namespace tactus::tools {
namespace {

using sim::SceneKey;
using sim::SceneTable;
using text::AskedKey;

struct KeysOptions {
  std::string table;
  bool markdown{false}, man{false}, schema{false};
};

std::string title_of(const SceneTable& table) { return table.name.empty() ? "the file" : table.name; }

// "number, N/m, 0 to 100000"
std::string kind_of(const SceneKey& key) {
  std::string text = sim::type_of(key.asked);
  const std::string unit = sim::unit_of(key.asked), values = sim::values_of(key.asked);
  if (!unit.empty()) text += ", " + unit;
  if (!values.empty()) text += (key.asked.type == AskedKey::Type::kWord ? ": " : ", ") + values;
  return text;
}

std::string default_of(const SceneKey& key) {
  if (key.asked.required) return "required";
  return key.fallback.empty() ? "none" : key.fallback;
}

std::string with_of(const SceneKey& key) { return key.only_with.empty() ? "" : fmt::format(" ({})", key.only_with); }

void print_text(const std::vector<SceneTable>& language) {
  for (const SceneTable& table : language) {
    fmt::print("{}\n  {}\n", title_of(table), table.purpose);
    for (const SceneKey& key : table.keys)
      fmt::print("  {}{}\n      {}\n      {}; default: {}\n", key.asked.key, with_of(key), key.meaning, kind_of(key),
                 default_of(key));
    fmt::print("\n");
  }
}

// Escapes bars, which would end a table cell.
std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

void print_markdown(const std::vector<SceneTable>& language) {
  for (const SceneTable& table : language) {
    fmt::print("### {}\n\n{}\n\n| key | type, unit, range | default | meaning |\n| --- | --- | --- | --- |\n",
               table.name.empty() ? "The file" : fmt::format("`{}`", table.name), table.purpose);
    for (const SceneKey& key : table.keys)
      fmt::print("| `{}`{} | {} | {} | {} |\n", key.asked.key, with_of(key), cell(kind_of(key)), cell(default_of(key)),
                 cell(key.meaning));
    fmt::print("\n");
  }
}

std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out;
}

void print_man(const std::vector<SceneTable>& language) {
  fmt::print(
      ".TH TACTUS.SCENE 5 \"\" \"tactus\" \"File Formats\"\n.SH NAME\ntactus.scene \\- a scene of tactus\n"
      ".SH DESCRIPTION\nA scene is a TOML file: the bodies, the effects that are simulated, the proxy, the device's "
      "place and what the simulated hand does. Units are SI, in the keys' names; rotations are vectors, axis times "
      "angle; the world's z is up. \\fBtactus scene check\\fR \\fIFILE\\fR names every mistake with its line.\n"
      ".SH TABLES\n");
  for (const SceneTable& table : language) {
    fmt::print(".SS {}\n{}\n", roff(title_of(table)), roff(table.purpose));
    for (const SceneKey& key : table.keys)
      fmt::print(".TP\n.BR {} \"{}\"\n{}.\n{}; default: {}.\n", roff(key.asked.key), roff(with_of(key)),
                 roff(key.meaning), roff(kind_of(key)), roff(default_of(key)));
  }
  fmt::print(".SH SEE ALSO\n.BR tactus (1), tactus.toml (5)\n");
}

bool is_called(const SceneTable& table, const std::string& name) {
  return table.name == name || table.name == "[" + name + "]" || table.name == "[[" + name + "]]";
}

int print_keys(const KeysOptions& options) {
  auto language = sim::scene_language();
  if (options.schema) {
    fmt::print("{}\n", json_text(scene_schema(language), 2));
    return 0;
  }
  if (!options.table.empty()) {
    std::string all;
    for (const SceneTable& table : language)
      if (!table.name.empty()) all += (all.empty() ? "" : ", ") + table.name;
    std::erase_if(language, [&](const SceneTable& table) { return !is_called(table, options.table); });
    if (language.empty()) {
      return complain(fmt::format("tactus scene keys: '{}' is not a table; accepted: {}", options.table, all),
                      kExitBadInput);
    }
  }
  if (options.markdown)
    print_markdown(language);
  else if (options.man)
    print_man(language);
  else
    print_text(language);
  return 0;
}

}  // namespace

void add_scene_keys_command(CLI::App& scene, int& exit_code) {
  auto options = std::make_shared<KeysOptions>();
  CLI::App* keys =
      scene.add_subcommand("keys", "List the tables and keys of scene files, each key with unit, range and default.");
  keys->footer(
      "The list is made from the loader's own definitions, so it is always up to date.\n"
      "Exit status: 0 good; 2 there is no such table.\n\n"
      "Examples:\n"
      "  tactus scene keys simulation\n"
      "  tactus scene keys --json-schema > tactus-scene.schema.json");
  keys->add_option("TABLE", options->table, "table to list, such as body or '[[body]] path'; default: all");
  auto* markdown = keys->add_flag("--markdown", options->markdown, "print Markdown tables");
  auto* man = keys->add_flag("--man", options->man, "print the manual page tactus.scene(5)");
  auto* schema = keys->add_flag("--json-schema", options->schema,
                                "print a JSON schema (2020-12), for editors and for programs that write scenes");
  markdown->excludes(man)->excludes(schema);
  man->excludes(schema);
  keys->callback([options, &exit_code] { exit_code = print_keys(*options); });
}

}  // namespace tactus::tools
