#include "firmware/boards/linux/linux_io.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "firmware/boards/linux/linux_program.h"

namespace tactus::firmware {

std::string ValueFile::open(const std::string& path, bool writes) {
  close();
  file_ = ::open(path.c_str(), (writes ? O_RDWR : O_RDONLY) | O_CLOEXEC);
  if (file_ >= 0) return "";
  const char* remedy = errno == EACCES ? "; run as root, or give this user the right" : "";
  return path + ": " + std::strerror(errno) + remedy;
}

void ValueFile::close() noexcept {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
  known_ = false;
}

bool ValueFile::read(std::uint64_t& value) const noexcept {
  std::array<char, 32> text;
  const ssize_t size = pread(file_, text.data(), text.size(), 0);
  if (size <= 0) return false;
  const char* begin = text.data();
  const char* end = begin + size;
  if (*begin == '-') {
    std::int64_t negative = 0;
    if (std::from_chars(begin, end, negative).ec != std::errc{}) return false;
    value = static_cast<std::uint64_t>(negative);
    return true;
  }
  return std::from_chars(begin, end, value).ec == std::errc{};
}

bool ValueFile::write(std::uint64_t value) noexcept {
  if (known_ && value == written_) return true;
  std::array<char, 24> text;
  char* end = std::to_chars(text.data(), text.data() + text.size() - 1, value).ptr;
  *end++ = '\n';
  const ssize_t size = end - text.data();
  known_ = pwrite(file_, text.data(), static_cast<std::size_t>(size), 0) == size;
  written_ = value;
  return known_;
}

std::string LinuxMechanics::open_line(Line& line, const LineDescription& description, bool writes) {
  line.active = description.active == '1' ? 1 : 0;
  if (description.path.empty()) {
    line.file.close();
    return "";
  }
  return line.file.open(description.path, writes);
}

std::string LinuxMechanics::open_axis(Axis& axis, const AxisDescription& description) {
  axis.count.close();
  axis.duty.close();
  axis.direction.close();
  axis.unused_bits = 64 - description.count_bits;
  axis.counted = false;
  axis.position = 0;
  if (!description.count.empty()) {
    if (std::string error = axis.count.open(description.count, false); !error.empty()) return error;
  }
  if (description.pwm.empty()) return "";
  axis.duty_ns_per_effort = static_cast<float>(pwm_period_ns_) / description.full_effort;
  ValueFile period, enable;
  std::string error = period.open(description.pwm + "/period", true);
  if (!error.empty()) return error + " (a PWM is there once its number is written into its chip's 'export')";
  if (error = axis.duty.open(description.pwm + "/duty_cycle", true); !error.empty()) return error;
  if (error = enable.open(description.pwm + "/enable", true); !error.empty()) return error;
  if (error = axis.direction.open(description.direction, true); !error.empty()) return error;
  // Zero duty first: the kernel accepts no period shorter than the duty.
  if (!axis.duty.write(0) || !period.write(pwm_period_ns_) || !enable.write(1) || !axis.direction.write(0))
    return description.pwm + ": takes no period of " + std::to_string(pwm_period_ns_) + " ns: " + std::strerror(errno);
  return "";
}

std::string LinuxMechanics::open(const MechanicsDescription& description) {
  pwm_period_ns_ = description.pwm_period_ns;
  std::string error = open_line(stop_line_, description.stop_line, false);
  if (error.empty()) error = open_line(motor_bus_, description.motor_bus, false);
  if (error.empty()) error = open_line(brake_line_, description.brake_line, true);
  for (unsigned i = 0; i < kAxes && error.empty(); ++i) error = open_axis(axes_[i], description.axes[i]);
  if (!error.empty()) return error;
  good_ = true;
  failures_ = 0;
  drive(ControllerOutputs{});
  return good_ ? "" : "the motors do not take a value: see the lines and PWMs of the mechanics file";
}

void LinuxMechanics::check(bool good) noexcept {
  if (good) return;
  good_ = false;
  ++failures_;
}

// Extends the counter beyond its width: correct as long as it moves less than half its range per period.
bool LinuxMechanics::read_count(Axis& axis, std::int32_t& count) noexcept {
  std::uint64_t raw = 0;
  if (!axis.count.read(raw)) return false;
  const std::uint64_t moved = raw - (axis.counted ? axis.raw : 0);
  const auto difference =
      static_cast<std::int64_t>(moved << axis.unused_bits) >> static_cast<int>(axis.unused_bits);  // sign extended
  axis.position += static_cast<std::uint32_t>(difference);
  axis.raw = raw;
  axis.counted = true;
  count = static_cast<std::int32_t>(axis.position);
  return true;
}

bool LinuxMechanics::is_active(const Line& line, bool if_absent) noexcept {
  if (!line.file.is_open()) return if_absent;
  std::uint64_t level = 0;
  const bool read = line.file.read(level);
  check(read);
  return read && level == line.active;
}

void LinuxMechanics::sample(ControllerInputs& inputs) noexcept {
  inputs.time_us = static_cast<std::uint64_t>(now_ns() / 1000);
  for (unsigned i = 0; i < kAxes; ++i) {
    Axis& axis = axes_[i];
    inputs.counts[i] = static_cast<std::int32_t>(axis.position);  // the last value if the read below fails
    if (!axis.count.is_open() || read_count(axis, inputs.counts[i])) continue;
    inputs.encoder_errors = static_cast<std::uint8_t>(inputs.encoder_errors | 1u << i);
    check(false);
  }
  inputs.emergency_stop = is_active(stop_line_, false);
  const bool bus_good = is_active(motor_bus_, true);
  inputs.motor_bus_ok = bus_good && good_;
  good_ = true;  // the next drive() and sample() clear it on a failure
}

void LinuxMechanics::set_effort(Axis& axis, float effort) noexcept {
  const float wanted_ns = (effort < 0 ? -effort : effort) * axis.duty_ns_per_effort;
  // NaN fails the comparison below: zero duty.
  const float most_ns = static_cast<float>(pwm_period_ns_);
  const auto duty_ns = wanted_ns > 0 ? static_cast<std::uint64_t>(std::min(wanted_ns, most_ns)) : 0;
  const std::uint64_t direction = effort < 0 ? 1 : 0;
  if (duty_ns == 0) return check(axis.duty.write(0));  // the direction is unchanged
  if (!axis.direction.is_written(direction)) {
    const bool at_rest = axis.duty.write(0);
    check(at_rest);
    if (!at_rest || !axis.direction.write(direction)) return check(false);
  }
  check(axis.duty.write(duty_ns));
}

void LinuxMechanics::drive(const ControllerOutputs& outputs) noexcept {
  const std::uint64_t shorted = brake_line_.active;
  if (!outputs.brake && brake_line_.file.is_open()) check(brake_line_.file.write(1 - shorted));
  for (unsigned i = 0; i < kAxes; ++i) {
    if (axes_[i].duty.is_open()) set_effort(axes_[i], outputs.brake ? 0.0f : outputs.effort[i]);
  }
  if (outputs.brake && brake_line_.file.is_open()) check(brake_line_.file.write(shorted));
}

}  // namespace tactus::firmware
