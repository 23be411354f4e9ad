// sim: the firmware on simulated mechanics (simulated_device.h), in the haptic thread. Any description can be
// simulated.
#include "hal/device_class.h"
#include "hal/simulated_device.h"

namespace tactus::hal {
namespace {

Result<OpenedDevice> open(const DeviceRequest& request) {
  SimulationOptions simulation;
  simulation.period_ns = request.period_ns;
  simulation.seed = request.seed;
  simulation.faults = request.faults;
  if (const Status status = SimulatedDevice::check(simulation); !status.ok()) return status;
  DeviceProfile profile = request.profile;  // no drives here: their damping is that of the mechanics
  profile.plant.damping_Ns_per_m += profile.drive_damping_Ns_per_m;
  profile.plant.damping_Nms_per_rad += profile.drive_damping_Nms_per_rad;
  auto device = std::make_unique<SimulatedDevice>(profile, request.hand, simulation);
  return OpenedDevice{std::make_unique<AnyDevice>(std::move(device)), {}, {}};
}

}  // namespace

extern const DeviceClass simulated_class;
const DeviceClass simulated_class{.name = "sim",
                                  .forms = "sim",
                                  .what = "the firmware on simulated mechanics, for any description",
                                  .check_address = check_no_address,
                                  .open = open,
                                  .hand_by_script = true};

}  // namespace tactus::hal
