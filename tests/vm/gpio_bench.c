// The kernel's gpio-sim with its interrupt simulator, as one module: Debian's real-time kernel leaves both out. The two
// sources come from Debian's linux-source package of the same version.
#include <linux/irq.h>

// The simulator's own call needs a symbol that modules do not get, and interrupts off; this one is for modules, and takes
// the simulated interrupt from the real-time kernel's threads as well.
#define handle_simple_irq(descriptor) generic_handle_irq_safe(irqnum)
#include "irq_sim.c"
#include "gpio-sim.c"
