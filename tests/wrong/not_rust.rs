spring: energy = 0.5 * k * x^2
