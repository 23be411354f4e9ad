// Instructions and stack of a control period on the target, over what a period can meet.
//
// Runs in QEMU with -icount shift=6: an instruction is 64 ns of the machine's time, 1.6 counts of its 25 MHz timer, so
// every single one shows. What it counts are instructions, not the cycles of a chip: those depend on its memory. The
// first thing measured is a loop whose count is known. Output: lines of `name typical worst`; of a sweep through the
// registers in place of the typical the operation and register of the worst. Status 2: a register was not written.
#include <algorithm>
#include <bit>

#include "firmware/boards/cortex_m/board_mechanics.h"
#include "firmware/boards/cortex_m/board_storage.h"
#include "firmware/boards/cortex_m/configuration.h"
#include "firmware/boards/cortex_m/serial_link.h"
#include "firmware/boards/cortex_m/startup.h"
#include "tests/firmware/boards/cortex_m/emulated/semihosting.h"

using namespace tactus::firmware;
using namespace tactus::firmware::cortex_m;

extern "C" {
extern BoardRegisters board_registers;
extern StorageMemory storage_memory;
}

namespace {

// CMSDK timer 0: counts down at the core's clock.
std::uint32_t timer() noexcept { return register_at(0x40000004u); }
void start_timer() noexcept {
  register_at(0x40000008u) = 0xffffffffu;
  register_at(0x40000000u) = 1;
}

// 64 ns an instruction, 40 ns a count.
std::uint32_t instructions_of(std::uint32_t counts) noexcept { return (counts * 5 + 4) / 8; }

struct NoPort {
  void transmit() noexcept {}
};
using Link = SerialLink<NoPort>;

// Six motors: the image's own device has three, and would be the cheaper case.
constexpr Config six_motors() noexcept {
  Config c = make_configuration();
  for (unsigned i = 3; i < kAxes; ++i) c.max_effort[i] = 1.0f;
  c.max_torque_Nm = 1.2f;
  return c;
}

struct Rig {
  PeriodClock clock;
  NoPort port;
  Link link{port};
  SysTickRegisters beat{};
  Device device{six_motors()};
  BoardMechanics mechanics{board_registers, clock, {10, 10, 10, 1, 1, 1}};
  BoardStorage storage{storage_memory};
  std::uint32_t sequence{0};
  std::uint32_t empty_counts{0};
  std::uint32_t random{1};
  std::size_t deepest{0};

  std::uint32_t next_random() noexcept { return random = random * 1664525u + 1013904223u; }

  void stuff_and_receive(std::span<const std::byte> frame) noexcept {
    std::array<std::byte, kMaxStuffedSize> line;
    const std::size_t size = stuff(frame, line);
    for (std::size_t i = 0; i < size; ++i) link.received(line[i]);
  }
  void command(State wanted, const AxisValues& effort, bool rearm = false, bool corrupt = false) noexcept {
    std::array<std::byte, kCommandFrameSize> frame;
    encode_command({wanted, rearm, ++sequence, effort}, frame);
    if (corrupt) frame.back() ^= std::byte{1};
    stuff_and_receive(frame);
  }
  void request(Operation operation, std::uint16_t address, std::uint32_t value) noexcept {
    std::array<std::byte, kServiceFrameSize> frame;
    encode_service(
        {.operation = operation, .status = ServiceStatus::kGood, .tag = 1, .address = address, .value = value},
        ServiceDirection::kRequest, frame);
    stuff_and_receive(frame);
  }
  void drain() noexcept {
    std::byte b{};
    while (link.next_to_send(b)) {}
  }

  // One control period, counted. Not inlined: its frame is where the stack below is measured from.
  [[gnu::noinline]] std::uint32_t period() noexcept {
    clock.tick();
    (void)clock.take_tick();
    std::uint32_t here;
    asm volatile("mov %0, sp" : "=r"(here));
    auto* const top = reinterpret_cast<std::uint32_t volatile*>(here);
    for (auto* word = top - 1; word >= stack_limit; --word) *word = kStackPaint;
    const std::uint32_t before = timer();
    run_period(device, mechanics, link, storage);
    const std::uint32_t after = timer();
    auto* word = const_cast<std::uint32_t volatile*>(stack_limit);
    while (word < top && *word == kStackPaint) ++word;
    deepest = std::max(deepest, static_cast<std::size_t>(top - word) * sizeof(std::uint32_t));
    drain();
    return instructions_of(before - after - empty_counts);
  }
};

void print(const char* text) noexcept {
  register std::uint32_t operation asm("r0") = 0x04;  // SYS_WRITE0
  register const char* parameter asm("r1") = text;
  asm volatile("bkpt 0xab" : "+r"(operation) : "r"(parameter) : "memory");
}
void print(std::uint32_t number) noexcept {
  std::array<char, 12> text{};
  char* first = &text.back();
  do *--first = static_cast<char>('0' + number % 10);
  while ((number /= 10) != 0);
  print(first);
}

std::uint32_t g_most = 0;  // over all that is printed as a period

void report(const char* name, std::uint32_t typical, std::uint32_t worst) noexcept {
  print(name);
  print(" ");
  print(typical);
  print(" ");
  print(worst);
  print("\n");
}

constexpr unsigned kPeriods = 200;
constexpr unsigned kLineBytes = kSerialBitRate_Hz / 10 / 1000;  // what the line can bring in a period of 1 ms

// `before_each(i)` prepares period i. Typical is the median.
template <class Prepare>
void scenario(Rig& rig, const char* name, Prepare&& before_each) noexcept {
  static std::array<std::uint16_t, kPeriods> counts;
  for (unsigned i = 0; i < kPeriods; ++i) {
    before_each(i);
    counts[i] = static_cast<std::uint16_t>(std::min<std::uint32_t>(rig.period(), 0xffff));
  }
  std::sort(counts.begin(), counts.end());
  g_most = std::max<std::uint32_t>(g_most, counts.back());
  report(name, counts[kPeriods / 2], counts.back());
}

[[gnu::noinline]] std::uint32_t known_loop(std::uint32_t rounds) noexcept {
  const std::uint32_t before = timer();
  asm volatile("1: subs %0, #1\n bne 1b" : "+r"(rounds) : : "cc");
  return instructions_of(before - timer());
}

void bring_to_force(Rig& rig) noexcept {
  for (int i = 0; i < 3; ++i) {
    rig.command(State::kIdle, {});
    (void)rig.period();
  }
  rig.command(State::kIdle, {}, true);
  (void)rig.period();
  for (int i = 0; i < 3; ++i) {
    rig.command(State::kForce, {});
    (void)rig.period();
  }
}

void noise(Rig& rig, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i) rig.link.received(static_cast<std::byte>(rig.next_random() >> 24));
}

void control_periods(Rig& rig) noexcept {
  constexpr AxisValues small{0.25f, 0.5f, 0.75f, 0.1f, 0.2f, 0.3f}, huge{90, -80, 70, 5, -6, 7};
  scenario(rig, "silent", [](unsigned) {});
  scenario(rig, "idle", [&](unsigned) { rig.command(State::kIdle, {}); });
  bring_to_force(rig);
  scenario(rig, "force", [&](unsigned) { rig.command(State::kForce, small); });
  scenario(rig, "force_limited", [&](unsigned) { rig.command(State::kForce, huge); });
  scenario(rig, "force_fading", [&](unsigned i) {
    if (i % 9 == 0) rig.command(State::kForce, huge);
  });
  scenario(rig, "frame_corrupt", [&](unsigned i) { rig.command(State::kForce, huge, false, i % 9 != 0); });
  scenario(rig, "two_commands", [&](unsigned) {
    rig.command(State::kForce, huge);
    rig.command(State::kForce, huge);
  });
  scenario(rig, "with_request", [&](unsigned i) {
    rig.command(State::kForce, huge);
    rig.request(Operation::kRead, static_cast<std::uint16_t>(i), 0);
  });
  scenario(rig, "line_noise", [&](unsigned) { noise(rig, kLineBytes); });
  scenario(rig, "emergency_stop", [&](unsigned i) {
    board_registers.pins = i % 2 == 0 ? kPinSupplyGood : kPinSupplyGood | kPinStopReleased;
    rig.command(State::kForce, huge, i % 2 == 1);
  });
  board_registers.pins = kPinSupplyGood | kPinStopReleased;
}

// The parts around the controller that are off by default: the arm's weight with every term, thermal model, filter.
void switch_everything_on(Rig& rig) noexcept {
  const auto write = [&](unsigned address, float value) {
    const ServiceMessage reply = rig.device.serve({.operation = Operation::kWrite,
                                                   .status = ServiceStatus::kGood,
                                                   .tag = 0,
                                                   .address = static_cast<std::uint16_t>(address),
                                                   .value = std::bit_cast<std::uint32_t>(value)});
    if (reply.status != ServiceStatus::kGood) exit_emulator(2);
  };
  rig.command(State::kIdle, {});
  (void)rig.period();
  constexpr std::uint32_t every_axis = kMaxCombination;
  for (unsigned term = 0; term < kAxes * kGravityTerms; ++term) {
    write(number::kGravityAmplitude + term, 0.01f);
    write(number::kGravityCombination + term, std::bit_cast<float>(every_axis - term));
  }
  for (unsigned axis = 0; axis < kAxes; ++axis) {
    write(number::kThermalGain + axis, 1e-3f);
    write(number::kThermalTime + axis, 10.0f);
    write(number::kThermalWarning + axis, 50.0f);
    write(number::kThermalLimit + axis, 100.0f);
  }
  write(number::kSpeedCorner, 100.0f);
}

void everything_on(Rig& rig) noexcept {
  constexpr AxisValues huge{90, -80, 70, 5, -6, 7};
  switch_everything_on(rig);
  bring_to_force(rig);
  scenario(rig, "all_parts", [&](unsigned) { rig.command(State::kForce, huge); });
  scenario(rig, "all_and_request", [&](unsigned i) {
    rig.command(State::kForce, huge);
    rig.request(Operation::kRead, static_cast<std::uint16_t>(i), 0);
  });
  scenario(rig, "all_and_noise", [&](unsigned) {
    rig.link.received(std::byte{0});  // ends the noise before
    rig.command(State::kForce, huge);
    rig.request(Operation::kRead, number::kSerial, 0);
    noise(rig, kLineBytes - 1 - (kCommandFrameSize + 2) - (kServiceFrameSize + 2));
  });
}

// Every register, every operation, with values wild and tame. In FORCE most writes are refused, in IDLE they act.
void service_sweep(Rig& rig, State wanted) noexcept {
  constexpr unsigned last_address = 0x8ff;
  std::uint32_t most = 0, at_most = 0;
  for (unsigned operation = 1; operation <= 3; ++operation)
    for (unsigned address = 0; address <= last_address; ++address) {
      rig.command(wanted, {90, -80, 70, 5, -6, 7}, address % 8 == 0);
      const std::uint32_t value = address % 2 == 0 ? rig.next_random() : std::bit_cast<std::uint32_t>(1.0f);
      rig.request(static_cast<Operation>(operation), static_cast<std::uint16_t>(address), value);
      const std::uint32_t count = rig.period();
      if (count > most) {
        most = count;
        at_most = operation << 16 | address;
      }
    }
  g_most = std::max(g_most, most);
  report(wanted == State::kForce ? "sweep_in_force" : "sweep_in_idle", at_most, most);
}

// Beside the period: what the interrupt handlers spend on a byte, without the core's own entry and return.
void bytes(Rig& rig) noexcept {
  rig.drain();
  constexpr std::uint32_t count = 64;
  std::uint32_t before = timer();
  for (std::uint32_t i = 0; i < count; ++i) rig.link.received(std::byte{0});
  const std::uint32_t receive = instructions_of(before - timer()) / count;
  (void)rig.period();
  rig.link.send_state(std::span<const std::byte>(std::array<std::byte, kMaxFrameSize>{}));
  before = timer();
  std::byte b{};
  for (std::uint32_t i = 0; i < count; ++i) (void)rig.link.next_to_send(b);
  report("byte_received_sent", receive, instructions_of(before - timer()) / count);
}

}  // namespace

extern "C" {

[[noreturn]] void stop_after_fault(const std::uint32_t*) {
  constexpr std::uint32_t fault_status = 99;
  exit_emulator(fault_status);
}

int main() {
  start_timer();
  constexpr std::uint32_t rounds = 10'000;
  const std::uint32_t once = known_loop(rounds), twice = known_loop(2 * rounds);
  report("known_loop", once, twice);
  if (twice - once < 2 * rounds - 1 || twice - once > 2 * rounds + 1) exit_emulator(1);

  static Rig rig;
  board_registers.pins = kPinSupplyGood | kPinStopReleased;
  (void)rig.clock.start(rig.beat, 25'000'000, six_motors().period_us);
  const std::uint32_t before = timer();
  rig.empty_counts = before - timer();
  control_periods(rig);
  everything_on(rig);
  service_sweep(rig, State::kForce);
  service_sweep(rig, State::kIdle);
  bytes(rig);
  report("period", 0, g_most);
  report("stack", 0, static_cast<std::uint32_t>(rig.deepest));
  exit_emulator(0);
}
}
