"""Reference methods that share no kernel with the strain-mode model they check."""
