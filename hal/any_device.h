// Type-erased device, for a session that chooses its device when the program starts.
//
// Costs two virtual calls a tick; inside them the device's own type is used. Owns the device. Thread: construction,
// as() and link_report() [setup] and by the owner after the loop has ended; read(), write() [rt], with the bounds of
// the device inside.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "hal/device_on_link.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

class AnyDevice {
 public:
  template <haptics::HapticDevice D>
  explicit AnyDevice(std::unique_ptr<D> device) : held_(std::make_unique<Held<D>>(std::move(device))) {}

  const haptics::DeviceProperties& properties() const noexcept { return held_->properties(); }
  void read(haptics::DeviceInput& input) noexcept { held_->read(input); }
  void write(const haptics::DeviceCommand& command) noexcept { held_->write(command); }

  // [setup] Call just before the first tick: drops the frames that wait on its link and resets the link's counters.
  Status start() { return held_->start(); }

  // The frame counts of its link; nullopt if the device has no link.
  std::optional<LinkReport> link_report() const noexcept { return held_->link_report(); }
  // The device itself if it is a D, else null.
  template <haptics::HapticDevice D>
  D* as() const noexcept {
    auto* held = dynamic_cast<Held<D>*>(held_.get());
    return held == nullptr ? nullptr : held->device.get();
  }

 private:
  struct Holder {
    virtual ~Holder() = default;
    virtual const haptics::DeviceProperties& properties() const noexcept = 0;
    virtual void read(haptics::DeviceInput& input) noexcept = 0;
    virtual void write(const haptics::DeviceCommand& command) noexcept = 0;
    virtual Status start() = 0;
    virtual std::optional<LinkReport> link_report() const noexcept = 0;
  };

  template <class D>
  struct Held final : Holder {
    explicit Held(std::unique_ptr<D> d) : device(std::move(d)) {}
    const haptics::DeviceProperties& properties() const noexcept override { return device->properties(); }
    void read(haptics::DeviceInput& input) noexcept override { device->read(input); }
    void write(const haptics::DeviceCommand& command) noexcept override { device->write(command); }
    Status start() override {
      if constexpr (requires { device->start(); })
        return device->start();
      else
        return Status::good();
    }
    std::optional<LinkReport> link_report() const noexcept override {
      if constexpr (requires { device->link_report(); })
        return device->link_report();
      else
        return std::nullopt;
    }
    std::unique_ptr<D> device;
  };

  std::unique_ptr<Holder> held_;
};

static_assert(haptics::HapticDevice<AnyDevice>);

}  // namespace tactus::hal
