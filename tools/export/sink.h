// Output of an export, one sink for each format. One pass over the tape writes to all of them.
//
// Thread: the exporting one. Bound: constant memory, whatever the tape's length, but for the index of an MCAP file,
// about 100 bytes a megabyte. Units: SI. Frame: world for bodies, as in the columns' table for ticks.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rt/base/spatial.h"
#include "tools/export/columns.h"
#include "tools/export/output_file.h"
#include "tools/session/tape_player.h"

namespace tactus::exporting {

enum class MemberRole : std::uint32_t {
  kProxy = 0,   // the device holds it
  kMember = 1,  // in the sub-world
  kBorder = 2,  // in the sub-world, and in touch with a body outside of it
};
std::string_view name_of(MemberRole role) noexcept;  // proxy, member, border

struct ExportedBody {
  BodyId id{kNoBody};
  MemberRole role{MemberRole::kMember};
  Posed pose;   // world_from_body: centre of mass, principal axes
  Posed given;  // of the frame that the scene file places (sim/model/given_pose.h); written in CSV and HDF5
};

// The bodies of the sub-world after a tick, by id.
struct ExportedFrame {
  std::uint64_t tick{0};
  double time_s{0};
  std::span<const ExportedBody> bodies;
};

struct ExportContext {
  const session::OpenTape* tape{nullptr};
  const sim::Scene* scene{nullptr};  // null: no bodies are exported
  std::vector<Column> columns;
  double period_s{1e-3};
  std::string program;  // name and version, for formats that have a place for it
};

class Sink {
 public:
  virtual ~Sink() = default;
  // An error is final, and one line with the file's path.
  virtual Status tick(const Row& row) = 0;
  virtual Status bodies(const ExportedFrame& frame) = 0;
  // Completes the file. Without it the destructor removes what was written.
  virtual Status finish() = 0;
  virtual std::uint64_t bytes() const = 0;  // after finish(): of the files
};

// The context must outlive the sink. CSV writes the bodies into a second file, bodies_path(path).
Result<std::unique_ptr<Sink>> csv_sink(const std::string& path, const ExportContext& context);
Result<std::unique_ptr<Sink>> hdf5_sink(const std::string& path, const ExportContext& context);
Result<std::unique_ptr<Sink>> mcap_sink(const std::string& path, const ExportContext& context);
Result<std::unique_ptr<Sink>> perfetto_sink(const std::string& path, const ExportContext& context);

// "a.csv" gives "a.bodies.csv".
std::string bodies_path(const std::string& csv_path);

// Appends a number so that reading it gives the same bits. `for_json`: null where it is not finite.
void append_number(std::string& text, double number, bool for_json);
void append_number(std::string& text, std::uint64_t number);
void append_value(std::string& text, const Column& column, const Value& value, bool for_json);

}  // namespace tactus::exporting
