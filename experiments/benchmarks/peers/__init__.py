"""Engines that the same problem is given to: ours, diffrax, scipy, CasADi and MuJoCo."""
