"""Energy that rough surfaces lose to a single bounce: writes the tables that kernels/materials/albedo.slang reads.

    python scripts/tabulate_albedos.py

Needs NumPy; takes some minutes, and writes the same bytes each time. Losses are means over facets of GGX with
heights correlated, as kernels/materials/microfacet.slang has them. The tables hold the fourth roots of losses, which
are interpolated linearly: far from grazing light losses grow with the fourth power of the roughness. Where that would
say that more is lost than is, and so have light made, the nodes around are lowered.
"""

from itertools import product
from pathlib import Path

import numpy as np

OUTPUT = Path(__file__).parent.parent / "crates/render/src/translation/device_scene/albedos.bin"

# Nodes of the tables, equal to those in kernels/materials/albedo.slang.
WIDTHS, COSINES, INDICES, SHEENS = 16, 32, 20, 16
STRETCHED_WIDTHS, STRETCHES, STRETCHED_COSINES = 22, 12, 32
# Cosines of the azimuth, to the direction along which facets are stretched.
AZIMUTHS = np.array([0, 0.1, 0.35, 1])
ROUGHNESS = np.linspace(np.sqrt(1e-3), 1, WIDTHS)
CONTRAST = np.geomspace(0.003 / 2.003, 0.5, INDICES)
FACETS = 128 ** 2
# Excess that is not seen: a part of the light in each loss, none in the shift of the cosine in the second place.
NOT_SEEN = np.array([1e-4, 0, 1e-4, 1e-4])


def index(contrast):
    return (1 + contrast) / (1 - contrast)


# Place of a cosine on an axis from 0 to 1, dense where light grazes.

def steepness(alpha, n, inside):
    critical2 = 1 - n ** -2
    return alpha * critical2 / (alpha * alpha + critical2) if inside else alpha


def place(cosine, k):
    return 0.7 * np.sqrt(cosine * (1 + k) / (cosine + k)) + 0.3 * cosine


def cosine_at(where, k):
    fine = np.linspace(0, 1, 4001) ** 3
    return max(1e-6, np.interp(where, place(fine, k), fine))


# Integrals

def fresnel(cosine, eta):
    sine2 = eta * eta * (1 - cosine * cosine)
    inner = np.sqrt(np.clip(1 - sine2, 0, 1))
    p = (cosine - eta * inner) / (cosine + eta * inner)
    s = (eta * cosine - inner) / (eta * cosine + inner)
    return np.where(sine2 >= 1, 1, (p * p + s * s) / 2), inner, sine2 >= 1


def smith(cosine, alpha):
    cosine2 = np.clip(cosine * cosine, 1e-18, 1)
    t = alpha * alpha * (1 - cosine2) / cosine2
    return 0.5 * t / (np.sqrt(1 + t) + 1)


def visible_normals(mu, alpha):
    """Cosines of facets to wo and to the surface's normal, two arrays; the facets have the density of those seen from
    the cosine `mu`."""
    i = np.arange(FACETS)
    u, v = (i + 0.5) / FACETS, (i * 0.6180339887498949 + 0.5) % 1
    sine = np.sqrt(max(0, 1 - mu * mu))
    wo = np.array([alpha * sine, 0, mu])
    wo /= np.linalg.norm(wo)
    up = (1 - v) * (1 + wo[2])
    z = up - wo[2]
    r = np.sqrt(np.clip((1 - z) * (1 + z), 0, 1))
    m = np.stack([alpha * (r * np.cos(np.pi * u) + wo[0]), alpha * r * np.sin(np.pi * u), up])
    m /= np.linalg.norm(m, axis=0)
    return sine * m[0] + mu * m[2], m[2]


def single_bounce(mu, alpha, etas):
    """Loss of a mirror, and for each eta a row: the light that a boundary reflects, its loss, and the loss of a
    boundary that reflects nothing but totally."""
    c, up = visible_normals(mu, alpha)
    lo = smith(mu, alpha)
    z = 2 * c * up - mu
    mirror = np.where(z > 0, (1 + lo) / (1 + lo + smith(z, alpha)), 0)
    rows = []
    for eta in etas:
        f, inner, total = fresnel(c, eta)
        z = eta * (c * up - mu) - inner * up
        passes = np.where((z < 0) & ~total, np.minimum(1, (1 + lo) / (1 + smith(z, alpha))), 0)
        rows.append([(f * mirror).mean(), 1 - (f * mirror + (1 - f) * passes).mean(),
                     1 - np.where(total, mirror, passes).mean()])
    return 1 - mirror.mean(), np.array(rows)


def charlie(mu, roughness, n=200):
    """Directional albedo of Charlie sheen (KHR_materials_sheen)."""
    alpha = roughness * roughness
    k = (1 - alpha) ** 2
    a, b, c, d, e = (p * (1 - k) + q * k for p, q in ((21.5473, 25.3245), (3.82987, 3.32435), (0.19823, 0.16801),
                                                       (-1.97760, -1.27393), (-4.32054, -4.85967)))

    def masking(x):
        curve = lambda x: a / (1 + b * np.maximum(x, 1e-6) ** c) + d * x + e
        return np.where(x < 0.5, np.exp(curve(np.minimum(x, 0.5))), np.exp(2 * curve(0.5) - curve(1 - np.maximum(x, 0.5))))

    q = (np.arange(n) + 0.5) / n
    z, phi = np.meshgrid(q * q, np.pi * q, indexing="ij")
    r = np.sqrt(1 - z * z)
    h = np.stack([r * np.cos(phi) + np.sqrt(1 - mu * mu), r * np.sin(phi), z + mu])
    sine2 = np.clip(1 - h[2] ** 2 / (h * h).sum(0), 0, 1)
    value = (2 + 1 / alpha) * sine2 ** (0.5 / alpha) / (2 * np.pi) / (4 * mu * (1 + masking(np.float64(mu)) + masking(z)))
    return (value * 2 * q[:, None]).sum() * 2 * np.pi / n ** 2


LOSSES = [0, 2, 3]
UPWARD = np.array([1, -1, 1, 1])


def roots(table):
    """Copy of the table with the fourth roots of its losses."""
    table = table.copy()
    table[..., LOSSES] = np.maximum(0, table[..., LOSSES]) ** 0.25
    return table


def powers(table):
    table = table.copy()
    table[..., LOSSES] **= 4
    return table


# Tables by side, index, width and cosine: the loss of a mirror, the shift to the cosine at which a smooth boundary
# reflects as much, the loss of a boundary, and that of a clear one. Inside, the first two are not used.

def shift(reflected, mirror_loss, mu, n):
    """Shift from `mu` to the cosine at which a smooth boundary reflects `reflected` as a part of a mirror's light."""
    cosines = np.linspace(0, 1, 20001)
    share = np.minimum(1, reflected / np.maximum(1e-9, 1 - mirror_loss))
    return np.interp(-share, -fresnel(cosines, 1 / n)[0], cosines) - mu


def losses(roughness, where, contrasts, inside):
    """Rows of the table's four numbers at one place of its axes, one row for each of `contrasts`."""
    alpha, ns = roughness ** 2, index(contrasts)
    rows = []
    for n in ns if inside else ns[:1]:
        mu = cosine_at(where, steepness(alpha, n, inside))
        mirror, bounced = single_bounce(mu, alpha, [n] if inside else 1 / ns)
        rows += [[mirror, 0 if inside else shift(reflected, mirror, mu, n), lost, clear]
                 for (reflected, lost, clear), n in zip(bounced, [n] if inside else ns)]
    return np.array(rows)


def nodes_of(inside):
    where = np.linspace(0, 1, COSINES)
    return np.array([[losses(r, w, CONTRAST, inside) for w in where] for r in ROUGHNESS]).transpose(2, 0, 1, 3)


def between(table, at):
    """Interpolated values of all cells at the place `at` within each: (along index, width, cosine), 0 to 1."""
    corners = lambda i, j, k: table[i:INDICES - 1 + i, j:WIDTHS - 1 + j, k:COSINES - 1 + k]
    weight = lambda steps: np.prod([t if step else 1 - t for step, t in zip(steps, at)])
    return sum(weight(steps) * corners(*steps) for steps in product((0, 1), repeat=3))


def in_cells(inside, at):
    """True values of all cells at the place `at` within each."""
    index_at, width_at, cosine_at = at
    contrasts = CONTRAST[:-1] ** (1 - index_at) * CONTRAST[1:] ** index_at
    roughness = (1 - width_at) * ROUGHNESS[:-1] + width_at * ROUGHNESS[1:]
    where = (np.arange(COSINES - 1) + cosine_at) / (COSINES - 1)
    return np.array([[losses(r, w, contrasts, inside) for w in where] for r in roughness]).transpose(2, 0, 1, 3)


def lowered(table, inside):
    """The table, lowered little by little where it would say more than there is at several places between its nodes."""
    places = [(0.5, 0.5, 0.5), (0.3, 0.7, 0.25), (0.7, 0.3, 0.75)]
    truth = [in_cells(inside, at) for at in places]
    for _ in range(40):
        down = np.zeros_like(table)
        for at, true in zip(places, truth):
            excess = 0.2 * np.maximum(0, powers(between(roots(table), at)) - true - NOT_SEEN)
            for i, j, k in product((0, 1), repeat=3):
                corner = down[i:INDICES - 1 + i, j:WIDTHS - 1 + j, k:COSINES - 1 + k]
                np.maximum(corner, excess, out=corner)
        table = table - down
    return table


def mean(column, roughness, contrast, inside):
    """Means over the hemisphere of a column of roots as it is interpolated: the losses, and in the second place the
    mirror's albedo x how far Fresnel's reflectance is toward that at grazing incidence."""
    mu, weight = np.polynomial.legendre.leggauss(400)
    mu, weight = ((mu + 1) / 2) ** 2, weight * (mu + 1) / 2
    n = index(contrast)
    where = place(mu, steepness(roughness ** 2, n, inside)) * (COSINES - 1)
    values = powers(np.stack([np.interp(where, np.arange(COSINES), channel) for channel in column.T], 1))
    cosine = np.clip(mu + values[:, 1], 1e-4, 1)
    values[:, 1] = (1 - values[:, 0]) * (fresnel(cosine, 1 / n)[0] - contrast ** 2) / (1 - contrast ** 2)
    return (2 * mu * weight) @ values


def means(table, inside):
    """Means of all columns: losses raised little by little where they would be less than those between the columns, and
    the values in the second place lowered where they would be more."""
    columns = roots(table)
    rows = np.array([[mean(columns[q, g], r, c, inside) for g, r in enumerate(ROUGHNESS)] for q, c in enumerate(CONTRAST)])
    weights = lambda at: [(slice(i, INDICES - 1 + i), slice(j, WIDTHS - 1 + j), abs(1 - i - at[0]) * abs(1 - j - at[1]))
                          for i, j in product((0, 1), repeat=2)]
    at = lambda values, where: sum(w * values[q, g] for q, g, w in weights(where))
    places = [(0.5, 0.5), (0.5, 0), (0, 0.5)]
    truth = []
    for where in places:
        between = at(columns, where)
        contrast = CONTRAST[:-1] ** (1 - where[0]) * CONTRAST[1:] ** where[0]
        roughness = (1 - where[1]) * ROUGHNESS[:-1] + where[1] * ROUGHNESS[1:]
        truth.append(np.array([[mean(between[q, g], r, c, inside) for g, r in enumerate(roughness)]
                               for q, c in enumerate(contrast)]))
    for _ in range(40):
        up = np.zeros_like(rows)
        for where, true in zip(places, truth):
            lacking = 0.2 * np.maximum(0, UPWARD * (roots(true) - at(roots(rows), where)))
            for q, g, w in weights(where):
                up[q, g] = np.maximum(up[q, g], lacking * (w > 0))
        rows = powers(roots(rows) + UPWARD * up)
    return rows


def sheen():
    """Albedo of sheen by roughness and cosine, raised where it would say less than there is between its nodes."""
    at = lambda i, j: charlie(max(5e-4, cosine_at(j / (COSINES - 1), 1)), 10 ** (i / (SHEENS - 1) - 1))
    table = np.array([[at(i, j) for j in range(COSINES)] for i in range(SHEENS)])
    raised = table.copy()
    for i, j in product(range(SHEENS - 1), range(COSINES - 1)):
        cell = (slice(i, i + 2), slice(j, j + 2))
        raised[cell] = np.maximum(raised[cell], table[cell] + at(i + 0.5, j + 0.5) - table[cell].mean())
    return raised


# Loss of a mirror whose facets are stretched, by the roughness across, how far the roughness along is on its way to 1
# (its square root), the cosine, and the azimuth.

def stretched_loss(across, stretch, where, azimuth):
    y = across ** 2
    x = y + (1 - y) * stretch ** 2
    mu = cosine_at(where, x)
    sine = np.sqrt(max(0, 1 - mu * mu))
    wo = np.array([sine * azimuth, sine * np.sqrt(1 - azimuth ** 2), mu])
    masked = lambda w: smith(w[2], np.sqrt(((x * w[0]) ** 2 + (y * w[1]) ** 2) / np.maximum(1e-30, w[0] ** 2 + w[1] ** 2)))
    count = 96 ** 2
    i = np.arange(count)
    u, v = (i + 0.5) / count, (i * 0.6180339887498949 + 0.5) % 1
    seen = wo * [x, y, 1] / np.linalg.norm(wo * [x, y, 1])
    up = (1 - v) * (1 + seen[2])
    r = np.sqrt(np.clip(1 - (up - seen[2]) ** 2, 0, 1))
    m = np.stack([x * (r * np.cos(2 * np.pi * u) + seen[0]), y * (r * np.sin(2 * np.pi * u) + seen[1]), up])
    m /= np.linalg.norm(m, axis=0)
    wi = 2 * (wo @ m) * m - wo[:, None]
    return 1 - np.where(wi[2] > 0, (1 + masked(wo)) / (1 + masked(wo) + masked(wi)), 0).mean()


def stretched():
    """Losses by width, stretch, cosine and azimuth, lowered where they would say more than there is between the nodes;
    behind the cosines their mean, raised likewise."""
    widths, stretches = np.linspace(ROUGHNESS[0], 1, STRETCHED_WIDTHS), np.linspace(0, 1, STRETCHES)
    where = np.linspace(0, 1, STRETCHED_COSINES)
    losses = lambda r, s, c, a: np.array([[[[stretched_loss(*at) for at in product([ri], [si], [ci], a)] for ci in c]
                                           for si in s] for ri in r]).reshape(len(r), len(s), len(c), len(a))
    nodes = losses(widths, stretches, where, AZIMUTHS)
    middle = lambda axis, at: (1 - at) * axis[:-1] + at * axis[1:]
    places = [(0.5, 0.5, 0.5, 0.5), (0.3, 0.7, 0.25, 0.4), (0.7, 0.3, 0.75, 0.6)]
    truth = [losses(*(middle(axis, at) for axis, at in zip((widths, stretches, where, AZIMUTHS), place))) for place in places]
    corner = lambda table, steps: table[tuple(slice(step, size - 1 + step) for step, size in zip(steps, table.shape))]
    weigh = lambda steps, at: np.prod([t if step else 1 - t for step, t in zip(steps, at)])
    for _ in range(40):
        down = np.zeros_like(nodes)
        for at, true in zip(places, truth):
            found = sum(weigh(steps, at) * corner(nodes ** 0.25, steps) for steps in product((0, 1), repeat=4)) ** 4
            excess = 0.2 * np.maximum(0, found - true - NOT_SEEN[0])
            for steps in product((0, 1), repeat=4):
                np.maximum(corner(down, steps), excess, out=corner(down, steps))
        nodes = np.maximum(0, nodes - down)
    roots = nodes ** 0.25

    def mean(columns, across, stretch):
        mu, weight = np.polynomial.legendre.leggauss(200)
        mu, weight = ((mu + 1) / 2) ** 2, weight * (mu + 1) / 2
        azimuth = np.abs(np.cos((np.arange(64) + 0.5) / 64 * np.pi / 2))
        x = across ** 2 + (1 - across ** 2) * stretch ** 2
        at = place(mu, x) * (STRETCHED_COSINES - 1)
        rows = np.stack([np.interp(at, np.arange(STRETCHED_COSINES), column) for column in columns.T], 1)
        values = np.array([np.interp(azimuth, AZIMUTHS, row) for row in rows]) ** 4
        return (2 * mu * weight) @ values.mean(1)

    means = np.array([[mean(roots[i, j], r, s) for j, s in enumerate(stretches)] for i, r in enumerate(widths)])
    half = np.array([[mean(roots[i:i + 2, j:j + 2].mean((0, 1)), widths[i:i + 2].mean(), stretches[j:j + 2].mean())
                      for j in range(STRETCHES - 1)] for i in range(STRETCHED_WIDTHS - 1)])
    for _ in range(40):
        raised = means ** 0.25
        found = sum(corner(raised, steps) for steps in product((0, 1), repeat=2)) / 4
        lacking = 0.2 * np.maximum(0, half ** 0.25 - found)
        for steps in product((0, 1), repeat=2):
            np.maximum(corner(raised, steps), corner(raised, steps) + lacking, out=corner(raised, steps))
        means = raised ** 4
    return np.floor(np.clip(roots, 0, 1) * 65535), np.ceil(np.clip(means ** 0.25, 0, 1) * 65535)


def packed(table, offset, scale, rounded=np.floor):
    """The table as integers of 16 bits: 0 stands for `offset`, 65535 for `offset + scale`."""
    return rounded(np.clip((table - offset) / scale, 0, 1) * 65535).astype("<u2")


def main():
    blocks = []
    for inside in (False, True):
        table = np.clip(lowered(nodes_of(inside), inside), [0, -1, 0, 0], 1)
        cells = packed(roots(table), np.array([0, -1, 0, 0]), np.array([1, 2, 1, 1]))
        mean = packed(roots(means(table, inside)), 0, 1, lambda x: UPWARD * np.ceil(UPWARD * x))
        blocks.append(np.concatenate([cells, mean[:, :, None]], axis=2))
    blocks.append(packed(np.pad(sheen()[:, :, None], ((0, 0), (0, 0), (0, 3))), 0, 4, np.ceil))
    losses, mean = stretched()
    column = np.pad(mean[:, :, None, None], ((0, 0), (0, 0), (0, 0), (0, 3)))
    blocks.append(np.concatenate([losses, column], axis=2).astype("<u2"))
    OUTPUT.write_bytes(b"".join(block.tobytes() for block in blocks))


if __name__ == "__main__":
    main()
