// The list of all effects, one line each, in the order in which their stages run.
//
// An effect object is of a class with a Setup (a plain value; `used()`: true if the effect has anything to do). It is
// constructed from the Setup and the world's capacities, adds its stages to the table, and saves, restores, exports and
// imports its state between steps (or derives from Stateless). README.md describes how to add one. Thread: [any].
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

using EffectObjects = std::tuple<  //
    Gravity,                       //
    Damping,                       //
    Drag,                          //
    Attraction,                    //
    ScriptedMotion,                //
    Joints,                        //
    ContactTorque,                 //
    Restitution,                   //
    ContinuousCollision,           //
    Texture,                       //
    Transients                     //
    >;

}  // namespace tactus::physics
