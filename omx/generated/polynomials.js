// Sine, cosine and arc tangent in plain arithmetic.
//
// Written by notebooks/21-very-many-poses.ipynb. Do not edit: change the chapter and run it.
// Lengths are in mm, angles in rad.

/** Sine of x, to the last bit of x, |x| <= 10000 rad. 31 operations. */
export function sine(x) {
    const n = Math.floor(1/2 + x/Math.PI);
    const rest = x - Math.PI*n;
    const t = rest - 1.2246467991473532e-16*n;
    const u = t*t;
    const sign = 1 + 4*Math.floor(n/2) - 2*n;
    return (
        sign*t*(0.9999999999999999 + u*(u*(0.008333333333282756 + u*(u*(2.7557316609073673e-06
        + u*((1.6048168318165643e-10 - 7.374387503862757e-13*u)*u - 2.505188194671259e-08))
        - 0.00019841269824861897)) - 0.16666666666666072))
    );
}

/** Cosine of x, to the last bit of x, |x| <= 10000 rad. 32 operations. */
export function cosine(x) {
    const n = Math.floor(1/2 + x/Math.PI);
    const rest = x - Math.PI*n;
    const t = rest - 1.2246467991473532e-16*n;
    const u = t*t;
    const sign = 1 + 4*Math.floor(n/2) - 2*n;
    return (
        sign*(1.0 + u*(u*(0.04166666666666388 + u*(u*(2.4801587277414926e-05 + u*(u*(2.0876561839933163e-09
        + (4.608977003001797e-14*u - 1.1462901901757276e-11)*u) - 2.755731639102575e-07))
        - 0.001388888888877299)) - 0.4999999999999997))
    );
}

/** The angle of (x, y), rad. 45 operations. */
export function arc_tangent(y, x) {
    const across = Math.abs(x);
    const up = Math.abs(y);
    const smaller = across < up ? across : up;
    const larger = across < up ? up : across;
    const border = (Math.sqrt(2) - 1)*larger;
    const over = border < smaller ? smaller - larger : smaller;
    const under = border < smaller ? larger + smaller : (larger <= 0 ? 1.0 : larger);
    const t = over/under;
    const u = t*t;
    const part = (
        t*(1.0 + u*(u*(0.1999999999885511 + u*(u*(0.11111106180455946 + u*(u*(0.07689953496306857
        + u*(u*(0.056883492268090106 + (0.021135373157693246*u - 0.04348052215716463)*u)
        - 0.06640233930429408)) - 0.09090773074808414)) - 0.14285714180976467)) - 0.3333333333332844))
    );
    const octant = border < smaller ? Math.PI/4 + part : part;
    const quadrant = across < up ? Math.PI/2 - octant : octant;
    const upper = x < 0 ? Math.PI - quadrant : quadrant;
    return y < 0 ? -upper : upper;
}
