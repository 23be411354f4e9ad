// Comma-separated values: one row a tick, the first line names the columns. Bodies in a second file, one row for each
// body of each frame.
#include "tools/export/sink.h"

#include <filesystem>

namespace tactus::exporting {
namespace {

constexpr std::string_view kBodyHeader =
    "tick,time_s,body,role,position_x_m,position_y_m,position_z_m,rotation_w,rotation_x,rotation_y,rotation_z\n";

class CsvSink final : public Sink {
 public:
  CsvSink(const ExportContext& context, std::unique_ptr<OutputFile> ticks, std::unique_ptr<OutputFile> bodies)
      : context_(context), ticks_(std::move(ticks)), bodies_(std::move(bodies)) {
    for (const Column& column : context.columns) {
      if (!line_.empty()) line_ += ',';
      line_ += column.name;
    }
    line_ += '\n';
    ticks_->write(line_);
    if (bodies_ != nullptr) bodies_->write(kBodyHeader);
  }

  Status tick(const Row& row) override {
    line_.clear();
    for (const Column& column : context_.columns) {
      append_value(line_, column, value_of(column, row, context_.period_s), false);
      line_ += ',';
    }
    line_.back() = '\n';
    ticks_->write(line_);
    return ticks_->status();
  }

  Status bodies(const ExportedFrame& frame) override {
    for (const ExportedBody& body : frame.bodies) {
      line_.clear();
      append_number(line_, frame.tick);
      line_ += ',';
      append_number(line_, frame.time_s, false);
      line_ += ',';
      append_number(line_, std::uint64_t{body.id});
      line_ += ',';
      line_ += name_of(body.role);
      const Vec3d& p = body.given.position;
      const Quatd& q = body.given.rotation;
      for (const double number : {p.x, p.y, p.z, q.w, q.x, q.y, q.z}) {
        line_ += ',';
        append_number(line_, number, false);
      }
      line_ += '\n';
      bodies_->write(line_);
    }
    return bodies_->status();
  }

  Status finish() override {
    bytes_ = ticks_->bytes() + (bodies_ != nullptr ? bodies_->bytes() : 0);
    if (const Status status = ticks_->finish(); !status.ok()) return status;
    return bodies_ != nullptr ? bodies_->finish() : Status::good();
  }

  std::uint64_t bytes() const override { return bytes_; }

 private:
  const ExportContext& context_;
  std::unique_ptr<OutputFile> ticks_, bodies_;
  std::string line_;
  std::uint64_t bytes_{0};
};

}  // namespace

std::string bodies_path(const std::string& csv_path) {
  std::filesystem::path path(csv_path);
  const std::string extension = path.extension().string();
  return path.replace_extension().string() + ".bodies" + (extension.empty() ? ".csv" : extension);
}

Result<std::unique_ptr<Sink>> csv_sink(const std::string& path, const ExportContext& context) {
  auto ticks = OutputFile::create(path);
  if (!ticks.ok()) return ticks.status();
  std::unique_ptr<OutputFile> bodies;
  if (context.scene != nullptr) {
    auto second = OutputFile::create(bodies_path(path));
    if (!second.ok()) return second.status();
    bodies = std::move(second).value();
  }
  return std::unique_ptr<Sink>(new CsvSink(context, std::move(ticks).value(), std::move(bodies)));
}

}  // namespace tactus::exporting
