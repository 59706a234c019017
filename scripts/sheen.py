#!/usr/bin/env python3
"""Fit the directional albedo of the Charlie sheen [E51] from above, and print the rows of SHEEN_ALBEDO (src/packed/constants.rs).

    E(c, r) ~ sum over j, i of K[j][i] c^(j/2) r^i      cosine c from 0 to 1, roughness r from 0.3 to 1

The albedo is integrated in f64; a linear program finds the least largest error of all fits that nowhere lie below it. Needs numpy and
scipy."""

import numpy as np
from scipy.optimize import linprog

# Lambda of Estevez & Kulla 2017, table 1: rows of (alpha = 0, alpha = 1).
TERMS = [(25.3245, 21.5473), (3.32435, 3.82987), (0.16801, 0.19823), (-1.27393, -1.97760), (-4.85967, -4.32054)]
ROWS, COLUMNS = 7, 4


def exponent(x, alpha):
    t = (1 - alpha) ** 2
    a, b, c, d, e = (t * rough + (1 - t) * smooth for rough, smooth in TERMS)
    return a / (1 + b * x**c) + d * x + e


def lam(c, alpha):
    return np.where(c < 0.5, np.exp(exponent(c, alpha)), np.exp(2 * exponent(0.5, alpha) - exponent(1 - c, alpha)))


def albedo(co, roughness, n=400):
    """Light at the cosine co that the lobe sends on, of white."""
    alpha = roughness**2
    u = (np.arange(n) + 0.5) / n
    ci, width = (u**1.5)[:, None], (1.5 * u**0.5 / n)[:, None]
    phi = (u * np.pi)[None, :]
    si, so = np.sqrt(1 - ci * ci), np.sqrt(1 - co * co)
    x, y, z = si * np.cos(phi) + so, si * np.sin(phi), ci + co
    sin_h = np.sqrt((x * x + y * y) / (x * x + y * y + z * z))
    density = (2 + 1 / alpha) * sin_h ** (1 / alpha) / (2 * np.pi)
    seen = 1 / ((1 + lam(ci, alpha) + lam(co, alpha)) * 4 * ci * co)
    return float((density * seen * ci * width * 2 * np.pi / n).sum())


def terms(c, r):
    return [c ** (j / 2) * r**i for j in range(ROWS) for i in range(COLUMNS)]


def main():
    places = [(max(1e-3, c), r) for c in np.linspace(0, 1, 41) ** 1.5 for r in np.linspace(0.3, 1, 29)]
    wanted = np.array([albedo(c, r) for c, r in places])
    powers = np.array([terms(c, r) for c, r in places])
    # least e with E <= fit <= E + e
    ones = np.ones((len(places), 1))
    rows = np.vstack([np.hstack([-powers, 0 * ones]), np.hstack([powers, -ones])])
    limits = np.concatenate([-wanted - 2e-4, wanted])
    cost = [0] * (ROWS * COLUMNS) + [1]
    found = linprog(cost, A_ub=rows, b_ub=limits, bounds=[(None, None)] * len(cost), method="highs")
    fit = np.round(found.x[:-1], 4)
    off = powers @ fit - wanted
    for row in fit.reshape(ROWS, COLUMNS):
        print("    [" + ", ".join(f"{k:.4f}" for k in row) + "],")
    print(f"error from {off.min():.4f} to {off.max():.4f}, largest albedo {wanted.max():.4f}")


if __name__ == "__main__":
    main()
