//! The rays of a pixel drawn into a picture of the scene, from its own camera or from another one.
//!
//! Each ray is a segment in the scene, projected by the camera of the picture. Segments are drawn over bodies, also where a
//! body hides them.

use super::query::{RayQuery, answer};
use super::ray_kinds::{Kind, destination, heaviest, label, of_samples, xml};
use super::tree::{Node, Tree};
use crate::camera::Camera;
use crate::control::{Cancelled, Control};
use crate::lanes::Real;
use crate::math;
use crate::scene::Scene;
use crate::scene::compile::with_world;
use crate::scene::world::World;
use crate::shading::light::Source;
use data_encoding::BASE64;
use glam::DVec3;
use std::fmt::Write;

/// Segments that are drawn: those of the largest weight. More could not be told apart.
pub const SEGMENTS: usize = 1_000;
/// Units across a picture that is drawn smaller than it could be read.
const LEAST: f64 = 800.0;
/// Units across the legend.
const LEGEND: f64 = 660.0;
/// Angle between two points of a curve, in radians.
const TURN: f64 = 0.03;
/// Halvings of a curve at most: 2^8 pieces.
const HALVINGS: u32 = 8;

/// What is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    /// The rays, as they are [`drawn`](Tree::drawn).
    pub tree: &'a Tree,
    /// The scene whose rays they are.
    pub scene: &'a Scene,
    /// The same scene with the camera that sees them, if that is another one.
    pub seen_from: Option<&'a Scene>,
    /// The rendered picture as a PNG file.
    pub picture: Option<&'a [u8]>,
    /// Whether these are the rays of all samples.
    pub all_samples: bool,
}

/// A ray in the scene.
struct Segment<'a> {
    node: &'a Node,
    kind: Kind,
    ends: [DVec3; 2],
    /// Whether it goes on where nothing is.
    leaves: bool,
}

impl Overlay<'_> {
    /// The drawing as SVG, which loads nothing else.
    pub fn draw(&self, control: &Control) -> Result<String, Cancelled> {
        let tree = self.tree;
        let mut strongest: Vec<&Node> = tree.rays.iter().filter(|node| node.direction != [0.0; 3]).collect();
        let all = strongest.len();
        // Stable, so that of equal weights the ray that was followed first is drawn.
        strongest.sort_by(|a, b| heaviest(b.weight).total_cmp(&heaviest(a.weight)));
        strongest.truncate(SEGMENTS);
        // What matters most lies on top.
        strongest.reverse();
        let mut segments = Vec::with_capacity(strongest.len());
        for node in strongest {
            if control.stops() {
                return Err(Cancelled);
            }
            let mut segment = segment(self.scene, tree, node);
            if self.seen_from.is_none() && segment.kind == Kind::Camera {
                // It is seen as a point. Near to the eye the rounding of its coordinates would say where.
                segment.ends[0] = segment.ends[0].midpoint(segment.ends[1]);
            }
            segments.push(segment);
        }
        let seen_by = self.seen_from.unwrap_or(self.scene);
        Ok(with_world!(&seen_by.world, |world| self.svg(&world.camera, seen_by, &segments, all)))
    }

    fn svg<R: Real>(&self, camera: &Camera<R>, seen_by: &Scene, segments: &[Segment<'_>], all: usize) -> String {
        let size = [seen_by.width, seen_by.height].map(f64::from);
        let scale = (LEAST / size[0].max(size[1])).max(1.0);
        let drawing = Drawing { camera, size, scale };
        let [width, height] = size.map(|length| length * scale);
        let legend = self.legend(segments, all);
        // Letters grow with large pictures, so that they can be read where the whole is shown.
        let unit = (width.max(height) / LEAST).max(1.0);
        let full = [width.max(LEGEND * unit), height + unit * (24.0 + 20.0 * legend.len() as f64)];
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" \
             font-family=\"sans-serif\" font-size=\"{2}\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
             <clipPath id=\"picture\"><rect width=\"{width}\" height=\"{height}\"/></clipPath>\n",
            full[0],
            full[1],
            13.0 * unit
        );
        let _ = match self.picture {
            Some(file) => writeln!(
                svg,
                "<image width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
                 href=\"data:image/png;base64,{}\"/>",
                BASE64.encode(file)
            ),
            None => writeln!(svg, "<rect width=\"{width}\" height=\"{height}\" fill=\"#d8d8d8\"/>"),
        };
        svg += "<g clip-path=\"url(#picture)\" fill=\"none\" stroke-linecap=\"round\">\n";
        for segment in segments {
            let path = drawing.path(segment.ends);
            if path.is_empty() {
                continue;
            }
            let thickness = unit * (1.0 + 2.5 * heaviest(segment.node.weight).min(1.0).sqrt());
            let dashes =
                if segment.leaves { format!(" stroke-dasharray=\"{0} {0}\"", 5.0 * unit) } else { String::new() };
            let title = format!(
                "{} to {}, weight {:.4}",
                label(segment.node),
                destination(segment.node),
                heaviest(segment.node.weight)
            );
            let _ = writeln!(
                svg,
                "<g{dashes}><title>{}</title><path d=\"{path}\" stroke=\"white\" stroke-opacity=\"0.7\" \
                 stroke-width=\"{:.2}\"/><path d=\"{path}\" stroke=\"{}\" stroke-width=\"{thickness:.2}\"/></g>",
                xml(&title),
                thickness + 1.6 * unit,
                segment.kind.color()
            );
        }
        self.marks(&drawing, segments, unit, &mut svg);
        svg += "</g>\n";
        for (row, (color, text)) in legend.iter().enumerate() {
            let y = height + unit * (24.0 + 20.0 * row as f64);
            let x = match color {
                Some(color) => {
                    let _ = write!(
                        svg,
                        "<path d=\"M{},{} h{}\" stroke=\"{color}\" stroke-width=\"{}\"/>",
                        12.0 * unit,
                        y - 4.0 * unit,
                        22.0 * unit,
                        3.5 * unit
                    );
                    44.0
                }
                None => 12.0,
            };
            let _ = writeln!(svg, "<text x=\"{}\" y=\"{y}\">{}</text>", x * unit, xml(text));
        }
        svg + "</svg>\n"
    }

    /// A ring around the pixel, or around the eye where another camera sees it.
    fn marks<R: Real>(&self, drawing: &Drawing<'_, R>, segments: &[Segment<'_>], unit: f64, svg: &mut String) {
        let eye = segments.iter().find(|segment| segment.kind == Kind::Camera).map(|segment| segment.ends[0]);
        let at = match self.seen_from {
            Some(_) => eye.and_then(|eye| drawing.camera.project(eye)),
            None => Some(self.tree.pixel.map(|x| f64::from(x) + 0.5)),
        };
        let Some([x, y]) = at.map(|at| at.map(|x| x * drawing.scale)).filter(|at| drawing.holds(*at)) else { return };
        for (color, width) in [("white", 4.0), (Kind::Camera.color(), 2.0)] {
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{}\" stroke=\"{color}\" stroke-width=\"{}\"/>",
                7.0 * unit,
                width * unit
            );
        }
    }

    /// Rows of text, some with a color.
    fn legend(&self, segments: &[Segment<'_>], all: usize) -> Vec<(Option<&'static str>, String)> {
        let [x, y] = self.tree.pixel;
        let samples = of_samples(self.tree.samples, self.all_samples);
        let ring = if self.seen_from.is_some() { "the ring is its eye" } else { "in the ring" };
        let mut rows = vec![(None, format!("The rays of pixel {x}, {y}{samples} ({ring})"))];
        let kinds = Kind::counted(segments.iter().map(|segment| segment.kind));
        rows.extend(kinds.iter().map(|(kind, count)| (Some(kind.color()), format!("{}: {count}", kind.name()))));
        if segments.len() < all {
            let left_out = all - segments.len();
            rows.push((None, format!("Only the {} of the largest weight; {left_out} are left out.", segments.len())));
        }
        if self.tree.truncated {
            rows.push((None, "There are more rays than were recorded.".to_owned()));
        }
        let how = "Thicker rays weigh more. Dashed rays leave the scene. Bodies do not hide rays here.";
        rows.push((None, how.to_owned()));
        rows
    }
}

/// Where a ray ends: at what it hits, at its light, or at the border of the scene.
fn segment<'a>(scene: &Scene, tree: &Tree, node: &'a Node) -> Segment<'a> {
    let [from, dir] = [node.origin, node.direction].map(DVec3::from_array);
    let kind = Kind::of(node, tree);
    let light = node.light.and_then(|light| with_world!(&scene.world, |world| position(world, light)));
    let to_light = light.map(|light| (light - from).dot(dir).max(0.0));
    let hit = match &node.hit {
        Some(hit) => Some(DVec3::from_array(hit.point)),
        None if kind == Kind::Blocked => {
            let query = RayQuery { origin: node.origin, direction: node.direction, t_min: 0.0, t_max: to_light };
            answer(scene, &query).at.map(|hit| DVec3::from_array(hit.point))
        }
        None => None,
    };
    let end = hit.or_else(|| to_light.map(|t| from + dir * t));
    let leaves = end.is_none();
    let border = || {
        let size = with_world!(&scene.world, |world| world.size.to_f64());
        from + dir * exit(from, dir, 2.0 * size)
    };
    Segment { node, kind, ends: [from, end.unwrap_or_else(border)], leaves }
}

fn position<R: Real>(world: &World<R>, light: usize) -> Option<DVec3> {
    match world.lights.get(light)?.source {
        Source::Point { position } | Source::Spot { position, .. } => {
            Some(DVec3::from_array(position.map(Real::to_f64)))
        }
        Source::Directional { .. } => None,
    }
}

/// Distance at which a ray leaves the ball of this radius around the origin; a ray from outside goes as far as its start is
/// away.
fn exit(from: DVec3, dir: DVec3, radius: f64) -> f64 {
    let radius = radius.max(from.length()).max(1.0);
    let along = from.dot(dir);
    (along * along + radius * radius - from.length_squared()).max(0.0).sqrt() - along
}

/// A picture of the scene.
struct Drawing<'a, R> {
    camera: &'a Camera<R>,
    /// Of the picture in pixels.
    size: [f64; 2],
    /// Units of the drawing in a pixel.
    scale: f64,
}

impl<R: Real> Drawing<'_, R> {
    /// Whether a place lies in the picture.
    fn holds(&self, at: [f64; 2]) -> bool {
        (0..2).all(|axis| (0.0..=self.size[axis] * self.scale).contains(&at[axis]))
    }

    /// The visible part of a segment as a path of SVG.
    fn path(&self, ends: [DVec3; 2]) -> String {
        let Some([a, b]) = self.camera.clip(ends) else { return String::new() };
        let mut points = vec![a];
        if let Some(eye) = self.camera.bends_around() {
            bend(eye, a, b, HALVINGS, &mut points);
        }
        points.push(b);
        let places: Vec<_> = points.iter().map(|point| self.camera.project(*point)).collect();
        let mut path = String::new();
        let mut last = None;
        for pair in places.windows(2) {
            let &[Some(from), Some(to)] = pair else { continue };
            // Where a panorama's ends meet, the curve goes on at the other side.
            if points.len() > 2 && (from[0] - to[0]).abs() > 0.5 * self.size[0] {
                continue;
            }
            let Some([from, to]) = self.within(from, to) else { continue };
            if last != Some(from) {
                let _ = write!(path, "M{:.2},{:.2}", from[0] * self.scale, from[1] * self.scale);
            }
            let _ = write!(path, "L{:.2},{:.2}", to[0] * self.scale, to[1] * self.scale);
            last = Some(to);
        }
        path
    }

    /// The part of a line that lies in the picture or close to it (Liang and Barsky 1984).
    fn within(&self, from: [f64; 2], to: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let margin = 0.1 * self.size[axis];
            let (low, high) = (-margin, self.size[axis] + margin);
            let step = to[axis] - from[axis];
            if step == 0.0 {
                if !(low..=high).contains(&from[axis]) {
                    return None;
                }
                continue;
            }
            let [a, b] = [(low - from[axis]) / step, (high - from[axis]) / step];
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        let at = |t: f64| std::array::from_fn(|axis| from[axis] + t * (to[axis] - from[axis]));
        let ends = [if enter > 0.0 { at(enter) } else { from }, if leave < 1.0 { at(leave) } else { to }];
        (enter <= leave && ends.iter().flatten().all(|x| x.is_finite())).then_some(ends)
    }
}

/// Points between two, so near to each other that an eye sees hardly a turn from one to the next.
fn bend(eye: DVec3, a: DVec3, b: DVec3, halvings: u32, points: &mut Vec<DVec3>) {
    let (from, to) = (a - eye, b - eye);
    let is_near = from == DVec3::ZERO || to == DVec3::ZERO || math::atan2(from.cross(to).length(), from.dot(to)) < TURN;
    if is_near || halvings == 0 {
        return;
    }
    // Half of the angle, not of the length: bisectors divide the side by the lengths of the others.
    let middle = a.lerp(b, from.length() / (from.length() + to.length()));
    bend(eye, a, middle, halvings - 1, points);
    points.push(middle);
    bend(eye, middle, b, halvings - 1, points);
}
