/// \file
/// All of the library's headers.
///
/// \mainpage
///
/// tactus lets a hand feel a large world of rigid bodies through a force-feedback device at 1 kHz. The library is the
/// program's own inside: a scene, options and a device go in, and every tick gives force, poses, members, contacts,
/// energy and faults.
///
/// \include first_touch.cpp
///
/// - tactus::Session runs a scene, in virtual time tick by tick or in real time on a thread of its own.
/// - tactus::Scene reads the text of a scene, tactus::Options says how it is run.
/// - tactus::Device is what to implement for a device that the library does not know.
/// - tactus::Tick, tactus::BodyState, tactus::Contact are what comes out.
/// - tactus::Error is how every call says that it did not work.
///
/// With CMake `find_package(tactus)` and `target_link_libraries(... tactus::tactus)`; without it
/// `g++ -std=c++20 program.cpp $(pkg-config --cflags --libs tactus)`. Units are SI and in the names; the frame is the
/// world's unless a name or its description says otherwise.
#pragma once

#include "tactus/device.h"
#include "tactus/error.h"
#include "tactus/options.h"
#include "tactus/scene.h"
#include "tactus/session.h"
#include "tactus/state.h"
#include "tactus/summary.h"
#include "tactus/tape.h"
#include "tactus/tick.h"
#include "tactus/types.h"
#include "tactus/version.h"
