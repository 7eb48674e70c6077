"""The pendulum absorber: design model, LQG controller, closed loop in MuJoCo, tuning, export."""
