//! Changes the settings of a built scene, for comparing settings without building it again.

use super::camera::{camera_of, edges_of};
use super::ceiling::ceiling;
use super::effects::{black, derive_flags, remove};
use super::{Precise, Scene, adapts, with_world};
use crate::accel::Shape;
use crate::bound::ceiling::Ceiling;
use crate::camera::{Basis, Window};
use crate::film::Display;
use crate::lanes::Real;
use crate::scene::description;
use crate::scene::effects::Effect;
use crate::scene::usage::Used;
use crate::scene::world::{ENDLESS, Pruning, World};
use crate::shading::material::Material;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Weight below which rays are not followed that look for an object.
pub(crate) const LEAST_SHARE: f64 = 1e-3;

impl Scene {
    /// Sets what ends the recursion. A scene that was built with `max_depth` 1 has no wavelengths, and no bound on what its
    /// surfaces gather: it is to be built with 2 if it is to be rendered with more.
    pub fn set_recursion(&mut self, max_depth: u32, min_weight: f64) {
        self.set_rules(max_depth, Pruning::Weight(min_weight));
    }

    /// Follows each pixel's rays until it is proved to be at most `max_codes` off.
    pub fn set_proved(&mut self, max_codes: u8) {
        let depth = self.ceiling().reach.max_depth.unwrap_or(ENDLESS);
        self.set_rules(depth, Pruning::Proved { max_codes });
    }

    /// The ceiling that the scene has with the settings of another description of it.
    pub fn ceiling_with(&self, description: &description::Description) -> Ceiling {
        with_world!(&self.world, |world| ceiling(description, world))
    }

    /// Sets what its pictures are held against.
    pub fn set_ceiling(&mut self, ceiling: Ceiling) {
        with_world!(&mut self.world, |world| world.ceiling = ceiling)
    }

    fn set_rules(&mut self, max_depth: u32, pruning: Pruning) {
        fn set<R: Real>(world: &mut World<R>, max_depth: u32, pruning: Pruning) {
            (world.rules.max_depth, world.rules.pruning) = (max_depth, pruning);
            // Effects of rays that leave surfaces are on only where such rays are followed.
            derive_flags(world);
        }
        with_world!(&mut self.world, |world| set(world, max_depth, pruning))
    }

    /// The scene without one of its effects, to see what it costs, with as many samples as it then asks for. None where the
    /// effect cannot be taken out of a built scene. Its geometry is shared, and its table of effects and its bounds stay as
    /// they were.
    pub fn without(&self, effect: Effect) -> Option<Self> {
        fn take<R: Real>(scene: &Scene, world: &World<R>, effect: Effect) -> Option<(World<R>, u32, bool)> {
            let mut world = world.clone();
            let named = scene.named_samples;
            let samples = remove(effect, &mut world).then(|| world.effects.samples(named))?;
            let adaptive = adapts(named, scene.statistical.is_some(), &world);
            Some((world, samples, adaptive))
        }
        if effect == Effect::Antialiasing {
            return self.refines().then(|| Self { antialias: false, ..self.share(self.world.clone()) });
        }
        let (world, samples, adaptive) = match &self.world {
            Precise::Single(world) => take(self, world, effect).map(|(world, n, is)| (Precise::Single(world), n, is)),
            Precise::Double(world) => take(self, world, effect).map(|(world, n, is)| (Precise::Double(world), n, is)),
        }?;
        Some(Self { samples, adaptive, ..self.share(world) })
    }

    /// The scene of the light that one of its `objects` sends to the camera, directly, by mirrors and through bodies, and of
    /// nothing else: the object shines with radiance 1, and nothing is seen in it or through it. None if there is no such object.
    pub(crate) fn glowing(&self, object: u32, samples: u32) -> Option<Self> {
        if object >= self.sources.objects() {
            return None;
        }
        let is_it = |source| self.sources.top(source) == object;
        let world = match &self.world {
            Precise::Single(world) => Precise::Single(glowing(world, is_it)),
            Precise::Double(world) => Precise::Double(glowing(world, is_it)),
        };
        Some(Self { samples, adaptive: false, antialias: false, statistical: None, ..self.share(world) })
    }

    /// The scene whose picture is what a window shows of this one's. Its geometry is shared.
    #[must_use]
    pub fn through(&self, window: &Window) -> Self {
        fn of<R: Real>(world: &World<R>, window: &Window) -> World<R> {
            World { camera: world.camera.through(window), ..world.clone() }
        }
        let world = match &self.world {
            Precise::Single(world) => Precise::Single(of(world, window)),
            Precise::Double(world) => Precise::Double(of(world, window)),
        };
        Self { width: window.width, height: window.height, ..self.share(world) }
    }

    /// The same scene around another world.
    fn share(&self, world: Precise) -> Self {
        Self {
            world,
            sources: Arc::clone(&self.sources),
            effects: self.effects.clone(),
            warnings: self.warnings.clone(),
            pictures: self.pictures.clone(),
            assets: self.assets.clone(),
            ..*self
        }
    }

    /// Sets the size of the picture. `camera` is the one that the scene was built with. Both sides are at least 1 and within
    /// the limits.
    pub fn set_size(&mut self, camera: &description::Camera, width: u32, height: u32) {
        fn set<R: Real>(world: &mut World<R>, camera: &description::Camera, basis: &Basis, width: u32, height: u32) {
            world.camera = camera_of(camera, basis, width, height);
            world.edges = world.edges.and_then(|_| edges_of(camera, width, height));
        }
        let Some(basis) = Basis::new(&camera.view()) else { return };
        (self.width, self.height) = (width, height);
        with_world!(&mut self.world, |world| set(world, camera, &basis, width, height))
    }
}

/// A material that shines with radiance 1 where the given one is there, and does nothing else.
fn shining<R: Real>(material: &Material<R>) -> Material<R> {
    let holed = material.pbr.as_deref().filter(|pbr| pbr.has_holes());
    Material { emission: [R::from_f64(1.0); 3], pbr: holed.map(|pbr| Box::new(pbr.shining())), ..Material::black() }
}

/// A dark world in which some items of the scene itself shine, and their placed geometries.
fn glowing<R: Real>(world: &World<R>, shines: impl Fn(u32) -> bool) -> World<R> {
    let mut world = World { display: Display::default(), transparent: false, behind: None, ..world.clone() };
    (world.background, world.environment) = (black(), None);
    (world.ambient, world.surroundings, world.lights) = (black(), None, Vec::new());
    for material in &mut world.materials {
        material.emission = black();
        if let Some(pbr) = &mut material.pbr {
            pbr.dark = true;
        }
    }
    if let Some(fog) = &mut world.fog {
        fog.color = black();
    }
    world.rules.pruning = Pruning::Weight(LEAST_SHARE);
    world.rules.color_bleeding = false;
    let bright: Vec<Material<R>> = world.materials.iter().map(shining).collect();
    let first_bright = world.materials.len() as u32;
    world.usage.materials.extend(bright.iter().map(|_| Used { anywhere: true, ..Used::default() }));
    world.materials.extend(bright);
    let mut geometries = world.geometries.to_vec();
    // The geometry of each that is placed by what shines: others may place the same one, and stay dark.
    let mut placed_bright = BTreeMap::new();
    let mut left = vec![world.root];
    while let Some(geometry) = left.pop() {
        let mut items = std::mem::take(&mut geometries[geometry].items);
        for item in items.iter_mut().filter(|item| geometry != world.root || shines(item.source)) {
            let Shape::Instance(instance) = &mut item.shape else {
                (item.material, item.transmission) = (first_bright + item.material, black());
                continue;
            };
            let placed = instance.geometry as usize;
            instance.geometry = *placed_bright.entry(placed).or_insert_with(|| {
                geometries.push(geometries[placed].clone());
                left.push(geometries.len() - 1);
                geometries.len() as u32 - 1
            });
        }
        geometries[geometry].items = items;
    }
    world.geometries = geometries.into();
    derive_flags(&mut world);
    world
}
