//! What a prepared model computes with: the numbers that do not depend on directions, for those who write its formula down
//! in another language. The formulas themselves are in docs/maths/shading.md and in the files of the families.

use glam::{DVec2, DVec3};

use super::microfacet::Shadowing;
use super::phong::Highlight;
use super::ward::Form;

/// A formula with its numbers. Colours are linear red, green and blue; what stands over pi in a formula is so here.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelConstants {
    /// `f` everywhere.
    Lambert {
        /// Over pi.
        f: DVec3,
    },
    /// albedo / pi (a + b s / max(cos_i, cos_o)).
    OrenNayar {
        /// Not over pi.
        albedo: DVec3,
        /// A of the source.
        a: f64,
        /// B of the source.
        b: f64,
    },
    /// diffuse + specular times a power.
    Phong {
        /// What the power is taken of.
        highlight: Highlight,
        /// Over pi.
        diffuse: DVec3,
        /// With what the power is scaled by.
        specular: DVec3,
        /// Of the power.
        exponent: f64,
    },
    /// diffuse + Schlick's reflectance times the facets.
    CookTorrance {
        /// Over pi.
        diffuse: DVec3,
        /// At normal incidence.
        f0: DVec3,
        /// D G / (4 cos_i cos_o).
        facets: FacetConstants,
    },
    /// The reflectance of a metal times the facets.
    Conductor {
        /// Of red, green and blue.
        metals: [MetalConstants; 3],
        /// D G / (4 cos_i cos_o).
        facets: FacetConstants,
    },
    /// What passes a dielectric coat twice times the base, and what the coat reflects.
    Coated {
        /// Over pi.
        base: DVec3,
        /// The coat's refractive index, above 1.
        ior: f64,
        /// D G / (4 cos_i cos_o).
        facets: FacetConstants,
    },
    /// The same with a table of what passes.
    RoughPlastic {
        /// rho / (pi eta^2 (1 - rho' R)).
        base: DVec3,
        /// The coat's refractive index, above 1.
        ior: f64,
        /// D G / (4 cos_i cos_o).
        facets: FacetConstants,
        /// The share of light that passes at cosines from 0 to 1 in equal steps; linear between them.
        passes: Vec<f64>,
    },
    /// Body, sheen, highlight and clear coat.
    Principled(Box<PrincipledConstants>),
    /// diffuse + specular times a Gaussian.
    Ward {
        /// How it is normalised.
        form: Form,
        /// Over pi.
        diffuse: DVec3,
        /// Over 4 pi alpha_x alpha_y.
        specular: DVec3,
        /// 1 / alpha along u and along v.
        inverse: DVec2,
    },
    /// A base that fades where the highlight grows.
    AshikhminShirley {
        /// 28 R_d (1 - R_s) / (23 pi).
        base: DVec3,
        /// At normal incidence.
        specular: DVec3,
        /// Along u and along v.
        exponents: DVec2,
        /// sqrt((n_u + 1) (n_v + 1)) / (8 pi).
        height: f64,
    },
    /// diffuse + a F G / (1 + b (1 - cos_h))^c / (cos_i cos_o).
    Abc {
        /// Over pi.
        diffuse: DVec3,
        /// Over pi.
        a: DVec3,
        /// How narrow.
        b: f64,
        /// The exponent.
        c: f64,
        /// Refractive index, 1 or above.
        ior: f64,
    },
    /// Each channel by itself.
    Sgd {
        /// Red, green and blue.
        channels: [SgdChannel; 3],
    },
}

/// How facets stand and hide each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacetConstants {
    /// D.
    pub distribution: DistributionConstants,
    /// G.
    pub shadowing: Shadowing,
}

/// Distribution of the facets' normals: `height` is D along the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DistributionConstants {
    /// Trowbridge and Reitz.
    Ggx {
        /// Along u and along v.
        alpha: DVec2,
        /// 1 / (pi alpha_x alpha_y).
        height: f64,
    },
    /// Normalised as in Walter 2007.
    Beckmann {
        /// Along u and along v.
        alpha: DVec2,
        /// 1 / (pi alpha_x alpha_y).
        height: f64,
    },
    /// Of the angle; masked as Beckmann's.
    Gaussian {
        /// All around.
        alpha: f64,
        /// By quadrature.
        height: f64,
    },
    /// A power of the cosine; masked as Beckmann's.
    Blinn {
        /// All around.
        alpha: f64,
        /// Of the power.
        exponent: f64,
        /// (n + 2) / (2 pi).
        height: f64,
    },
}

/// A metal of index eta + i k.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetalConstants {
    /// eta^2 - k^2.
    pub difference: f64,
    /// 4 eta^2 k^2.
    pub product: f64,
}

/// Burley's model.
#[derive(Debug, Clone, PartialEq)]
pub struct PrincipledConstants {
    /// Colour of the body, or of the metal.
    pub base: DVec3,
    /// Of the highlight as far as the base colour tints it.
    pub tinted_f0: DVec3,
    /// Of the body.
    pub roughness: f64,
    /// 0 to 1.
    pub metallic: f64,
    /// Refractive index, 1 or above.
    pub ior: f64,
    /// How far the base colour tints the highlight.
    pub spec_tint: f64,
    /// Colour and strength.
    pub sheen: DVec3,
    /// None without one.
    pub coat: Option<ClearCoatConstants>,
    /// D G / (4 cos_i cos_o) of the main highlight.
    pub facets: FacetConstants,
}

/// The second highlight of Burley's model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClearCoatConstants {
    /// alpha^2 - 1.
    pub narrow: f64,
    /// D is this over 1 + narrow h_z^2, its strength included.
    pub height: f64,
    /// Whether it is divided by 4 cos_i cos_o.
    pub published: bool,
    /// Reflectance at normal incidence.
    pub f0: f64,
    /// alpha of its shadowing.
    pub shadowing: f64,
}

/// A channel of the shifted gamma distribution, in the symbols of the source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SgdChannel {
    /// Share of light that is scattered back; not over pi.
    pub rho_d: f64,
    /// Weight of the highlight; not over pi.
    pub rho_s: f64,
    /// Roughness.
    pub alpha: f64,
    /// How fast the highlight falls off.
    pub p: f64,
    /// F_0 of the reflectance.
    pub f0: f64,
    /// F_1 of the reflectance.
    pub f1: f64,
    /// K: normalises the distribution.
    pub normal: f64,
    /// Of the shadowing.
    pub lambda: f64,
    /// Of the shadowing.
    pub c: f64,
    /// Of the shadowing.
    pub k: f64,
    /// Of the shadowing.
    pub theta0: f64,
}
