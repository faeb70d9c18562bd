"""Sine, cosine and arc tangent in plain arithmetic.

Written by notebooks/21-very-many-poses.ipynb. Do not edit: change the chapter and run it.
Lengths are in mm, angles in rad. `..._batch` is the same formula for columns: arrays of one
shape, NumPy's or those of another library that keeps to the array API standard.
"""

from math import floor, pi, sqrt

from omx.arrays import Array, namespace, where


def sine(x: float) -> float:
    """Sine of x, to the last bit of x, |x| <= 10000 rad. 31 operations."""
    n = floor(1/2 + x/pi)
    rest = x - pi*n
    t = rest - 1.2246467991473532e-16*n
    u = t*t
    sign = 1 + 4*floor(n/2) - 2*n
    return (
        sign*t*(0.9999999999999999 + u*(u*(0.008333333333282756 + u*(u*(2.7557316609073673e-06
        + u*((1.6048168318165643e-10 - 7.374387503862757e-13*u)*u - 2.505188194671259e-08))
        - 0.00019841269824861897)) - 0.16666666666666072))
    )


def sine_batch(x: Array) -> Array:
    """Sine of x, to the last bit of x, |x| <= 10000 rad. Columns in, columns out."""
    xp = namespace(x)
    n = xp.floor(1/2 + x/pi)
    rest = x - pi*n
    t = rest - 1.2246467991473532e-16*n
    u = t*t
    sign = 1 + 4*xp.floor(n/2) - 2*n
    return (
        sign*t*(0.9999999999999999 + u*(u*(0.008333333333282756 + u*(u*(2.7557316609073673e-06
        + u*((1.6048168318165643e-10 - 7.374387503862757e-13*u)*u - 2.505188194671259e-08))
        - 0.00019841269824861897)) - 0.16666666666666072))
    )


def cosine(x: float) -> float:
    """Cosine of x, to the last bit of x, |x| <= 10000 rad. 32 operations."""
    n = floor(1/2 + x/pi)
    rest = x - pi*n
    t = rest - 1.2246467991473532e-16*n
    u = t*t
    sign = 1 + 4*floor(n/2) - 2*n
    return (
        sign*(1.0 + u*(u*(0.04166666666666388 + u*(u*(2.4801587277414926e-05 + u*(u*(2.0876561839933163e-09
        + (4.608977003001797e-14*u - 1.1462901901757276e-11)*u) - 2.755731639102575e-07))
        - 0.001388888888877299)) - 0.4999999999999997))
    )


def cosine_batch(x: Array) -> Array:
    """Cosine of x, to the last bit of x, |x| <= 10000 rad. Columns in, columns out."""
    xp = namespace(x)
    n = xp.floor(1/2 + x/pi)
    rest = x - pi*n
    t = rest - 1.2246467991473532e-16*n
    u = t*t
    sign = 1 + 4*xp.floor(n/2) - 2*n
    return (
        sign*(1.0 + u*(u*(0.04166666666666388 + u*(u*(2.4801587277414926e-05 + u*(u*(2.0876561839933163e-09
        + (4.608977003001797e-14*u - 1.1462901901757276e-11)*u) - 2.755731639102575e-07))
        - 0.001388888888877299)) - 0.4999999999999997))
    )


def arc_tangent(y: float, x: float) -> float:
    """The angle of (x, y), rad. 45 operations."""
    across = abs(x)
    up = abs(y)
    smaller = across if across < up else up
    larger = up if across < up else across
    border = (sqrt(2) - 1)*larger
    over = smaller - larger if border < smaller else smaller
    under = larger + smaller if border < smaller else (1.0 if larger <= 0 else larger)
    t = over/under
    u = t*t
    part = (
        t*(1.0 + u*(u*(0.1999999999885511 + u*(u*(0.11111106180455946 + u*(u*(0.07689953496306857
        + u*(u*(0.056883492268090106 + (0.021135373157693246*u - 0.04348052215716463)*u)
        - 0.06640233930429408)) - 0.09090773074808414)) - 0.14285714180976467)) - 0.3333333333332844))
    )
    octant = pi/4 + part if border < smaller else part
    quadrant = pi/2 - octant if across < up else octant
    upper = pi - quadrant if x < 0 else quadrant
    return -upper if y < 0 else upper


def arc_tangent_batch(y: Array, x: Array) -> Array:
    """The angle of (x, y), rad. Columns in, columns out."""
    xp = namespace(y, x)
    across = xp.abs(x)
    up = xp.abs(y)
    smaller = where(across < up, across, up)
    larger = where(across < up, up, across)
    border = (sqrt(2) - 1)*larger
    over = where(border < smaller, smaller - larger, smaller)
    under = where(border < smaller, larger + smaller, where(larger <= 0, 1.0, larger))
    t = over/under
    u = t*t
    part = (
        t*(1.0 + u*(u*(0.1999999999885511 + u*(u*(0.11111106180455946 + u*(u*(0.07689953496306857
        + u*(u*(0.056883492268090106 + (0.021135373157693246*u - 0.04348052215716463)*u)
        - 0.06640233930429408)) - 0.09090773074808414)) - 0.14285714180976467)) - 0.3333333333332844))
    )
    octant = where(border < smaller, pi/4 + part, part)
    quadrant = where(across < up, pi/2 - octant, octant)
    upper = where(x < 0, pi - quadrant, quadrant)
    return where(y < 0, -upper, upper)
