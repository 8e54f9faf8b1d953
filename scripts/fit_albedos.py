"""Fits kernels/materials/albedo.slang: how much light rough surfaces return after a single bounce.

    python scripts/fit_albedos.py > kernels/materials/albedo.slang

Needs numpy alone. Integrates over the visible normals of GGX (and, for sheen, over the hemisphere), fits sums of a few
sigmoids by Levenberg and Marquardt's method, reweighted toward the least largest error, and shifts each to the side on
which what is made up for with it never makes light. Takes some minutes; the same numbers each time.
"""

import sys

import numpy as np

ALPHA = np.array([0.04, 0.07, 0.1, 0.15, 0.2, 0.26, 0.32, 0.39, 0.46, 0.53, 0.6, 0.67, 0.74, 0.81, 0.88, 0.94, 1.0]) ** 2
COSINE = np.array([0.01, 0.016, 0.025, 0.035, 0.05, 0.065, 0.085, 0.11, 0.14, 0.18, 0.22, 0.27, 0.33, 0.4, 0.48, 0.56,
                   0.65, 0.74, 0.83, 0.92, 1.0])
# (n - 1) / (n + 1): the root of the reflectance at normal incidence, for indices n from 1.005 to 3.
CONTRAST = np.array([0.0025, 0.01, 0.02, 0.03, 0.04, 0.055, 0.075, 0.1, 0.13, 0.165, 0.2, 0.25, 0.3, 0.36, 0.42, 0.5])
LEAST_GLASS = 2  # where the fits for glass begin, in CONTRAST
FACETS = 120 ** 2


# Integrals

def fresnel(cosine, eta):
    sine2 = eta * eta * (1 - cosine * cosine)
    inner = np.sqrt(np.clip(1 - sine2, 0, 1))
    p = (cosine - eta * inner) / (cosine + eta * inner)
    s = (eta * cosine - inner) / (eta * cosine + inner)
    return np.where(sine2 >= 1, 1, (p * p + s * s) / 2), inner, sine2 >= 1


def smith(cosine, alpha):
    cosine2 = np.clip(cosine * cosine, 1e-18, 1)
    return (np.sqrt(1 + alpha * alpha * (1 - cosine2) / cosine2) - 1) / 2


def visible_normals(mu, alpha):
    """(cosine to wo, cosine to the surface) of facets with the density of those seen from cosine mu."""
    i = np.arange(FACETS)
    u, v = (i + 0.5) / FACETS, (i * 0.6180339887498949 + 0.5) % 1
    sine = np.sqrt(max(0, 1 - mu * mu))
    wo = np.array([alpha * sine, 0, mu])
    wo /= np.linalg.norm(wo)
    z = (1 - v) * (1 + wo[2]) - wo[2]
    r = np.sqrt(np.clip(1 - z * z, 0, 1))
    h = np.stack([r * np.cos(np.pi * u) + wo[0], r * np.sin(np.pi * u), z + wo[2]])
    m = np.stack([h[0] * alpha, h[1] * alpha, np.maximum(h[2], 0)])
    m /= np.linalg.norm(m, axis=0)
    return sine * m[0] + mu * m[2], m[2]


def single_bounce(mu, alpha, etas):
    """(mirror; then for each eta: reflected, transmitted, all that passes where nothing but total reflection reflects)."""
    c, up = visible_normals(mu, alpha)
    lo = smith(mu, alpha)
    z = 2 * c * up - mu
    mirror = np.where(z > 0, (1 + lo) / (1 + lo + smith(z, alpha)), 0)
    rows = []
    for eta in etas:
        f, inner, total = fresnel(c, eta)
        z = eta * (c * up - mu) - inner * up
        passes = np.where((z < 0) & ~total, np.minimum(1, (1 + lo) / (1 + smith(z, alpha))), 0)
        rows.append([(f * mirror).mean(), ((1 - f) * passes).mean(), np.where(total, mirror, passes).mean()])
    return mirror.mean(), np.array(rows)


def charlie(mu, alpha, n=400):
    """Directional albedo of Charlie sheen (KHR_materials_sheen)."""
    def curve(x):
        k = (1 - alpha) ** 2
        a, b, c, d, e = (p * (1 - k) + q * k for p, q in ((21.5473, 25.3245), (3.82987, 3.32435), (0.19823, 0.16801),
                                                           (-1.97760, -1.27393), (-4.32054, -4.85967)))
        return a / (1 + b * x ** c) + d * x + e

    def masking(c):
        return np.where(c < 0.5, np.exp(curve(np.minimum(c, 0.5))),
                        np.exp(2 * curve(0.5) - curve(1 - np.maximum(c, 0.5))))

    q = (np.arange(n) + 0.5) / n
    z, phi = np.meshgrid(q * q, np.pi * q, indexing="ij")
    r = np.sqrt(1 - z * z)
    h = np.stack([r * np.cos(phi) + np.sqrt(1 - mu * mu), r * np.sin(phi), z + mu])
    sine2 = np.clip(1 - h[2] ** 2 / (h * h).sum(0), 0, 1)
    value = (2 + 1 / alpha) * sine2 ** (0.5 / alpha) / (2 * np.pi) / (4 * mu * (1 + masking(np.float64(mu)) + masking(z)))
    return (value * 2 * q[:, None]).sum() * 2 * np.pi / n ** 2


# Fits

def squash(x):
    q = 1 / np.sqrt(1 + x * x)
    return x * q, q ** 3


class Fit:
    """scale(x) * (constant + sum of heights * squash(bias + weights . x))."""

    def __init__(self, inputs, target, units, scale=1.0, sensitivity=1.0, rounds=300, starts=4):
        x = np.stack([np.broadcast_to(i, target.shape).ravel() for i in inputs], 1)
        n, d = x.shape
        scale = np.broadcast_to(scale, target.shape).ravel()
        sensitivity = np.broadcast_to(sensitivity, target.shape).ravel()
        self.units, self.inputs, self.largest = units, d, np.inf
        for start in range(starts):
            g = np.random.default_rng(start)
            p = np.concatenate([g.normal(0, 2, units * d), g.normal(0, 1, units), g.normal(0, 0.1, units), [target.mean()]])
            self._descend(p, x, target.ravel(), scale, sensitivity, rounds)

    def parts(self, p):
        u, d = self.units, self.inputs
        return p[:u * d].reshape(u, d), p[u * d:u * d + u], p[u * d + u:u * d + 2 * u], p[-1]

    def _descend(self, p, x, y, scale, sensitivity, rounds):
        n = len(y)
        importance, damping = np.ones(n), 1e-2

        def evaluate(p):
            w, b, v, c = self.parts(p)
            h, slope = squash(x @ w.T + b)
            return ((h @ v + c) * scale - y) * sensitivity, h, slope, v

        e, h, slope, v = evaluate(p)
        for step in range(rounds):
            if step > rounds // 3 and step % 5 == 0:
                importance *= np.sqrt(0.3 + abs(e) / abs(e).max())
                importance /= np.sqrt((importance ** 2).mean())
            dv = slope * v
            j = np.concatenate([(dv[:, :, None] * x[:, None, :]).reshape(n, -1), dv, h, np.ones((n, 1))], 1)
            j *= (scale * sensitivity * importance)[:, None]
            a, gradient, cost = j.T @ j, j.T @ (e * importance), ((e * importance) ** 2).sum()
            for _ in range(8):
                q = p - np.linalg.solve(a + damping * np.diag(np.diag(a) + 1e-8) + 1e-9 * n * np.eye(len(p)), gradient)
                new = evaluate(q)
                if ((new[0] * importance) ** 2).sum() < cost:
                    p, (e, h, slope, v), damping = q, new, max(damping / 4, 1e-9)
                    break
                damping = min(damping * 4, 1e6)
            if abs(e).max() < self.largest:
                self.largest, self.p = abs(e).max(), p.copy()

    def __call__(self, *inputs):
        shape = np.broadcast_shapes(*(np.shape(i) for i in inputs))
        w, b, v, c = self.parts(self.p)
        x = np.stack([np.broadcast_to(i, shape).ravel() for i in inputs], 1)
        return (squash(x @ w.T + b)[0] @ v + c).reshape(shape)

    def shift(self, by):
        self.p[-1] += by

    def slang(self, names):
        """Lines that leave the sum in `sum`; inputs in the order in which the compiler can share their products."""
        w, b, v, c = self.parts(self.p)
        vector = lambda numbers: "float4(" + ", ".join(f"{k:.6g}" for k in numbers) + ")"
        lines = [f"float sum = {c:.6g};"]
        for i in range(0, self.units, 4):
            s = slice(i, i + 4)
            terms = [vector(b[s])] + [f"{vector(w[s, k])} * {name}" for k, name in enumerate(names)]
            lines += [f"sum += dot({vector(v[s])}, squash({terms[0]}"]
            lines += [f"    + {term}" for term in terms[1:]]
            lines[-1] += "));"
        return "\n".join("    " + line for line in lines)


# What is fitted

def inputs(alpha, cosine=None, contrast=None):
    """The quantities that the fits are functions of, by the names that they have in Slang."""
    g = np.sqrt(alpha)
    named = {"g": g}
    if contrast is not None:
        n = (1 + contrast) / (1 - contrast)
        named |= {"critical": np.sqrt(1 - 1 / n ** 2), "quartic": contrast ** 0.25}
    if cosine is not None:
        named |= {"mu": cosine, "narrow": cosine / (cosine + 0.5 * alpha), "wide": cosine / (cosine + 0.5 * g)}
        if contrast is not None:
            named["inner"] = cosine / (cosine + named["critical"])
    return named


DEFINITIONS = {
    "g": "sqrt(alpha)", "critical": "sqrt(1.0 - eta * eta)", "quartic": "sqrt(sqrt((1.0 - eta) / (1.0 + eta)))",
    "narrow": "mu / (mu + 0.5 * alpha)", "wide": "mu / (mu + 0.5 * g)", "inner": "mu / (mu + critical)",
    "low": "mu / (mu + 0.2)",
}


def emit(name, comment, arguments, names, fit, result="sum"):
    print(f"/// {comment}\nfloat {name}({', '.join('float ' + a for a in arguments)})\n{{")
    for n in dict.fromkeys((["g"] if {"wide"} & set(names) else []) + list(names)):
        if n in DEFINITIONS:
            print(f"    float {n} = {DEFINITIONS[n]};")
    print(fit.slang(names))
    print(f"    return {result};\n}}\n")
    print(f"{name}: largest error {fit.largest:.1e}", file=sys.stderr)


def mean(values):
    """Of a function of the cosine, weighted by the cosine, over nodes() along the last axis."""
    x, w = nodes()
    return (values * 2 * x * w).sum(-1)


def nodes():
    """Dense where the functions are steep: at grazing light."""
    x, w = np.polynomial.legendre.leggauss(60)
    x, w = (x + 1) / 2, w / 2
    return x * x, 2 * x * w


def fit_mean(values, loss, alpha, contrast=None):
    """Means, most exact where the largest loss is large beside them."""
    named = inputs(alpha, contrast=contrast)
    names = ["g"] if contrast is None else ["g", "critical", "quartic"]
    m = mean(values)
    sensitivity = loss.max(-1) / np.maximum(m, 1e-5)
    fit = Fit([named[n] for n in names], m, 4 if contrast is None else 8, named["g"] ** 2, np.minimum(sensitivity, 50),
              rounds=600, starts=6)
    fit.shift(0.002)
    return names, fit


def main():
    index = (1 + CONTRAST) / (1 - CONTRAST)
    etas = np.concatenate([1 / index, index])
    table = [[single_bounce(m, a, etas) for m in COSINE] for a in ALPHA]
    mirror = np.array([[cell[0] for cell in row] for row in table])
    bounces = np.array([[cell[1] for cell in row] for row in table])
    count = len(CONTRAST)
    reflected = bounces[:, :, :count, 0]
    print("""// Generated by scripts/fit_albedos.py: what materials/albedo.slang explains. Sums of sigmoids.
#language slang 2018

float4 squash(float4 x) { return x / sqrt(1.0 + x * x); }

/// The fits for transmitting boundaries hold to this ratio of the smaller index to the larger.
static const float MOST_FITTED_ETA = %.6g;
""" % (1 / index[LEAST_GLASS]))

    # Mirrors.
    names = ["g", "wide", "narrow", "mu"]
    a, m = np.meshgrid(ALPHA, COSINE, indexing="ij")
    named = inputs(a, m)
    lost = Fit([named[n] for n in names], 1 - mirror, 8, named["g"], rounds=600, starts=6)
    lost.shift(-0.005)
    emit("fittedMirrorLoss", "1 - albedo of a mirror.", ["mu", "alpha"], names, lost,
         f"g * sum - {lost.largest:.2g}")
    fine = np.linspace(0.03, 1, 60) ** 2
    x, _ = nodes()

    def mirror_loss(alpha, cosine):
        named = inputs(alpha, cosine)
        return np.clip(named["g"] * lost(*(named[n] for n in ("g", "wide", "narrow", "mu"))) - lost.largest, 0, 1)

    values = mirror_loss(fine[:, None], x[None])
    mean_names, fit = fit_mean(values, values, fine)
    emit("fittedMirrorLossMean", "Its mean.", ["alpha"], mean_names, fit, "alpha * sum")

    # Reflection by dielectrics, on the side of the smaller index.
    names = ["g", "quartic", "wide", "narrow"]
    a, m, s = np.meshgrid(ALPHA, COSINE, CONTRAST, indexing="ij")
    named = inputs(a, m, s)
    albedo = 1 - mirror_loss(a, m)
    cosines = np.linspace(1e-4, 1, 40001)
    target, slope = np.zeros_like(a), np.zeros_like(a)
    for j in range(count):
        f = fresnel(cosines, 1 / index[j])[0]
        share = np.minimum(reflected[:, :, j] / albedo[:, :, j], 1)
        target[:, :, j] = np.interp(-(share + 0.002 * (1 - share)), -f, cosines)
        slope[:, :, j] = np.interp(target[:, :, j], cosines, abs(np.gradient(f, cosines)))
    effective = Fit([named[n] for n in names], target - m, 8, named["g"], np.minimum(albedo * slope, 3) + 0.02,
                    rounds=600, starts=6)
    emit("fittedEffectiveCosine", "Where a smooth boundary reflects what a rough one does at `mu`.",
         ["mu", "alpha", "eta"], names, effective, "mu + g * sum")

    a, s, m = np.meshgrid(np.concatenate([[1e-8], ALPHA]), CONTRAST, x, indexing="ij")
    named = inputs(a, m, s)
    cosine = np.clip(m + named["g"] * effective(*(named[n] for n in names)), 1e-4, 1)
    weight = (fresnel(cosine, (1 - s) / (1 + s))[0] - s * s) / (1 - s * s)
    weight = mean((1 - mirror_loss(a, m)) * weight)
    named = inputs(a[:, :, 0], contrast=s[:, :, 0])
    names = ["g", "quartic"]
    fit = Fit([named[n] for n in names], weight, 8, 1.0, 1 / (1 - weight))
    fit.shift(-0.5 * fit.largest)
    emit("fittedFresnelWeightMean", "Mean of albedo x Fresnel's weight.", ["alpha", "eta"], names, fit)

    # Boundaries that transmit.
    names = ["g", "critical", "narrow", "inner", "mu"]
    a, m, s = np.meshgrid(ALPHA, COSINE, CONTRAST[LEAST_GLASS:], indexing="ij")
    named = inputs(a, m, s)
    for side, first, units in (("Outer", LEAST_GLASS, 8), ("Inner", count + LEAST_GLASS, 16)):
        kept = bounces[:, :, first:first + count - LEAST_GLASS, :2].sum(-1)
        fit = Fit([named[n] for n in names], 1 - kept, units, rounds=600, starts=5)
        fit.shift(-1.2 * fit.largest)
        emit(f"fitted{side}Loss", f"What a boundary loses of light on its {side.lower()} side.", ["mu", "alpha", "eta"],
             names, fit)
        a3, s3, m3 = np.meshgrid(fine[::3], CONTRAST[LEAST_GLASS:], x, indexing="ij")
        fine_named = inputs(a3, m3, s3)
        values = np.clip(fit(*(fine_named[n] for n in names)), 0, 1)
        mean_names, fit = fit_mean(values, values, a3[:, :, 0], s3[:, :, 0])
        emit(f"fitted{side}LossMean", "Its mean.", ["alpha", "eta"], mean_names, fit, "alpha * sum")

    # Inside, what a boundary that reflects nothing but totally loses beyond that.
    names = ["g", "critical", "inner", "mu"]
    named = inputs(a, m, s)
    kept = bounces[:, :, count + LEAST_GLASS:]
    beyond = kept[..., :2].sum(-1) - kept[..., 2]
    fit = Fit([named[n] for n in names], beyond, 4, named["g"], rounds=600, starts=6)
    fit.shift(-fit.largest)
    emit("fittedClearLoss", "What a boundary that reflects totally alone loses more on its inner side.",
         ["mu", "alpha", "eta"], names, fit, "g * sum")
    a3, s3, m3 = np.meshgrid(fine[::3], CONTRAST[LEAST_GLASS:], x, indexing="ij")
    fine_named = inputs(a3, m3, s3)
    values = mean(fine_named["g"] * fit(*(fine_named[n] for n in names)))
    named = inputs(a3[:, :, 0], contrast=s3[:, :, 0])
    names = ["g", "critical"]
    fit = Fit([named[n] for n in names], values, 4, named["g"], rounds=600, starts=6)
    emit("fittedClearLossMean", "Its mean.", ["alpha", "eta"], names, fit, "g * sum")

    # Sheen.
    roughness, m = np.meshgrid(np.linspace(0.1, 1, 16), COSINE, indexing="ij")
    albedo = np.vectorize(lambda r, m: charlie(m, r * r))(roughness, m)
    fit = Fit([roughness, m, m / (m + 0.2)], albedo, 12, 1.0, 1 / np.maximum(1, albedo), rounds=600, starts=6)
    fit.shift(2 * fit.largest)
    emit("fittedSheenAlbedo", "Directional albedo of Charlie sheen.", ["mu", "roughness"], ["roughness", "mu", "low"], fit)


if __name__ == "__main__":
    main()
