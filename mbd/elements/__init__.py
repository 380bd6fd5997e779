"""What an element is: the linear and the nonlinear protocol, and the compiled loops over the nonlinear ones."""
