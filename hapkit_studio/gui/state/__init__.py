"""The user's choices and the state of the device, without widgets."""
