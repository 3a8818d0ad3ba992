"""Where students write environments of their own: code, its marks, its trial, and files from someone else."""
