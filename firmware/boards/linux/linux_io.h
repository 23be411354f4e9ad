// Mechanics of a Linux board through the kernel's own files: encoders from the counter subsystem, motors by sysfs PWM
// with a direction line, e-stop, motor supply and motor short as lines that read or take 0 and 1 (a GPIO's value file).
//
// All files are opened at set-up and held; a period reads and writes them at offset 0, and writes only what changed.
// Whatever fails in a period (a counter that cannot be read, a motor that takes no value) counts as a bad motor supply:
// the controller brakes, and says so. A new direction is written at zero duty; the short is closed after the duties are
// zero and opened before they are not.
// Thread: open() [setup]; sample(), drive() [rt], the control period's. Bound: of a period, 8 reads and 19 writes of a
// few bytes; how long one takes is the driver's: memory-mapped controllers need microseconds, expanders behind I2C
// hundreds. Source: Linux Documentation/driver-api/generic-counter.rst, pwm.rst.
#pragma once

#include "firmware/board.h"
#include "firmware/boards/linux/mechanics_file.h"

namespace tactus::firmware {

// A file of the kernel's that shows or takes one value.
class ValueFile {
 public:
  ValueFile() = default;
  ~ValueFile() { close(); }
  ValueFile(const ValueFile&) = delete;
  ValueFile& operator=(const ValueFile&) = delete;

  std::string open(const std::string& path, bool writes);  // the error; empty: none
  void close() noexcept;
  bool is_open() const noexcept { return file_ >= 0; }
  bool read(std::uint64_t& value) const noexcept;  // decimal; a negative one in two's complement
  bool write(std::uint64_t value) noexcept;        // nothing to do when it is the last one written
  bool is_written(std::uint64_t value) const noexcept { return known_ && written_ == value; }

 private:
  int file_{-1};
  std::uint64_t written_{0};
  bool known_{false};  // written_ is there
};

class LinuxMechanics {
 public:
  // The error in one line; empty: none. Motors are at zero duty and shorted afterwards.
  std::string open(const MechanicsDescription& description);

  void sample(ControllerInputs& inputs) noexcept;
  void drive(const ControllerOutputs& outputs) noexcept;

  std::uint64_t failures() const noexcept { return failures_; }  // reads and writes that failed

 private:
  struct Axis {
    ValueFile count, duty, direction;
    unsigned unused_bits{32};  // of 64, above the counter's
    std::uint64_t raw{0};
    std::uint32_t position{0};
    bool counted{false};
    float duty_ns_per_effort{0};
  };
  struct Line {
    ValueFile file;
    std::uint64_t active{1};
  };

  std::string open_axis(Axis& axis, const AxisDescription& description);
  static std::string open_line(Line& line, const LineDescription& description, bool writes);
  bool read_count(Axis& axis, std::int32_t& count) noexcept;
  bool is_active(const Line& line, bool if_absent) noexcept;
  void set_effort(Axis& axis, float effort) noexcept;
  void check(bool good) noexcept;

  std::array<Axis, kAxes> axes_;
  Line stop_line_, motor_bus_, brake_line_;
  std::uint32_t pwm_period_ns_{0};
  bool good_{true};  // nothing failed since the last sample
  std::uint64_t failures_{0};
};

static_assert(Mechanics<LinuxMechanics>);

}  // namespace tactus::firmware
