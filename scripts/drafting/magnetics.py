"""Inductance of coaxial turns, and what a winding's field has in the multipoles of a sphere inside it."""
import math

MU0 = 4e-7 * math.pi


def elliptic(m):
    """Complete elliptic integrals K and E, by the arithmetic-geometric mean [Abramowitz & Stegun 17.6]."""
    a, b, c, power, s = 1.0, math.sqrt(1 - m), math.sqrt(m), 1.0, m / 2
    while c > 1e-14:
        a, b, c = (a + b) / 2, math.sqrt(a * b), (a - b) / 2
        s, power = s + power * c * c, 2 * power
    return math.pi / (2 * a), math.pi / (2 * a) * (1 - s)


def mutual_H(r1, r2, apart):
    """Two coaxial turns [Maxwell; Grover, Inductance Calculations, ch. 11]."""
    m = 4 * r1 * r2 / ((r1 + r2) ** 2 + apart ** 2)
    k = math.sqrt(m)
    K, E = elliptic(m)
    return MU0 * math.sqrt(r1 * r2) * ((2 / k - k) * K - 2 / k * E)


def legendre_slopes(c, count):
    """P'_l(c) for l = 1, 3, 5, ..."""
    slopes, below, slope_below, p, slope, l = [], 1.0, 0.0, c, 1.0, 1
    while len(slopes) < count:
        if l % 2:
            slopes.append(slope)
        next_p = ((2 * l + 1) * c * p - l * below) / (l + 1)
        below, slope_below, p, slope = p, slope, next_p, slope_below + (2 * l + 1) * p
        l += 1
    return slopes
