// The program of every test: Catch2's own, and a watch over the threads that a case starts. The thread sanitizer sees
// only what threads do, so its build runs only the cases tagged [threads] (tests/CMakeLists.txt): a case that starts a
// thread without the tag would be left out unnoticed, so this program fails.
#include <dlfcn.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>

#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

namespace {

std::atomic<int> threads_started{0};
int cases_without_tag = 0;

struct ThreadWatch : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;

  void testCaseStarting(const Catch::TestCaseInfo& info) override {
    TestEventListenerBase::testCaseStarting(info);
    threads_started = 0;
  }
  void testCaseEnded(const Catch::TestCaseStats& stats) override {
    TestEventListenerBase::testCaseEnded(stats);
    const auto& tags = stats.testInfo.lcaseTags;
    if (threads_started == 0 || std::find(tags.begin(), tags.end(), "threads") != tags.end()) return;
    ++cases_without_tag;
    std::fprintf(stderr, "%s:%zu: '%s' starts threads: add the tag [threads], so that the thread sanitizer runs it\n",
                 stats.testInfo.lineInfo.file, stats.testInfo.lineInfo.line, stats.testInfo.name.c_str());
  }
};
CATCH_REGISTER_LISTENER(ThreadWatch)

}  // namespace

// The sanitizers have one of their own.
#if !TACTUS_SANITIZED
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) noexcept {
  static const auto next = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  if (next == nullptr) std::abort();
  ++threads_started;
  return next(thread, attributes, start, argument);
}
#endif

int main(int argc, char** argv) {
  const int status = Catch::Session().run(argc, argv);
  return status == 0 && cases_without_tag > 0 ? 1 : status;
}
