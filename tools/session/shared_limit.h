// Largest stable stiffness of the couplings of two hands that hold one body: each device then acts on the other through
// the global world, with its delay.
//
// A device's sample reaches the other hand's sub-world one to two global steps later, 1.5 r T in the mean. Where both
// couplings (K, B; device of mass m and damping b) hold a body without mass, a device is held by K/2 to where it is and
// by K/2 to where the other was. Differential motion x_A = -x_B, delay t:
//     m s^2 + b s + (K/2 + s B/2) (1 + e^(-s t)) = 0
// has no root on the imaginary axis while K t/2 < b + B/2, for w t < pi/2: stiffness times delay against damping, as
// for any two devices coupled by their positions (Nuno, Basanez, Ortega 2011, "Passivity-based control for bilateral
// teleoperation: a tutorial"). shared_formula_limit is the formula of coupling_limits.h with the whole of K late by
// delay_s + 1.5 r T: its line is (b + B) / (T/2 + t_d + 1.5 r T).
//
// The bound is too strict: the proxies have mass and the worlds extrapolate. Measured (2026-11-26; m 0.3 kg, b 0.5 N
// s/m, B 2 to 10 N s/m, ratio 4 to 20, proxies 0.05 to 0.4 kg, bodies 0.01 to 0.5 kg): with the body jointed to both
// proxies, oscillations grow from 1.6 to 13 times this stiffness on; with the body squeezed between them, not below
// that. So the limit is computed: two hands are simulated, by the loops' and the world's own code, with a light body
// jointed to both proxies, without arms, dry friction and passivity controllers. The limit is the stiffness from which
// on an oscillation grows.
//
// Above the limit nothing breaks: the border's tank and the passivity controllers bound the energy of an oscillation,
// and the damping of the hands adds to b.
//
// Thread: normal, set-up; one simulation of a second where the gains are stable, some ten where they are not. Units:
// SI.
#pragma once

#include "rt/haptics/device.h"
#include "sim/model/scene.h"
#include "tools/session/run_options.h"

namespace tactus::session {

// Stiffness in world units, with the scene's damping, of two hands like this one; infinite where the scene's own
// stiffness over kAllowedStiffnessShare is stable; 0: no stiffness is. `scene`: of the hand (sim::scene_of_hand).
SharedLimits shared_limits(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device);

// Whether an oscillation of two such hands on one light body decays with this stiffness and the scene's damping.
enum class SharedAxis { kTranslation, kRotation };
bool shared_body_rings_out(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device,
                           SharedAxis axis, double stiffness);

// By the formula, at most what the device's own limit is.
double shared_formula_limit(const sim::Scene& scene, const RunOptions& options, const haptics::DeviceProperties& device,
                            SharedAxis axis);

}  // namespace tactus::session
