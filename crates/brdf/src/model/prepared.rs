//! Models ready to be evaluated: everything that does not depend on directions is computed.

use glam::DVec3;

use super::ashikhmin_shirley::AshikhminShirley;
use super::constants::ModelConstants;
use super::cook_torrance::Microfacet;
use super::diffuse::{Lambert, OrenNayar};
use super::fit::{Abc, Sgd};
use super::phong::Phong;
use super::principled::Principled;
use super::reflect::Reflect;
use super::rough_plastic::RoughPlastic;
use super::ward::Ward;
use crate::{Block, Brdf, Claims, DirectionPair, HORIZON, Libm, Machine, Plain};

/// A prepared model. The same formulas serve single pairs in f64 with `libm`, which is the
/// reference, and blocks of pairs.
#[derive(Debug, Clone)]
pub struct PreparedModel(pub(super) Prepared);

/// A model of each family.
#[derive(Debug, Clone)]
pub(super) enum Prepared {
    Lambert(Lambert),
    OrenNayar(OrenNayar),
    Phong(Phong),
    Microfacet(Microfacet),
    RoughPlastic(Box<RoughPlastic>),
    Principled(Box<Principled>),
    Ward(Ward),
    AshikhminShirley(AshikhminShirley),
    Abc(Abc),
    Sgd(Box<Sgd>),
}

/// Evaluates an expression with the model of any variant.
macro_rules! each {
    ($self:expr, $model:ident => $done:expr) => {
        match &$self.0 {
            Prepared::Lambert($model) => $done,
            Prepared::OrenNayar($model) => $done,
            Prepared::Phong($model) => $done,
            Prepared::Microfacet($model) => $done,
            Prepared::RoughPlastic($model) => $done,
            Prepared::Principled($model) => $done,
            Prepared::Ward($model) => $done,
            Prepared::AshikhminShirley($model) => $done,
            Prepared::Abc($model) => $done,
            Prepared::Sgd($model) => $done,
        }
    };
}

impl PreparedModel {
    /// Returns f of each lane of a block.
    ///
    /// # Shapes
    /// Rows are red, green and blue; columns are lanes.
    ///
    /// # Units
    /// 1/sr; linear.
    ///
    /// # Error
    /// Lanes are independent of each other and of `N`. With the functions of `libm` the bits
    /// are those of [`Brdf::f`]; the error of the branch-free functions is in
    /// docs/maths/shading.md.
    #[must_use]
    pub fn f_block<M: Machine, const N: usize>(
        &self,
        machine: M,
        block: &Block<N>,
    ) -> [[f64; N]; 3] {
        each!(self, model => model.block(machine, block))
    }

    /// Formula with all its constants that do not depend on directions.
    #[must_use]
    pub fn constants(&self) -> ModelConstants {
        each!(self, model => model.constants())
    }
}

impl Brdf for PreparedModel {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        if !(pair.cos_i() >= HORIZON && pair.cos_o() >= HORIZON) {
            return DVec3::ZERO;
        }
        let machine = Plain::<Libm>::new();
        let mut block = Block::<1>::new();
        block.fill(machine, std::slice::from_ref(pair));
        DVec3::from(self.f_block(machine, &block).map(|[value]| value))
    }

    fn claims(&self) -> Claims {
        each!(self, model => model.claims())
    }
}
