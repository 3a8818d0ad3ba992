"""What the whole window is made of: theme, style, icons, number fields, switches."""
