#include "hal/can/can_interface.h"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>

#include "firmware/can_bus_load.h"

namespace tactus::hal {
namespace {

using Controller = CanInterface::Controller;

// The payload of an attribute as a T; T{} if it is shorter.
template <class T>
T payload_of(const rtattr* attribute) {
  T value{};
  if (RTA_PAYLOAD(attribute) >= sizeof value) std::memcpy(&value, RTA_DATA(attribute), sizeof value);
  return value;
}

template <class F>
void for_each_attribute(const void* first, std::size_t size, F&& visit) {
  const auto* attribute = static_cast<const rtattr*>(first);
  auto left = static_cast<unsigned>(size);
  for (; RTA_OK(attribute, left); attribute = RTA_NEXT(attribute, left)) visit(attribute);
}

Controller controller_of(std::uint32_t state) {
  constexpr std::array<Controller, 6> known{Controller::kActive, Controller::kWarning, Controller::kPassive,
                                            Controller::kBusOff, Controller::kStopped, Controller::kSleeping};
  return state < known.size() ? known[state] : Controller::kUnknown;
}

void take_can_data(const rtattr* data, CanInterface& found) {
  for_each_attribute(RTA_DATA(data), RTA_PAYLOAD(data), [&](const rtattr* a) {
    switch (a->rta_type & NLA_TYPE_MASK) {
      case IFLA_CAN_BITTIMING:
        found.bit_per_s = payload_of<can_bittiming>(a).bitrate;
        break;
      case IFLA_CAN_DATA_BITTIMING:
        found.data_bit_per_s = payload_of<can_bittiming>(a).bitrate;
        break;
      case IFLA_CAN_STATE:
        found.controller = controller_of(payload_of<std::uint32_t>(a));
        break;
      case IFLA_CAN_RESTART_MS:
        found.restart_ms = payload_of<std::uint32_t>(a);
        break;
      case IFLA_CAN_BERR_COUNTER: {
        const auto errors = payload_of<can_berr_counter>(a);
        found.tx_errors = errors.txerr, found.rx_errors = errors.rxerr;
        break;
      }
      default:
        break;
    }
  });
}

void take_link(const nlmsghdr* answer, CanInterface& found) {
  const auto* link = static_cast<const ifinfomsg*>(NLMSG_DATA(answer));
  found.is_can = link->ifi_type == ARPHRD_CAN;
  found.up = (link->ifi_flags & IFF_UP) != 0;
  for_each_attribute(IFLA_RTA(link), IFLA_PAYLOAD(answer), [&](const rtattr* a) {
    if (a->rta_type == IFLA_MTU) found.fd = payload_of<std::uint32_t>(a) >= CANFD_MTU;
    if (a->rta_type != IFLA_LINKINFO) return;
    bool is_can_kind = false;
    found.is_virtual = true;
    for_each_attribute(RTA_DATA(a), RTA_PAYLOAD(a), [&](const rtattr* part) {
      if (part->rta_type == IFLA_INFO_KIND)
        is_can_kind = std::strncmp(static_cast<const char*>(RTA_DATA(part)), "can", RTA_PAYLOAD(part)) == 0;
      if (is_can_kind) found.is_virtual = false;
      if (part->rta_type == IFLA_INFO_DATA && is_can_kind) take_can_data(part, found);
    });
  });
}

struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) close(number);
  }
};

// Requests the interface's data; the reply is in `buffer`. Returns 0 or the error number.
int ask(unsigned index, std::span<char> buffer) {
  const Descriptor netlink{socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)};
  if (netlink.number < 0) return errno;
  struct {
    nlmsghdr header;
    ifinfomsg link;
  } question{};
  question.header.nlmsg_len = NLMSG_LENGTH(sizeof question.link);
  question.header.nlmsg_type = RTM_GETLINK;
  question.header.nlmsg_flags = NLM_F_REQUEST;
  question.link.ifi_index = static_cast<int>(index);
  if (send(netlink.number, &question, question.header.nlmsg_len, 0) < 0) return errno;
  pollfd poll_for{netlink.number, POLLIN, 0};
  if (poll(&poll_for, 1, static_cast<int>(kAnswerWait.count())) <= 0) return ETIMEDOUT;
  const ssize_t size = recv(netlink.number, buffer.data(), buffer.size(), 0);
  if (size < 0) return errno;
  const auto* answer = reinterpret_cast<const nlmsghdr*>(buffer.data());
  if (!NLMSG_OK(answer, static_cast<unsigned>(size))) return EPROTO;
  return answer->nlmsg_type == RTM_NEWLINK ? 0 : EPROTO;
}

// "there is can0 can1", or what to do if there is none.
std::string others() {
  std::string names;
  struct if_nameindex* all = if_nameindex();
  for (struct if_nameindex* one = all; one != nullptr && one->if_index != 0; ++one)
    if (std::strstr(one->if_name, "can") != nullptr) names += fmt::format(" {}", one->if_name);
  if (all != nullptr) if_freenameindex(all);
  if (names.empty()) return "there is no CAN interface: plug the adapter in and load its driver";
  return "there is" + names;
}

}  // namespace

Status check_can_name(std::string_view name) {
  constexpr std::size_t kMaxName = IFNAMSIZ - 1;
  if (name.empty()) return Status::error("names no CAN interface");
  if (name.size() > kMaxName) return Status::error(fmt::format("names an interface of more than {} letters", kMaxName));
  return Status::good();
}

Result<CanInterface> find_can_interface(const std::string& name) {
  const unsigned index = if_nametoindex(name.c_str());
  if (index == 0) return Status::error(fmt::format("no interface '{}'; {}", name, others()));
  alignas(nlmsghdr) std::array<char, 16384> buffer{};
  if (const int error = ask(index, buffer); error != 0)
    return Status::error(fmt::format("the kernel says nothing about {}: {}", name, std::strerror(error)));
  CanInterface found;
  found.name = name;
  take_link(reinterpret_cast<const nlmsghdr*>(buffer.data()), found);
  return found;
}

Status check_can_interface(const CanInterface& interface, bool fd) {
  const std::string& name = interface.name;
  if (!interface.is_can) return Status::error(fmt::format("{} is no CAN interface; {}", name, others()));
  const bool needs_rate = !interface.is_virtual && interface.bit_per_s == 0;
  if (!interface.up)
    return Status::error(fmt::format("{0} is down; as root: ip link set {0} up{1}", name,
                                     needs_rate ? " type can bitrate 1000000 restart-ms 100" : ""));
  if (fd && !interface.fd)
    return Status::error(
        fmt::format("{0} does not take CAN FD frames; as root: ip link set {0} down, then {1}, then up", name,
                    interface.is_virtual ? "mtu 72" : "type can bitrate 1000000 dbitrate 5000000 fd on"));
  if (interface.controller == Controller::kBusOff && interface.restart_ms == 0)
    return Status::error(
        fmt::format("{0} is bus-off and does not restart by itself; mend the bus, then as root: "
                    "ip link set {0} down, type can restart-ms 100, up",
                    name));
  return Status::good();
}

Status check_can_rate(const CanInterface& interface, bool fd, std::chrono::nanoseconds period) {
  if (interface.bit_per_s == 0) return Status::good();
  const std::uint64_t data_rate =
      fd ? (interface.data_bit_per_s > 0 ? interface.data_bit_per_s : interface.bit_per_s) : 0;
  const std::uint64_t needed_ns = firmware::worst_period_ns(interface.bit_per_s, data_rate);
  if (needed_ns > static_cast<std::uint64_t>(period.count()))
    return Status::error(
        fmt::format("{0} runs at {1} bit/s: one period's frames take up to {2} us there, the period is {3} us; "
                    "as root: ip link set {0} down, type can bitrate 1000000, up; or a lower --rate",
                    interface.name, interface.bit_per_s, needed_ns / 1000, period.count() / 1000));
  return Status::good();
}

}  // namespace tactus::hal
