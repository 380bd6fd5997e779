"""The assembled machine: matrices and rows, equilibrium, natural modes."""
