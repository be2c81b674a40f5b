"""What a calibration comes to, in numbers and in words, each computed once.

Reports, the terminal and files print these; none of them fits or judges anything itself.
"""
