// Simulated drives on CAN sockets: what a command reaches answers at once, as real drives do.
//
// A World has the drives and moves them: buses(), hear(bus, frame), fetch(bus, answer), advance() for a period. Thread:
// construction [setup], the rest by one thread. A bus that is down is tried again with each call.
#pragma once

#include <poll.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "firmware/boards/linux/linux_program.h"
#include "firmware/boards/linux_can/can_socket.h"
#include "hal/drives/simulated_drives.h"
#include "tests/vm/bench_parts.h"

namespace tactus::vm {

template <class World>
class DrivePeer {
 public:
  // One interface per bus of the description; an empty one is a bus that is not served. `filters`: what is heard.
  DrivePeer(World& world, std::uint32_t period_us, const std::vector<std::string>& interfaces, bool fd,
            std::vector<can_filter> filters = {{0, 0}})
      : world_(world), period_us_(period_us), filters_(std::move(filters)) {
    if (interfaces.size() != world.buses()) fail("accepted: one interface per bus of the description");
    for (const std::string& name : interfaces) open(name, fd);
    // All peers of an arm begin their periods together, as a clock that they have in common says.
    deadline_ns_ = firmware::now_ns() / period_ns() * period_ns();
  }

  // One period: answers commands until its end, then lets it pass.
  void run_period() {
    deadline_ns_ += period_ns();
    while (wait()) {
      for (unsigned bus = 0; bus < sockets_.size(); ++bus) take_commands(bus);
    }
    world_.advance();
    for (unsigned bus = 0; bus < sockets_.size(); ++bus) send_answers(bus);
    ++periods_;
  }

  std::uint64_t periods() const noexcept { return periods_; }
  std::uint64_t silent_periods() const noexcept { return periods_ - heard_; }  // since the last command
  unsigned not_sent() const noexcept { return not_sent_; }
  std::uint32_t lost() const noexcept {
    std::uint32_t lost = 0;
    for (const auto& socket : sockets_) lost += socket != nullptr ? socket->lost() : 0;
    return lost;
  }

 private:
  static constexpr unsigned kQueuedAnswers = 64;

  std::int64_t period_ns() const noexcept { return std::int64_t{period_us_} * 1000; }

  void open(const std::string& interface, bool fd) {
    sockets_.push_back(nullptr);
    if (interface.empty()) return;
    auto socket = std::make_unique<firmware::CanSocket>();
    const auto failed = socket->open({interface.c_str(), filters_, 0, fd, kQueuedAnswers});
    if (failed.step != firmware::CanOpenError::Step::kNone) fail(interface + ": " + std::strerror(failed.number));
    sockets_.back() = std::move(socket);
  }

  // False: the period is over.
  bool wait() const {
    const std::int64_t left_ns = deadline_ns_ - firmware::now_ns();
    if (left_ns <= 0) return false;
    std::array<pollfd, hal::kMaxBuses> polls{};
    for (unsigned i = 0; i < sockets_.size(); ++i)
      polls[i] = {sockets_[i] != nullptr ? sockets_[i]->descriptor() : -1, POLLIN, 0};
    const timespec time{0, left_ns};
    return ppoll(polls.data(), sockets_.size(), &time, nullptr) > 0;
  }

  void take_commands(unsigned bus) {
    if (sockets_[bus] == nullptr) return;
    int error = 0;
    const unsigned count = sockets_[bus]->receive(error);
    for (unsigned i = 0; i < count; ++i) {
      const firmware::CanReceived& from = sockets_[bus]->frame(i);
      hal::DriveFrame frame{.id = from.id & CAN_EFF_MASK, .extended = (from.id & CAN_EFF_FLAG) != 0, .fd = from.fd};
      frame.size = static_cast<std::uint8_t>(from.data.size());
      std::memcpy(frame.data.data(), from.data.data(), from.data.size());
      heard_ = periods_;
      world_.hear(bus, frame);
      send_answers(bus);
    }
  }

  void send_answers(unsigned bus) {
    hal::ReceivedDriveFrame answer;
    while (world_.fetch(bus, answer)) {
      const std::uint32_t id = answer.frame.extended ? answer.frame.id | CAN_EFF_FLAG : answer.frame.id;
      if (sockets_[bus] == nullptr ||
          sockets_[bus]->send(id, std::as_bytes(answer.frame.bytes()), answer.frame.fd) != 0)
        ++not_sent_;
    }
  }

  World& world_;
  std::uint32_t period_us_;
  std::vector<can_filter> filters_;
  std::vector<std::unique_ptr<firmware::CanSocket>> sockets_;  // null: not served
  std::int64_t deadline_ns_{0};
  std::uint64_t periods_{0}, heard_{0};
  unsigned not_sent_{0};
};

// An arm whose drives and mechanics are in this process.
class WholeArm {
 public:
  WholeArm(const hal::DeviceProfile& profile, const hal::HandModel& hand, std::uint32_t period_us,
           const std::vector<std::string>& interfaces)
      : world_(profile, hand, std::int64_t{period_us} * 1000),
        peer_(world_, period_us, interfaces, profile.description.drives.data_bit_per_s != 0) {}

  void run_period() { peer_.run_period(); }
  std::uint64_t periods() const noexcept { return peer_.periods(); }
  std::uint64_t silent_periods() const noexcept { return peer_.silent_periods(); }
  unsigned not_sent() const noexcept { return peer_.not_sent(); }
  std::uint32_t lost() const noexcept { return peer_.lost(); }
  hal::DriveLaw law(unsigned axis) noexcept { return world_.drive(axis).law(); }
  void restart_hand() noexcept { world_.restart_clock(); }
  const hal::Plant& plant() const noexcept { return world_.plant(); }
  // From the next period on.
  void inject(hal::DriveFault fault) noexcept {
    fault.tick = world_.tick();
    world_.inject(fault);
  }

 private:
  hal::SimulatedDrives world_;
  DrivePeer<hal::SimulatedDrives> peer_;
};

}  // namespace tactus::vm
