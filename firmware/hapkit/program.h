// The whole program: connects the board's hardware with the controller.
#pragma once

namespace program {

// Start the hardware with the motor off.
void begin();

// Handle what has been received; the samples run by themselves, in an interrupt.
void poll();

}  // namespace program
