"""How the arm is shown: the 3-D viewer, the panels with sliders, the figures."""
