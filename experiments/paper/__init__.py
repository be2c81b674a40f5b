"""The paper, figure by figure: what this software computes beside what is printed."""
