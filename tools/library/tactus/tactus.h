/// \file
/// All of the library's headers.
///
/// \mainpage
///
/// tactus lets a hand feel a large world of rigid bodies through a force-feedback device at 1 kHz. The library contains
/// the complete program: its inputs are a scene, options and a device; each tick returns force, poses, members,
/// contacts, energy and faults.
///
/// \include first_touch.cpp
///
/// - tactus::Session runs a scene, in virtual time tick by tick or in real time on its own thread.
/// - tactus::Scene reads a scene, tactus::Options sets how it is run.
/// - tactus::Device is the interface to implement for a device that the library does not support.
/// - tactus::Tick, tactus::BodyState, tactus::Contact are the outputs.
/// - tactus::Error is how every call reports failure.
///
/// With CMake `find_package(tactus)` and `target_link_libraries(... tactus::tactus)`; without it
/// `g++ -std=c++20 program.cpp $(pkg-config --cflags --libs tactus)`. Units are SI and in the names; the frame is the
/// world's unless a name or its description says otherwise.
/// \namespace tactus
/// The public interface. tactus::library is not public.
///
/// \example first_touch.cpp
/// Five seconds of a scene in virtual time.
/// \example own_device.cpp
/// A device that the library does not support.
/// \example real_time.cpp
/// A run in real time, its monitor, and clearing a fault.
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
