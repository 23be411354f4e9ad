#include "hal/gpio/gpio_lines.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "rt/base/clock.h"

namespace tactus::hal {
namespace {

constexpr const char* kConsumer = "tactus";
constexpr unsigned kQueuedEdges = 16;  // size of the kernel's event queue of one line
constexpr int kTries = 5;

gpiod_line* line_of(void* line) noexcept { return static_cast<gpiod_line*>(line); }
gpiod_chip* chip_of(void* chip) noexcept { return static_cast<gpiod_chip*>(chip); }

int flags_of(const GpioLine& line) { return line.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0; }

// Compares the quickest of kTries calls with the limit: a single slow call may be due to preemption, not to the chip.
template <class F>
Status check_quick(const std::string& chip, unsigned offset, F&& call) {
  std::int64_t quickest_ns = std::int64_t{1} << 62;
  for (int i = 0; i < kTries; ++i) {
    const std::int64_t start = MonotonicClock::now_ns();
    if (!call()) return Status::error(fmt::format("line {} of {}: {}", offset, chip, std::strerror(errno)));
    quickest_ns = std::min(quickest_ns, MonotonicClock::now_ns() - start);
  }
  if (quickest_ns <= std::chrono::nanoseconds(GpioLines::kMaxCall).count()) return Status::good();
  return Status::error(
      fmt::format("line {} of {} takes {} us a call: a chip behind I2C or USB is too slow here, use one of the "
                  "processor's",
                  offset, chip, quickest_ns / 1000));
}

Status cannot_request(const std::string& chip, unsigned offset, gpiod_line* line) {
  if (errno == EBUSY) {
    const char* user = gpiod_line_consumer(line);
    return Status::error(fmt::format("line {} of {} is in use by '{}'; end that, or use another line", offset, chip,
                                     user != nullptr ? user : "the kernel"));
  }
  return Status::error(fmt::format("line {} of {}: {}", offset, chip, std::strerror(errno)));
}

Status cannot_open(const std::string& chip) {
  if (errno == EACCES || errno == EPERM)
    return Status::error(
        fmt::format("no permission for {}; give your user read and write access to its device "
                    "file (a udev rule for SUBSYSTEM \"gpio\")",
                    chip));
  return Status::error(fmt::format("no chip '{}' ({}); gpiodetect lists them", chip, std::strerror(errno)));
}

}  // namespace

Result<std::unique_ptr<GpioLines>> GpioLines::open(const GpioOptions& options) {
  std::unique_ptr<GpioLines> lines(new GpioLines);
  if (const Status status = lines->request(options); !status.ok()) return status;
  return lines;
}

Status GpioLines::request(const GpioOptions& options) {
  chip_name_ = options.chip;
  chip_ = gpiod_chip_open_lookup(options.chip.c_str());
  if (chip_ == nullptr) return cannot_open(options.chip);
  const unsigned count = gpiod_chip_num_lines(chip_of(chip_));
  for (const auto& line : {options.estop, options.enable, options.probe, options.heartbeat})
    if (line && line->offset >= count)
      return Status::error(fmt::format("{} has {} lines, 0 to {}; not {}", chip_name_, count, count - 1, line->offset));
  if (options.estop)
    if (const Status status = request_estop(*options.estop); !status.ok()) return status;
  if (options.enable)
    if (const Status status = request_output(*options.enable, "enable", enable_); !status.ok()) return status;
  if (options.probe)
    if (const Status status = request_output(*options.probe, "probe", probe_); !status.ok()) return status;
  if (options.heartbeat) return request_output(*options.heartbeat, "heartbeat", heartbeat_);
  return Status::good();
}

Status GpioLines::request_estop(const GpioLine& line) {
  gpiod_line* const requested = gpiod_chip_get_line(chip_of(chip_), line.offset);
  if (requested == nullptr || gpiod_line_request_both_edges_events_flags(requested, kConsumer, flags_of(line)) != 0)
    return cannot_request(chip_name_, line.offset, requested);
  estop_ = requested;
  const int descriptor = gpiod_line_event_get_fd(requested);
  if (descriptor < 0 || fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK) != 0)
    return Status::error(fmt::format("line {} of {}: {}", line.offset, chip_name_, std::strerror(errno)));
  // Edges are already queued here, so no change is lost between this read and the first estop().
  estop_active_ = read_estop_level();
  return check_quick(chip_name_, line.offset, [&] { return gpiod_line_get_value(requested) >= 0; });
}

Status GpioLines::request_output(const GpioLine& line, const char* purpose, Output& output) {
  gpiod_line* const requested = gpiod_chip_get_line(chip_of(chip_), line.offset);
  const std::string consumer = fmt::format("{} {}", kConsumer, purpose);
  if (requested == nullptr || gpiod_line_request_output_flags(requested, consumer.c_str(), flags_of(line), 0) != 0)
    return cannot_request(chip_name_, line.offset, requested);
  output.line = requested;
  return check_quick(chip_name_, line.offset, [&] { return gpiod_line_set_value(requested, 0) == 0; });
}

GpioLines::~GpioLines() {
  set(enable_, false);
  set(probe_, false);
  set(heartbeat_, false);
  if (chip_ != nullptr) gpiod_chip_close(chip_of(chip_));  // releases its lines
}

bool GpioLines::read_estop_level() noexcept {
  const int value = gpiod_line_get_value(line_of(estop_));
  if (value < 0) count_failed_read();
  return value != 0;
}

int GpioLines::read_estop_edges(gpiod_line_event* edges) noexcept {
  const int count = gpiod_line_event_read_multiple(line_of(estop_), edges, kQueuedEdges);
  if (count >= 0) {
    edges_.fetch_add(static_cast<unsigned>(count), std::memory_order_relaxed);
    return count;
  }
  if (errno == EAGAIN) return 0;  // none
  count_failed_read();
  return -1;
}

bool GpioLines::estop_level() noexcept { return estop_ != nullptr && read_estop_level(); }

bool GpioLines::estop_edge() noexcept {
  if (estop_ == nullptr) return false;
  std::array<gpiod_line_event, kQueuedEdges> edges;
  const int count = read_estop_edges(edges.data());
  if (count < 0) return true;
  return std::any_of(edges.begin(), edges.begin() + count, [](const gpiod_line_event& edge) {
    return edge.event_type == GPIOD_LINE_EVENT_RISING_EDGE;  // of the logical level
  });
}

bool GpioLines::estop() noexcept {
  if (estop_ == nullptr) return false;
  std::array<gpiod_line_event, kQueuedEdges> edges;
  const int count = read_estop_edges(edges.data());
  if (count < 0) return true;
  bool was_active = estop_active_;
  for (unsigned i = 0; i < static_cast<unsigned>(count); ++i) {
    estop_active_ = edges[i].event_type == GPIOD_LINE_EVENT_RISING_EDGE;  // of the logical level
    was_active = was_active || estop_active_;
  }
  // A full queue may have lost the newest edges: read the present level.
  if (static_cast<unsigned>(count) == kQueuedEdges) estop_active_ = read_estop_level();
  return was_active || estop_active_;
}

void GpioLines::set(Output& output, bool active) noexcept {
  if (output.line == nullptr || output.active == active) return;
  if (gpiod_line_set_value(line_of(output.line), active ? 1 : 0) != 0) {
    ++write_failed_;
    return;
  }
  output.active = active;
}

void GpioLines::enable(bool on) noexcept { set(enable_, on); }
void GpioLines::probe(bool active) noexcept { set(probe_, active); }
void GpioLines::heartbeat() noexcept { set(heartbeat_, !heartbeat_.active); }

}  // namespace tactus::hal
