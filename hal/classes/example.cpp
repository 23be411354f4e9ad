// example: the template of a maker's own class (example_device.h), a simulated puck. Its properties are its own, so a
// description has no effect.
#include "hal/device_class.h"
#include "hal/example_device.h"

namespace tactus::hal {
namespace {

Result<OpenedDevice> open(const DeviceRequest&) {
  return OpenedDevice{std::make_unique<AnyDevice>(std::make_unique<ExampleDevice>()), {}, {}};
}

}  // namespace

extern const DeviceClass example_class;
const DeviceClass example_class{.name = "example",
                                .forms = "example",
                                .what = "a puck on springs: a template for your own class",
                                .check_address = check_no_address,
                                .open = open,
                                .describes_itself = true};

}  // namespace tactus::hal
