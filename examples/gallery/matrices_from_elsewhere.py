"""
Stiffness and mass matrices of another program
==============================================

Stiffness and mass matrices from any finite-element program can be reduced for a simulation. This example reduces a
cantilever of beam elements to its free end, and compares the natural frequencies with beam theory.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import eigh

import gearcase

LENGTH, COUNT = 0.5, 20  # m, elements
MODULUS, DENSITY = 210e9, 7850.0
AREA, INERTIA = 0.02 * 0.03, 0.02 * 0.03**3 / 12  # of a section 20 mm wide and 30 mm high

# %%
# Each node has two unknowns: the deflection in z (axis 3) and the rotation about y (axis 5). An element has four:

h = LENGTH / COUNT
turn = np.diag([1.0, -h, 1.0, -h])  # a positive rotation about y is a negative slope dz/dx
bending = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
inertia = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
stiffness, mass = np.zeros((2, 2 * COUNT + 2, 2 * COUNT + 2))
for i in range(COUNT):
    rows = np.s_[2 * i : 2 * i + 4, 2 * i : 2 * i + 4]
    stiffness[rows] += MODULUS * INERTIA / h**3 * turn @ bending @ turn
    mass[rows] += DENSITY * AREA * h / 420 * turn @ inertia @ turn
nodes = np.column_stack([np.linspace(0, LENGTH, COUNT + 1), np.zeros((COUNT + 1, 2))])
equations = np.array([(node + 1, axis) for node in range(COUNT + 1) for axis in (3, 5)])

# %%
# Node 1 is fixed. The reduced body has the two unknowns of the last node and the fixed-interface modes up to 3 kHz:

tip = gearcase.Point(nodes=(COUNT + 1,), axes=("uz", "ry"))
body = gearcase.reduce(stiffness, mass, {"tip": tip}, nodes=nodes, equations=equations, held=(1,), band=3000)
frequencies = np.sqrt(eigh(body.stiffness, body.mass, eigvals_only=True)) / (2 * np.pi)

# %%
# Exact (Euler-Bernoulli): f = b^2 / (2 pi L^2) sqrt(E I / (rho A)) with cos(b) cosh(b) = -1:

roots = np.array([1.8751041, 4.6940911, 7.8547574])
exact = roots**2 / (2 * np.pi * LENGTH**2) * np.sqrt(MODULUS * INERTIA / (DENSITY * AREA))

# %%
# Receptance of the free end (deflection for a force of 1 N), and exact natural frequencies as dotted lines. The
# printed error is the largest of the first three frequencies:

hertz = np.linspace(10, 3000, 2000)
unit = np.eye(len(body.mass))[0]
response = [np.linalg.solve(body.stiffness - (2 * np.pi * f) ** 2 * body.mass, unit)[0] for f in hertz]
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
axes.semilogy(hertz, np.abs(response))
for root in exact:
    axes.axvline(root, color="0.5", ls=":")
axes.set(xlabel="frequency, Hz", ylabel="receptance of the free end, m/N")
worst = float(max(abs(frequencies[:3] / exact - 1)))
print(f"{frequencies[0]:.2f} Hz, exact {exact[0]:.2f} Hz, {len(frequencies)} unknowns, error {worst:.1e}")
