"""Section VI of the paper, reproduced: every table and every figure, computed and compared."""
