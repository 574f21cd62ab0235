//! Drawings of a ray tree: Graphviz text and SVG, coloured by the kind of ray.

use super::tree::{Node, NodeKind, Tree};
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
    /// A drawing.
    Svg,
}

/// Colour of each kind of ray.
fn color(node: &Node) -> &'static str {
    match node.kind {
        NodeKind::Camera => "#1f3a93",
        NodeKind::Reflected => "#c0392b",
        NodeKind::Transmitted => "#16803c",
        NodeKind::Gathered => "#7d3c98",
        NodeKind::Shadow if node.transmittance == Some([0.0; 3]) => "#555555",
        NodeKind::Shadow => "#d68910",
    }
}

/// E1, R2, T3, S4: eye, reflected, transmitted or shadow ray, with its number.
fn label(node: &Node) -> String {
    let letter = match node.kind {
        NodeKind::Camera => 'E',
        NodeKind::Reflected => 'R',
        NodeKind::Transmitted => 'T',
        NodeKind::Gathered => 'G',
        NodeKind::Shadow => 'S',
    };
    format!("{letter}{}", node.id)
}

fn ending(node: &Node) -> String {
    match (&node.hit, node.light) {
        (Some(hit), _) => hit.name.clone().unwrap_or_else(|| hit.object.clone()),
        (None, Some(light)) => format!("light {light}"),
        (None, None) => "background".to_owned(),
    }
}

fn heaviest(weight: [f64; 3]) -> f64 {
    weight.into_iter().fold(0.0, f64::max)
}

const DOT_HEAD: &str = "digraph rays {\n  rankdir=TB;\n  node [shape=box, fontname=\"sans-serif\"];\n";

fn svg_head(places: &[(f64, f64)]) -> String {
    let width = places.iter().map(|p| p.0).fold(0.0, f64::max) + 60.0;
    let height = places.iter().map(|p| p.1).fold(0.0, f64::max) + 50.0;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    )
}

/// Rays that are written at a time.
const PART: usize = 256;

impl Tree {
    /// Its text in parts, for one who cannot keep all of it. The JSON has no white space.
    pub fn parts(mut self, format: TreeFormat) -> impl Iterator<Item = String> + Send {
        let places = if format == TreeFormat::Svg { self.places() } else { Vec::new() };
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
            TreeFormat::Svg => (svg_head(&places), 2, "</svg>\n"),
        };
        let count = self.rays.len();
        let parts = (0..passes).flat_map(move |pass| (0..count).step_by(PART).map(move |from| (pass, from)));
        let text = move |(pass, from): (usize, usize)| {
            let range = from..count.min(from + PART);
            match (format, pass) {
                (TreeFormat::Json, _) => self.json_of(range),
                (TreeFormat::Dot, _) => self.dot_of(range),
                (TreeFormat::Svg, 0) => self.lines_of(range, &places),
                (TreeFormat::Svg, _) => self.circles_of(range, &places),
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
            let text = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            // Writing to a String cannot fail.
            let _ = writeln!(dot, "  r{} [label=\"{text}\", color=\"{}\"];", node.id, color(node));
            if let Some(parent) = node.parent {
                let _ = writeln!(dot, "  r{parent} -> r{} [color=\"{}\"];", node.id, color(node));
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
                color(node)
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
                ending(node),
                node.weight,
                node.contribution
            );
            // XML has no way to write these.
            let is_xml = |c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
            let title: String = title.chars().filter(is_xml).collect();
            let title = title.replace('&', "&amp;").replace('<', "&lt;");
            let _ = writeln!(
                svg,
                "<g><title>{title}</title><circle cx=\"{x}\" cy=\"{y}\" r=\"13\" fill=\"{}\"/>\
                 <text x=\"{x}\" y=\"{}\" fill=\"white\" text-anchor=\"middle\">{}</text></g>",
                color(node),
                y + 4.0,
                label(node)
            );
        }
        svg
    }

    /// Centre of each node: leaves side by side, parents above the middle of their children.
    fn places(&self) -> Vec<(f64, f64)> {
        let mut span = vec![None::<(f64, f64)>; self.rays.len()];
        let mut next_leaf = 30.0;
        // Children come after their parents in the list; in the drawing leaves are in depth-first order.
        for id in self.depth_first() {
            if span[id].is_none() {
                span[id] = Some((next_leaf, next_leaf));
                next_leaf += 36.0;
            }
            let (low, high) = span[id].unwrap_or_default();
            if let Some(parent) = self.rays[id].parent {
                let (a, b) = span[parent as usize].unwrap_or((low, high));
                span[parent as usize] = Some((a.min(low), b.max(high)));
            }
        }
        let middle = |span: Option<(f64, f64)>| span.map_or(0.0, |(low, high)| 0.5 * (low + high));
        self.rays.iter().zip(span).map(|(node, span)| (middle(span), 60.0 * f64::from(node.depth) - 30.0)).collect()
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
