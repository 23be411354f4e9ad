#include "firmware/boards/linux/board_thread.h"

#include <sched.h>
#include <signal.h>
#include <time.h>

#include <cstring>

namespace tactus::firmware {
namespace {

constexpr std::size_t kStackBytes = 64 * 1024;

int wake_signal() noexcept { return SIGRTMIN + 3; }
void do_nothing(int) {}

}  // namespace

void* BoardThread::run(void* self) noexcept {
  auto* thread = static_cast<BoardThread*>(self);
  thread->body_(thread->context_);
  thread->ended_.store(true, std::memory_order_release);
  return nullptr;
}

std::string BoardThread::start(Body body, void* context, int priority) {
  struct sigaction action {};
  action.sa_handler = &do_nothing;  // without SA_RESTART: the call returns EINTR
  sigaction(wake_signal(), &action, nullptr);

  body_ = body;
  context_ = context;
  stopping_.store(false);
  ended_.store(false);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  const int error = pthread_create(&thread_, &attributes, &run, this);
  pthread_attr_destroy(&attributes);
  if (error != 0) return std::string("no thread for the link: ") + std::strerror(error);
  started_ = true;
  sched_param parameters{};
  parameters.sched_priority = priority;
  realtime_ = priority > 0 && pthread_setschedparam(thread_, SCHED_FIFO, &parameters) == 0;
  return "";
}

void BoardThread::stop() noexcept {
  if (!started_) return;
  request_stop();
  while (!ended_.load(std::memory_order_acquire)) {
    pthread_kill(thread_, wake_signal());
    const timespec pause{0, 1'000'000};
    nanosleep(&pause, nullptr);
  }
  pthread_join(thread_, nullptr);
  started_ = false;
}

}  // namespace tactus::firmware
