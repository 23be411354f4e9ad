// The suite's exchange with the device: one frame in and one out per period, on a thread like the haptic loop's. Every
// period gives a record; a normal thread evaluates the records.
//
// The commands follow a plan of phases, each for a number of ticks or until the director ends it. The director receives
// every record in order and may request the next phase or the end. In stepped mode (a link without a clock) one thread
// does both, tick by tick, and times are multiples of the period.
// Thread: run() normal; ExchangeTick [rt]: no allocation, no lock; it pushes records into a ring of fixed size; records
// that do not fit are counted. Units in the names.
#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include "hal/any_link.h"
#include "hal/frame_codec.h"
#include "rt/base/ring.h"
#include "rt/thread/periodic_thread.h"

namespace tactus::hil {

enum class Got : std::uint8_t { kNothing = 0, kFresh = 1, kCorrupt = 2, kDisconnected = 3 };
enum class Sent : std::uint8_t { kNotTried = 0, kTaken = 1, kRefused = 2 };

// Record of one period. `state` is the newest whole frame, of this tick where `got` is kFresh.
struct Record {
  std::uint64_t tick{0};
  std::int64_t now_ns{0}, arrival_ns{0}, sent_ns{0};  // CLOCK_MONOTONIC, or periods in stepped mode
  std::uint32_t superseded{0};                        // frames that this one replaced
  std::uint32_t command{0};                           // sequence of the command of this tick; 0: none
  std::uint32_t phase{0};
  Got got{Got::kNothing};
  Sent sent{Sent::kNotTried};
  firmware::StateFrame state;
  Vec3d position_m;  // of the tool, device frame, from the newest whole frame
};
static_assert(std::is_trivially_copyable_v<Record>);

enum class Harm : std::uint8_t { kNone = 0, kBrokenCrc = 1, kNotFinite = 2, kRepeated = 3 };

// Commands of one phase.
struct ExchangePhase {
  std::uint64_t ticks{0};  // 0: until the director ends the phase
  firmware::State wanted{firmware::State::kIdle};
  bool send{true};
  bool rearm{false};  // the flag rises in the phase's third tick: the device acts on the rise
  Harm harm{Harm::kNone};
  Vec3d force_N{};  // device frame, at the tool
};

enum class Next { kGoOn, kNextPhase, kStop };
using Director = std::function<Next(const Record&)>;

struct ExchangeSettings {
  std::int64_t period_ns{1'000'000};
  bool stepped{false};
  loop::SetupRequest setup;
};

// Sequence numbers and codec state, kept from one exchange to the next.
struct Conversation {
  hal::FrameCodec codec;
  std::uint64_t command_sequence{0};
  firmware::StateFrame state;
  haptics::DeviceSample sample;
};

// The haptic thread's side.
class ExchangeTick {
 public:
  ExchangeTick(hal::AnyLink& link, Conversation& conversation, std::span<const ExchangePhase> plan,
               std::int64_t period_ns, bool stepped);

  bool operator()(const loop::TickTiming& timing) noexcept;

  Ring& records() noexcept { return records_; }
  // Counters of the link as of the last period; before the first period those given here.
  void begin_with(const hal::LinkCounters& counters) noexcept { counters_ = counters; }
  const hal::LinkCounters& counters() const noexcept { return counters_; }
  void ask_for_phase(std::uint32_t phase) noexcept { asked_phase_.store(phase, std::memory_order_relaxed); }

 private:
  void receive(Record& record) noexcept;
  void send(const ExchangePhase& phase, Record& record) noexcept;
  bool advance() noexcept;
  std::int64_t now_ns() const noexcept;

  hal::AnyLink& link_;
  Conversation& conversation_;
  std::span<const ExchangePhase> plan_;
  std::int64_t period_ns_;
  bool stepped_;
  std::uint64_t tick_{0}, phase_began_{0};
  std::uint32_t phase_{0};
  std::atomic<std::uint32_t> asked_phase_{0};
  std::array<std::byte, firmware::kCommandFrameSize> last_command_{};
  hal::LinkCounters counters_;
  Ring records_;
};

struct ExchangeResult {
  std::vector<Record> records;       // empty unless `keep`
  std::uint64_t dropped_records{0};  // lost because the ring was full; above 0 the figures are invalid
  hal::LinkCounters counters;        // of this exchange
  loop::SetupReport setup;           // real time only
  loop::TimingHealth timing;
};

// Runs the plan to its end. `keep`: returns the records. Errors: of the operating system or the link.
Result<ExchangeResult> run_exchange(hal::AnyLink& link, Conversation& conversation, const ExchangeSettings& settings,
                                    std::span<const ExchangePhase> plan, const Director& director = {},
                                    bool keep = true);

}  // namespace tactus::hil
