#include "rt/thread/realtime_thread.h"

#include <pthread.h>
#include <signal.h>

#include <catch2/catch.hpp>
#include <thread>

using namespace tactus;
using namespace tactus::loop;

namespace {

constexpr SetupRequest kModest{
    .cpu = -1, .priority = 0, .lock_memory = false, .hold_cpu_awake = false, .stack_KiB = 16};
constexpr std::uint32_t kStack_KiB = 256;

// The body of a thread: records what it finds, and ends when `may_end` is set.
struct Visit {
  std::atomic<bool> may_end{false}, began{false};
  bool own_thread{false}, signals_blocked{false}, set_up{false}, runs{false};
  std::size_t stack_bytes{0};
  const RealtimeThread* thread{nullptr};
  std::thread::id caller{std::this_thread::get_id()};

  static void body(void* context) noexcept {
    Visit& v = *static_cast<Visit*>(context);
    v.own_thread = std::this_thread::get_id() != v.caller;
    sigset_t blocked;
    pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
    v.signals_blocked = sigismember(&blocked, SIGINT) == 1 && sigismember(&blocked, SIGTERM) == 1;
    v.set_up = v.thread->report().find("denormals") != nullptr && denormals_flushed();
    v.runs = v.thread->running();
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) == 0) {
      pthread_attr_getstacksize(&attributes, &v.stack_bytes);
      pthread_attr_destroy(&attributes);
    }
    v.began = true;
    while (!v.may_end) std::this_thread::yield();
  }
};

}  // namespace

TEST_CASE("a real-time thread runs its body once, set up, with signals blocked, on the stack asked for",
          "[loop][threads]") {
  RealtimeThread thread;
  Visit visit;
  visit.thread = &thread;
  CHECK_FALSE(thread.started());
  CHECK_FALSE(thread.running());
  REQUIRE(thread.start(kStack_KiB, kModest, &Visit::body, &visit).ok());
  CHECK(thread.report().degraded());  // no privilege was asked for
  while (!visit.began) std::this_thread::yield();
  CHECK((thread.started() && thread.running()));
  CHECK_FALSE(thread.start(kStack_KiB, kModest, &Visit::body, &visit).ok());
  visit.may_end = true;
  while (thread.running()) std::this_thread::yield();
  CHECK(thread.started());  // it ended, and nobody has joined it
  CHECK_FALSE(thread.start(kStack_KiB, kModest, &Visit::body, &visit).ok());
  thread.join();
  CHECK_FALSE(thread.started());
  CHECK((visit.own_thread && visit.signals_blocked && visit.set_up && visit.runs));
  CHECK(visit.stack_bytes >= kStack_KiB * 1024);
  sigset_t blocked;
  pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
  CHECK(sigismember(&blocked, SIGINT) == 0);  // the caller's are as they were
}

TEST_CASE("a thread that was joined starts again, and one that never started joins at once", "[loop][threads]") {
  RealtimeThread thread;
  thread.join();
  int calls = 0;
  for (int round = 1; round <= 3; ++round) {
    REQUIRE(thread
                .start(
                    kStack_KiB, kModest, [](void* count) noexcept { ++*static_cast<int*>(count); }, &calls)
                .ok());
    thread.join();
    CHECK(calls == round);
  }
}

TEST_CASE("a real-time thread that goes waits for its body", "[loop][threads]") {
  bool ended = false;
  {
    RealtimeThread thread;
    REQUIRE(thread
                .start(
                    kStack_KiB, kModest,
                    [](void* flag) noexcept {
                      for (int i = 0; i < 1000; ++i) std::this_thread::yield();
                      *static_cast<bool*>(flag) = true;
                    },
                    &ended)
                .ok());
  }
  CHECK(ended);
}
