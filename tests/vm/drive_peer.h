// Simulated drives on CAN sockets: what a command reaches answers at once, as real drives do.
//
// Thread: construction [setup], the rest by one thread. A bus that is down is tried again with each call.
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

class DrivePeer {
 public:
  // One interface per bus of the description.
  DrivePeer(const hal::DeviceProfile& profile, const hal::HandModel& hand, std::uint32_t period_us,
            const std::vector<std::string>& interfaces)
      : world(profile, hand, std::int64_t{period_us} * 1000), period_us_(period_us), buses_(world.make_buses()) {
    if (interfaces.size() != buses_.size()) fail("accepted: one interface per bus of the description");
    for (const std::string& name : interfaces) open(name, profile.description.drives.data_bit_per_s != 0);
    deadline_ns_ = firmware::now_ns();
  }

  // One period: answers commands until its end, then moves the mechanics.
  void run_period() {
    deadline_ns_ += std::int64_t{period_us_} * 1000;
    while (wait()) {
      for (unsigned bus = 0; bus < sockets_.size(); ++bus) take_commands(bus);
    }
    world.advance();
    for (unsigned bus = 0; bus < buses_.size(); ++bus) send_answers(bus);
    ++periods_;
  }

  std::uint64_t periods() const noexcept { return periods_; }
  std::uint64_t silent_periods() const noexcept { return periods_ - heard_; }  // since the last command
  unsigned not_sent() const noexcept { return not_sent_; }
  std::uint32_t lost() const noexcept { return sockets_[0]->lost(); }

  hal::SimulatedDrives world;

 private:
  static constexpr unsigned kQueuedAnswers = 64;

  void open(const std::string& interface, bool fd) {
    constexpr can_filter kAll{0, 0};
    auto socket = std::make_unique<firmware::CanSocket>();
    const auto failed = socket->open({interface.c_str(), {&kAll, 1}, 0, fd, kQueuedAnswers});
    if (failed.step != firmware::CanOpenError::Step::kNone) fail(interface + ": " + std::strerror(failed.number));
    sockets_.push_back(std::move(socket));
  }

  // False: the period is over.
  bool wait() const {
    const std::int64_t left_ns = deadline_ns_ - firmware::now_ns();
    if (left_ns <= 0) return false;
    std::array<pollfd, hal::kMaxBuses> polls{};
    for (unsigned i = 0; i < sockets_.size(); ++i) polls[i] = {sockets_[i]->descriptor(), POLLIN, 0};
    const timespec time{0, left_ns};
    return ppoll(polls.data(), sockets_.size(), &time, nullptr) > 0;
  }

  void take_commands(unsigned bus) {
    int error = 0;
    const unsigned count = sockets_[bus]->receive(error);
    for (unsigned i = 0; i < count; ++i) {
      const firmware::CanReceived& from = sockets_[bus]->frame(i);
      hal::DriveFrame frame{.id = from.id & CAN_EFF_MASK, .extended = (from.id & CAN_EFF_FLAG) != 0, .fd = from.fd};
      frame.size = static_cast<std::uint8_t>(from.data.size());
      std::memcpy(frame.data.data(), from.data.data(), from.data.size());
      heard_ = periods_;
      (void)buses_[bus]->send(frame);
      send_answers(bus);
    }
  }

  void send_answers(unsigned bus) {
    hal::ReceivedDriveFrame answer;
    while (buses_[bus]->receive(answer)) {
      const std::uint32_t id = answer.frame.extended ? answer.frame.id | CAN_EFF_FLAG : answer.frame.id;
      if (sockets_[bus]->send(id, std::as_bytes(answer.frame.bytes()), answer.frame.fd) != 0) ++not_sent_;
    }
  }

  std::uint32_t period_us_;
  hal::DriveBuses buses_;  // to the simulated drives
  std::vector<std::unique_ptr<firmware::CanSocket>> sockets_;
  std::int64_t deadline_ns_{0};
  std::uint64_t periods_{0}, heard_{0};
  unsigned not_sent_{0};
};

}  // namespace tactus::vm
