"""Estimation theory as pure functions: bounds, and later filters and smoothers."""
