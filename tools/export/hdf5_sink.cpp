// HDF5: one dataset a column below /ticks, with its unit, frame and meaning as attributes; the bodies' states below
// /bodies, one row for each body of each frame; the scene's text and the settings of the run as text.
//
// Chunks of 4,096 rows, shuffled and deflated. Built only where libhdf5 is there.
#include <hdf5.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/export/sink.h"
#include "tools/json_text.h"

namespace tactus::exporting {
namespace {

constexpr hsize_t kChunkRows = 4096;
constexpr unsigned kDeflateLevel = 1;

class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), close_(closer) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() { (void)close(); }
  bool close() {
    const hid_t id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }
  bool ok() const { return id_ >= 0; }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor)

 private:
  hid_t id_{-1};
  herr_t (*close_)(hid_t){nullptr};
};

herr_t keep_description(unsigned, const H5E_error2_t* error, void* text) {
  *static_cast<std::string*>(text) = error->desc;
  return 0;
}

// The innermost reason of the library's last error.
std::string last_error() {
  std::string text = "unknown";
  (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, &keep_description, &text);
  return text;
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), &H5Tclose);
  (void)H5Tset_size(type, H5T_VARIABLE);
  (void)H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

bool put_attribute(hid_t owner, const char* name, const std::string& text) {
  const Handle type = text_type(), space(H5Screate(H5S_SCALAR), &H5Sclose);
  const Handle attribute(H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT), &H5Aclose);
  const char* bytes = text.c_str();
  return attribute.ok() && H5Awrite(attribute, type, &bytes) >= 0;
}

bool put_attribute(hid_t owner, const char* name, double number) {
  const Handle space(H5Screate(H5S_SCALAR), &H5Sclose);
  const Handle attribute(H5Acreate2(owner, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT), &H5Aclose);
  return attribute.ok() && H5Awrite(attribute, H5T_NATIVE_DOUBLE, &number) >= 0;
}

bool put_text(hid_t owner, const char* name, const std::string& text) {
  const Handle type = text_type(), space(H5Screate(H5S_SCALAR), &H5Sclose);
  const Handle dataset(H5Dcreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Dclose);
  const char* bytes = text.c_str();
  return dataset.ok() && H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &bytes) >= 0;
}

// A dataset that grows by blocks of rows.
class Series {
 public:
  // `width`: numbers a row; 1: one dimension.
  static Series create(hid_t group, const char* name, hid_t file_type, hid_t memory_type, hsize_t width) {
    const int dimensions = width == 1 ? 1 : 2;
    const hsize_t none[2]{0, width}, most[2]{H5S_UNLIMITED, width}, chunk[2]{kChunkRows, width};
    const Handle space(H5Screate_simple(dimensions, none, most), &H5Sclose);
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose);
    (void)H5Pset_chunk(properties, dimensions, chunk);
    (void)H5Pset_shuffle(properties);
    (void)H5Pset_deflate(properties, kDeflateLevel);
    // Whole chunks are written: a cache of them would be memory for nothing.
    const Handle access_list(H5Pcreate(H5P_DATASET_ACCESS), &H5Pclose);
    (void)H5Pset_chunk_cache(access_list, 0, 0, 1.0);
    Series series;
    series.memory_type_ = memory_type;
    series.width_ = width;
    series.row_bytes_ = H5Tget_size(memory_type) * width;
    series.dataset_ =
        Handle(H5Dcreate2(group, name, file_type, space, H5P_DEFAULT, properties, access_list), &H5Dclose);
    return series;
  }

  bool ok() const { return dataset_.ok(); }
  hid_t dataset() const { return dataset_; }

  void add(const void* row) {
    const auto* bytes = static_cast<const std::byte*>(row);
    buffer_.insert(buffer_.end(), bytes, bytes + row_bytes_);
  }
  std::size_t waiting() const { return buffer_.size() / row_bytes_; }

  bool flush() {
    const hsize_t rows = waiting();
    if (rows == 0) return true;
    const int dimensions = width_ == 1 ? 1 : 2;
    const hsize_t size[2]{written_ + rows, width_}, start[2]{written_, 0}, count[2]{rows, width_};
    if (H5Dset_extent(dataset_, size) < 0) return false;
    const Handle in_file(H5Dget_space(dataset_), &H5Sclose),
        in_memory(H5Screate_simple(dimensions, count, nullptr), &H5Sclose);
    if (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start, nullptr, count, nullptr) < 0) return false;
    if (H5Dwrite(dataset_, memory_type_, in_memory, in_file, H5P_DEFAULT, buffer_.data()) < 0) return false;
    written_ += rows;
    buffer_.clear();
    return true;
  }

  bool close() { return flush() && dataset_.close(); }

 private:
  Handle dataset_;
  hid_t memory_type_{-1};
  hsize_t width_{1}, written_{0};
  std::size_t row_bytes_{1};
  std::vector<std::byte> buffer_;
};

std::string settings_of(const session::OpenTape& tape) {
  auto settings = nlohmann::ordered_json::parse(tape.reader->text(), nullptr, /*allow_exceptions=*/false);
  if (!settings.is_object()) return {};
  settings.erase("scene");  // it is beside, as /scene
  return json_text(settings, 2);
}

class Hdf5Sink final : public Sink {
 public:
  Hdf5Sink(std::string path, const ExportContext& context) : path_(std::move(path)), context_(context) {}
  ~Hdf5Sink() override {
    if (finished_) return;
    columns_.clear();
    bodies_.clear();
    const bool was_open = file_.ok();
    (void)file_.close();
    if (was_open) remove_output(path_);
  }

  Status open() {
    (void)H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its own text on stderr
    file_ = Handle(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), &H5Fclose);
    if (!file_.ok() || !put_header() || !make_columns() || !make_bodies()) return failed();
    return Status::good();
  }

  Status tick(const Row& row) override {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const Column& column = context_.columns[i];
      const Value value = value_of(column, row, context_.period_s);
      const auto number = static_cast<std::uint32_t>(value.count);
      columns_[i].add(column.is_real()                     ? static_cast<const void*>(&value.real)
                      : column.type == ColumnType::kNumber ? static_cast<const void*>(&number)
                                                           : static_cast<const void*>(&value.count));
    }
    return flush_full(columns_) ? Status::good() : failed();
  }

  Status bodies(const ExportedFrame& frame) override {
    for (const ExportedBody& body : frame.bodies) {
      const auto role = static_cast<std::uint32_t>(body.role);
      const Vec3d& p = body.given.position;
      const Quatd& q = body.given.rotation;
      const double pose[7]{p.x, p.y, p.z, q.w, q.x, q.y, q.z};
      bodies_[0].add(&frame.tick);
      bodies_[1].add(&frame.time_s);
      bodies_[2].add(&body.id);
      bodies_[3].add(&role);
      bodies_[4].add(pose);
      if (!flush_full(bodies_)) return failed();
    }
    return Status::good();
  }

  Status finish() override {
    bool good = true;
    for (auto* list : {&columns_, &bodies_})
      for (Series& series : *list) good = series.close() && good;
    if (!good || H5Fflush(file_, H5F_SCOPE_GLOBAL) < 0) return failed();
    hsize_t size = 0;
    (void)H5Fget_filesize(file_, &size);
    if (!file_.close()) return failed();
    bytes_ = size;
    finished_ = true;
    return Status::good();
  }

  std::uint64_t bytes() const override { return bytes_; }

 private:
  bool put_header() {
    const session::TapeSettings& settings = context_.tape->settings;
    return put_attribute(file_, "program", context_.program) && put_attribute(file_, "made_by", settings.made_by) &&
           put_attribute(file_, "scene_name", settings.scene_name) &&
           put_attribute(file_, "scene_file", settings.scene_file) &&
           put_attribute(file_, "scene_hash", settings.scene_hash) &&
           put_attribute(file_, "period_s", context_.period_s) && put_text(file_, "scene", settings.scene_source) &&
           put_text(file_, "settings", settings_of(*context_.tape));
  }

  bool make_columns() {
    const Handle group(H5Gcreate2(file_, "ticks", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    if (!group.ok()) return false;
    for (const Column& column : context_.columns) {
      const bool number = column.type == ColumnType::kNumber;
      columns_.push_back(column.is_real()
                             ? Series::create(group, column.name.c_str(), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 1)
                         : number ? Series::create(group, column.name.c_str(), H5T_STD_U32LE, H5T_NATIVE_UINT32, 1)
                                  : Series::create(group, column.name.c_str(), H5T_STD_U64LE, H5T_NATIVE_UINT64, 1));
      if (!describe(columns_.back(), column.unit, column.frame, column.meaning)) return false;
    }
    return true;
  }

  bool make_bodies() {
    if (context_.scene == nullptr) return true;
    const Handle group(H5Gcreate2(file_, "bodies", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    if (!group.ok()) return false;
    bodies_.push_back(Series::create(group, "tick", H5T_STD_U64LE, H5T_NATIVE_UINT64, 1));
    bodies_.push_back(Series::create(group, "time_s", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 1));
    bodies_.push_back(Series::create(group, "body", H5T_STD_U32LE, H5T_NATIVE_UINT32, 1));
    bodies_.push_back(Series::create(group, "role", H5T_STD_U32LE, H5T_NATIVE_UINT32, 1));
    bodies_.push_back(Series::create(group, "pose", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 7));
    return describe(bodies_[0], "", "", "number of the tick after which the state is taken") &&
           describe(bodies_[1], "s", "", "simulated time at the end of that tick") &&
           describe(bodies_[2], "", "", "number of the body in the scene, from 0") &&
           describe(bodies_[3], "", "", "0 proxy, 1 member, 2 member at the border") &&
           describe(bodies_[4], "m, 1", "world", "position of the centre of mass x y z, rotation quaternion w x y z");
  }

  static bool describe(const Series& series, const std::string& unit, const std::string& frame,
                       const std::string& meaning) {
    return series.ok() && put_attribute(series.dataset(), "unit", unit) &&
           put_attribute(series.dataset(), "frame", frame) && put_attribute(series.dataset(), "meaning", meaning);
  }

  static bool flush_full(std::vector<Series>& list) {
    if (list.empty() || list.front().waiting() < kChunkRows) return true;
    for (Series& series : list)
      if (!series.flush()) return false;
    return true;
  }

  Status failed() const { return Status::error(path_ + ": cannot be written: " + last_error()); }

  std::string path_;
  const ExportContext& context_;
  Handle file_;
  std::vector<Series> columns_;
  std::vector<Series> bodies_;  // tick, time_s, body, role, pose
  std::uint64_t bytes_{0};
  bool finished_{false};
};

}  // namespace

Result<std::unique_ptr<Sink>> hdf5_sink(const std::string& path, const ExportContext& context) {
  auto sink = std::make_unique<Hdf5Sink>(path, context);
  if (const Status status = sink->open(); !status.ok()) return status;
  return std::unique_ptr<Sink>(std::move(sink));
}

}  // namespace tactus::exporting
