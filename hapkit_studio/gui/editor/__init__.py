"""The editor for students' own environments: code, marks, trials, and files from other people."""
