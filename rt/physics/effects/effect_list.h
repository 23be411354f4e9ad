// The table of effects that have a room of their own: one line each, in the order in which their stages run.
//
// A room is a class template that has a Setup (a plain value, `used()` says whether there is anything to do), is
// constructed from it and from the world's capacities, enters its stages into the table, and saves, restores and hands
// over what it holds between steps (or is Stateless). README.md says how to add one. Thread: [any].
#pragma once

#include <tuple>

#include "rt/physics/effects/attraction.h"
#include "rt/physics/effects/ccd.h"
#include "rt/physics/effects/contact_torque.h"
#include "rt/physics/effects/damping.h"
#include "rt/physics/effects/drag.h"
#include "rt/physics/effects/gravity.h"
#include "rt/physics/effects/joints.h"
#include "rt/physics/effects/restitution.h"
#include "rt/physics/effects/scripted_motion.h"
#include "rt/physics/effects/texture.h"
#include "rt/physics/effects/transients.h"

namespace tactus::physics {

using EffectRooms = std::tuple<  //
    Gravity,                     //
    Damping,                     //
    Drag,                        //
    Attraction,                  //
    ScriptedMotion,              //
    Joints,                      //
    ContactTorque,               //
    Restitution,                 //
    ContinuousCollision,         //
    Texture,                     //
    Transients                   //
    >;

}  // namespace tactus::physics
