"""The paper's figures with measured data, one file each, and its claim about model errors."""
