//! The ray tree of a pixel: every ray as data, recorded by the kernel itself.

use super::query::name_of;
use crate::bound::interval::raise;
use crate::control::{Cancelled, Control};
use crate::lanes::{Ids, Lanes, Real, V3};
use crate::render::{Grouping, samples_of, trace_pixel_samples};
use crate::scene::Scene;
use crate::scene::compile::Precise;
use crate::scene::limits::TREE_RAYS;
use crate::scene::world::{Pruning, World};
use crate::shading::media::{Media, MediumList};
use crate::trace::hits::Hits;
use crate::trace::kernel::{Tracer, first};
use crate::trace::observer::{NotFollowed, Observer, Snell};
use crate::trace::pixel::eye_media;
use crate::trace::ray_packet::{RayKind, RayPacket};
use schemars::JsonSchema;
use serde::Serialize;

/// Every ray of one pixel.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "RayTree")]
pub struct Tree {
    /// Column and row of the pixel.
    pub pixel: [u32; 2],
    /// `single` or `double`: the format of all numbers here.
    pub precision: &'static str,
    /// Samples of the pixel; each has a camera ray.
    pub samples: u32,
    /// The pixel's linear value: the mean of its samples in double precision, and then `raised`. A sample is the sum of its rays'
    /// contributions, that of `fog` before its own, times the number of samples, added in the order of `rays` in this precision
    /// together with the rounding errors of these additions.
    pub value: [f64; 3],
    /// The 8-bit codes that the picture shows for the value, with its exposure and tone.
    pub codes: [u8; 3],
    /// How many codes these are off at most, for what the contributions lack; 255 if nothing bounds that.
    pub codes_off: u8,
    /// What the proved mode adds so that the pixel lies in the middle of what it may be; 0 for most pixels.
    pub raised: [f64; 3],
    /// R: at most so much the contributions lack, for rays that were not followed and lights that were not asked for.
    pub lacking: [f64; 3],
    /// Whether there were more rays than the limit `tree_rays`, or than fit into 80 MiB; then the contributions do not add up.
    pub truncated: bool,
    /// The rays, each after its parent.
    pub rays: Vec<Node>,
}

impl Tree {
    /// Bytes of memory it takes, about.
    pub fn bytes(&self) -> usize {
        let hit = |hit: &NodeHit| {
            let [body, name] = [&hit.body, &hit.name].map(|text| text.as_ref().map_or(0, String::len));
            hit.object.len() + body + name + hit.material.len()
        };
        self.rays.iter().map(|node| node.bytes() + node.hit.as_ref().map_or(0, hit)).sum()
    }
}

/// Kinds of rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "TreeRayKind")]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the names say it")]
pub enum NodeKind {
    Camera,
    Reflected,
    Transmitted,
    Gathered,
    Shadow,
}

/// One ray.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "TreeRay")]
pub struct Node {
    /// Its number: its place in the list.
    pub id: u32,
    /// The ray it comes from; none for camera rays.
    pub parent: Option<u32>,
    /// Its kind.
    pub kind: NodeKind,
    /// Rays in the chain so far, this one included.
    pub depth: u32,
    /// What its radiance is multiplied with on the way to the pixel.
    pub weight: [f64; 3],
    /// What it adds to the pixel itself, its children left out: ambient light, emission or background, and for shadow rays the
    /// light they let through.
    pub contribution: [f64; 3],
    /// What fog on its way adds in front of a surface that is only partly there. Elsewhere that is part of `contribution`.
    #[serde(skip_serializing_if = "is_dark")]
    pub fog: [f64; 3],
    /// Start.
    pub origin: [f64; 3],
    /// Unit direction; for shadow rays towards the light.
    pub direction: [f64; 3],
    /// The media it is in, the one that decides first; empty space around all is not listed.
    pub media: Vec<Medium>,
    /// What it hits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hit: Option<NodeHit>,
    /// Snell's law where it hits a surface that transmits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snell: Option<SnellAngles>,
    /// For shadow rays: the number of the light in `lights` of the scene, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<usize>,
    /// For shadow rays: how much of each channel passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmittance: Option<[f64; 3]>,
    /// Rays that would have left from here but were not followed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_followed: Vec<Ended>,
}

fn is_dark(light: &[f64; 3]) -> bool {
    *light == [0.0; 3]
}

/// A medium a ray is in.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "TreeMedium")]
pub struct Medium {
    /// JSON pointer of the body.
    pub object: String,
    /// Index of refraction.
    pub ior: f64,
}

/// What a ray hits.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "TreeHit")]
pub struct NodeHit {
    /// Distance.
    pub t: f64,
    /// The point on the surface.
    pub point: [f64; 3],
    /// Unit geometric normal, pointing out of the body's material.
    pub normal: [f64; 3],
    /// JSON pointer of the object in `objects`.
    pub object: String,
    /// JSON pointer of the body itself, if it stands in a group or definition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Name of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// JSON pointer of its material; `default` for bodies that name none.
    pub material: String,
    /// Whether the ray goes into the body's material.
    pub entering: bool,
}

impl Node {
    /// Bytes of memory it takes: also those of what it hits, which is known later.
    fn bytes(&self) -> usize {
        let media: usize = self.media.iter().map(|medium| size_of::<Medium>() + medium.object.len()).sum();
        size_of::<Self>() + media + 64
    }
}

impl Node {
    /// Makes it one of a number of samples.
    fn share(&mut self, samples: f64) {
        let ended = self.not_followed.iter_mut().map(|ended| &mut ended.weight);
        for light in [&mut self.weight, &mut self.contribution, &mut self.fog].into_iter().chain(ended) {
            *light = light.map(|channel| channel / samples);
        }
    }
}

/// Angles of Snell's law.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct SnellAngles {
    /// Index of refraction on the side the ray comes from.
    pub n1: f64,
    /// Index of refraction on the other side.
    pub n2: f64,
    /// Angle of incidence in degrees.
    pub theta1_deg: f64,
    /// Angle of refraction in degrees; none under total internal reflection.
    pub theta2_deg: Option<f64>,
    /// Total internal reflection.
    pub tir: bool,
    /// Unpolarised Fresnel reflectance, for information: materials without `fresnel` have constants instead.
    pub reflectance: f64,
}

/// A ray that was not followed.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "EndedRay")]
pub struct Ended {
    /// Its kind.
    pub kind: RayKind,
    /// The weight it would have had.
    pub weight: [f64; 3],
    /// `depth`, `weight`, `budget`, or `roulette`, where others stand for it.
    pub why: &'static str,
    /// How many 8-bit codes the pixel could have changed with it, at most; 255 if nothing bounds that.
    pub codes: u8,
}

/// Traces one pixel and records every ray. The pixel must lie inside the picture.
pub fn trace_pixel(scene: &Scene, x: u32, y: u32) -> Tree {
    trace_pixel_while(scene, x, y, &Control::default()).unwrap_or_else(|_| unreachable!("this is never cancelled"))
}

/// [`trace_pixel`], unless it is cancelled.
pub fn trace_pixel_while(scene: &Scene, x: u32, y: u32, control: &Control) -> Result<Tree, Cancelled> {
    match &scene.world {
        Precise::Single(world) => record::<f32>(scene, world, [x, y], control, "single"),
        Precise::Double(world) => record::<f64>(scene, world, [x, y], control, "double"),
    }
}

fn record<L>(
    scene: &Scene,
    world: &World<L::Real>,
    [x, y]: [u32; 2],
    control: &Control,
    precision: &'static str,
) -> Result<Tree, Cancelled>
where
    L: Lanes<Simd = ()>,
{
    let samples = samples_of(scene, [x, y], control)?;
    let recorder =
        Recorder::<L::Real> { scene, world, rays: Vec::new(), truncated: false, bytes: 0, before: (0, false, 0) };
    let _entered = control.enter();
    let mut tracer =
        Tracer::<L, _>::new((), world, &world.camera, &eye_media::<L>((), world), world.rules.pruning, recorder);
    let mean = trace_pixel_samples(&mut tracer, [x, y], samples, Grouping::of(scene), &mut Hits::none(()));
    control.add_rays(tracer.counts.total());
    let Recorder { mut rays, truncated, .. } = tracer.into_observer();
    if control.stops() {
        return Err(Cancelled);
    }
    let mut raised = [0.0; 3];
    if let Pruning::Proved { max_codes } = world.rules.pruning
        && world.display.is_plain()
    {
        let ends = mean.ends();
        raised = std::array::from_fn(|c| raise(mean.light[c], ends[c], max_codes));
    }
    let value = std::array::from_fn(|c| mean.light[c] + raised[c]);
    rays.iter_mut().for_each(|node| node.share(f64::from(samples)));
    bound_pruned(scene, value, &mut rays);
    let lacking = mean.omitted;
    let [shown, low, high] = [value, mean.light, std::array::from_fn(|c| mean.light[c] + lacking[c])]
        .map(|color| color.map(|channel: f64| channel as f32));
    let codes_off = scene.display().codes_around(shown, low, high).into_iter().fold(0, u8::max);
    let codes = scene.display().codes(shown);
    Ok(Tree { pixel: [x, y], precision, samples, value, codes, codes_off, raised, lacking, truncated, rays })
}

/// Says of each ray that was not followed what it could have changed: its weight times the most radiance there can be.
fn bound_pruned(scene: &Scene, value: [f64; 3], rays: &mut [Node]) {
    let most = scene.ceiling().reach.ceiling.unwrap_or([f64::MAX.sqrt(); 3]);
    for node in rays {
        for ended in &mut node.not_followed {
            let highest = std::array::from_fn(|c| (value[c] + ended.weight[c] * most[c]) as f32);
            let codes = scene.display().codes_off(value.map(|c| c as f32), highest);
            ended.codes = codes.into_iter().fold(0, u8::max);
        }
    }
}

/// Records the events of the kernel.
struct Recorder<'a, R> {
    scene: &'a Scene,
    world: &'a World<R>,
    rays: Vec<Node>,
    truncated: bool,
    /// Bytes of all rays.
    bytes: usize,
    /// The number of rays, whether it was truncated, and the bytes when the batch began.
    before: (usize, bool, usize),
}

/// Bytes of a tree: of 100,000 rays with short names it takes 60 MiB.
pub const TREE_BYTES: usize = 80 << 20;

/// The number of a ray that was not recorded.
const UNRECORDED: u32 = u32::MAX;

impl<R: Real> Recorder<'_, R> {
    fn push(&mut self, node: Node) -> u32 {
        self.bytes += node.bytes();
        if self.rays.len() as u64 >= TREE_RAYS.max || self.bytes > TREE_BYTES {
            self.truncated = true;
            return UNRECORDED;
        }
        let id = self.rays.len() as u32;
        self.rays.push(Node { id, ..node });
        id
    }

    fn node(&mut self, ray: u32) -> Option<&mut Node> {
        self.rays.get_mut(ray as usize)
    }
}

fn wide<L: Lanes>(v: V3<L>) -> [f64; 3] {
    v.lane(0).map(Real::to_f64)
}

/// A camera ray without values.
fn blank() -> Node {
    Node {
        id: 0,
        parent: None,
        kind: NodeKind::Camera,
        depth: 1,
        weight: [0.0; 3],
        contribution: [0.0; 3],
        fog: [0.0; 3],
        origin: [0.0; 3],
        direction: [0.0; 3],
        media: Vec::new(),
        hit: None,
        snell: None,
        light: None,
        transmittance: None,
        not_followed: Vec::new(),
    }
}

impl<L: Lanes> Observer<L> for Recorder<'_, L::Real> {
    const WATCHING: bool = true;

    fn ray(&mut self, ray: &RayPacket<L>, media: &Media<L::Real>) -> u32 {
        let (kind, parent) = match ray.kind {
            RayKind::Camera => (NodeKind::Camera, None),
            RayKind::Reflected => (NodeKind::Reflected, Some(ray.parent)),
            RayKind::Transmitted => (NodeKind::Transmitted, Some(ray.parent)),
            RayKind::Gathered => (NodeKind::Gathered, Some(ray.parent)),
        };
        let media = media
            .entries(ray.media.lane(0) as MediumList)
            .map(|medium| {
                let (top, own, _) = name_of(self.scene, self.world, medium.body);
                Medium { object: own.unwrap_or(top), ior: medium.ior.to_f64() }
            })
            .collect();
        self.push(Node {
            parent,
            kind,
            depth: ray.depth,
            weight: wide(ray.weight),
            origin: wide(ray.start()),
            direction: wide(ray.dir),
            media,
            ..blank()
        })
    }

    fn outside(&mut self) {
        self.push(blank());
    }

    /// A ray that adds twice has added the fog on its way first.
    fn contributes(&mut self, ray: u32, radiance: V3<L>) {
        if let Some(node) = self.node(ray) {
            node.fog = std::mem::replace(&mut node.contribution, wide(radiance));
        }
    }

    fn hits(&mut self, number: u32, ray: &RayPacket<L>, hits: &Hits<L>) {
        let (object, body, name) = name_of(self.scene, self.world, hits.expanded.lane(0));
        let material = self.scene.sources.material(self.world.owner(hits.expanded.lane(0)).item.material).to_owned();
        let texts = [&body, &name].map(|text| text.as_ref().map_or(0, String::len));
        self.bytes += object.len() + material.len() + texts.iter().sum::<usize>();
        if let Some(node) = self.node(number) {
            node.hit = Some(NodeHit {
                t: first(hits.t - ray.t_min),
                point: wide(hits.surface.point),
                normal: wide(hits.surface.ng),
                object,
                body,
                name,
                material,
                entering: hits.entering != 0,
            });
        }
    }

    fn shadow(&mut self, ray: u32, light: usize, origin: V3<L>, to_light: V3<L>, passed: V3<L>, radiance: V3<L>) {
        let Some(parent) = self.node(ray) else { return };
        let (depth, weight, media) = (parent.depth + 1, parent.weight, parent.media.clone());
        self.push(Node {
            parent: Some(ray),
            kind: NodeKind::Shadow,
            depth,
            weight,
            contribution: wide(radiance),
            origin: wide(origin),
            direction: wide(to_light),
            media,
            light: Some(self.world.lights[light].number as usize),
            transmittance: Some(wide(passed)),
            ..blank()
        });
    }

    fn refracts(&mut self, ray: u32, snell: Snell) {
        if let Some(node) = self.node(ray) {
            node.snell = Some(SnellAngles {
                n1: snell.n1,
                n2: snell.n2,
                theta1_deg: snell.theta1.to_degrees(),
                theta2_deg: (!snell.total).then(|| snell.theta2.to_degrees()),
                tir: snell.total,
                reflectance: snell.reflectance,
            });
        }
    }

    fn pixel(&mut self) {
        self.before = (0, false, 0);
        <Self as Observer<L>>::again(self);
    }

    fn batch(&mut self) {
        self.before = (self.rays.len(), self.truncated, self.bytes);
    }

    fn again(&mut self) {
        self.rays.truncate(self.before.0);
        (_, self.truncated, self.bytes) = self.before;
    }

    fn not_followed(&mut self, ray: u32, kind: RayKind, weight: V3<L>, why: NotFollowed) {
        let why = match why {
            NotFollowed::Depth => "depth",
            NotFollowed::Weight => "weight",
            NotFollowed::Budget => "budget",
            NotFollowed::Roulette => "roulette",
        };
        let weight = wide(weight);
        if let Some(node) = self.node(ray) {
            // Known when the pixel is.
            node.not_followed.push(Ended { kind, weight, why, codes: 0 });
        }
    }
}
