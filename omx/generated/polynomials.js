// Sine, cosine and arc tangent as polynomials, exact to rounding in the ranges given.
//
// Written by notebooks/21-very-many-poses.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

/** Sine of t, |t| <= pi/2. 16 operations. */
export function sine(t) {
    const u = t*t;
    return (
        t*(0.9999999999999999 + u*(u*(0.008333333333282756 + u*(u*(2.7557316609073673e-06
        + u*((1.6048168318165643e-10 - 7.374387503862757e-13*u)*u - 2.505188194671259e-08))
        - 0.00019841269824861897)) - 0.16666666666666072))
    );
}

/** Cosine of t, |t| <= pi/2. 17 operations. */
export function cosine(t) {
    const u = t*t;
    return (
        1.0 + u*(u*(0.04166666666666388 + u*(u*(2.4801587277414926e-05 + u*(u*(2.0876561839933163e-09
        + (4.608977003001797e-14*u - 1.1462901901757276e-11)*u) - 2.755731639102575e-07))
        - 0.001388888888877299)) - 0.4999999999999997)
    );
}

/** Arc tangent of t, |t| <= tan(pi/8). 22 operations. */
export function arc_tangent(t) {
    const u = t*t;
    return (
        t*(1.0 + u*(u*(0.1999999999885511 + u*(u*(0.11111106180455946 + u*(u*(0.07689953496306857
        + u*(u*(0.056883492268090106 + (0.021135373157693246*u - 0.04348052215716463)*u)
        - 0.06640233930429408)) - 0.09090773074808414)) - 0.14285714180976467)) - 0.3333333333332844))
    );
}
