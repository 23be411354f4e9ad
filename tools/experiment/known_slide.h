// Boxes that slide over triangles, against the known answer; shown beside an engine's row on rough ground. An engine
// whose boxes snag on a mesh's edges, or sink between them, moves them another way and does another amount of work.
//
// Gravity is tilted by phi against the ground's normal, tan(phi) > mu. A box that starts at rest then covers
//   s = g (sin(phi) - mu cos(phi)) t (t + h) / 2
// in the time t, with steps h of semi-implicit Euler: on a flat ground of triangles, and as well on straight ridges
// that carry it at their tops, across or along its way.
//
// Frame: z up, the slide is along +x. Units: SI. Thread: one.
#pragma once

#include <string_view>

#include "tools/experiment/engine.h"

namespace tactus::experiment {

enum class SlideGround : std::uint8_t { kFlat, kRidgesAcross, kRidgesAlong };

// Nine boxes at rest, of three orientations; its `settle_s` is the time t.
BoxScene make_slide(SlideGround ground);

struct SlideError {
  double share{0};          // largest distance of a box from where it should be / s
  std::string_view ground;  // where: "flat", "ridges across", "ridges along"
};

// The worst of the three grounds; infinite where the engine left out work.
SlideError slide_error(const EngineKind& kind, EngineOptions options);

}  // namespace tactus::experiment
