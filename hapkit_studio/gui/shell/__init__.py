"""The main window: its frame, actions and menus, and the program that opens it."""
