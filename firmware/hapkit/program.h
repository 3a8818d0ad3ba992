// The whole program: connects the board's hardware with the controller.
#pragma once

namespace program {

// Start the hardware with the motor off.
void begin();

// Process received messages; samples are taken in an interrupt.
void poll();

}  // namespace program
