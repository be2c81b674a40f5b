"""The linear models of section 3: state space, natural frequencies, stiffness."""
