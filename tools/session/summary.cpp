#include "tools/session/summary.h"

#include <fmt/format.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "hal/device_words.h"
#include "hal/host_faults.h"
#include "hal/printable.h"
#include "sim/model/choice_names.h"
#include "tools/version/version.h"

namespace tactus::session {
namespace {

using nlohmann::json;

double us(std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; }
double percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}
double mean_force_N(const RunSummary& s) {
  return s.stats.ticks == 0 ? 0.0 : s.stats.force_sum_N / static_cast<double>(s.stats.ticks);
}
double mean_sub_steps(const RunSummary& s) {
  return s.stats.ticks == 0 ? 0.0 : static_cast<double>(s.stats.sub_steps_sum) / static_cast<double>(s.stats.ticks);
}
std::string times_line(const char* name, const Histogram& h) {
  return fmt::format("  {:<22} p50 {:>7.1f}   p99 {:>7.1f}   p99.99 {:>7.1f}   max {:>8.1f} µs\n", name,
                     us(h.percentile_ns(50)), us(h.percentile_ns(99)), us(h.percentile_ns(99.99)), us(h.max_ns()));
}

json times_json(const Histogram& h) {
  return {{"count", h.count()},
          {"mean_us", h.mean_ns() * 1e-3},
          {"p50_us", us(h.percentile_ns(50))},
          {"p99_us", us(h.percentile_ns(99))},
          {"p99_99_us", us(h.percentile_ns(99.99))},
          {"max_us", us(h.max_ns())}};
}

std::string core_name(int cpu) { return cpu < 0 ? "all cores" : fmt::format("core {}", cpu); }

std::string timing_text(const RunSummary& s) {
  if (!s.real_time)
    return "timing                 virtual time: no clock was read; the time of a global step is predicted from its "
           "counts\n";
  const auto& t = s.timing;
  std::string text = "timing\n";
  text += times_line("wake-up", t.wake_latency);
  text += times_line("execution", t.execution);
  text += times_line("  compute", s.compute);
  text += times_line(s.simulated() ? "  simulated device" : "  device", s.device);
  text += fmt::format(
      "  {:<22} {} of {} ticks; cause: late wake-up {}, interrupted {}, own work {}; {} deadlines skipped\n",
      "overruns", t.overruns, t.ticks, s.overruns_late_wake, s.overruns_interrupted, s.overruns_own_work,
      t.skipped_ticks);
  text += fmt::format("  {:<22} {} minor, {} major page faults; {} involuntary context switches\n", "haptic thread",
                      t.minor_faults, t.major_faults, t.involuntary_switches);
  // Not part of the verdict, but the first cause to check when wake-ups are late.
  if (s.stolen_share.value_or(0) > 0)
    text += fmt::format("  {:<22} {:.2f} % of the time of {}, taken by this machine's host (the machine)\n", "stolen",
                        100 * *s.stolen_share, core_name(s.haptic_cpu));
  return text;
}

std::uint64_t ticks_with(const RunSummary& s, StatusBit bit) {
  return s.stats.status_ticks[std::countr_zero(static_cast<std::uint32_t>(bit))];
}

double ratio_percentile(const RunSummary& s, double percent) {
  return 1e-3 * static_cast<double>(s.cost_prediction.measured_permille.percentile_ns(percent));
}

// The governor's choices, and the error of its predicted tick times.
std::string governor_text(const RunSummary& s) {
  std::string text =
      fmt::format("  {:<22} {} ticks with fewer sub-steps, {} cut at a sweep; {} cycles with fewer members\n",
                  "governor", ticks_with(s, kSubStepsReduced), ticks_with(s, kSolverCut), s.stats.restrained_cycles);
  if (s.real_time)
    text += fmt::format(
        "  {:<22} predicted p50 {:.1f}, p99 {:.1f} µs; measured / predicted p50 {:.2f}, p99 {:.2f}; {:.2f} % above\n",
        "cost model", us(s.cost_prediction.predicted_ns.percentile_ns(50)),
        us(s.cost_prediction.predicted_ns.percentile_ns(99)), ratio_percentile(s, 50), ratio_percentile(s, 99),
        percent(s.cost_prediction.above, s.stats.ticks));
  return text;
}

json governor_json(const RunSummary& s) {
  json object{{"ticks_with_fewer_sub_steps", ticks_with(s, kSubStepsReduced)},
              {"ticks_cut_at_a_sweep", ticks_with(s, kSolverCut)},
              {"cycles_with_fewer_members", s.stats.restrained_cycles}};
  if (!s.real_time) return object;
  const loop::CostModel& c = s.calibration.cost;
  object["calibration"] = {{"scale", s.calibration.scale},
                           {"spread", s.calibration.spread},
                           {"fixed_ns", c.fixed},
                           {"per_body_ns", c.per_body},
                           {"per_pair_ns", c.per_pair},
                           {"per_search_ns", c.per_search},
                           {"per_contact_ns", c.per_contact},
                           {"per_border_contact_ns", c.per_border},
                           {"per_body_sub_step_ns", c.per_body_sub_step},
                           {"per_contact_sub_step_ns", c.per_contact_sub_step},
                           {"per_point_sub_step_ns", c.per_point_sub_step},
                           {"per_border_contact_sub_step_ns", c.per_border_sub_step},
                           {"synchronisation_ns", c.synchronisation},
                           {"per_border_contact_synchronised_ns", c.per_border_synchronised},
                           {"per_join_ns", c.per_join}};
  object["predicted"] = times_json(s.cost_prediction.predicted_ns);
  object["measured_over_predicted"] = {{"p50", ratio_percentile(s, 50)},
                                       {"p99", ratio_percentile(s, 99)},
                                       {"ticks_above", s.cost_prediction.above},
                                       {"percent_above", percent(s.cost_prediction.above, s.stats.ticks)}};
  return object;
}

std::string global_text(const RunSummary& s) {
  if (!s.has_global) return "global world           none: direct coupling, the whole world runs at the haptic rate\n";
  std::string text = "global world\n";
  if (s.global_step.count() > 0) text += times_line("step", s.global_step);
  text +=
      fmt::format("  {:<22} {} cycles of {} ticks; {} late, the longest {} ticks; clock dilated by {:.0f} ms\n",
                  "exchange", s.stats.cycles, s.ratio, s.stats.late_cycles, s.stats.cycle_ticks_max, s.dilation_ms());
  text += fmt::format("  {:<22} {} bodies, at most {} contacts; deepest overlap {:.3f} mm\n", "size", s.global.bodies,
                      s.global.most_contacts, 1e3 * s.global.deepest_m);
  const sim::EnergyBalance& balance = s.global.energy;
  text += balance.complete
              ? fmt::format("  {:<22} at most {:.4f} J of motion; {:.4f} J put in by the hand; {:.4f} J unexplained\n",
                            "energy", balance.most_kinetic_J, balance.work_in_J, balance.unexplained_J)
              : fmt::format("  {:<22} not judged: more than gravity and the hand does work here\n", "energy");
  if (s.global.broken_joints > 0) text += fmt::format("  {:<22} {} broken\n", "joints", s.global.broken_joints);
  if (s.global.asleep > 0 || s.global.fell_asleep > 0)
    text += fmt::format("  {:<22} {} bodies awake, at most {}; {} asleep; {} fell asleep, {} woke up\n", "sleeping",
                        s.global.awake, s.global.most_awake, s.global.asleep, s.global.fell_asleep, s.global.woke_up);
  if (s.global.resets > 0) text += fmt::format("  {:<22} {} times\n", "scene reset", s.global.resets);
  text += fmt::format("  {:<22} component of the proxy at most {} bodies; {} joins, {} leaves\n", "contact graph",
                      s.stats.component_max, s.global.joins, s.global.leaves);
  if (s.options.hands > 1)
    text += fmt::format("  {:<22} {} bodies from one sub-world to another\n", "handed over", s.global.handed_over);
  return text;
}

// Counts of all state frames that the device numbered and of all commands, by outcome.
std::string link_text(const RunSummary& s) {
  if (!s.link) return {};
  const hal::LinkCounters& link = s.link->link;
  const hal::LinkedDeviceCounters& reads = s.link->reads;
  std::string text = fmt::format("device                 {}\n", s.device_identity);
  text +=
      fmt::format("  {:<22} {} received: {} fresh, {} superseded, {} corrupt; {} malformed, {} lost\n", "state frames",
                  link.received, reads.fresh, reads.superseded, reads.corrupt, link.malformed, s.link->lost);
  text +=
      fmt::format("  {:<22} {} without a new frame, {} without a device\n", "ticks", reads.missing, reads.disconnected);
  text += fmt::format("  {:<22} {} sent, {} superseded, {} failed\n", "command frames", link.sent, link.send_superseded,
                      link.send_failed);
  text += fmt::format("  {:<22} {} errors, {} disconnects\n", "link", link.errors, link.disconnects);
  return text + times_line("age of the force", s.link->force_age);
}

json link_json(const RunSummary& s) {
  const hal::LinkCounters& link = s.link->link;
  const hal::LinkedDeviceCounters& reads = s.link->reads;
  return {{"identity", s.device_identity},
          {"received", link.received},
          {"fresh", reads.fresh},
          {"superseded", reads.superseded},
          {"corrupt", reads.corrupt},
          {"malformed", link.malformed},
          {"lost", s.link->lost},
          {"missing_ticks", reads.missing},
          {"disconnected_ticks", reads.disconnected},
          {"sent", link.sent},
          {"send_superseded", link.send_superseded},
          {"send_failed", link.send_failed},
          {"errors", link.errors},
          {"disconnects", link.disconnects},
          {"force_age", times_json(s.link->force_age)}};
}

std::string fault_text(const loop::FaultEvent& event) {
  return hal::describe(event.fault, {event.device_state, event.device_fault, event.device_limits});
}

std::string faults_text(const RunSummary& s) {
  const std::uint64_t count = s.stats.fault_count;
  std::string text = fmt::format("faults                 {}\n", count == 0 ? "none" : fmt::format("{}", count));
  std::size_t left = s.stats.faults.size();
  for (const auto& event : s.stats.faults) {
    if (--left == 0 && s.stats.fault_events_dropped > 0)
      text += fmt::format("  {} {}, faults and re-arms, not listed\n", s.stats.fault_events_dropped,
                          s.stats.fault_events_dropped == 1 ? "event" : "events");
    text += fmt::format("  tick {:<17} {}{}\n", event.tick, event.cleared != 0 ? "re-armed after: " : "",
                        event.cleared != 0 ? std::string(describe(event.fault)) : fault_text(event));
  }
  for (const std::string& refusal : s.arm_refusals) text += fmt::format("  not armed: {}\n", refusal);
  return text;
}

std::string status_text(const RunSummary& s) {
  std::string text;
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    const std::string_view name = name_of(static_cast<StatusBit>(1u << bit));
    if (s.stats.status_ticks[bit] == 0 || name.empty() || (1u << bit) == kProxyContact) continue;
    text += fmt::format("  {:<22} {} ticks\n", name, s.stats.status_ticks[bit]);
  }
  return text.empty() ? text : "limits and conditions\n" + text;
}

std::string setup_text(const RunSummary& s) {
  if (!s.real_time) return {};
  std::string text = "set-up of the haptic thread\n";
  for (const auto& step : s.setup.steps)
    text += fmt::format("  {:<4} {:<17} {}\n", step.ok ? "ok" : "FAIL", step.name, step.message());
  return text;
}

// Energy account of the border, in both worlds; signs as in tools/session/README.md.
std::string border_energy_text(const RunSummary& s) {
  if (!s.has_global) return {};
  return fmt::format(
      "energy at the border\n"
      "  {:<22} {:+.4f} J on members, {:+.4f} J by corrections; tank {:.4f} J\n"
      "  {:<22} {:+.4f} J by outside bodies on members, {:+.4f} J by imposed motion, {:+.4f} J by returned impulses\n",
      "sub-world", s.stats.border_work_J, s.stats.corrected_J, s.stats.border_tank_J, "global world",
      s.global.border_work_J, s.global.imposed_energy_J, s.global.returned_energy_J);
}

json run_json(const RunSummary& s) {
  return {{"rate_Hz", s.options.rate_Hz},
          {"ratio", s.ratio},
          {"ticks", s.stats.ticks},
          {"duration_s", static_cast<double>(s.stats.ticks) * s.options.period_s()},
          {"wall_s", s.wall_s},
          {"coupling", sim::name_of(s.options.coupling)},
          {"border", sim::name_of(s.options.border)},
          {"device", s.options.device},
          {"bodies", s.bodies}};
}

json gains_json(const RunSummary& s) {
  return {{"stiffness_N_per_m", s.gains.gains.stiffness_N_per_m},
          {"damping_Ns_per_m", s.gains.gains.damping_Ns_per_m},
          {"stiffness_Nm_per_rad", s.gains.gains.stiffness_Nm_per_rad},
          {"damping_Nms_per_rad", s.gains.gains.damping_Nms_per_rad},
          {"lowered", s.gains.lowered()}};
}

json timing_json(const RunSummary& s) {
  const auto& t = s.timing;
  json j = {{"wake_up", times_json(t.wake_latency)},
            {"execution", times_json(t.execution)},
            {"compute", times_json(s.compute)},
            {s.simulated() ? "simulated_device" : "device", times_json(s.device)},
            {"overruns", t.overruns},
            {"overruns_late_wake", s.overruns_late_wake},
            {"overruns_interrupted", s.overruns_interrupted},
            {"overruns_own_work", s.overruns_own_work},
            {"skipped_ticks", t.skipped_ticks},
            {"minor_page_faults", t.minor_faults},
            {"major_page_faults", t.major_faults},
            {"involuntary_context_switches", t.involuntary_switches}};
  if (s.stolen_share) j["stolen_share"] = *s.stolen_share;
  return j;
}

json sub_world_json(const RunSummary& s) {
  return {{"members_max", s.stats.members_max},
          {"members_cap", s.members_cap},
          {"contacts_max", s.stats.contacts_max},
          {"points_max", s.stats.points_max},
          {"pairs_max", s.stats.pairs_max},
          {"border_contacts_max", s.stats.border_max},
          {"sub_steps_mean", mean_sub_steps(s)},
          {"deepest_overlap_m", s.stats.deepest_m},
          {"deepest_overlap_share", s.stats.deepest_share},
          {"capacity_bits", s.stats.capacity_bits},
          {"dropped_entries", s.stats.dropped}};
}

json global_world_json(const RunSummary& s) {
  json j = {{"cycles", s.stats.cycles},
            {"late_cycles", s.stats.late_cycles},
            {"longest_cycle_ticks", s.stats.cycle_ticks_max},
            {"dilation_ms", s.dilation_ms()},
            {"bodies_awake", s.global.awake},
            {"bodies_awake_max", s.global.most_awake},
            {"joints_broken", s.global.broken_joints},
            {"bodies_asleep", s.global.asleep},
            {"bodies_fell_asleep", s.global.fell_asleep},
            {"bodies_woke_up", s.global.woke_up},
            {"stopped_energy_J", s.global.stopped_energy_J},
            {"contacts_max", s.global.most_contacts},
            {"component_max", s.stats.component_max},
            {"resets", s.global.resets},
            {"joins", s.global.joins},
            {"leaves", s.global.leaves},
            {"deepest_overlap_m", s.global.deepest_m},
            {"capacity_bits", s.global.capacity_bits},
            {"dropped_entries", s.global.dropped_entries}};
  const sim::EnergyBalance& balance = s.global.energy;
  j["energy_book"] = {{"complete", balance.complete},
                      {"kinetic_max_J", balance.most_kinetic_J},
                      {"work_on_proxy_J", balance.proxy_work_J},
                      {"work_put_in_J", balance.work_in_J},
                      {"unexplained_J", balance.unexplained_J}};
  j["deepest_overlap_share"] = s.global.overlap.share;
  j["deepest_share_m"] = s.global.overlap.depth;
  if (s.global.overlap.share > 0) j["deepest_share_bodies"] = {s.global.overlap.a, s.global.overlap.b};
  if (s.global_step.count() > 0) j["step"] = times_json(s.global_step);
  if (s.options.hands > 1) j["handed_over"] = s.global.handed_over;
  return j;
}

json hand_json(const RunSummary& s) {
  return {{"contact_ticks", s.stats.contact_ticks}, {"contact_percent", percent(s.stats.contact_ticks, s.stats.ticks)},
          {"force_mean_N", mean_force_N(s)},        {"force_max_N", s.stats.force_max_N},
          {"torque_max_Nm", s.stats.torque_max_Nm}, {"force_step_max_N", s.stats.force_step_max_N}};
}

json energy_json(const RunSummary& s) {
  json j = {{"device_port_J", s.stats.device_energy_J},
            {"passivity_control_J", s.stats.damped_energy_J},
            {"border",
             {{"work_on_members_J", s.stats.border_work_J},
              {"corrected_J", s.stats.corrected_J},
              {"tank_J", s.stats.border_tank_J}}}};
  if (s.has_global) {
    json& border = j["border"];
    border["global_work_on_members_J"] = s.global.border_work_J;
    border["imposed_J"] = s.global.imposed_energy_J;
    border["returned_J"] = s.global.returned_energy_J;
  }
  if (s.simulated()) {
    j["hand_work_J"] = s.hand_work_J;
    j["motor_work_J"] = s.motor_work_J;
  }
  return j;
}

json conditions_json(const RunSummary& s) {
  json conditions = json::object();
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    const std::string_view name = name_of(static_cast<StatusBit>(1u << bit));
    if (!name.empty() && s.stats.status_ticks[bit] > 0) conditions[std::string(name)] = s.stats.status_ticks[bit];
  }
  return conditions;
}

json faults_json(const RunSummary& s) {
  json faults = json::array();
  for (const auto& event : s.stats.faults) {
    faults.push_back({{"tick", event.tick},
                      {"code", static_cast<std::uint32_t>(event.fault)},
                      {"text", event.cleared != 0 ? std::string(describe(event.fault)) : fault_text(event)},
                      {"device_state", hal::name_of(event.device_state)},
                      {"device_fault", hal::shown_fault(event.device_fault)},
                      {"device_fault_text", hal::describe_device_fault(event.device_fault)},
                      {"device_limits", event.device_limits},
                      {"device_limits_text", hal::describe_device_limits(event.device_limits)},
                      {"rearmed", event.cleared != 0}});
  }
  return faults;
}

}  // namespace

bool RunSummary::fault_latched() const noexcept {
  return !stats.faults.empty() && stats.faults.items[stats.faults.size() - 1].cleared == 0;
}

double RunSummary::dilation_ms() const noexcept {
  if (!has_global) return 0;
  const double haptic_ms = static_cast<double>(stats.ticks) * options.period_s() * 1e3;
  const double global_ms = static_cast<double>(stats.cycles) * ratio * options.period_s() * 1e3;
  return std::max(0.0, haptic_ms - global_ms);
}

std::string to_text(const RunSummary& s) {
  const RunVerdict verdict = judge(s);
  const std::string hand =
      s.options.hands > 1 ? fmt::format("hand {} of {}: ", s.options.hand + 1, s.options.hands) : "";
  std::string text = fmt::format("\ntactus run: {}{} ({})\n", hand,
                                 s.scene_title.empty() ? s.scene_name : s.scene_title, verdict.line());
  text += verdict.text();
  text += fmt::format("run                    {} ticks at {:g} Hz, ratio {}, {} coupling, border {}, device {}\n",
                      s.stats.ticks, s.options.rate_Hz, s.ratio, sim::name_of(s.options.coupling),
                      sim::name_of(s.options.border), s.options.device);
  text += fmt::format("made by                tactus {}; scene {}, text {}\n", version(),
                      hal::printable(s.options.scene.string()), s.scene_hash);
  if (s.gains.lowered())
    text += fmt::format("coupling               {}: {}\n", lowered_text(s.gains), lowered_why(s.options, s.ratio));
  text += link_text(s);
  text += timing_text(s);
  text +=
      fmt::format("sub-world\n  {:<22} at most {} members of {} (cap {}), {} contacts, {} points, {} border contacts\n",
                  "high water", s.stats.members_max, s.bodies, s.members_cap, s.stats.contacts_max, s.stats.points_max,
                  s.stats.border_max);
  text += fmt::format("  {:<22} mean {:.2f} of {}; deepest overlap {:.3f} mm\n", "sub-steps", mean_sub_steps(s),
                      s.sub_steps, 1e3 * s.stats.deepest_m);
  text += governor_text(s);
  text += global_text(s);
  text += fmt::format("hand\n  {:<22} {:.1f} % of the ticks\n", "in contact",
                      percent(s.stats.contact_ticks, s.stats.ticks));
  text += fmt::format("  {:<22} mean {:.2f} N, max {:.2f} N, {:.3f} N m; largest step {:.2f} N a tick\n", "force",
                      mean_force_N(s), s.stats.force_max_N, s.stats.torque_max_Nm, s.stats.force_step_max_N);
  text += fmt::format("  {:<22} device port {:+.4f} J, passivity control {:.4f} J\n", "energy", s.stats.device_energy_J,
                      s.stats.damped_energy_J);
  if (s.simulated())
    text += fmt::format("  {:<22} by the hand {:+.4f} J, by the motors {:+.4f} J\n", "work on the device",
                        s.hand_work_J, s.motor_work_J);
  text += border_energy_text(s);
  text += status_text(s);
  text += faults_text(s);
  if (s.stats.capacity_bits != 0)
    text += fmt::format("capacity               exceeded (bits {:#x}), {} entries left out\n", s.stats.capacity_bits,
                        s.stats.dropped);
  if (!s.tape.empty())
    text += fmt::format(
        "tape                   {} ({}), {} records dropped\n", s.tape,
        s.tape_fault.empty() ? fmt::format("{:.1f} MB", static_cast<double>(s.tape_bytes) * 1e-6) : "incomplete",
        s.tape_dropped);
  if (!s.tape_fault.empty())
    text += fmt::format("  {:<20} {}; {} ticks are not on it\n", "tape fault", s.tape_fault, s.tape_lost_ticks);
  if (!s.fault_tape.empty()) text += fmt::format("flight recorder        {}\n", s.fault_tape);
  if (!s.fault_tape_error.empty()) text += fmt::format("flight recorder        not kept: {}\n", s.fault_tape_error);
  text += fmt::format("state hash             {:016x}\n", s.state_hash);
  return text + setup_text(s);
}

json to_json(const RunSummary& s) {
  json j;
  j["scene"] = s.scene_name;
  j["scene_file"] = s.options.scene.string();
  j["scene_hash"] = s.scene_hash;
  if (s.options.hands > 1) j["number"] = s.options.hand + 1;  // of the hand
  const RunVerdict verdict = judge(s);
  j["verdict"] = verdict.line();
  j["level"] = name_of(verdict.level());
  j["rules"] = to_json(verdict);
  j["exit_code"] = verdict.exit_code();
  j["degraded"] = s.degraded();
  j["real_time"] = s.real_time;
  j["run"] = run_json(s);
  j["coupling_gains"] = gains_json(s);
  if (s.real_time) {
    j["timing"] = timing_json(s);
    if (s.link) j["device_link"] = link_json(s);
    for (const auto& step : s.setup.steps)
      j["setup"].push_back({{"name", step.name}, {"ok", step.ok}, {"message", std::string(step.message())}});
  }
  j["sub_world"] = sub_world_json(s);
  j["governor"] = governor_json(s);
  if (s.has_global) j["global_world"] = global_world_json(s);
  j["hand"] = hand_json(s);
  j["energy"] = energy_json(s);
  j["condition_ticks"] = conditions_json(s);
  j["faults"] = faults_json(s);
  j["fault_events_dropped"] = s.stats.fault_events_dropped;
  j["arm_refusals"] = s.arm_refusals;
  j["state_hash"] = fmt::format("{:016x}", s.state_hash);
  if (!s.tape.empty())
    j["tape"] = {{"path", s.tape},
                 {"bytes", s.tape_bytes},
                 {"dropped_records", s.tape_dropped},
                 {"lost_ticks", s.tape_lost_ticks},
                 {"fault", s.tape_fault}};
  if (!s.fault_tape.empty()) j["flight_recorder"] = s.fault_tape;
  if (!s.fault_tape_error.empty()) j["flight_recorder_error"] = s.fault_tape_error;
  return j;
}

}  // namespace tactus::session
