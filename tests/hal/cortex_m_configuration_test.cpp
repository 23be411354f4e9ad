// The Cortex-M image is built for the device that the host knows as desk3d: its figures must not drift from what
// follows from the description.
#include "firmware/boards/cortex_m/configuration.h"

#include <catch2/catch.hpp>

#include "hal/identity_check.h"
#include "hal/loopback_link.h"

using namespace tactus;
using namespace tactus::hal;
namespace image = tactus::firmware::cortex_m;

namespace {

const DeviceProfile& desk() { return *find_profile("desk3d"); }

// Questions go to a device with the image's configuration and identity.
struct ImageLink : LoopbackLink {
  firmware::Device device{image::make_configuration(), image::kIdentity};
  ImageLink() : LoopbackLink(desk(), HandModel(), 1'000'000) {}

  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds) {
    return device.serve(request);
  }
};

// Half a unit of the fourth digit, at most.
Approx to_four_digits(float x) { return Approx(static_cast<double>(x)).epsilon(5e-4).margin(0); }

}  // namespace

TEST_CASE("the Cortex-M image's figures are those that follow from the description desk3d") {
  const firmware::Config built = image::make_configuration(), wanted = firmware_config(desk(), built.period_us);
  CHECK(built.quantum == wanted.quantum);
  for (unsigned i = 0; i < kAxisCount; ++i) {
    CAPTURE(i);
    CHECK(static_cast<double>(built.max_effort[i]) == to_four_digits(wanted.max_effort[i]));
    CHECK(static_cast<double>(built.max_speed[i]) == to_four_digits(wanted.max_speed[i]));
  }
  CHECK(static_cast<double>(built.max_force_N) == to_four_digits(wanted.max_force_N));
  CHECK(built.max_torque_Nm == wanted.max_torque_Nm);
  CHECK(built.fade_frames == wanted.fade_frames);
  CHECK(built.brake_frames == wanted.brake_frames);
}

TEST_CASE("a host that expects a desk3d takes the Cortex-M image for one, and one that expects another does not") {
  ImageLink link;
  const Status status = check_identity(desk(), image::make_configuration().period_us, link);
  INFO(status.message());
  CHECK(status.ok());
  CHECK_FALSE(check_identity(*find_profile("virtuose6d"), image::make_configuration().period_us, link).ok());
}
