"""What a loop renders, one question a file or folder: stability, accuracy, fidelity, Z-width, failures."""
