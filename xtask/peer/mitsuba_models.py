"""BSDFs for Mitsuba of models that it has no plugins for: Phong and Blinn-Phong as published, Blinn-Phong normalised, Ward.

They follow the publications and share no code with brood. `l` is the direction to the light, `v` that to the eye; what
`reflected` gives is the BRDF times the cosine of `l`, in which the first two, who speak of reflected light, are written.
"""

import math

import drjit
import mitsuba

from reflecting_bsdf import Reflecting

# Of a mesh: its directions along the surface at the vertices, three numbers each.
TANGENT = "vertex_tangent"


class Model(Reflecting):
    """A diffuse part and a highlight."""

    def __init__(self, properties):
        super().__init__(properties)
        self.diffuse = mitsuba.Color3f(properties["diffuse"])
        self.specular = mitsuba.Color3f(properties["specular"])


class Phong(Model):
    """Phong 1975: k_d n.l + k_s (r.v)^n, r the light mirrored at the normal; light of irradiance pi is its unit."""

    def __init__(self, properties):
        super().__init__(properties)
        self.exponent = properties["exponent"]

    def reflected(self, l, v):
        mirrored = mitsuba.Vector3f(-l.x, -l.y, l.z)
        along = drjit.maximum(drjit.dot(mirrored, v), 0.0)
        return (self.diffuse * l.z + self.specular * along**self.exponent) / math.pi


class BlinnPhong(Phong):
    """Blinn 1977: the cosine of the half vector in place of Phong's."""

    def reflected(self, l, v):
        along = drjit.maximum(drjit.normalize(l + v).z, 0.0)
        return (self.diffuse * l.z + self.specular * along**self.exponent) / math.pi


class NormalisedBlinnPhong(Phong):
    """Giesen 2009: a BRDF whose albedo at normal incidence is k_s."""

    def reflected(self, l, v):
        n = self.exponent
        along = drjit.maximum(drjit.normalize(l + v).z, 0.0)
        scale = (n + 2) * (n + 4) / (8 * math.pi * (2 ** (-n / 2) + n))
        return (self.diffuse / math.pi + self.specular * (scale * along**n)) * l.z


class Ward(Model):
    """Ward 1992, equation 5a. x is the direction along the surface: a mesh's own where it has such, else Mitsuba's."""

    def __init__(self, properties):
        super().__init__(properties)
        self.alpha = properties["alpha_x"], properties["alpha_y"]

    def directions(self, si, light):
        if self.alpha[0] == self.alpha[1]:
            return light, si.wi
        along = si.to_local(si.shape.eval_attribute_3(TANGENT, si))
        # Made orthogonal to the interpolated normal, as brood does; 0 where there is none.
        x, y = along.x, along.y
        length = drjit.sqrt(x * x + y * y)
        x, y = drjit.select(length > 0.0, x / length, 1.0), drjit.select(length > 0.0, y / length, 0.0)
        return tuple(mitsuba.Vector3f(x * w.x + y * w.y, x * w.y - y * w.x, w.z) for w in (light, si.wi))

    def reflected(self, l, v):
        h = drjit.normalize(l + v)
        x, y = h.x / self.alpha[0], h.y / self.alpha[1]
        peak = drjit.exp(-(x * x + y * y) / (h.z * h.z))
        area = 4 * math.pi * self.alpha[0] * self.alpha[1]
        return (self.diffuse / math.pi + self.specular * peak / (area * drjit.sqrt(l.z * v.z))) * l.z


for name, model in {
    "phong_published": Phong, "blinn_phong_published": BlinnPhong,
    "blinn_phong_normalised": NormalisedBlinnPhong, "ward_published": Ward,
}.items():
    mitsuba.register_bsdf(name, model)
