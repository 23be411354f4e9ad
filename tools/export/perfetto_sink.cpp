// The trace event format in JSON, for Perfetto and chrome://tracing: a counter track for each group of columns, a slice
// for each cycle, a mark where a fault latches. Times in us of simulated time.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "tools/export/sink.h"
#include "tools/json_text.h"

namespace tactus::exporting {
namespace {

using nlohmann::ordered_json;

constexpr int kProcess = 1, kHapticThread = 1;

class PerfettoSink final : public Sink {
 public:
  PerfettoSink(std::unique_ptr<OutputFile> file, const ExportContext& context)
      : context_(context), file_(std::move(file)) {
    file_->write(R"({"displayTimeUnit":"ms","traceEvents":[)");
    event({{"name", "process_name"},
           {"ph", "M"},
           {"pid", kProcess},
           {"tid", kHapticThread},
           {"args", {{"name", "tactus: " + context.tape->settings.scene_name}}}});
    event({{"name", "thread_name"},
           {"ph", "M"},
           {"pid", kProcess},
           {"tid", kHapticThread},
           {"args", {{"name", "cycles"}}}});
  }

  Status tick(const Row& row) override {
    const loop::TickRecord& tick = row.tick;
    const double now_us = 1e6 * static_cast<double>(tick.out.tick) * context_.period_s;
    last_us_ = now_us + 1e6 * context_.period_s;
    if (tick.adopts != 0) begin_cycle(tick.out.tick, now_us);
    if (tick.out.fault != fault_ && tick.out.fault != Fault::kNone)
      event({{"name", fmt::format("fault: {}", describe(tick.out.fault))},
             {"ph", "i"},
             {"s", "g"},
             {"ts", now_us},
             {"pid", kProcess},
             {"tid", kHapticThread},
             {"args", {{"tick", tick.out.tick}}}});
    fault_ = tick.out.fault;
    add_counters(row, now_us);
    return file_->status();
  }

  Status bodies(const ExportedFrame&) override { return Status::good(); }  // the format has no place for them

  Status finish() override {
    if (cycle_) end_cycle(last_us_);
    const session::TapeSettings& settings = context_.tape->settings;
    const ordered_json other{{"written_by", context_.program},
                             {"recorded_by", settings.made_by},
                             {"scene", settings.scene_file},
                             {"scene_hash", settings.scene_hash}};
    file_->write("\n],\"otherData\":" + json_text(other) + "}\n");
    return file_->finish();
  }

  std::uint64_t bytes() const override { return file_->bytes(); }

 private:
  void event(const ordered_json& object) {
    file_->write(first_ ? "\n" : ",\n");
    first_ = false;
    file_->write(json_text(object));
  }

  void begin_cycle(std::uint64_t tick, double now_us) {
    if (cycle_) end_cycle(now_us);
    cycle_ = {tick, now_us};
  }

  void end_cycle(double now_us) {
    event({{"name", "cycle"},
           {"ph", "X"},
           {"ts", cycle_->from_us},
           {"dur", now_us - cycle_->from_us},
           {"pid", kProcess},
           {"tid", kHapticThread},
           {"args", {{"first_tick", cycle_->tick}}}});
    cycle_.reset();
  }

  // One event for each group: the members of `args` share its track's name.
  void add_counters(const Row& row, double now_us) {
    for (std::size_t i = 0; i < context_.columns.size();) {
      const std::string& group = context_.columns[i].group;
      line_ = first_ ? "\n" : ",\n";
      line_ += fmt::format(R"({{"name":"{}","ph":"C","pid":{},"ts":)", group, kProcess);
      append_number(line_, now_us, true);
      line_ += ",\"args\":{";
      const std::size_t begin = i;
      for (; i < context_.columns.size() && context_.columns[i].group == group; ++i) {
        const Column& column = context_.columns[i];
        line_ += i == begin ? "\"" : ",\"";
        line_ += column.name;
        line_ += "\":";
        append_value(line_, column, value_of(column, row, context_.period_s), true);
      }
      line_ += "}}";
      if (group == "time") continue;  // it is the axis
      file_->write(line_);
      first_ = false;
    }
  }

  struct Cycle {
    std::uint64_t tick{0};
    double from_us{0};
  };

  const ExportContext& context_;
  std::unique_ptr<OutputFile> file_;
  std::optional<Cycle> cycle_;
  Fault fault_{Fault::kNone};
  double last_us_{0};
  std::string line_;
  bool first_{true};
};

}  // namespace

Result<std::unique_ptr<Sink>> perfetto_sink(const std::string& path, const ExportContext& context) {
  auto file = OutputFile::create(path);
  if (!file.ok()) return file.status();
  return std::unique_ptr<Sink>(new PerfettoSink(std::move(file).value(), context));
}

}  // namespace tactus::exporting
