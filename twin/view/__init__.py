"""What people look at: Rerun recordings, figures and tables. Reads results, changes none."""
