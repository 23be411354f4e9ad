// Mechanics of a Linux board through the kernel's files: encoders from the counter subsystem, motors by sysfs PWM with
// a direction line; e-stop, motor supply and motor short as lines with values 0 and 1 (a GPIO's value file).
//
// All files are opened at set-up and stay open; a period reads and writes them at offset 0, and writes only changed
// values. Any failure in a period (a counter that cannot be read, a motor that accepts no value) counts as a bad motor
// supply: the controller brakes and reports it. A new direction is written at zero duty; the motor short is closed
// after the duties are zero and opened before they are not. Thread: open() [setup]; sample(), drive() [rt], the control
// period's. Bound: per period 8 reads and 19 writes of a few bytes; their duration depends on the driver: microseconds
// for memory-mapped controllers, hundreds of microseconds for I2C expanders. Source: Linux
// Documentation/driver-api/generic-counter.rst, pwm.rst.
#pragma once

#include "firmware/board.h"
#include "firmware/boards/linux/mechanics_file.h"

namespace tactus::firmware {

// A kernel file that contains one value.
class ValueFile {
 public:
  ValueFile() = default;
  ~ValueFile() { close(); }
  ValueFile(const ValueFile&) = delete;
  ValueFile& operator=(const ValueFile&) = delete;

  std::string open(const std::string& path, bool writes);  // returns the error; empty: none
  void close() noexcept;
  bool is_open() const noexcept { return file_ >= 0; }
  bool read(std::uint64_t& value) const noexcept;  // decimal; negative values in two's complement
  bool write(std::uint64_t value) noexcept;        // does nothing if it is the last written value
  bool is_written(std::uint64_t value) const noexcept { return known_ && written_ == value; }

 private:
  int file_{-1};
  std::uint64_t written_{0};
  bool known_{false};  // written_ is valid
};

class LinuxMechanics {
 public:
  // Returns the error in one line; empty: none. Afterwards the motors are at zero duty and shorted.
  std::string open(const MechanicsDescription& description);

  void sample(ControllerInputs& inputs) noexcept;
  void drive(const ControllerOutputs& outputs) noexcept;

  std::uint64_t failures() const noexcept { return failures_; }  // reads and writes that failed

 private:
  struct Axis {
    ValueFile count, duty, direction;
    unsigned unused_bits{32};  // 64 minus the counter's width
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
