// Events of a run as lines for people and for journald: a level, a name, fields.
//
//   <4>overruns count=12 total=310 suppressed=4
// The level stands in front as journald takes it, where standard error goes to a journal; else it is left out. The
// same event comes at most once in an interval; what was held back is counted into the next one. Thread: one, normal;
// never the haptic thread. Time comes from the caller. Bound: one line an event, values quoted where they have blanks.
#pragma once

#include <cstdio>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>

namespace tactus::service {

enum class Level : int { kError = 3, kWarning = 4, kNotice = 5, kInfo = 6 };  // of syslog(3)

class EventLog {
 public:
  using Fields = std::initializer_list<std::pair<const char*, std::string>>;

  EventLog(std::FILE* out, bool with_level, double interval_s)
      : out_(out), with_level_(with_level), interval_s_(interval_s) {}

  // Rate-limited by its name.
  void event(Level level, const std::string& name, Fields fields, double now_s);
  void set_interval(double interval_s) { interval_s_ = interval_s; }

  // Standard error goes to a journal (systemd says so).
  static bool to_journal();

 private:
  struct Seen {
    double last_s{0};
    unsigned long suppressed{0};
  };
  std::FILE* out_;
  bool with_level_;
  double interval_s_;
  std::map<std::string, Seen> seen_;
};

}  // namespace tactus::service
