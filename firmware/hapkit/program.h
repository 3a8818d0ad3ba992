// The whole program, which connects the board's hardware with the controller.
#pragma once

namespace program {

// Start the hardware with the motor off.
void begin();

// Process received messages; samples are processed in an interrupt.
void poll();

}  // namespace program
