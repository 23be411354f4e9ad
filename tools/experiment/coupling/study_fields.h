// The members of the coupling study's results, for part_bytes.h. Thread: [any].
#pragma once

#include "tools/experiment/coupling/coupling_study.h"
#include "tools/experiment/coupling/setting_cost.h"
#include "tools/experiment/coupling/whole_run.h"

namespace tactus::experiment {

template <class Io>
void fields(Io& io, StudyRow& row) {
  auto& [scene, scheme, members, gains, lowered, energy, worst_instant, speed_squared, at_rest, force_error, hold,
         moving, worst, sync_step, vibration, vibration_worst, vibration_encoder, stable, loop, by_seed, spectrum] =
      row;
  io(scene, scheme, members, gains, lowered, energy, worst_instant, speed_squared, at_rest, force_error, hold, moving,
     worst, sync_step, vibration, vibration_worst, vibration_encoder, stable, loop, by_seed, spectrum);
}

template <class Io>
void fields(Io& io, StudyScene& scene) {
  auto& [name, bodies, members, component, points, share, force, apart_force, apart_energy, loop] = scene;
  io(name, bodies, members, component, points, share, force, apart_force, apart_energy, loop);
}

template <class Io>
void fields(Io& io, EnergyAccount& account) {
  auto& [device, border_work, corrected, tank, spent, global_work, imposed, returned] = account;
  io(device, border_work, corrected, tank, spent, global_work, imposed, returned);
}

template <class Io>
void fields(Io& io, WholeRunRow& row) {
  auto& [scene, scheme, members, gains, seconds, hand, apart, sub_steps, force_error, by_quarter, force_rms, off,
         off_most, off_share, drift, deepest, direct_deepest, kinetic, over_work, gain, direct_gain, rise, direct_rise,
         unexplained, direct_unexplained, at_play, direct_kinetic, standing, fallen, stands, account, start, end,
         direct_end] = row;
  io(scene, scheme, members, gains, seconds, hand, apart, sub_steps, force_error, by_quarter, force_rms, off, off_most,
     off_share, drift, deepest, direct_deepest, kinetic, over_work, gain, direct_gain, rise, direct_rise, unexplained,
     direct_unexplained, at_play, direct_kinetic, standing, fallen, stands, account, start, end, direct_end);
}

template <class Io>
void fields(Io& io, StudyReport& report) {
  auto& [rows, scenes, whole, seeds, windows, window_s, line_Hz] = report;
  io(rows, scenes, whole, seeds, windows, window_s, line_Hz);
}

template <class Io>
void fields(Io& io, SettingSums& sums) {
  auto& [error, energy, vibration, steps, ticks_us, global_us] = sums;
  io(error, energy, vibration, steps, ticks_us, global_us);
}

}  // namespace tactus::experiment
