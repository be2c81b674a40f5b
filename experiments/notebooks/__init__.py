"""The paper as a notebook, run by the tests."""
