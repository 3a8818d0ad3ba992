"""What a loop renders, one question a file or folder: stability, speed and accuracy, Z-width, failures."""
