"""What BSDFs in Python have in common: Mitsuba asks for samples and densities, which light that is a delta never uses."""

import drjit
import mitsuba


class Reflecting(mitsuba.BSDF):
    """Reflects on one side. What it reflects is the BRDF times the cosine of the direction to the light."""

    def __init__(self, properties):
        super().__init__(properties)
        flags = mitsuba.BSDFFlags.GlossyReflection | mitsuba.BSDFFlags.FrontSide
        self.m_components = [flags]
        self.m_flags = flags

    def reflected(self, light, eye):
        """A colour for directions in the local frame, both above the surface."""
        raise NotImplementedError

    def directions(self, si, light):
        """Those to the light and to the eye, with x along the surface."""
        return light, si.wi

    def value(self, si, wo, active):
        lit = active & (si.wi.z > 0.0) & (wo.z > 0.0)
        return drjit.select(lit, self.reflected(*self.directions(si, wo)), 0.0), lit

    def sample(self, context, si, sample1, sample2, active=True):
        wo = mitsuba.warp.square_to_cosine_hemisphere(sample2)
        sampled = mitsuba.BSDFSample3f()
        sampled.wo = wo
        sampled.pdf = mitsuba.warp.square_to_cosine_hemisphere_pdf(wo)
        sampled.eta = 1.0
        sampled.sampled_type = mitsuba.UInt32(int(self.m_flags))
        sampled.sampled_component = mitsuba.UInt32(0)
        value, lit = self.value(si, wo, active)
        return sampled, drjit.select(lit & (sampled.pdf > 0.0), value / sampled.pdf, 0.0)

    def eval(self, context, si, wo, active=True):
        return self.value(si, wo, active)[0]

    def pdf(self, context, si, wo, active=True):
        return drjit.select(active, mitsuba.warp.square_to_cosine_hemisphere_pdf(wo), 0.0)

    def eval_pdf(self, context, si, wo, active=True):
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

    def traverse(self, callback):
        pass

    def to_string(self):
        return f"{type(self).__name__}[]"
