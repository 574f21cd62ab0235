//! Drawings of a ray tree: Graphviz text and SVG, colored by the kind of ray.

use super::ray_kinds::{Kind, destination, ending, heaviest, label, material, of_samples, xml};
use super::tree::{Ended, Node, Tree};
use crate::trace::ray_packet::RayKind;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt::Write;
use std::ops::Range;

/// How a ray tree is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TreeFormat {
    /// Every ray with all its numbers.
    #[default]
    Json,
    /// Graphviz.
    Dot,
    /// A drawing of one sample's rays.
    Svg,
    /// The rays of one sample drawn into the picture, as SVG.
    Overlay,
}

/// A ray that was not followed, in a few characters: R or T, and its bound.
fn pruned(ended: &Ended) -> String {
    let letter = match ended.kind {
        RayKind::Reflected => 'R',
        RayKind::Transmitted => 'T',
        _ => 'G',
    };
    if ended.codes == u8::MAX { format!("{letter} any") } else { format!("{letter} \u{2264}{}", ended.codes) }
}

/// As much of a name as has room: its end, since pointers differ there.
fn shortened(name: &str) -> String {
    let length = name.chars().count();
    if length <= NAME {
        return name.to_owned();
    }
    std::iter::once('\u{2026}').chain(name.chars().skip(length + 1 - NAME)).collect()
}

const DOT_HEAD: &str = "digraph rays {\n  rankdir=TB;\n  node [shape=box, fontname=\"sans-serif\"];\n";

/// Between the middles of two leaves: room for a name below each.
const LEAF: f64 = 84.0;
/// Between the rays of a chain.
const ROW: f64 = 76.0;
/// Characters of a name that have room.
const NAME: usize = 14;
/// A row of the legend.
const LINE: f64 = 18.0;
/// Most rays that are named: beyond, the names would only make the drawing larger than a browser shows.
const NAMED: usize = 1_000;

/// Its beginning: the size, and the legend above the tree.
fn svg_head(tree: &Tree, all_samples: bool, top: f64, places: &[(f64, f64)]) -> String {
    let width = places.iter().map(|p| p.0).fold(0.0, f64::max).max(620.0) + LEAF;
    let height = places.iter().map(|p| p.1).fold(0.0, f64::max) + ROW;
    let [x, y] = tree.pixel;
    let shown = of_samples(tree.samples, all_samples);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"16\" y=\"22\" font-size=\"14\">Rays of pixel {x}, {y}{shown}: {}</text>\n",
        tree.rays.len()
    );
    for (row, (kind, count)) in Kind::counted(tree.rays.iter().map(|node| Kind::of(node, tree))).iter().enumerate() {
        let (x, y) = (22.0 + 300.0 * (row % 2) as f64, 42.0 + LINE * (row / 2) as f64);
        let _ = writeln!(
            svg,
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"6\" fill=\"{}\"/><text x=\"{}\" y=\"{}\">{}: {count}</text>",
            kind.color(),
            x + 12.0,
            y + 4.0,
            kind.name()
        );
    }
    let notes = [
        "Thicker lines add more light. Below a ray: what it hits, and of which material.",
        "Dashed: not followed, and how many codes of 255 that ray alone changes at most.",
    ];
    for (row, note) in notes.into_iter().enumerate() {
        let y = top - 52.0 + LINE * row as f64;
        let _ = writeln!(svg, "<text x=\"16\" y=\"{y}\" fill=\"#555555\">{note}</text>");
    }
    svg
}

/// Rays that are written at a time.
const PART: usize = 256;

impl Tree {
    /// What a drawing shows: the rays of all samples, or of the first one alone, in the same order and with the same numbers.
    #[must_use]
    pub fn drawn(mut self, all_samples: bool) -> Self {
        if all_samples {
            return self;
        }
        let mut places: Vec<Option<u32>> = Vec::with_capacity(self.rays.len());
        let mut rays = Vec::new();
        for node in self.rays {
            let parent = node.parent.map(|parent| places[parent as usize]);
            let is_kept = parent.map_or(rays.is_empty(), |parent| parent.is_some());
            places.push(is_kept.then_some(rays.len() as u32));
            if is_kept {
                rays.push(Node { parent: parent.flatten(), ..node });
            }
        }
        self.rays = rays;
        self
    }

    /// Its text in parts, for one who cannot keep all of it. The JSON has no white space. A drawing shows the first sample, or
    /// all of them. An overlay needs more than the tree: [`Overlay`](super::overlay::Overlay).
    pub fn parts(mut self, format: TreeFormat, all_samples: bool) -> impl Iterator<Item = String> + Send {
        let is_drawing = matches!(format, TreeFormat::Svg | TreeFormat::Overlay);
        if is_drawing {
            self = self.drawn(all_samples);
        }
        let kinds = Kind::counted(self.rays.iter().map(|node| Kind::of(node, &self))).len();
        let top = 104.0 + LINE * kinds.div_ceil(2) as f64;
        let places = if is_drawing { self.places(top) } else { Vec::new() };
        let (head, passes, tail) = match format {
            TreeFormat::Json => {
                let rays = std::mem::take(&mut self.rays);
                // Numbers and words always become JSON, and the rays come last.
                let mut head = serde_json::to_string(&self).unwrap_or_default();
                head.truncate(head.len().saturating_sub("]}".len()));
                self.rays = rays;
                (head, 1, "]}")
            }
            TreeFormat::Dot => (DOT_HEAD.to_owned(), 1, "}\n"),
            TreeFormat::Svg | TreeFormat::Overlay => (svg_head(&self, all_samples, top, &places), 2, "</svg>\n"),
        };
        let count = self.rays.len();
        let parts = (0..passes).flat_map(move |pass| (0..count).step_by(PART).map(move |from| (pass, from)));
        let text = move |(pass, from): (usize, usize)| {
            let range = from..count.min(from + PART);
            match (format, pass) {
                (TreeFormat::Json, _) => self.json_of(range),
                (TreeFormat::Dot, _) => self.dot_of(range),
                (_, 0) => self.lines_of(range, &places),
                (_, _) => self.circles_of(range, &places),
            }
        };
        std::iter::once(head).chain(parts.map(text)).chain(std::iter::once(tail.to_owned()))
    }

    fn json_of(&self, range: Range<usize>) -> String {
        let mut json = String::new();
        for node in &self.rays[range] {
            if node.id > 0 {
                json.push(',');
            }
            json += &serde_json::to_string(node).unwrap_or_default();
        }
        json
    }

    fn dot_of(&self, range: Range<usize>) -> String {
        let mut dot = String::new();
        for node in &self.rays[range] {
            let text = format!("{} {}\nweight {:.4}", label(node), ending(node), heaviest(node.weight));
            let color = Kind::of(node, self).color();
            let text = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            // Writing to a String cannot fail.
            let _ = writeln!(dot, "  r{} [label=\"{text}\", color=\"{color}\"];", node.id);
            if let Some(parent) = node.parent {
                let _ = writeln!(dot, "  r{parent} -> r{} [color=\"{color}\"];", node.id);
            }
        }
        dot
    }

    fn lines_of(&self, range: Range<usize>, places: &[(f64, f64)]) -> String {
        let mut svg = String::new();
        for (node, &(x, y)) in self.rays[range.clone()].iter().zip(&places[range]) {
            let Some(&(px, py)) = node.parent.and_then(|p| places.get(p as usize)) else { continue };
            let thickness = 0.5 + 4.0 * heaviest(node.weight).min(1.0);
            let _ = writeln!(
                svg,
                "<line x1=\"{px}\" y1=\"{py}\" x2=\"{x}\" y2=\"{y}\" stroke=\"{}\" stroke-width=\"{thickness:.2}\"/>",
                Kind::of(node, self).color()
            );
        }
        svg
    }

    fn circles_of(&self, range: Range<usize>, places: &[(f64, f64)]) -> String {
        let mut svg = String::new();
        for (node, &(x, y)) in self.rays[range.clone()].iter().zip(&places[range]) {
            let title = format!(
                "{} to {}, weight {:?}, contribution {:?}",
                label(node),
                destination(node),
                node.weight,
                node.contribution
            );
            let kind = Kind::of(node, self);
            let _ = writeln!(
                svg,
                "<g><title>{}</title><circle cx=\"{x}\" cy=\"{y}\" r=\"13\" fill=\"{}\"/>\
                 <text x=\"{x}\" y=\"{}\" fill=\"white\" text-anchor=\"middle\" font-size=\"9\">{}</text></g>",
                xml(&title),
                kind.color(),
                y + 3.0,
                label(node)
            );
            let names = [Some(ending(node)), material(node).map(str::to_owned)];
            let names = names.into_iter().flatten().filter(|_| self.rays.len() <= NAMED);
            for (row, (name, color)) in names.zip(["black", "#555555"]).enumerate() {
                // The edge keeps it readable where a line passes.
                let _ = writeln!(
                    svg,
                    "<text x=\"{x}\" y=\"{}\" fill=\"{color}\" text-anchor=\"middle\" font-size=\"10\" stroke=\"white\" \
                     stroke-width=\"3\" paint-order=\"stroke\">{}</text>",
                    y + 24.0 + 11.0 * row as f64,
                    xml(&shortened(&name))
                );
            }
            for (row, ended) in node.not_followed.iter().enumerate() {
                let y = y + 9.0 * (row as f64 - 0.5 * (node.not_followed.len() - 1) as f64);
                let _ = writeln!(
                    svg,
                    "<path d=\"M{},{y} h8\" stroke=\"#666666\" stroke-dasharray=\"3 2\"/><text x=\"{}\" y=\"{}\" \
                     fill=\"#666666\" font-size=\"9\">{}</text>",
                    x + 13.0,
                    x + 22.0,
                    y + 3.0,
                    pruned(ended)
                );
            }
        }
        svg
    }

    /// Centre of each node: leaves side by side, parents above the middle of their children.
    fn places(&self, top: f64) -> Vec<(f64, f64)> {
        let mut span = vec![None::<(f64, f64)>; self.rays.len()];
        let mut next_leaf = 0.5 * LEAF;
        // Children come after their parents in the list; in the drawing leaves are in depth-first order.
        for id in self.depth_first() {
            if span[id].is_none() {
                span[id] = Some((next_leaf, next_leaf));
                next_leaf += LEAF;
            }
            let (low, high) = span[id].unwrap_or_default();
            if let Some(parent) = self.rays[id].parent {
                let (a, b) = span[parent as usize].unwrap_or((low, high));
                span[parent as usize] = Some((a.min(low), b.max(high)));
            }
        }
        let middle = |span: Option<(f64, f64)>| span.map_or(0.0, |(low, high)| 0.5 * (low + high));
        self.rays
            .iter()
            .zip(span)
            .map(|(node, span)| (middle(span), top + ROW * f64::from(node.depth.saturating_sub(1))))
            .collect()
    }

    /// The rays, each after all its descendants.
    fn depth_first(&self) -> Vec<usize> {
        let mut children = vec![Vec::new(); self.rays.len()];
        let mut roots = Vec::new();
        for (id, node) in self.rays.iter().enumerate() {
            match node.parent {
                Some(parent) => children[parent as usize].push(id),
                None => roots.push(id),
            }
        }
        let mut order = Vec::with_capacity(self.rays.len());
        let mut stack = roots;
        while let Some(id) = stack.pop() {
            order.push(id);
            stack.append(&mut children[id]);
        }
        order.reverse();
        order
    }
}
