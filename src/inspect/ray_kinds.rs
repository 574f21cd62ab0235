//! What drawings of rays have in common: kinds with their colors and names, labels, and text in XML.

use super::tree::{Node, NodeKind, Tree};

/// Kinds of rays as drawings tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Camera,
    Reflected,
    TotallyReflected,
    Transmitted,
    Gathered,
    Free,
    Blocked,
}

const ALL: [Kind; 7] = [
    Kind::Camera,
    Kind::Reflected,
    Kind::TotallyReflected,
    Kind::Transmitted,
    Kind::Gathered,
    Kind::Free,
    Kind::Blocked,
];

impl Kind {
    /// The kind of a ray of a tree.
    pub(super) fn of(node: &Node, tree: &Tree) -> Self {
        let parent = node.parent.and_then(|parent| tree.rays.get(parent as usize));
        match node.kind {
            NodeKind::Camera => Self::Camera,
            NodeKind::Reflected if parent.and_then(|parent| parent.snell).is_some_and(|snell| snell.tir) => {
                Self::TotallyReflected
            }
            NodeKind::Reflected => Self::Reflected,
            NodeKind::Transmitted => Self::Transmitted,
            NodeKind::Gathered => Self::Gathered,
            NodeKind::Shadow if node.transmittance == Some([0.0; 3]) => Self::Blocked,
            NodeKind::Shadow => Self::Free,
        }
    }

    /// Its color.
    pub(super) fn color(self) -> &'static str {
        match self {
            Self::Camera => "#1f3a93",
            Self::Reflected => "#c0392b",
            Self::TotallyReflected => "#e056a0",
            Self::Transmitted => "#16803c",
            Self::Gathered => "#7d3c98",
            Self::Free => "#d68910",
            Self::Blocked => "#555555",
        }
    }

    /// Its name in a legend.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Camera => "E: from the eye",
            Self::Reflected => "R: reflected",
            Self::TotallyReflected => "R: total internal reflection",
            Self::Transmitted => "T: transmitted",
            Self::Gathered => "G: gathered from around",
            Self::Free => "S: to a light that it reaches",
            Self::Blocked => "S: to a light, blocked",
        }
    }

    /// The kinds that there are, and how many rays of each.
    pub(super) fn counted(kinds: impl Iterator<Item = Self>) -> Vec<(Self, usize)> {
        let mut counts = [0; ALL.len()];
        kinds.for_each(|kind| counts[kind as usize] += 1);
        ALL.into_iter().zip(counts).filter(|(_, count)| *count > 0).collect()
    }
}

/// E1, R2, T3, S4: eye, reflected, transmitted or shadow ray, with its number.
pub(super) fn label(node: &Node) -> String {
    let letter = match node.kind {
        NodeKind::Camera => 'E',
        NodeKind::Reflected => 'R',
        NodeKind::Transmitted => 'T',
        NodeKind::Gathered => 'G',
        NodeKind::Shadow => 'S',
    };
    format!("{letter}{}", node.id)
}

/// What it ends at: the name of what it hits, or its pointer.
pub(super) fn ending(node: &Node) -> String {
    match (&node.hit, node.light) {
        (Some(hit), _) => hit.name.clone().unwrap_or_else(|| hit.object.clone()),
        (None, Some(light)) => format!("light {light}"),
        (None, None) => "background".to_owned(),
    }
}

/// The name of the material it hits.
pub(super) fn material(node: &Node) -> Option<&str> {
    node.hit.as_ref().map(|hit| hit.material.strip_prefix("/materials/").unwrap_or(&hit.material))
}

/// Where it ends, in words.
pub(super) fn destination(node: &Node) -> String {
    let of = material(node).map_or_else(String::new, |material| format!(" of {material}"));
    ending(node) + &of
}

/// Which samples of a pixel are drawn, to go on with after its name.
pub(super) fn of_samples(samples: u32, all: bool) -> String {
    match (samples, all) {
        (1, _) => String::new(),
        (samples, true) => format!(", all {samples} samples"),
        (samples, false) => format!(", the first of {samples} samples"),
    }
}

/// The largest channel of a weight.
pub(super) fn heaviest(weight: [f64; 3]) -> f64 {
    weight.into_iter().fold(0.0, f64::max)
}

/// Any text as text of XML, without what XML has no way to write.
pub(super) fn xml(text: &str) -> String {
    let is_xml = |c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let text: String = text.chars().filter(is_xml).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
