//! The forest of nodes: checked and walked without recursion, however deep a file nests them.

use super::super::fault::{Fault, Faults, Kind};
use super::json::{Document, Node};
use glam::{DMat4, DQuat, DVec3};

/// Most nodes of a file.
pub(crate) const NODES: usize = 1 << 16;
/// Most levels of nodes.
pub(crate) const NODE_LEVELS: usize = 1_000;

/// Translation, rotation and scale of a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trs {
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
}

/// Where a node is in its parent, and its weights of morph targets.
#[derive(Debug, Clone)]
pub(super) struct Local {
    pub(super) matrix: Option<DMat4>,
    pub(super) trs: Trs,
    pub(super) weights: Option<Vec<f64>>,
}

impl Local {
    pub(super) fn of(node: &Node) -> Self {
        let matrix = node.matrix.map(|columns| {
            let mut matrix = DMat4::from_cols_array(&columns);
            // Nodes are affine: what a last row could say has no meaning.
            (matrix.x_axis.w, matrix.y_axis.w, matrix.z_axis.w, matrix.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
            matrix
        });
        let trs = Trs {
            translation: node.translation.map_or(DVec3::ZERO, DVec3::from_array),
            rotation: node.rotation.map_or(DQuat::IDENTITY, unit),
            scale: node.scale.map_or(DVec3::ONE, DVec3::from_array),
        };
        Self { matrix, trs, weights: node.weights.clone() }
    }

    fn matrix(&self) -> DMat4 {
        let Trs { translation, rotation, scale } = self.trs;
        self.matrix.unwrap_or_else(|| DMat4::from_scale_rotation_translation(scale, rotation, translation))
    }
}

/// The rotation of a quaternion of any length but 0.
pub(super) fn unit(quaternion: [f64; 4]) -> DQuat {
    let quaternion = DQuat::from_array(quaternion);
    let length = quaternion.length();
    if length > 1e-12 { quaternion / length } else { DQuat::IDENTITY }
}

/// The parent of each node. References have been checked.
pub(super) fn parents(document: &Document) -> Vec<Option<usize>> {
    let mut parents = vec![None; document.nodes.len()];
    for (i, node) in document.nodes.iter().enumerate() {
        node.children.iter().for_each(|&child| parents[child] = Some(i));
    }
    parents
}

/// The root above each node.
pub(super) fn roots(document: &Document) -> Vec<usize> {
    let parents = parents(document);
    let mut roots: Vec<Option<usize>> = vec![None; parents.len()];
    let mut way = Vec::new();
    for node in 0..parents.len() {
        let mut at = node;
        let root = loop {
            match (roots[at], parents[at]) {
                (Some(root), _) => break root,
                (None, None) => break at,
                (None, Some(parent)) => {
                    way.push(at);
                    at = parent;
                }
            }
        };
        roots[at] = Some(root);
        way.drain(..).for_each(|below| roots[below] = Some(root));
    }
    roots.into_iter().flatten().collect()
}

/// Notes nodes with two parents or in a loop, and roots of scenes that are none.
pub(super) fn check_forest(document: &Document, faults: &mut Faults) {
    let count = document.nodes.len();
    if count > NODES {
        let detail = format!("{count} nodes are over the limit of {NODES} (nodes)");
        faults.push(Fault::new("/nodes", Kind::Limit, detail));
        return;
    }
    let mut parents: Vec<Option<usize>> = vec![None; count];
    for (i, node) in document.nodes.iter().enumerate() {
        for (k, &child) in node.children.iter().enumerate() {
            let pointer = format!("/nodes/{i}/children/{k}");
            match parents.get_mut(child) {
                None => {
                    faults.push(Fault::new(pointer, Kind::UnknownReference, format!("there is no node {child}")));
                }
                Some(Some(other)) => {
                    let detail = format!("node {child} is a child of node {other} already, and has one parent at most");
                    faults.push(Fault::new(pointer, Kind::Cycle, detail));
                }
                Some(parent) => *parent = Some(i),
            }
        }
    }
    let looped = loops(&parents);
    for &node in &looped {
        faults.push(Fault::new(format!("/nodes/{node}"), Kind::Cycle, "the node is a part of a loop of nodes"));
    }
    if looped.is_empty()
        && let Some(deep) = too_deep(&parents)
    {
        let detail = format!("the node is more than {NODE_LEVELS} levels deep (node_levels)");
        faults.push(Fault::new(format!("/nodes/{deep}"), Kind::Limit, detail));
    }
    for (i, scene) in document.scenes.iter().enumerate() {
        for (k, &root) in scene.nodes.iter().enumerate() {
            let pointer = format!("/scenes/{i}/nodes/{k}");
            match parents.get(root) {
                None => {
                    faults.push(Fault::new(pointer, Kind::UnknownReference, format!("there is no node {root}")));
                }
                Some(Some(parent)) => {
                    let detail = format!("node {root} is no root: it is a child of node {parent}");
                    faults.push(Fault::new(pointer, Kind::Cycle, detail));
                }
                Some(None) => {}
            }
        }
    }
}

/// The nodes that are their own ancestors.
fn loops(parents: &[Option<usize>]) -> Vec<usize> {
    // The walk on which a node was met first.
    let mut met = vec![usize::MAX; parents.len()];
    let mut looped = Vec::new();
    for start in 0..parents.len() {
        let mut at = Some(start);
        while let Some(node) = at.filter(|node| met[*node] == usize::MAX) {
            met[node] = start;
            at = parents[node];
        }
        // The walk has met itself.
        if let Some(first) = at.filter(|node| met[*node] == start) {
            let mut node = first;
            loop {
                looped.push(node);
                match parents[node] {
                    Some(parent) if parent != first => node = parent,
                    _ => break,
                }
            }
        }
    }
    looped.sort_unstable();
    looped
}

/// A node that is too deep, if there is one.
fn too_deep(parents: &[Option<usize>]) -> Option<usize> {
    let mut levels = vec![0; parents.len()];
    let mut way = Vec::new();
    for start in 0..parents.len() {
        let mut at = Some(start);
        while let Some(node) = at.filter(|node| levels[*node] == 0) {
            way.push(node);
            at = parents[node];
        }
        let mut level = at.map_or(0, |node| levels[node]);
        while let Some(node) = way.pop() {
            level += 1;
            levels[node] = level;
        }
    }
    levels.iter().position(|level| *level > NODE_LEVELS)
}

/// From each node to the model, in a forest.
pub(super) fn worlds(document: &Document, locals: &[Local], parents: &[Option<usize>]) -> Vec<DMat4> {
    let mut worlds: Vec<Option<DMat4>> = vec![None; locals.len()];
    let mut way = Vec::new();
    for start in 0..document.nodes.len() {
        let mut at = Some(start);
        while let Some(node) = at.filter(|node| worlds[*node].is_none()) {
            way.push(node);
            at = parents[node];
        }
        let mut world = at.and_then(|node| worlds[node]).unwrap_or(DMat4::IDENTITY);
        while let Some(node) = way.pop() {
            world *= locals[node].matrix();
            worlds[node] = Some(world);
        }
    }
    worlds.into_iter().map(Option::unwrap_or_default).collect()
}

/// The nodes of a scene that are to be seen, in the order of the file: parents before their children.
pub(super) fn visible(document: &Document, scene: Option<usize>, parents: &[Option<usize>]) -> Vec<usize> {
    let roots = match scene {
        Some(scene) => document.scenes[scene].nodes.clone(),
        // Without any scene all nodes are shown.
        None => (0..parents.len()).filter(|node| parents[*node].is_none()).collect(),
    };
    let mut waiting: Vec<usize> = roots.into_iter().rev().collect();
    let mut visible = Vec::new();
    // A scene may name a root twice, though it must not.
    let mut met = vec![false; parents.len()];
    while let Some(node) = waiting.pop() {
        let is_hidden = document.nodes[node].extensions.visibility.as_ref().is_some_and(|it| !it.visible);
        if !is_hidden && !std::mem::replace(&mut met[node], true) {
            visible.push(node);
            waiting.extend(document.nodes[node].children.iter().rev());
        }
    }
    visible
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_found_with_the_tails_that_lead_to_them_left_out() {
        assert_eq!(loops(&[Some(1), Some(2), Some(1), Some(0), None]), [1, 2]);
        assert_eq!(loops(&[Some(0)]), [0]);
        assert_eq!(loops(&[None, Some(0), Some(1)]), [0; 0]);
    }

    #[test]
    fn a_chain_may_have_a_thousand_levels() {
        let chain = |count: usize| (0..count).map(|i| i.checked_sub(1)).collect::<Vec<_>>();
        assert_eq!(too_deep(&chain(1_000)), None);
        assert_eq!(too_deep(&chain(60_000)), Some(1_000));
    }
}
