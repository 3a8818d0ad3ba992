"""What is chosen and what the device does, without widgets."""
