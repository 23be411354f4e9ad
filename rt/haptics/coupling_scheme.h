// How the haptic side and the global world are coupled: the paper's method and the three it is compared with
// (paper, section 3.3). Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::haptics {

enum class CouplingScheme : std::uint32_t {
  kSubWorld = 0,       // members run at the device's rate; the worlds exchange once a cycle
  kDirect = 1,         // the whole world runs at the device's rate; no global world
  kInterpolation = 2,  // the device feels the proxy's positions interpolated between global states; its effort of a
                       // cycle is stored and applied as one impulse at the synchronisation
  kStatic = 3,         // the proxy moves at the device's rate among members that are frozen; its state is imposed on
                       // the global world at the synchronisation
};

}  // namespace tactus::haptics
