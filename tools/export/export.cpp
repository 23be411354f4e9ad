#include "tools/export/export.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "hal/host_faults.h"
#include "rt/base/denormals.h"
#include "tools/export/body_frames.h"
#include "tools/export/sink.h"
#include "tools/version/version.h"

namespace tactus::exporting {
namespace {

struct Output {
  const char* option;
  const std::string ExportOptions::*path;
  Result<std::unique_ptr<Sink>> (*make)(const std::string& path, const ExportContext& context);
};

#if !TACTUS_HAS_HDF5
Result<std::unique_ptr<Sink>> hdf5_sink_missing(const std::string&, const ExportContext&) {
  return Status::error("--hdf5: this build has no libhdf5");
}
#endif

const Output kOutputs[] {
  {"--csv", &ExportOptions::csv, &csv_sink},
#if TACTUS_HAS_HDF5
      {"--hdf5", &ExportOptions::hdf5, &hdf5_sink},
#else
      {"--hdf5", &ExportOptions::hdf5, &hdf5_sink_missing},
#endif
      {"--mcap", &ExportOptions::mcap, &mcap_sink}, {"--perfetto", &ExportOptions::perfetto, &perfetto_sink},
};

// What Perfetto gets without --signals: all columns at full rate are more than it can show.
const std::vector<std::string> kDrawnBest{"force", "counts", "energy", "times"};

// The files that the options ask for, each with the option's name.
std::vector<std::pair<std::string, std::string>> files_of(const ExportOptions& options) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const Output& output : kOutputs)
    if (const std::string& path = options.*output.path; !path.empty()) files.emplace_back(output.option, path);
  if (!options.csv.empty() && options.world_Hz > 0) files.emplace_back("--csv", bodies_path(options.csv));
  return files;
}

// The same file, by whatever names.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(a, ignored) == std::filesystem::weakly_canonical(b, ignored) ||
         std::filesystem::equivalent(a, b, ignored);
}

Status check_files(const ExportOptions& options) {
  const auto files = files_of(options);
  if (files.empty()) return Status::error("no output; accepted: one or more of --csv, --hdf5, --mcap, --perfetto FILE");
  if (!options.hdf5.empty() && !has_hdf5())
    return Status::error(
        "--hdf5: this build has no libhdf5 (Debian: libhdf5-dev); accepted: --csv, --mcap, --perfetto");
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (same_file(files[i].second, options.tape))
      return Status::error(fmt::format("{}: {} is the tape; accepted: another file", files[i].first, files[i].second));
    for (std::size_t k = 0; k < i; ++k)
      if (same_file(files[i].second, files[k].second))
        return Status::error(fmt::format("{}: {} is written by {}; accepted: another file", files[i].first,
                                         files[i].second, files[k].first));
    if (const Status status = check_output(files[i].second, options.overwrite); !status.ok())
      return Status::error(files[i].first + ": " + status.message());
  }
  return Status::good();
}

// One walk through a tape into all sinks.
class Exporter {
 public:
  Exporter(const ExportOptions& options, ExportReport& report) : options_(options), report_(report) {}

  Status open(session::OpenTape& tape) {
    context_.tape = drawn_.tape = &tape;
    context_.period_s = drawn_.period_s = tape.settings.options.period_s();
    context_.program = drawn_.program = "tactus " + version();
    auto columns = select_columns(options_.signals),
         drawn = select_columns(options_.signals.empty() ? kDrawnBest : options_.signals);
    if (!columns.ok()) return Status::error("--signals: " + columns.message());
    context_.columns = std::move(columns).value();
    drawn_.columns = std::move(drawn).value();
    report_.columns = context_.columns.size();
    report_.warning = tape.warning;
    if (options_.world_Hz <= 0) return open_sinks();
    auto session = session::session_of(tape);
    if (!session.ok()) return session.status();
    session_ = std::move(session).value();
    context_.scene = &session_->scene;
    frames_.emplace(std::move(session_->loop), session_->scene, options_.world_Hz, context_.period_s);
    return open_sinks();
  }

  Status take(const loop::TapeRecord& record) {
    switch (record.kind) {
      case loop::kTickRecord: {
        const auto tick = session::tick_of(record);
        return tick.ok() ? take_tick(tick.value()) : tick.status();
      }
      case loop::kTimesRecord: {
        const auto times = session::times_of(record);
        if (times.ok() && waiting_ && times.value().tick == waiting_->tick.out.tick) waiting_->times = times.value();
        return times.status();
      }
      case loop::kTapeGap:
        if (frames_) frames_->lose_step();
        return Status::good();
      case loop::kKeyframeRecord:
      case loop::kSnapshotRecord:
        return frames_ ? frames_->take(record) : Status::good();
      default:
        return session::bad_record(record, fmt::format("is of unknown kind {}", record.kind));
    }
  }

  void take_damage(const std::string& what) {
    if (report_.damage.empty()) report_.damage = what;
    if (frames_) frames_->lose_step();
  }

  Status finish() {
    if (const Status status = write_waiting(); !status.ok()) return status;
    for (auto& sink : sinks_) {
      if (const Status status = sink->finish(); !status.ok()) return failed(status);
      report_.bytes += sink->bytes();
    }
    for (const auto& file : files_of(options_)) report_.files.push_back(file.second);
    if (frames_) {
      report_.different_ticks = frames_->different();
      report_.unreplayable_ticks = frames_->unreplayable();
    }
    warn();
    return Status::good();
  }

  bool machine_failed() const noexcept { return machine_failed_; }

 private:
  Status open_sinks() {
    for (const Output& output : kOutputs) {
      const std::string& path = options_.*output.path;
      if (path.empty()) continue;
      auto sink = output.make(path, output.make == &perfetto_sink ? drawn_ : context_);
      if (!sink.ok()) return Status::error(fmt::format("{}: {}", output.option, sink.message()));
      sinks_.push_back(std::move(sink).value());
    }
    return Status::good();
  }

  Status take_tick(const loop::TickRecord& tick) {
    if (const Status status = write_waiting(); !status.ok()) return status;
    const std::uint64_t number = tick.out.tick;
    if (next_tick_ != 0 && number > next_tick_) report_.lost_ticks += number - next_tick_;
    next_tick_ = number + 1;
    if (frames_) frames_->play(tick);
    const double time_s = time_of(number, context_.period_s);
    if (time_s < options_.from_s || time_s >= options_.to_s) return Status::good();
    ++report_.rows;
    waiting_ = Row{tick, {}};
    waiting_->tick.device.sample.device_fault = hal::shown_fault(tick.device.sample.device_fault);
    return frames_ && frames_->due(tick) ? write_frame(frames_->frame(tick)) : Status::good();
  }

  // A tick's times come behind it on the tape.
  Status write_waiting() {
    if (!waiting_) return Status::good();
    for (auto& sink : sinks_)
      if (const Status status = sink->tick(*waiting_); !status.ok()) return failed(status);
    waiting_.reset();
    return Status::good();
  }

  Status write_frame(const ExportedFrame& frame) {
    ++report_.frames;
    report_.bodies += frame.bodies.size();
    for (auto& sink : sinks_)
      if (const Status status = sink->bodies(frame); !status.ok()) return failed(status);
    return Status::good();
  }

  Status failed(const Status& status) {
    machine_failed_ = true;
    return status;
  }

  void warn() {
    const auto add = [&](const std::string& text) { report_.warning += (report_.warning.empty() ? "" : "; ") + text; };
    if (!report_.damage.empty()) add(report_.damage);
    if (report_.lost_ticks > 0) add(fmt::format("{} ticks are not on the tape", report_.lost_ticks));
    if (report_.unreplayable_ticks > 0)
      add(fmt::format("{} ticks before a keyframe: no bodies there", report_.unreplayable_ticks));
    if (report_.different_ticks > 0)
      add(fmt::format("{} ticks replay otherwise than taped: the bodies are not the run's", report_.different_ticks));
    if (report_.rows == 0) add("no tick between --from and --to");
  }

  const ExportOptions& options_;
  ExportReport& report_;
  ExportContext context_, drawn_;  // drawn_: Perfetto's
  std::unique_ptr<session::Session> session_;
  std::optional<BodyFrames> frames_;
  std::vector<std::unique_ptr<Sink>> sinks_;
  std::optional<Row> waiting_;  // written when its times have come, or the next tick
  std::uint64_t next_tick_{0};
  bool machine_failed_{false};
};

}  // namespace

bool has_hdf5() noexcept { return TACTUS_HAS_HDF5 != 0; }

Status check(const ExportOptions& options) {
  if (!(options.from_s >= 0))
    return Status::error(fmt::format("--from: {:g} is no time; accepted: 0 s or more", options.from_s));
  if (!(options.to_s > options.from_s))
    return Status::error(
        fmt::format("--to: {:g} is not after --from {:g}; accepted: a later time in s", options.to_s, options.from_s));
  if (!(options.world_Hz >= 0) || std::isinf(options.world_Hz))
    return Status::error(
        fmt::format("--world: {:g} is no rate; accepted: 0 to the tape's rate in Hz", options.world_Hz));
  if (const auto columns = select_columns(options.signals); !columns.ok())
    return Status::error("--signals: " + columns.message());
  return check_files(options);
}

Result<ExportReport> export_tape(const ExportOptions& options, const std::function<void(double)>& progress,
                                 bool& machine) {
  machine = false;
  set_denormals_flush();
  if (const Status status = check(options); !status.ok()) return status;
  auto opened = session::open_tape(options.tape);
  if (!opened.ok()) return opened.status();
  session::OpenTape& tape = opened.value();
  ExportReport report;
  Exporter exporter(options, report);
  if (const Status status = exporter.open(tape); !status.ok()) return status;
  Status status =
      session::walk(tape, {.record = [&](const loop::TapeRecord& record) { return exporter.take(record); },
                           .damage = [&](const std::string& what, std::uint64_t) { exporter.take_damage(what); },
                           .progress = progress});
  if (status.ok()) status = exporter.finish();
  machine = exporter.machine_failed();
  if (!status.ok()) return status;
  return report;
}

}  // namespace tactus::exporting
