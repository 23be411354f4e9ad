// Logs events of a run as readable lines, also for journald: a level, a name, fields.
//
//   <4>overruns count=12 total=310 suppressed=4
// The level precedes the line in journald's format if standard error goes to a journal; otherwise it is omitted. The
// same event is logged at most once per interval; suppressed ones are counted in the next. Thread: one, normal;
// never the haptic thread. Time comes from the caller. Bound: one line per event; values with blanks are quoted.
#pragma once

#include <cstdio>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>

namespace tactus::service {

enum class LogLevel : int { kError = 3, kWarning = 4, kNotice = 5, kInfo = 6 };  // of syslog(3)

class EventLog {
 public:
  using Fields = std::initializer_list<std::pair<const char*, std::string>>;

  EventLog(std::FILE* out, bool with_level, double interval_s)
      : out_(out), with_level_(with_level), interval_s_(interval_s) {}

  // Rate-limited by its name.
  void event(LogLevel level, const std::string& name, Fields fields, double now_s);
  void set_interval(double interval_s) { interval_s_ = interval_s; }
  // Of several hands: the number of the one that the events are of, a field of every line.
  void set_hand(unsigned number) { hand_ = number; }

  // True if standard error goes to a journal, as reported by systemd.
  static bool to_journal();

 private:
  struct Seen {
    double last_s{0};
    unsigned long suppressed{0};
  };
  std::FILE* out_;
  bool with_level_;
  double interval_s_;
  unsigned hand_{0};  // 0: there is one
  std::map<std::string, Seen> seen_;
};

}  // namespace tactus::service
