//! Pictures that somebody waits for, cut into tiles and rendered by the nodes of the farm. The bytes are the same.

use super::Service;
use super::pictures::Source;
use crate::service::farm::Farm;
use crate::service::farm::coordinator::{self, Order, Stopped};
use crate::service::farm::names::Class;
use crate::service::farm::work::SceneSource;
use crate::service::pictures::assembly::{empty, join};
use crate::service::pictures::render::RenderSpec;
use crate::service::pictures::tile_bytes::Tile;
use crate::service::scenes::prepared::{PreparedScene, planned};
use crate::service::scheduler::admission::Work;
use std::time::Duration;
use strahl::film::Region;
use strahl::render::{Cancelled, Picture};
use uuid::Uuid;

/// Edges of tiles, in pixels.
const EDGES: [u32; 3] = [128, 64, 32];
/// Tiles for each slot: the last ones are short.
const FOR_EACH_SLOT: f64 = 8.0;
/// How long a piece may take: nobody waits longer.
const LIMIT: Duration = Duration::from_secs(120);

impl Service {
    /// Renders a picture on nodes, if it takes long enough for that and they can; none if it is rendered here.
    pub(super) fn spread(
        &self,
        work: &Work,
        source: &Source,
        ready: &PreparedScene,
        spec: &RenderSpec,
    ) -> Result<Option<Picture>, Cancelled> {
        let Some((farm, least)) = self.farm.as_deref().and_then(|farm| Some((farm, farm.spread?))) else {
            return Ok(None);
        };
        let slots = farm.nodes.slots();
        if slots == 0 || ready.scene.from_files || !spec.layers.is_empty() || !farm.broker.is_connected() {
            return Ok(None);
        }
        // The estimate is of the picture's own pixels, on all threads of this process.
        let (whole, window) = (Region::whole(ready.scene.width, ready.scene.height), &spec.window);
        let (plan, _) = planned(ready, whole, &work.workers, &work.control)?;
        let Some(estimate) = plan.estimate else { return Ok(None) };
        let pixel_ms = estimate.ms * work.workers.threads() as f64 / whole.pixels() as f64;
        let ms = pixel_ms * spec.region.pixels() as f64;
        if ms / (work.workers.threads() as f64) < least.as_secs_f64() * 1e3 {
            return Ok(None);
        }
        let Some((text, format, settings)) = source.text(self) else { return Ok(None) };
        let scene = SceneSource { text: SceneSource::name_of(&text), format, settings, frame: None };
        if let Err(error) = farm.share_scene(&scene, &text) {
            tracing::warn!(%error, "a scene cannot be put into the farm's store; its picture is rendered here");
            return Ok(None);
        }
        let name = Uuid::now_v7().to_string();
        let order = Order {
            name: &name,
            tenant: work.workers.tenant(),
            class: Class::Hi,
            scene,
            window: *window,
            pixel_ms,
            limit: LIMIT,
            control: &work.control,
        };
        let pixels = spec.region.pixels() as f64 / (FOR_EACH_SLOT * f64::from(slots));
        let edge = EDGES.into_iter().find(|edge| f64::from(*edge).powi(2) <= pixels).unwrap_or(EDGES[2]);
        let mut tiles = OfPicture::new([window.width, window.height], spec.region, edge);
        finish(farm, &order, &mut tiles).map(|is_done| is_done.then_some(tiles.picture))
    }
}

/// Renders all tiles; false if nodes cannot.
fn finish(farm: &Farm, order: &Order<'_>, tiles: &mut OfPicture) -> Result<bool, Cancelled> {
    let ended = farm.render(order, tiles);
    farm.forget_results(order.name);
    match ended {
        Ok(()) => Ok(true),
        Err(Stopped::Cancelled) => Err(Cancelled),
        Err(Stopped::Dead(_, why) | Stopped::TooLarge(why) | Stopped::Broker(why)) => {
            tracing::warn!(why, "nodes cannot render a picture; it is rendered here");
            Ok(false)
        }
    }
}

/// The tiles of a picture, and what there is of it.
struct OfPicture {
    left: Vec<(u32, Region)>,
    pixels: u64,
    picture: Picture,
}

impl OfPicture {
    fn new(size: [u32; 2], region: Region, edge: u32) -> Self {
        let mut left: Vec<_> = (0..).zip(region.tiles(edge)).collect();
        left.reverse();
        Self { left, pixels: region.pixels(), picture: empty(size, region) }
    }
}

impl coordinator::Tiles for OfPicture {
    fn next(&mut self) -> Option<(u32, Region)> {
        let next = self.left.pop()?;
        self.pixels -= next.1.pixels();
        Some(next)
    }

    fn pixels_left(&self) -> u64 {
        self.pixels
    }

    fn share(&self) -> f64 {
        1.0
    }

    fn finished(&mut self, tile: Tile) -> bool {
        join(&mut self.picture, &tile.picture);
        true
    }
}
