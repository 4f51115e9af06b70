"""Electrons of a surface in a light, by Gauss–Legendre panels over published tables and the constants of scipy."""

import numpy as np
import scipy.constants
import scipy.interpolate

# CIE 15: A by Planck's law at 2848 K with the second constant of its time; daylight's tables go by temperatures that
# are as much higher as that constant has become since. D65 beyond 780 nm by ISO 11664-2's table: 63.8434, 64.3040 ….
DAYLIGHT_K = {name: nominal * 1.4388 / 1.4380 for name, nominal in (("D55", 5500.0), ("D65", 6500.0))}


def whole_table(colour, light):
    """colour-science's table of an illuminant and, beyond its end, what CIE 15 says; ``colour``: the package."""
    table = colour.SDS_ILLUMINANTS[light]
    nm, power = table.wavelengths, table.values
    if light == "A":
        more_nm = np.arange(nm[-1] + 5.0, 1101.0, 5.0)
        planck = more_nm**-5.0 / np.expm1(1.435e7 / 2848 / more_nm)
        more = 100.0 * planck / (560.0**-5.0 / np.expm1(1.435e7 / 2848 / 560.0))
    elif light in DAYLIGHT_K:
        t = DAYLIGHT_K[light]
        x = 0.244063 + 0.09911e3 / t + 2.9678e6 / t**2 - 4.6070e9 / t**3
        daylight = colour.sd_CIE_illuminant_D_series(np.array([x, -3.0 * x**2 + 2.870 * x - 0.275]))
        beyond = daylight.wavelengths > nm[-1]
        more_nm, more = daylight.wavelengths[beyond], daylight.values[beyond]
    else:
        return nm, power
    return np.append(nm, more_nm), np.append(power, more)


def electrons(colour, light, efficiency, reflectance, *, lux, f_number, area_um2, time_s):
    """Electrons in each channel; ``efficiency``, ``reflectance``: functions of the wavelength in nm."""
    table_nm, table = whole_table(colour, light)
    x, w = np.polynomial.legendre.leggauss(6)
    nm = (table_nm[:-1, None] + (x + 1) * np.diff(table_nm)[:, None] / 2).ravel()
    weight = (w * np.diff(table_nm)[:, None] / 2).ravel()
    eye = colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"]
    seen = np.interp(nm, eye.wavelengths, eye.values, left=0.0, right=0.0)  # CIE S 010: straight between nanometres
    power = scipy.interpolate.make_interp_spline(table_nm, table, k=1)(nm)
    power *= lux / (683.002 * (weight * power * seen).sum())
    joules_per_photon = scipy.constants.h * scipy.constants.c / (nm * 1e-9)
    per_m2 = reflectance(nm) * power / (4 * f_number**2) / joules_per_photon
    return efficiency(nm) @ (weight * per_m2) * (area_um2 * 1e-12 * time_s)


def efficiency(tables, channels, nm, *, per_energy, peak, filters=()):
    """Electrons per photon (channels, n): lines through tables {letter: (nm, values)}, whose highest is the peak."""
    tables = {letter: (np.array(w), np.array(v)) for letter, (w, v) in tables.items()}

    def per(w):
        return w if per_energy else np.ones_like(w)

    highest = max(float((v / per(w)).max()) for w, v in tables.values())
    passed = np.ones_like(nm)
    for w, v in filters:
        passed = passed * _line(np.array(w), np.array(v), nm)
    return np.array([_line(w, v, nm) / per(nm) * peak / highest for w, v in map(tables.get, channels)]) * passed


def _line(w, v, nm):
    return np.where((nm >= w[0]) & (nm <= w[-1]), scipy.interpolate.make_interp_spline(w, v, k=1)(nm), 0.0)
