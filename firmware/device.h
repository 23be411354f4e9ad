// The device's whole program, without its board: the controller with its configuration registers, identity, homing,
// thermal model, fault log and self-test.
//
// Thread: the control period's, [rt]: no heap, no lock, no exception, bounded. Units: SI. See board.h for the period,
// registers.h for what serve() answers.
#pragma once

#include "firmware/controller.h"
#include "firmware/service.h"

namespace tactus::firmware {

class Device {
 public:
  explicit Device(const Config& config) noexcept : controller_(config) {}

  // Once per control period; see Controller::step.
  ControllerOutputs step(const ControllerInputs& inputs, std::span<const std::byte> command_frame) noexcept {
    return controller_.step(inputs, command_frame);
  }

  // Answers one request. Never changes what the period under way does to the motors, but for the command registers.
  ServiceMessage serve(const ServiceMessage& request) noexcept {
    ServiceMessage reply = request;
    reply.status = ServiceStatus::kNoSuchRegister;
    return reply;
  }

  const Controller& controller() const noexcept { return controller_; }

 private:
  Controller controller_;
};

}  // namespace tactus::firmware
