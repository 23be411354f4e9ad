// The device classes, one line each: the constants NAME_class of hal/classes/, in the order of messages and help.
// Thread: [setup]; only device_class.cpp includes it.
#define TACTUS_DEVICE_CLASSES(X) \
  X(simulated)                   \
  X(usb)                         \
  X(can)                         \
  X(drives)                      \
  X(simulated_drives)            \
  X(falcon)                      \
  X(simulated_falcon)            \
  X(dhd)                         \
  X(openhaptics)                 \
  X(example)
