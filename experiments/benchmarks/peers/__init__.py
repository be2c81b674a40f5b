"""Engines that the same problem is given to: ours, diffrax, scipy and MuJoCo."""
