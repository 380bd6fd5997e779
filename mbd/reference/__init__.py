"""The linear reference that nonlinear elements are held against: loads, stiffness, modes."""
