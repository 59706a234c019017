"""Spectral tables: writes src/spectrum/tables.txt, which the program carries.

    pip install colour-science==0.4.7
    python3 scripts/spectral-tables.py > src/spectrum/tables.txt

One table a line: its name, the first wavelength and the step in nm, then the values. The observer's curves run from
360 to 830 nm; lamps as far as they are published inside of that. Where a lamp is published no further than 780 nm
and has a formula, the rest is computed: daylight by CIE 15, illuminant A by its own formula.
"""

import math
import warnings

warnings.filterwarnings("ignore")
import colour  # noqa: E402
from colour.colorimetry import sd_CIE_illuminant_D_series  # noqa: E402
from colour.temperature import CCT_to_xy_CIE_D  # noqa: E402

FIRST, LAST = 360, 830
# name in scene files, name in the package
LAMPS = [
    ("FL2", "FL2"),
    ("FL7", "FL7"),
    ("FL11", "FL11"),
    ("HP1", "HP1"),
    ("HP4", "HP4"),
    ("LED-B1", "LED-B1"),
    ("LED-B3", "LED-B3"),
    ("LED-B5", "LED-B5"),
]
# the second radiation constant when the D series was defined, and now, m K
C2_OLD, C2 = 1.4380, 1.438776877


def line(name, first, step, values):
    numbers = " ".join(f"{v:.7g}" for v in values)
    print(f"{name} {first:g} {step:g} {numbers}")


def inside(curve, step):
    curve = curve.copy()
    first = max(FIRST, curve.wavelengths[0])
    last = min(LAST, curve.wavelengths[-1])
    assert curve.shape.interval == step and (first - curve.wavelengths[0]) % step == 0
    chosen = [v for w, v in zip(curve.wavelengths, curve.values) if first <= w <= last]
    return first, chosen


def incandescent(nm):
    """Illuminant A by its definition, CIE 15 eq. 1."""
    return 100 * (560 / nm) ** 5 * math.expm1(1.435e7 / (2848 * 560)) / math.expm1(1.435e7 / (2848 * nm))


def daylight(kelvin, published):
    """Daylight of a nominal colour temperature to 830 nm, as published where it is."""
    computed = sd_CIE_illuminant_D_series(CCT_to_xy_CIE_D(kelvin * C2 / C2_OLD))
    for w, v in zip(published.wavelengths, published.values):
        assert abs(computed[w] - v) < 2e-3, (w, v)
        computed[w] = v
    return computed


print("# Made by scripts/spectral-tables.py from colour-science", colour.__version__, "(CIE 15:2018, CIE 018:2019).")
print("# name first_nm step_nm values")
observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
for column, name in enumerate(["xbar", "ybar", "zbar"]):
    line(name, FIRST, 1, observer.values[:, column])
illuminants = colour.SDS_ILLUMINANTS
for w, v in zip(illuminants["A"].wavelengths, illuminants["A"].values):
    assert abs(incandescent(w) - v) < 1e-4 * v, (w, v)
line("A", FIRST, 5, [incandescent(w) for w in range(FIRST, LAST + 1, 5)])
for name, kelvin in [("D50", 5000), ("D65", 6500)]:
    first, values = inside(daylight(kelvin, illuminants[name]), 5)
    line(name, first, 5, values)
for name, theirs in LAMPS:
    first, values = inside(illuminants[theirs], 5)
    line(name, first, 5, values)


def bases():
    """Reflectances that are red, green and blue in daylight and add up to one: the smoothest from 0 to 1 at every 10 nm.

    Of two of them the squares of second differences, and those of what they leave of one, are made least under the six
    conditions on their colours, by the alternating direction method of multipliers.
    """
    import numpy as np

    nm = np.arange(FIRST, LAST + 1)
    published = daylight(6500, illuminants["D65"])
    lit = np.interp(nm, published.wavelengths, published.values)
    cmf = np.array([np.interp(nm, observer.wavelengths, column) for column in observer.values.T])
    primaries = np.array([[x / y, 1, (1 - x - y) / y] for x, y in [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)]]).T
    white = cmf @ lit / (cmf[1] @ lit)
    to_rgb = np.linalg.inv(primaries * np.linalg.solve(primaries, white))
    knots = np.arange(FIRST, LAST + 1, 10)
    n = len(knots)
    hats = np.array([np.interp(nm, knots, row) for row in np.eye(n)])
    colours = to_rgb @ (cmf * lit) / (cmf[1] @ lit) @ hats.T
    second = np.diff(np.eye(n), 2, axis=0)
    rough = second.T @ second
    roughness = np.block([[2 * rough, rough], [rough, 2 * rough]])
    zero = np.zeros_like(colours)
    conditions, wanted = np.block([[colours, zero], [zero, colours]]), np.array([1, 0, 0, 0, 1, 0])
    kept = np.vstack([np.eye(2 * n), np.hstack([np.eye(n), np.eye(n)])])
    weight = 1e-2
    system = np.block([[roughness + weight * kept.T @ kept, conditions.T], [conditions, np.zeros((6, 6))]])
    inverse = np.linalg.inv(system)
    within, dual = np.full(3 * n, 0.4), np.zeros(3 * n)
    for _ in range(200_000):
        found = (inverse @ np.concatenate([weight * kept.T @ (within - dual), wanted]))[: 2 * n]
        next_within = np.clip(kept @ found + dual, 0, 1)
        dual += kept @ found - next_within
        done = max(abs(kept @ found - next_within).max(), abs(within - next_within).max()) < 1e-9
        within = next_within
        if done:
            break
    red, green = found[:n], found[n:]
    return [np.clip(basis, 0, 1) for basis in (red, green, 1 - red - green)]


for name, basis in zip(["basis-r", "basis-g", "basis-b"], bases()):
    line(name, FIRST, 10, [round(value, 9) + 0.0 for value in basis])
