// MCAP: the ticks as JSON objects with a schema, topic tactus/tick; the bodies as Foxglove's SceneUpdate, topic
// tactus/bodies. Times are simulated time from 0.
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/export/mcap_writer.h"
#include "tools/export/scene_entities.h"
#include "tools/export/sink.h"
#include "tools/json_text.h"

namespace tactus::exporting {
namespace {

std::string tick_schema(const std::vector<Column>& columns) {
  nlohmann::ordered_json properties;
  for (const Column& column : columns) {
    nlohmann::ordered_json& property = properties[column.name];
    // What is not finite has no number in JSON: null.
    if (column.is_real())
      property["type"] = {"number", "null"};
    else
      property["type"] = "integer";
    std::string text = column.meaning;
    if (!column.unit.empty()) text += ", in " + (column.unit == "1" ? "pure numbers" : column.unit);
    if (!column.frame.empty()) text += ", " + column.frame + " frame";
    property["description"] = text;
  }
  return json_text(nlohmann::ordered_json{{"title", "tactus.Tick"}, {"type", "object"}, {"properties", properties}});
}

class McapSink final : public Sink {
 public:
  McapSink(std::unique_ptr<OutputFile> file, const ExportContext& context)
      : context_(context), writer_(std::move(file), context.program) {
    for (const Column& column : context.columns) keys_.push_back((keys_.empty() ? "{\"" : ",\"") + column.name + "\":");
    ticks_ = writer_.add_channel("tactus/tick", "tactus.Tick", tick_schema(context.columns));
    if (context.scene != nullptr)
      bodies_ = writer_.add_channel("tactus/bodies", "foxglove.SceneUpdate", scene_update_schema());
  }

  Status tick(const Row& row) override {
    text_.clear();
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const Column& column = context_.columns[i];
      text_ += keys_[i];
      append_value(text_, column, value_of(column, row, context_.period_s), true);
    }
    text_ += '}';
    writer_.message(ticks_, time_ns(row.tick.out.tick), text_);
    return writer_.status();
  }

  Status bodies(const ExportedFrame& frame) override {
    const std::uint64_t now_ns = time_ns(frame.tick);
    if (!fixed_written_) writer_.message(bodies_, now_ns, fixed_bodies_json(*context_.scene, now_ns));
    fixed_written_ = true;
    writer_.message(bodies_, now_ns, members_json(*context_.scene, frame, now_ns));
    return writer_.status();
  }

  Status finish() override { return writer_.finish(); }

  std::uint64_t bytes() const override { return writer_.bytes(); }

 private:
  std::uint64_t time_ns(std::uint64_t tick) const {
    return static_cast<std::uint64_t>(std::llround(1e9 * time_of(tick, context_.period_s)));
  }

  const ExportContext& context_;
  McapWriter writer_;
  std::uint16_t ticks_{0}, bodies_{0};
  bool fixed_written_{false};
  std::vector<std::string> keys_;  // what stands before each column's value
  std::string text_;
};

}  // namespace

Result<std::unique_ptr<Sink>> mcap_sink(const std::string& path, const ExportContext& context) {
  auto file = OutputFile::create(path);
  if (!file.ok()) return file.status();
  return std::unique_ptr<Sink>(new McapSink(std::move(file).value(), context));
}

}  // namespace tactus::exporting
