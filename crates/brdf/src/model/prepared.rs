//! Models ready to be evaluated: all that does not depend on directions has been computed.

use glam::DVec3;

use super::ashikhmin_shirley::AshikhminShirley;
use super::cook_torrance::Microfacet;
use super::diffuse::{Lambert, OrenNayar};
use super::fit::{Abc, Sgd};
use super::phong::Phong;
use super::principled::Principled;
use super::rough_plastic::RoughPlastic;
use super::ward::Ward;
use super::{Brdf, Claims, ModelConstants};
use crate::{Block, DirectionPair, HORIZON, Libm, Machine, Plain};

/// A model, prepared: the same formula for one pair in f64 with `libm`, which is the reference, and for blocks of pairs.
#[derive(Debug, Clone)]
pub struct PreparedModel(pub(super) Prepared);

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

/// What each model does of a block.
pub(super) trait Reflect {
    /// f of each lane, channel by channel.
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3];

    /// What it promises.
    fn claims(&self) -> Claims;

    /// What it computes with.
    fn constants(&self) -> ModelConstants;
}

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
    /// f of each lane of a block.
    ///
    /// # Shapes
    /// Red, green and blue, in each the lanes in their order.
    ///
    /// # Units
    /// 1/sr; linear.
    ///
    /// # Error
    /// No lane depends on another one or on how many there are. With the functions of `libm` the bits are those of
    /// [`Brdf::f`]; what the branchless ones differ by is in docs/maths/shading.md.
    #[must_use]
    pub fn f_block<M: Machine, const N: usize>(
        &self,
        machine: M,
        block: &Block<N>,
    ) -> [[f64; N]; 3] {
        each!(self, model => model.block(machine, block))
    }

    /// The formula that it is, and all numbers of it that do not depend on directions.
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
