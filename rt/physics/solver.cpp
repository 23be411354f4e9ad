#include "rt/physics/solver.h"

#include "rt/physics/integrate.h"
#include "rt/physics/push_out.h"

namespace tactus::physics {
namespace {

// Moving a body takes about 10 ns, handing work to another thread about 1 us.
constexpr std::uint32_t kMinBodies = 128;

template <class F>
void for_each_body(const Executor& executor, std::size_t bodies, F&& f) noexcept {
  executor.for_each_range(static_cast<std::uint32_t>(bodies), kMinBodies,
                          [&](std::uint32_t i, std::uint32_t end) noexcept {
                            for (; i < end; ++i) f(i);
                          });
}

}  // namespace

template <class S>
Solver<S>::Solver(const Capacities& capacities, bool scripted)
    : motion_(capacities.bodies),
      inverse_inertia_(capacities.bodies),
      motion_in_double_(kIsWhole || !scripted ? 0 : capacities.bodies),
      inverse_inertia_in_double_(motion_in_double_.capacity()),
      before_(capacities.bodies),
      pushed_(capacities.bodies),
      contacts_(capacities),
      border_(capacities) {}

template <class S>
void Solver<S>::prepare(const SolverInput& input, StageContext& context) noexcept {
  const StepSettings& settings = context.settings;
  const auto count = static_cast<std::uint32_t>(input.bodies.size());
  motion_.resize(count);
  inverse_inertia_.resize(count);
  for_each_body(input.executor, count, [&](std::uint32_t i) noexcept {
    const Body& body = input.bodies[i];
    SolverBody<S>& state = motion_[i];
    state = {};
    inverse_inertia_[i] = {};
    if (input.frozen[i] != 0) return;  // infinite mass, at rest
    state.v = number_cast<S>(body.motion.velocity.linear);
    state.w = number_cast<S>(body.motion.velocity.angular);
    state.inverse_mass = static_cast<S>(1.0 / body.mass);
    state.gyroscopic = settings.gyroscopic && is_anisotropic(body.inertia) ? S(1) : S(0);
    inverse_inertia_[i] = number_cast<S>(rotate_diagonal(
        body.motion.pose.rotation, Vec3d{1.0 / body.inertia.x, 1.0 / body.inertia.y, 1.0 / body.inertia.z}));
  });
  pushed_.clear();
  for (std::uint32_t i = 0; i < input.wrenches.size(); ++i)
    if (input.wrenches[i] != Wrenchd{}) static_cast<void>(pushed_.try_push(i));
  for (std::uint32_t i = 0; i < kMaxSprings; ++i) {
    const PoseSpring spring = i < input.springs.size() ? input.springs[i] : PoseSpring{};
    const Posed start = spring.enabled ? input.bodies[number_of(spring.slot)].motion.pose : Posed{};
    springs_[i].prepare(spring, start, motion_.span(), inverse_inertia_.span(), static_cast<S>(context.h));
  }
  run_stages(input, Phase::kPrepare, context);
  contacts_.prepare(std::span<const Contact>(input.contacts), state(), settings.dt, input.executor);
  if constexpr (kIsWhole) {
    border_.prepare(input.border, input.ghosts, input.bodies, state(),
                    {.rule = input.border_rule,
                     .h = context.h,
                     .impulse_scale = input.impulse_scale,
                     .sweep = context.rule,
                     .friction = settings.friction});
    context.ghosts = border_.ghosts();
  }
}

template <class S>
void Solver<S>::run_stages(const SolverInput& input, Phase phase, StageContext& context) noexcept {
  if constexpr (kIsWhole) {
    context.motion = motion_.span();
    context.inverse_inertia = inverse_inertia_.span();
    input.stages.run(phase, context);
  } else if (phase == Phase::kForces) {
    apply_gravity(input, context);
  } else if (input.stages.has(phase)) {
    run_stages_in_double(input, phase, context);
  }
}

template <class S>
void Solver<S>::apply_gravity(const SolverInput& input, const StageContext& context) noexcept {
  if (context.settings.gravity == Vec3d{}) return;
  const Vec3d change = context.h * context.settings.gravity;
  for_each_body(input.executor, motion_.size(), [&](std::uint32_t i) noexcept {
    if (motion_[i].inverse_mass > S(0)) motion_[i].v += number_cast<S>(input.bodies[i].gravity_scale * change);
  });
}

// A body that the stages leave alone keeps its bits: the cast to double and back is exact. Inertias are changed before
// the first sub-step alone.
template <class S>
void Solver<S>::run_stages_in_double(const SolverInput& input, Phase phase, StageContext& context) noexcept {
  const auto count = motion_.size();
  motion_in_double_.resize(count);
  for_each_body(input.executor, count,
                [&](std::uint32_t i) noexcept { motion_in_double_[i] = number_cast<double>(motion_[i]); });
  if (phase == Phase::kPrepare) {
    inverse_inertia_in_double_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) inverse_inertia_in_double_[i] = number_cast<double>(inverse_inertia_[i]);
  }
  context.motion = motion_in_double_.span();
  context.inverse_inertia = inverse_inertia_in_double_.span();
  input.stages.run(phase, context);
  for_each_body(input.executor, count,
                [&](std::uint32_t i) noexcept { motion_[i] = number_cast<S>(motion_in_double_[i]); });
  if (phase == Phase::kPrepare)
    for (std::uint32_t i = 0; i < count; ++i) inverse_inertia_[i] = number_cast<S>(inverse_inertia_in_double_[i]);
}

template <class S>
void Solver<S>::apply_wrenches(const SolverInput& input, double h) noexcept {
  for (const std::uint32_t i : pushed_) {
    const Wrenchd& wrench = input.wrenches[i];
    motion_[i].v += (static_cast<S>(h) * motion_[i].inverse_mass) * number_cast<S>(wrench.force);
    motion_[i].w += inverse_inertia_[i] * number_cast<S>(h * wrench.torque);
  }
}

// Warm start for a sub-step that no sweep corrects: if the whole of it would raise the kinetic energy, it is scaled to
// the share at which the energy is smallest.
template <class S>
void Solver<S>::warm_start_without_gain(const SolverInput& input, StageContext& context) noexcept {
  before_.resize(motion_.size());
  for (std::uint32_t i = 0; i < motion_.size(); ++i) before_[i] = {motion_[i].v, motion_[i].w};
  border_.warm_start(state());
  contacts_.warm_start_freely(state());
  run_stages(input, Phase::kWarmStart, context);
  EnergyChange<S> change;
  for (std::uint32_t i = 0; i < motion_.size(); ++i)
    if (motion_[i].inverse_mass > S(0))
      change.add(motion_[i], inverse_inertia_[i],
                 {motion_[i].v - before_[i].linear, motion_[i].w - before_[i].angular});
  const S share = change.best_share();
  if (share == S(1)) return;
  contacts_.scale_impulses(share);
  border_.scale_impulses(share);
  context.factor = static_cast<double>(share);
  run_stages(input, Phase::kScale, context);
  for (std::uint32_t i = 0; i < motion_.size(); ++i) {
    motion_[i].v = before_[i].linear + share * (motion_[i].v - before_[i].linear);
    motion_[i].w = before_[i].angular + share * (motion_[i].w - before_[i].angular);
  }
}

template <class S>
void Solver<S>::sweep_relax(const SolverInput& input, const SweepRule<S>& rule, StageContext& context,
                            bool last) noexcept {
  run_stages(input, Phase::kRelax, context);
  border_.relax(state(), rule, last);
  contacts_.relax(state(), rule, context.settings.friction, last);
}

template <class S>
void Solver<S>::store(const SolverInput& input, StageContext& context, std::uint32_t uncorrected) noexcept {
  context.factor = uncorrected > 1 ? 1.0 / static_cast<double>(uncorrected) : 1.0;
  contacts_.store(input.contacts, context.factor);
  run_stages(input, Phase::kFinish, context);  // joints' impulses on ghosts too
  if constexpr (kIsWhole)
    border_.store(input.border, input.ghosts, input.bodies, motion_.span(), context.settings.dt, context.factor);
  for_each_body(input.executor, motion_.size(), [&](std::uint32_t i) noexcept {
    const SolverBody<S>& state = motion_[i];
    if (state.inverse_mass == S(0)) return;
    BodyMotion& motion = input.bodies[i].motion;
    motion.pose.position += number_cast<double>(state.delta_position);
    motion.pose.rotation = normalized(number_cast<double>(state.delta_rotation) * motion.pose.rotation);
    // A velocity that the sweeps did not change keeps its exact double value.
    const auto changed = [](Vec3d& kept, const Vec3<S>& now) noexcept {
      if constexpr (std::is_same_v<S, double>)
        kept = now;
      else
        kept += number_cast<double>(now - number_cast<S>(kept));
    };
    changed(motion.velocity.linear, state.v);
    changed(motion.velocity.angular, state.w);
  });
}

template <class S>
void Solver<S>::step(const SolverInput& input, const StepSettings& settings, const CutPredicate& cut,
                     StepReport& report) noexcept {
  const double h = settings.dt / static_cast<double>(settings.sub_steps);
  StageContext context{.bodies = input.bodies,
                       .fixed_bodies = input.fixed_bodies,
                       .frozen = input.frozen,
                       .contacts = input.contacts,
                       .settings = settings,
                       .report = report,
                       .executor = input.executor};
  context.h = h;
  context.rule = SweepRule<double>::of(settings, h);
  const SweepRule<S> rule = SweepRule<S>::of(settings, static_cast<S>(h));
  const bool friction_when_biased =
      settings.friction && resolve(settings.friction_sweeps, settings.relax_sweeps) == FrictionSweeps::kEvery;
  std::uint32_t sweep = 0, uncorrected = 0;  // sub-steps since the last relax sweep
  const auto go_on = [&]() noexcept {
    if (report.cut_sweep == kNeverCut && cut(sweep)) report.cut_sweep = sweep;
    if (report.cut_sweep != kNeverCut) return false;
    ++sweep;
    return true;
  };

  PushOut push_out;
  const auto push_out_step = [&]() noexcept {
    if constexpr (kIsWhole)
      return PushOut::Step{input.bodies, motion_.span(), input.springs, settings.gravity, settings.dt};
    else
      return PushOut::Step{};
  };
  const bool has_ghosts = kIsWhole && !input.ghosts.empty();
  const auto pass = [&](double seconds) noexcept {
    if (has_ghosts) push_out.pass(push_out_step(), seconds);
  };

  prepare(input, context);
  pass(0.5 * h);
  for (std::uint32_t j = 0; j < settings.sub_steps; ++j) {
    context.sub_step = j;
    for (auto& spring : springs_) spring.release();
    border_.begin_sub_step(j, state());
    run_stages(input, Phase::kBeginSubStep, context);
    border_.count_joints(report.border_joints_J);
    context.ghosts_may_supply = border_.may_supply() && input.border_rule.available_J > 0.0;
    run_stages(input, Phase::kForces, context);
    apply_wrenches(input, h);
    border_.apply_replay(state());
    for (auto& spring : springs_) spring.hold(j);
    if (go_on()) {
      border_.warm_start(state());
      run_stages(input, Phase::kWarmStart, context);
      contacts_.warm_start(state(), rule);
      run_stages(input, Phase::kBiased, context);
      border_.solve_biased(state(), rule);
      contacts_.solve_biased(state(), rule, friction_when_biased);
    } else {
      warm_start_without_gain(input, context);
    }
    for (auto& spring : springs_) spring.save_angular_velocity();
    input.executor.for_each_range(motion_.size(), kMinBodies, [&](std::uint32_t begin, std::uint32_t end) noexcept {
      move_bodies(motion_.span().subspan(begin, end - begin),
                  std::span<const Body>(input.bodies.subspan(begin, end - begin)), static_cast<S>(h));
    });
    for (auto& spring : springs_) spring.apply_held_inertia();
    border_.move_ghosts();
    run_stages(input, Phase::kMoved, context);
    border_.find_offsets(state());
    bool counted = false;
    ++uncorrected;
    for (std::uint32_t k = 0; k < settings.relax_sweeps && go_on(); ++k) {
      counted = k + 1 == settings.relax_sweeps;
      sweep_relax(input, rule, context, counted);
      uncorrected = 0;
    }
    if (!counted && j + 1 == settings.sub_steps && report.cut_sweep != kNeverCut) {
      contacts_.keep_impulses(input.contacts);
      if constexpr (kIsWhole) border_.keep_impulses(input.border);
      run_stages(input, Phase::kKeep, context);
      sweep_relax(input, rule, context, true);
      counted = true;
    }
    if (!counted) contacts_.add_to_totals();
    context.border_left_J = border_.left_J();
    context.border_joints_J = 0;
    run_stages(input, Phase::kEndSubStep, context);
    border_.count_joints(report.border_joints_J + context.border_joints_J);
    border_.end_sub_step(state());
    for (auto& spring : springs_) spring.end_sub_step();
    pass(j + 1 == settings.sub_steps ? 0.5 * h : h);
  }
  for (std::uint32_t i = 0; i < input.springs.size(); ++i)
    input.springs[i].step_impulse = {number_cast<double>(springs_[i].impulse().force),
                                     number_cast<double>(springs_[i].impulse().torque)};
  if (has_ghosts) report.push_out_J = push_out.work_J(push_out_step());
  store(input, context, uncorrected);
}

template class Solver<double>;
template class Solver<float>;

}  // namespace tactus::physics
