//! A world in the precision that its scene asks for.

use crate::scene::world::World;

/// A world in either precision.
#[derive(Debug, Clone)]
pub enum Precise {
    /// 32 bits.
    Single(World<f32>),
    /// 64 bits.
    Double(World<f64>),
}

/// Does the same with a world in either precision: `with_world!(&scene.world, |world| world.branches)`.
macro_rules! with_world {
    ($precise:expr, |$world:ident| $answer:expr) => {
        match $precise {
            $crate::scene::compile::Precise::Single($world) => $answer,
            $crate::scene::compile::Precise::Double($world) => $answer,
        }
    };
}
pub(crate) use with_world;
