// The Falcon of the bench: the simulated device behind a USB device port, as its FTDI chip shows it to a host.
//
//   bench_falcon [OPTION VALUE]...
//   --scene FILE   whose hand holds the grip       --control FIFO  commands, a line each
//   --loaded 0|1   its firmware runs, default 0    --priority N    SCHED_FIFO, default 90
// Commands: `homed BITS`; `mute 0|1`, `garbage 0|1`, `cut 0|1`, `twice 0|1`: as FalconFaults; `unplug`, `plug`;
// `report`; `quit`. What happens is told as lines on standard output:
//   image bytes=N                                 firmware was loaded
//   force period=N                                the motors push for kSteady periods in a row
//   zero period=N after=N silent=N                they do not any more. after: periods since the last command line or
//                                                 signal; silent: since the host's last packet
// Full speed, as the device is: packets of 64 bytes, the first two of each the chip's status.
#include <fcntl.h>
#include <linux/usb/ch9.h>
#include <linux/usb/functionfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <string_view>

#include "firmware/boards/linux/board_thread.h"
#include "firmware/boards/linux/linux_program.h"
#include "firmware/boards/linux_usb/usb_gadget.h"
#include "hal/falcon/simulated_falcon.h"
#include "tests/vm/bench_parts.h"

namespace tactus::vm {
namespace {

constexpr std::uint16_t kVendor = 0x0403, kProduct = 0xcb48;
constexpr std::size_t kPacket = 64, kChip = 2;
constexpr std::int64_t kPeriod_ns = 1'000'000;
constexpr unsigned kSteady = 50;
const char* const kMount = "/run/tactus/falcon";

struct Options {
  std::string scene, control;
  bool loaded{false};
  int priority{90};
};

Options read_options(int argc, char** argv) {
  Options options;
  read_pairs(argc, argv, 1,
             {{"--scene", into(options.scene)},
              {"--control", into(options.control)},
              {"--loaded", [&](const char* value) { options.loaded = *value == '1'; }},
              {"--priority", into(options.priority)}});
  return options;
}

// --- descriptors: one interface of the maker's class with two bulk endpoints

void add(std::string& blob, std::uint32_t value, unsigned bytes) {
  for (unsigned i = 0; i < bytes; ++i) blob.push_back(static_cast<char>(value >> (8 * i) & 0xff));
}

std::string endpoint(std::uint8_t address) {
  std::string blob;
  add(blob, USB_DT_ENDPOINT_SIZE, 1);
  add(blob, USB_DT_ENDPOINT, 1);
  add(blob, address, 1);
  add(blob, USB_ENDPOINT_XFER_BULK, 1);
  add(blob, kPacket, 2);
  add(blob, 0, 1);
  return blob;
}

std::string descriptors() {
  std::string body;
  add(body, 3, 4);  // of full speed
  add(body, USB_DT_INTERFACE_SIZE, 1);
  add(body, USB_DT_INTERFACE, 1);
  for (const std::uint32_t field : {0u, 0u, 2u, 0xffu, 0xffu, 0xffu, 0u}) add(body, field, 1);
  body += endpoint(0x81) + endpoint(0x02);
  std::string blob;
  add(blob, FUNCTIONFS_DESCRIPTORS_MAGIC_V2, 4);
  add(blob, static_cast<std::uint32_t>(12 + body.size()), 4);
  // The chip's requests go to the device, not to an interface.
  add(blob, FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_ALL_CTRL_RECIP, 4);
  return blob + body;
}

std::string no_strings() {
  std::string blob;
  for (const std::uint32_t field : {static_cast<std::uint32_t>(FUNCTIONFS_STRINGS_MAGIC), 16u, 0u, 0u})
    add(blob, field, 4);
  return blob;
}

void write_text(const std::string& path, std::string_view text) {
  const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0 || write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
    fail(path + ": " + std::strerror(errno));
  close(file);
}

class FalconBench {
 public:
  FalconBench(const hal::HandModel& hand, const Options& options)
      : port_(hand, hal::kFalconGain, kPeriod_ns, options.loaded), control_lines_(options.control) {
    firmware::GadgetOptions gadget;
    gadget.serial = "FALCON-1";
    gadget.name = "falcon";
    gadget.mount = kMount;
    gadget.vendor = kVendor;
    gadget.product_id = kProduct;
    if (const std::string error = gadget_.create(gadget); !error.empty()) fail(error);
    write_text("/sys/kernel/config/usb_gadget/falcon/max_speed", "full-speed");
    control_file_ = open_file("ep0");
    for (const std::string& blob : {descriptors(), no_strings()})
      if (write(control_file_, blob.data(), blob.size()) != static_cast<ssize_t>(blob.size()))
        fail(std::string("FunctionFS refused a descriptor: ") + std::strerror(errno));
    in_file_ = open_file("ep1");
    out_file_ = open_file("ep2");
    for (const std::string& error :
         {control_.start(&run_body<&FalconBench::answer_control>, this, options.priority + 1),
          reader_.start(&run_body<&FalconBench::read_packets>, this, options.priority + 1),
          writer_.start(&run_body<&FalconBench::write_packets>, this, options.priority + 1), gadget_.bind()})
      if (!error.empty()) fail(error);
  }

  ~FalconBench() {
    gadget_.unbind();
    control_.stop();
    reader_.stop();
    writer_.stop();
    for (const int file : {in_file_, out_file_, control_file_}) close(file);
    gadget_.remove();
  }

  void run(const std::atomic<bool>& stop) {
    firmware::Pace pace(kPeriod_ns / 1000);
    for (bool go_on = true; go_on && !stop.load();) {
      pace.wait();
      {
        const std::lock_guard lock(mutex_);
        // The hand rests at the start of its path until there is force.
        if (!hand_moves_) port_.restart_hand();
        hand_moves_ = hand_moves_ || port_.green();
        port_.advance();
        ++periods_;
        tell();
      }
      std::string line;
      while (go_on && control_lines_.next(line)) go_on = obey(line);
    }
  }

 private:
  template <void (FalconBench::*kBody)()>
  static void run_body(void* bench) noexcept {
    (static_cast<FalconBench*>(bench)->*kBody)();
  }

  static int open_file(const char* name) {
    const std::string path = std::string(kMount) + "/" + name;
    const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) fail(path + ": " + std::strerror(errno));
    return file;
  }

  static void rest() { usleep(1000); }

  void answer_control() {
    while (!control_.stopping()) {
      usb_functionfs_event event{};
      if (read(control_file_, &event, sizeof event) != static_cast<ssize_t>(sizeof event)) {
        rest();
        continue;
      }
      if (event.type != FUNCTIONFS_SETUP) continue;
      const usb_ctrlrequest& setup = event.u.setup;
      const bool is_chip = (setup.bRequestType & USB_TYPE_MASK) == USB_TYPE_VENDOR && setup.wLength == 0;
      bool good = false;
      if (is_chip) {
        const std::lock_guard lock(mutex_);
        good = port_.control(static_cast<hal::FtdiRequest>(setup.bRequest), setup.wValue);
      }
      // The status stage: a read of nothing takes a request without data, a transfer in the wrong direction stalls.
      std::byte nothing{};
      [[maybe_unused]] const ssize_t done = good ? read(control_file_, &nothing, 0) : write(control_file_, &nothing, 0);
    }
  }

  void read_packets() {
    std::array<std::uint8_t, kPacket> packet;
    while (!reader_.stopping()) {
      const ssize_t size = read(out_file_, packet.data(), packet.size());
      if (size < 0) {
        rest();
        continue;
      }
      const std::lock_guard lock(mutex_);
      heard_ = periods_;
      (void)port_.write(std::span(packet).first(static_cast<std::size_t>(size)));
    }
  }

  // The chip sends what it has at once for the event character, else its status alone after the latency.
  void write_packets() {
    constexpr unsigned kLatency = 16;
    std::array<std::uint8_t, kPacket> packet{0x01, 0x60};
    for (unsigned quiet = 0; !writer_.stopping();) {
      int size = 0;
      {
        const std::lock_guard lock(mutex_);
        size = port_.read(std::span(packet).subspan(kChip), std::chrono::milliseconds(0));
      }
      if (size <= 0 && ++quiet < kLatency * 10) {
        usleep(100);
        continue;
      }
      quiet = 0;
      const std::size_t bytes = kChip + static_cast<std::size_t>(std::max(size, 0));
      if (write(in_file_, packet.data(), bytes) < 0) rest();
    }
  }

  void tell() {
    const auto n = [](std::uint64_t number) { return static_cast<unsigned long long>(number); };
    const double force_N = norm(port_.force());
    if (force_N == 0 && pushes_ > 0)
      std::printf("zero period=%llu after=%llu silent=%llu\n", n(periods_), n(periods_ - told_), n(periods_ - heard_));
    pushes_ = force_N != 0 ? pushes_ + 1 : 0;
    if (pushes_ == kSteady) std::printf("force period=%llu\n", n(periods_));
    force_N_ = force_N;
    largest_N_ = std::fmax(largest_N_, force_N);
    if (port_.image_bytes() == 0 || port_.image_bytes() == image_ || port_.image_bytes() != last_image_) {
      last_image_ = port_.image_bytes();
      return;
    }
    image_ = port_.image_bytes();
    std::printf("image bytes=%zu\n", image_);
  }

  bool obey(const std::string& line) {
    if (line == "quit") return false;
    if (line == "unplug")
      gadget_.unbind();
    else if (line == "plug") {
      if (const std::string error = gadget_.bind(); !error.empty()) fail(error);
    } else {
      const std::lock_guard lock(mutex_);
      change(line);
    }
    std::printf("done %s\n", line.c_str());
    return true;
  }

  void change(const std::string& line) {
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string name = line.substr(0, space);
    const unsigned value = static_cast<unsigned>(std::strtoul(line.c_str() + space, nullptr, 10));
    const std::map<std::string, bool*> switches{{"mute", &port_.faults.mute},
                                                {"garbage", &port_.faults.garbage},
                                                {"cut", &port_.faults.cut_packets},
                                                {"twice", &port_.faults.twice}};
    if (name == "report")
      std::printf("report periods=%llu force_N=%g largest_N=%g image=%zu\n", static_cast<unsigned long long>(periods_),
                  force_N_, largest_N_, port_.image_bytes());
    else if (name == "homed")
      port_.faults.homed = static_cast<std::uint8_t>(value);
    else if (const auto found = switches.find(name); found != switches.end())
      *found->second = value != 0;
    else
      fail("unknown command '" + line + "'");
    if (name != "report") told_ = periods_;
  }

  std::mutex mutex_;
  hal::SimulatedFalconPort port_;
  ControlLines control_lines_;
  firmware::UsbGadget gadget_;
  int control_file_{-1}, in_file_{-1}, out_file_{-1};
  std::uint64_t periods_{0}, heard_{0}, told_{0}, pushes_{0};
  double force_N_{0}, largest_N_{0};
  std::size_t image_{0}, last_image_{0};
  bool hand_moves_{false};
  firmware::BoardThread control_, reader_, writer_;  // declared last: stopped before what they use is destroyed
};

int run(const Options& options) {
  const hal::HandModel hand = options.scene.empty() ? hal::HandModel() : hand_of(read_scene(options.scene), false);
  FalconBench bench(hand, options);
  return serve(bench, options.priority);
}

}  // namespace
}  // namespace tactus::vm

int main(int argc, char** argv) { return tactus::vm::run(tactus::vm::read_options(argc, argv)); }
