#include "tests/firmware/boards/cortex_m/emulated/emulated_device.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "firmware/boards/cortex_m/startup.h"

namespace tactus::firmware::cortex_m {
namespace {

// PSRAM of mps2-an386.
constexpr std::uint32_t kMemoryAddress = 0x21000000;
constexpr std::size_t kMemorySize = 16u << 20;
constexpr int kSilence_ms = 20'000, kManyFrames = 3000;
constexpr std::uint64_t kStoodStill_us = 5000;

[[noreturn]] void become_emulator(const char* image, const std::string& memory, int line) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const std::string serial = "socket,id=line,fd=" + std::to_string(line);
  execlp("qemu-system-arm", "qemu-system-arm", "-M", "mps2-an386,memory-backend=psram", "-object", memory.c_str(),
         "-display", "none", "-monitor", "none", "-chardev", serial.c_str(), "-serial", "chardev:line", "-kernel",
         image, static_cast<char*>(nullptr));
  _exit(127);
}

}  // namespace

EmulatedDevice::EmulatedDevice(const char* image, const char* memory_file, std::span<char*> symbols) {
  for (std::size_t i = 0; i < kSymbols.size(); ++i) {
    const std::string prefix = std::string(kSymbols[i]) + "=";
    for (const char* text : symbols)
      if (std::strncmp(text, prefix.c_str(), prefix.size()) == 0)
        addresses_[i] = static_cast<std::uint32_t>(std::strtoul(text + prefix.size(), nullptr, 16));
    if (addresses_[i] < kMemoryAddress || addresses_[i] >= kMemoryAddress + kMemorySize)
      throw Failure("no address in the shared memory for " + std::string(kSymbols[i]));
  }

  const int file = open(memory_file, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0 || ftruncate(file, static_cast<off_t>(kMemorySize)) != 0)
    throw Failure("cannot make " + std::string(memory_file) + ": " + std::strerror(errno));
  void* const memory = mmap(nullptr, kMemorySize, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (memory == MAP_FAILED) throw Failure("cannot map " + std::string(memory_file) + ": " + std::strerror(errno));
  memory_ = static_cast<std::byte*>(memory);

  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) throw Failure("no socket pair");
  line_ = ends[0];
  fcntl(line_, F_SETFD, FD_CLOEXEC);
  const std::string backend = "memory-backend-file,id=psram,size=16M,share=on,mem-path=" + std::string(memory_file);
  emulator_ = fork();
  if (emulator_ == 0) become_emulator(image, backend, ends[1]);
  close(ends[1]);
  if (emulator_ < 0) throw Failure("cannot start an emulator");
}

EmulatedDevice::~EmulatedDevice() {
  if (emulator_ > 0) {
    kill(emulator_, SIGKILL);
    waitpid(emulator_, nullptr, 0);
  }
  if (line_ >= 0) close(line_);
  if (memory_ != nullptr) munmap(memory_, kMemorySize);
}

std::byte* EmulatedDevice::at(Symbol symbol) const {
  return memory_ + (addresses_[static_cast<std::size_t>(symbol)] - kMemoryAddress);
}

std::size_t EmulatedDevice::stack_size() const {
  return static_cast<std::size_t>(at(Symbol::kStackTop) - at(Symbol::kStackLimit));
}

std::size_t EmulatedDevice::stack_high_water() const {
  const auto* const first = reinterpret_cast<const std::uint32_t volatile*>(at(Symbol::kStackLimit));
  const std::size_t words = stack_size() / sizeof(std::uint32_t);
  std::size_t untouched = 0;
  while (untouched < words && first[untouched] == kStackPaint) ++untouched;
  return (words - untouched) * sizeof(std::uint32_t);
}

void EmulatedDevice::send_bytes(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(line_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) throw Failure("the emulator has ended");
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
}

void EmulatedDevice::send_frame(std::span<const std::byte> frame) {
  std::array<std::byte, kMaxStuffedSize> line{};
  send_bytes(std::span<const std::byte>(line).first(stuff(frame, line)));
}

// False where none comes in time.
bool EmulatedDevice::read_frame(int timeout_ms) {
  for (;;) {
    while (begin_ < end_)
      if (reader_.accept(incoming_[begin_++])) return true;
    pollfd waiting{line_, POLLIN, 0};
    if (poll(&waiting, 1, timeout_ms) <= 0) return false;
    const ssize_t size = recv(line_, incoming_.data(), incoming_.size(), 0);
    if (size <= 0) throw Failure("the emulator has ended");
    begin_ = 0;
    end_ = static_cast<std::size_t>(size);
  }
}

StateFrame EmulatedDevice::read_state() {
  for (;;) {
    if (!read_frame(kSilence_ms)) throw Failure("the device sends nothing");
    StateFrame state;
    if (decode_state(reader_.frame(), state) == DecodeError::kNone) return state;
    if (decode_service(reader_.frame(), ServiceDirection::kReply, reply_) == DecodeError::kNone) replied_ = true;
  }
}

StateFrame EmulatedDevice::next_state() {
  const StateFrame state = read_state();
  const bool restarted = state.sequence < state_sequence_;
  const bool stood_still = state_sequence_ != 0 && state.time_us - time_us_ > kStoodStill_us;
  state_sequence_ = state.sequence;
  time_us_ = state.time_us;
  echoed_ = state.echoed_sequence;
  ++states_since_command_;
  if (restarted || stood_still) throw StoodStill();
  return state;
}

StateFrame EmulatedDevice::turn(State wanted, const AxisValues& effort, bool rearm) {
  const StateFrame state = next_state();
  constexpr int lost = 20;  // states without an echo: the command did not come through
  if (command_was_taken() || states_since_command_ > lost) {
    std::array<std::byte, kCommandFrameSize> frame{};
    encode_command({wanted, rearm, ++sequence_, effort}, frame);
    send_frame(frame);
    states_since_command_ = 0;
  }
  return state;
}

void EmulatedDevice::await(const std::function<bool(const StateFrame&)>& holds, const char* otherwise) {
  for (int i = 0; i < kManyFrames; ++i)
    if (holds(next_state())) return;
  throw Failure(otherwise);
}

void EmulatedDevice::forget_waiting() {
  StateFrame state;
  while (read_frame(0))
    if (decode_state(reader_.frame(), state) == DecodeError::kNone) {
      state_sequence_ = state.sequence;
      time_us_ = state.time_us;
      echoed_ = state.echoed_sequence;
    }
}

void EmulatedDevice::await_fault() {
  for (int looks = 0; looks < kSilence_ms; ++looks) {
    if (registers().fault_program_count != 0) return;
    poll(nullptr, 0, 1);
  }
  throw Failure("no fault");
}

bool EmulatedDevice::stands_still_soon() try {
  constexpr int frames = 30;
  for (int i = 0; i < frames; ++i) (void)next_state();
  return false;
} catch (const StoodStill&) { return true; } catch (const Failure&) {
  return false;
}

void EmulatedDevice::await_restart() {
  for (int i = 0; i < kManyFrames; ++i) {
    const std::uint32_t before = state_sequence_;
    const StateFrame state = read_state();
    state_sequence_ = state.sequence;
    time_us_ = state.time_us;
    echoed_ = state.echoed_sequence;
    if (state.sequence < before) return;
  }
  throw Failure("the device does not restart");
}

ServiceMessage EmulatedDevice::ask(Operation operation, std::uint16_t address, std::uint32_t value) {
  replied_ = false;
  std::array<std::byte, kServiceFrameSize> frame{};
  encode_service(
      {.operation = operation, .status = ServiceStatus::kGood, .tag = ++tag_, .address = address, .value = value},
      ServiceDirection::kRequest, frame);
  send_frame(frame);
  for (int i = 0; i < kManyFrames; ++i) {
    (void)next_state();
    if (replied_ && reply_.tag == tag_) return reply_;
  }
  throw Failure("no reply to a request");
}

}  // namespace tactus::firmware::cortex_m
